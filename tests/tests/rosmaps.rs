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

#[test]
fn a_real_map_is_driven_on() {
    if shared_data("rosmaps").is_none() {
        return;
    }
    let scenario = workspace().join("tests/scenarios/turtlebot3_world.toml");
    let scenario = scenario.to_str().expect("a path");
    let result = zeronav(&["run", scenario, "--lockstep", "--headless", "--json"]).expect(0);
    assert_eq!(result["reached"], true, "{result:#}");
    assert_eq!(result["contacts"], 0);
    let driven_m = result["driven_m"].as_f64().expect("metres");
    assert!(driven_m >= 5.0, "{driven_m} m");
}
