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

/// Drives the scenario in lockstep: it arrives, touches nothing, and has driven so far.
#[track_caller]
fn drives(scenario: &str, driven_m_min: f64) {
    if shared_data("rosmaps").is_none() {
        return;
    }
    let file = workspace().join(format!("tests/scenarios/{scenario}.toml"));
    let file = file.to_str().expect("a path");
    let result = zeronav(&["run", file, "--lockstep", "--headless", "--json"]).expect(0);
    assert_eq!(result["reached"], true, "{result:#}");
    assert_eq!(result["contacts"], 0);
    let driven_m = result["driven_m"].as_f64().expect("metres");
    assert!(driven_m >= driven_m_min, "{driven_m} m");
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
