//! The shipped scenarios of local planning, one test each: driven in lockstep by the real processes
//! with the default controller, judged by what is really so, as their files expect it.

use serde_json::Value;
use zeronav_tests::{workspace, zeronav};

/// Drives a scenario and accepts nothing but its verdict.
fn drive(scenario: &str) -> Value {
    let result = zeronav(&["run", scenario, "--lockstep", "--headless", "--json"]).expect(0);
    assert_eq!(result["verdict"], "pass", "{result:#}");
    assert_eq!(result["contacts"], 0, "{result:#}");
    result
}

macro_rules! drives {
    ($($scenario:ident)*) => {
        $(
            #[test]
            fn $scenario() {
                drive(stringify!($scenario));
            }
        )*

        /// What [`drives!`] has a test for.
        const DRIVES: &[&str] = &[$(stringify!($scenario)),*];
    };
}

drives! {
    u_trap_1m
    u_trap_4m
    door
    goal_near_wall_5cm
    goal_near_wall_10cm
    goal_near_wall_20cm
    symmetric_post
    drop_box_0_8m
    drop_box_1_2m
    drop_box_2m
    oncoming_cart
    oncoming_person
    crossing_person_0_5mps
    crossing_person_1mps
    crossing_person_1_5mps
    blackout_0_2s
    blackout_0_5s
    blackout_2s
    blackout_invalid
    frozen_scan
    turned_scan
    odometry_jump
    slip
    hostile_planner_full_speed
    narrow_passage
}

/// What other tests of this folder drive.
const ELSEWHERE: [&str; 14] = [
    "blocked_aisle",
    "closed_aisle",
    "crossing_cart",
    "crossing_walkers",
    "door_closes",
    "hostile_planner_nan",
    "killed_planner",
    "moving_discs",
    "open_aisle",
    "sealed",
    "swap_planner",
    "unsealed",
    "u_trap",
    "zone_around_robot",
];

#[test]
fn every_scenario_that_is_listed_is_driven_by_a_test() {
    let listed = zeronav(&["list", "--json"]).expect(0);
    let rows = listed["scenarios"].as_array().expect("scenarios");
    assert!(rows.len() >= DRIVES.len(), "{} scenarios", rows.len());
    for row in rows {
        let name = row["name"].as_str().expect("a name");
        let is_driven = DRIVES.contains(&name) || ELSEWHERE.contains(&name);
        assert!(is_driven, "{name} has no test");
        let group = row["group"].as_str().expect("a group");
        assert!(!group.is_empty(), "{name} is in no group");
    }
}

#[test]
fn a_scenario_with_variants_is_run_by_its_own_name_too() {
    let own = drive("u_trap");
    let variant = drive("u_trap_1m");
    assert_eq!(own["scenario"], "u_trap");
    assert_eq!(own["run_hash"], variant["run_hash"]);
}

/// `beam` searches only among what moves; the rest is `dwa_t`, bit for bit.
#[test]
fn where_nothing_moves_the_default_controller_is_dwa_t() {
    let folder = tempfile::tempdir().expect("a folder");
    for scenario in ["door", "symmetric_post"] {
        let shipped = workspace().join(format!("launch/scenarios/{scenario}.toml"));
        let mut text = std::fs::read_to_string(shipped).expect("a scenario");
        text += "\n[services.local_planner]\nconfig.controller = \"dwa_t\"\n";
        let file = folder.path().join(format!("{scenario}.toml"));
        std::fs::write(&file, text).expect("written");
        let (beam, dwa_t) = (drive(scenario), drive(file.to_str().expect("a path")));
        assert!(beam["time_s"].as_f64() > Some(3.0), "{scenario}: {beam:#}");
        for same in ["time_s", "motion", "track_m"] {
            assert_eq!(beam[same], dwa_t[same], "{scenario}: {same}");
        }
    }
}

#[test]
fn planner_requesting_nan_does_not_move_the_robot() {
    let result = drive("hostile_planner_nan");
    assert!(result["driven_m"].as_f64().expect("metres") < 0.01);
}

/// The kill comes when launch sees its time, so the tick differs from run to run; the end does not.
#[test]
fn a_killed_planner_is_replaced_and_the_robot_arrives() {
    let result = drive("killed_planner");
    let restarts = result["restarts"].as_array().expect("restarts");
    assert_eq!(restarts.len(), 2, "{result:#}");
    for (restart, from_s) in restarts.iter().zip([3.0, 20.0]) {
        assert_eq!(restart["service"], "local_planner");
        let time_s = restart["time_s"].as_f64().expect("seconds");
        assert!((from_s..from_s + 2.0).contains(&time_s), "{restart:#}");
    }
}

#[test]
fn a_scenario_whose_binary_is_not_installed_is_not_offered() {
    let folder = tempfile::tempdir().expect("a folder");
    let alone = folder.path().join("zeronav");
    zeronav_tests::copy_binary("zeronav", folder.path());
    let listed = std::process::Command::new(&alone)
        .args(["list", "--json"])
        .current_dir(folder.path())
        .env_remove("CARGO")
        .env("PATH", "/usr/bin")
        .output()
        .expect("it runs");
    let listed: Value = serde_json::from_slice(&listed.stdout).expect("JSON");
    let rows = listed["scenarios"].as_array().expect("scenarios");
    let has = |name: &str| rows.iter().any(|row| row["name"] == name);
    assert!(has("blocked_aisle"), "{listed:#}");
    for name in [
        "hostile_planner_nan",
        "hostile_planner_full_speed",
        "swap_planner",
    ] {
        assert!(!has(name), "{name} is offered");
    }
}
