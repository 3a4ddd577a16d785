//! The stack with every noise of a real robot, and among dynamic obstacles.

use serde_json::Value;
use zeronav_tests::{workspace, zeronav};

fn lockstep(scenario: &str, more: &[&str]) -> Value {
    let file = workspace().join(scenario);
    let file = file.to_str().expect("a path");
    let mut arguments = vec!["run", file, "--lockstep", "--headless", "--json"];
    arguments.extend(more);
    let result = zeronav(&arguments).expect(0);
    assert_eq!(result["verdict"], "pass", "{result:#}");
    assert_eq!(result["contacts"], 0, "{result:#}");
    result
}

fn number(value: &Value) -> f64 {
    value.as_f64().expect("a number")
}

#[test]
fn with_every_noise_on_a_run_is_the_same_bit_for_bit() {
    let run = |seed: &str| lockstep("tests/scenarios/noisy_rooms.toml", &["--seed", seed]);
    let (first, again, other) = (run("7"), run("7"), run("8"));
    let pose = &first["pose"];
    assert!(
        number(&pose["odometry_error_m_max"]) > 0.01,
        "it drifts: {pose}"
    );
    assert!(number(&pose["error_m_max"]) < 0.1, "{pose}");
    assert!(first["run_hash"].is_string());
    for same in [
        "run_hash",
        "driven_m",
        "time_s",
        "track_m",
        "clearance_m_min",
    ] {
        assert_eq!(first[same], again[same], "{same}");
    }
    assert_ne!(first["run_hash"], other["run_hash"], "the seed counts");
}

#[test]
fn over_200_m_with_slip_and_drift_the_pose_is_within_10_cm_and_2_degrees() {
    let result = lockstep("tests/scenarios/drive_warehouse.toml", &[]);
    let pose = &result["pose"];
    eprintln!("{pose}");
    assert!(number(&result["driven_m"]) > 200.0);
    assert!(number(&pose["odometry_error_m_max"]) > 0.5, "{pose}");
    assert!(number(&pose["error_m_max"]) < 0.10, "{pose}");
    assert!(
        number(&pose["error_rad_max"]) < 2.0_f64.to_radians(),
        "{pose}"
    );
}

#[test]
fn a_robot_whose_wheels_spin_arrives_where_its_goal_is() {
    for seed in ["1", "2"] {
        let result = lockstep("tests/scenarios/spinning_wheels.toml", &["--seed", seed]);
        let pose = &result["pose"];
        assert!(
            number(&pose["odometry_error_m_max"]) > 2.0,
            "{seed}: {pose}"
        );
        assert!(number(&pose["error_m_max"]) < 0.15, "{seed}: {pose}");
    }
}

/// To a lidar that is wrong by centimetres walls seem to move while the wheels spin.
#[test]
fn a_short_sighted_robot_whose_wheels_spin_arrives_where_its_goal_is() {
    for seed in ["1", "3"] {
        let scenario = "tests/scenarios/spinning_wheels_short_sight.toml";
        let result = lockstep(scenario, &["--seed", seed]);
        let pose = &result["pose"];
        assert!(
            number(&pose["odometry_error_m_max"]) > 0.5,
            "{seed}: {pose}"
        );
        assert!(number(&pose["error_m_max"]) < 0.3, "{seed}: {pose}");
    }
}

#[test]
fn a_narrow_door_that_is_open_is_not_closed_by_looking_at_it_from_afar() {
    for seed in ["1", "5"] {
        lockstep("tests/scenarios/far_narrow_door.toml", &["--seed", seed]);
    }
}

#[test]
fn robot_drives_among_dynamic_obstacles_and_scores_its_tracking() {
    // At 0.3 m/s a walker needs two thirds of a second for the 0.2 m that make it a moving one.
    for (scenario, movers, delay_s_max) in [("moving_discs", 5, 1.0), ("crossing_walkers", 2, 1.5)]
    {
        let result = lockstep(&format!("launch/scenarios/{scenario}.toml"), &[]);
        let tracking = &result["tracking"];
        eprintln!("{scenario}: {tracking}");
        assert!(tracking["found"].as_u64() >= Some(movers), "{tracking}");
        let delay_s = number(&tracking["detection_delay_s_median"]);
        assert!((0.1..=delay_s_max).contains(&delay_s), "{tracking}");
        let rmse_mps = number(&tracking["velocity_rmse_mps"]);
        assert!((0.001..0.4).contains(&rmse_mps), "{tracking}");
    }
}
