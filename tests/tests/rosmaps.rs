//! Real maps: every one loads, and the robot drives on them.

use zeronav_tests::{shared_data, workspace, zeronav};
use zeronav_world::Occupancy;

#[test]
fn every_map_loads_and_has_room_and_walls() {
    let Some(folder) = shared_data("rosmaps") else {
        return;
    };
    let mut count = 0;
    for entry in std::fs::read_dir(&folder).expect("the folder").flatten() {
        let file = entry.path();
        if file.extension().is_none_or(|extension| extension != "yaml") {
            continue;
        }
        let loaded = zeronav_world::map_file::load(&file)
            .unwrap_or_else(|error| panic!("{}: {error}", file.display()));
        let map = loaded.map;
        assert_eq!(map.cells.len(), map.geometry.len(), "{}", file.display());
        for wanted in [Occupancy::Free, Occupancy::Occupied] {
            assert!(
                map.count(wanted) > 100,
                "{}: no {wanted:?} cells",
                file.display()
            );
        }
        count += 1;
    }
    assert!(count >= 5, "{count} maps");
}

/// How far beside the goal's tolerance the robot may really stand. [m]
const POSE_ERROR_M: f64 = 0.1;

/// Drives the scenario in lockstep: it arrives, touches nothing, has driven so far, and stands
/// where it was sent, whatever its odometry says.
#[track_caller]
fn drives(scenario_name: &str, driven_m_min: f64) {
    if shared_data("rosmaps").is_none() {
        return;
    }
    let file = workspace().join(format!("tests/scenarios/{scenario_name}.toml"));
    let file = file.to_str().expect("a path");
    let result = zeronav(&["run", file, "--lockstep", "--headless", "--json"]).expect(0);
    assert_eq!(result["reached"], true, "{result:#}");
    assert_eq!(result["contacts"], 0);
    let driven_m = result["driven_m"].as_f64().expect("metres");
    assert!(driven_m >= driven_m_min, "{driven_m} m");
    let text = std::fs::read_to_string(file).expect("the scenario");
    let scenario: toml::Table = text.parse().expect("TOML");
    let goal = scenario["goals"].as_array().and_then(|goals| goals.last());
    let goal = goal.expect("a goal");
    let coordinate = |n: usize| {
        let aim = goal["pose"][n].as_float().expect("metres");
        let is = result["pose"]["true_pose_last"][n].as_f64();
        is.expect("metres") - aim
    };
    let off_m = f64::hypot(coordinate(0), coordinate(1));
    let tolerance_m = goal.get("tolerance_m").and_then(toml::Value::as_float);
    let most_m = tolerance_m.unwrap_or(0.25) + POSE_ERROR_M;
    eprintln!(
        "{scenario_name}: {off_m:.3} m from the goal, {}",
        result["pose"]
    );
    assert!(off_m <= most_m, "{off_m} m from the goal");
}

#[test]
fn a_real_map_is_driven_on() {
    drives("turtlebot3_world", 5.0);
}

#[test]
fn twenty_metres_among_the_pillars_of_turtlebot3_world() {
    drives("drive_turtlebot3_world", 20.0);
}

#[test]
fn twenty_metres_through_the_depot() {
    drives("drive_nav2_depot", 20.0);
}

#[test]
fn twenty_metres_through_the_small_warehouse() {
    drives("drive_aws_small_warehouse", 20.0);
}

#[test]
fn twenty_metres_of_the_race_track() {
    drives("drive_f1t_columbia", 20.0);
}
