//! Robots with corners where there is no room to turn: the whole stack in lockstep, with the noise of its
//! lidar.

use zeronav_tests::{workspace, zeronav};

/// Drives a scenario on some seeds: it arrives and touches nothing.
fn drive(name: &str) {
    let file = workspace().join(format!("tests/scenarios/{name}.toml"));
    let file = file.to_str().expect("a path");
    for seed in ["1", "2"] {
        let arguments = [
            "run",
            file,
            "--lockstep",
            "--headless",
            "--json",
            "--seed",
            seed,
        ];
        let result = zeronav(&arguments).expect(0);
        assert_eq!(result["verdict"], "pass", "{name}, seed {seed}: {result:#}");
        assert_eq!(result["contacts"], 0, "{name}, seed {seed}: {result:#}");
    }
}

#[test]
fn a_rectangle_gets_away_from_a_wall() {
    drive("tight_beside_wall");
}

#[test]
fn a_long_rectangle_gets_away_from_a_wall_on_flat_arcs() {
    drive("tight_long_beside_wall");
}

#[test]
fn a_goal_along_a_wall_is_reached_with_its_yaw() {
    drive("tight_goal_along_wall");
}

#[test]
fn an_aisle_is_left_backwards() {
    drive("tight_aisle_backwards");
}

#[test]
fn a_long_robot_gets_round_a_corner() {
    drive("tight_corner");
}
