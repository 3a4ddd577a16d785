//! Map files of the ROS world, ours and those of others: every one loads, and the robot drives on
//! them.

use std::path::Path;
use zeronav_tests::data::{external_data, files, shipped_data};
use zeronav_tests::{Zeronav, workspace};
use zeronav_world::Occupancy;

/// Every map of a folder loads and has room and walls; how many there are.
fn every_map_has_room_and_walls(folder: &Path) -> usize {
    let maps = files(folder, "yaml");
    for file in &maps {
        let loaded = zeronav_world_files::map_file::load(file)
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
    }
    maps.len()
}

#[test]
fn every_shipped_map_loads_and_has_room_and_walls() {
    assert_eq!(every_map_has_room_and_walls(&shipped_data("rosmaps")), 4);
}

#[test]
#[ignore = "needs rosmaps at $ZERONAV_DATA"]
fn every_map_loads_and_has_room_and_walls_on_external_data() {
    assert!(every_map_has_room_and_walls(&external_data("rosmaps")) >= 5);
}

/// How far outside the goal's tolerance the robot may really stop. [m]
const POSE_ERROR_M: f64 = 0.1;

/// Drives the scenario in lockstep: it arrives, touches nothing, has driven so far, and stops
/// where it was sent, whatever its odometry says.
#[track_caller]
fn drives(text: &str, driven_m_min: f64) {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("it.toml"), text).expect("written");
    let arguments = ["run", "./it.toml", "--lockstep", "--headless", "--json"];
    let result = Zeronav::start_in(folder, &arguments).finish().expect(0);
    assert_eq!(result["reached"], true, "{result:#}");
    assert_eq!(result["contacts"], 0);
    let driven_m = result["driven_m"].as_f64().expect("metres");
    assert!(driven_m >= driven_m_min, "{driven_m} m");
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
        "{}: {off_m:.3} m from the goal, {}",
        scenario["title"], result["pose"]
    );
    assert!(off_m <= most_m, "{off_m} m from the goal");
}

/// The scenario of this name with its map's path in front: `folder` is what the path counts from.
fn scenario(name: &str, relative: &str, folder: &Path) -> String {
    let file = workspace().join(format!("tests/scenarios/{name}.toml"));
    let text = std::fs::read_to_string(&file).expect("the scenario");
    let maps = format!("map = \"{relative}");
    assert!(text.contains(&maps), "{name} names no map in {relative}");
    text.replace(&maps, &format!("map = \"{}/", folder.display()))
}

fn drives_on_external_data(name: &str, driven_m_min: f64) {
    let maps = external_data("rosmaps");
    drives(
        &scenario(&format!("external_data/{name}"), "rosmaps/", &maps),
        driven_m_min,
    );
}

#[test]
fn twenty_metres_through_the_drawn_rooms() {
    let maps = shipped_data("rosmaps");
    drives(&scenario("drive_rooms", "../data/rosmaps/", &maps), 20.0);
}

#[test]
#[ignore = "needs rosmaps at $ZERONAV_DATA"]
fn a_real_map_is_driven_on_external_data() {
    drives_on_external_data("turtlebot3_world", 5.0);
}

#[test]
#[ignore = "needs rosmaps at $ZERONAV_DATA"]
fn twenty_metres_of_turtlebot3_world_on_external_data() {
    drives_on_external_data("drive_turtlebot3_world", 20.0);
}

#[test]
#[ignore = "needs rosmaps at $ZERONAV_DATA"]
fn twenty_metres_of_the_depot_on_external_data() {
    drives_on_external_data("drive_nav2_depot", 20.0);
}

#[test]
#[ignore = "needs rosmaps at $ZERONAV_DATA"]
fn twenty_metres_of_the_small_warehouse_on_external_data() {
    drives_on_external_data("drive_aws_small_warehouse", 20.0);
}

#[test]
#[ignore = "needs rosmaps at $ZERONAV_DATA"]
fn twenty_metres_of_the_race_track_on_external_data() {
    drives_on_external_data("drive_f1t_columbia", 20.0);
}
