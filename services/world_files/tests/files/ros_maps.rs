//! Whole map files load as their authors meant them: a drawn one in every form, and, where the
//! environment names them, maps of the ROS world.

use super::data::{external_data, shipped_data};
use std::path::Path;
use zeronav_msgs::{Cell, Pose};
use zeronav_world::{Footprint, Occupancy, WorldSpec};
use zeronav_world_files::map_file::{load, save};

/// Name; columns and rows; occupied, free and unknown cells, counted by another program from the
/// same pixels.
const MAPS: [(&str, (u32, u32), [usize; 3]); 11] = [
    ("aws_small_warehouse", (286, 423), [3_673, 93_698, 23_607]),
    ("benchmr_intel_lab", (579, 581), [16_796, 306_261, 13_342]),
    ("f1t_berlin", (600, 600), [252_046, 107_954, 0]),
    ("f1t_columbia", (435, 350), [109_212, 43_024, 14]),
    ("f1t_mtl", (557, 502), [183_786, 95_828, 0]),
    ("nav2_100by100_10", (2000, 2000), [413_060, 3_586_940, 0]),
    ("nav2_100by100_15", (2000, 2000), [597_917, 3_402_083, 0]),
    ("nav2_depot", (604, 307), [5_947, 179_481, 0]),
    ("nav2_smoothers_world", (300, 300), [10_576, 79_424, 0]),
    ("tb3_sandbox", (384, 384), [870, 7_903, 138_683]),
    ("turtlebot3_world", (384, 384), [795, 7_939, 138_722]),
];

/// The drawn map: columns and rows; occupied, free and unknown cells, counted by another program
/// from the same pixels.
const DRAWN: ((u32, u32), [usize; 3]) = ((120, 80), [1_302, 6_605, 1_693]);

#[test]
fn every_form_of_the_drawn_map_is_the_same_map() {
    let folder = shipped_data("rosmaps");
    let load = |form: &str| {
        let loaded = load(&folder.join(format!("rooms_{form}.yaml"))).unwrap();
        assert!(loaded.warnings.is_empty(), "{form}: {:?}", loaded.warnings);
        loaded.map
    };
    let binary = load("p5");
    let found = [Occupancy::Occupied, Occupancy::Free, Occupancy::Unknown]
        .map(|occupancy| binary.count(occupancy));
    let size = (binary.geometry.width, binary.geometry.height);
    assert_eq!((size, found), DRAWN);
    // The pillar in the lower left room, its door, and what lies outside.
    let at = |x, y| binary.get(Cell::new(x, y));
    assert_eq!(at(14, 14), Some(Occupancy::Occupied));
    assert_eq!(at(28, 33), Some(Occupancy::Free));
    assert_eq!(at(2, 2), Some(Occupancy::Unknown));
    for form in ["p2", "png", "negative"] {
        assert!(load(form) == binary, "{form} differs from p5");
    }
}

#[test]
#[ignore = "needs rosmaps at $ZERONAV_DATA"]
fn every_map_loads_cell_by_cell_on_external_data() {
    let folder = external_data("rosmaps");
    for (name, (width, height), counts) in MAPS {
        let loaded = load(&folder.join(format!("{name}.yaml"))).unwrap();
        let map = loaded.map;
        assert_eq!(
            (map.geometry.width, map.geometry.height),
            (width, height),
            "{name}"
        );
        let found = [Occupancy::Occupied, Occupancy::Free, Occupancy::Unknown]
            .map(|occupancy| map.count(occupancy));
        assert_eq!(found, counts, "{name}");
        // Only the depot's threshold is above what map savers write for unknown cells.
        let n_warnings = usize::from(name == "nav2_depot");
        assert_eq!(loaded.warnings.len(), n_warnings, "{name}");
    }
}

#[track_caller]
fn survives_being_saved(file: &Path) {
    let map = load(file).unwrap().map;
    let saved = tempfile::tempdir().unwrap();
    let file = save(&map, saved.path(), "again").unwrap();
    assert_eq!(load(&file).unwrap().map, map);
}

#[test]
fn a_drawn_map_survives_being_saved() {
    survives_being_saved(&shipped_data("rosmaps").join("rooms_png.yaml"));
}

#[test]
#[ignore = "needs rosmaps at $ZERONAV_DATA"]
fn a_map_survives_being_saved_on_external_data() {
    survives_being_saved(&external_data("rosmaps").join("turtlebot3_world.yaml"));
}

/// The world of a map file has as much that is solid as the map, and a disc touches it where it
/// touches its cells; looked at on a lattice with these spacings of columns and rows.
#[track_caller]
fn agrees_with_its_cells(file: &Path, [columns, rows]: [usize; 2]) {
    let (world, _) = zeronav_world_files::load(&WorldSpec::of_map(file)).unwrap();
    let map = world.static_map().unwrap();
    let resolution_m = map.geometry.resolution_m;
    let area_m2: f64 = world
        .occupied_rectangles()
        .iter()
        .map(parry2d::bounding_volume::Aabb::volume)
        .sum();
    let n_occupied = u32::try_from(map.count(Occupancy::Occupied)).unwrap();
    let cells_m2 = f64::from(n_occupied) * resolution_m * resolution_m;
    assert!((area_m2 - cells_m2).abs() < 1e-6, "{area_m2} {cells_m2}");
    let radius_m = 4.0 * resolution_m;
    let disc = Footprint::disc(radius_m).unwrap();
    let (width, height) = map.geometry.size();
    let mut touched = [0, 0];
    for y in (7..height).step_by(rows) {
        for x in (3..width).step_by(columns) {
            let at = map.geometry.centre_of(Cell::new(x, y));
            // Around the disc, cell by cell.
            let mut touches = false;
            for dy in -5..=5 {
                for dx in -5..=5 {
                    let gap = |d: i32| (f64::from(d.abs()) - 0.5).max(0.0) * resolution_m;
                    let occupied = map.get(Cell::new(x + dx, y + dy)) == Some(Occupancy::Occupied);
                    touches |= occupied && gap(dx).hypot(gap(dy)) <= radius_m;
                }
            }
            let pose = Pose::new(at.x, at.y, 0.0);
            assert_eq!(world.touches(&disc, &pose), touches, "cell {x} {y}");
            touched[usize::from(touches)] += 1;
        }
    }
    assert!(touched.iter().all(|n| *n > 20), "{touched:?}");
}

#[test]
fn a_drawn_map_becomes_a_world_that_agrees_with_its_cells() {
    agrees_with_its_cells(&shipped_data("rosmaps").join("rooms_p5.yaml"), [2, 3]);
}

#[test]
#[ignore = "needs rosmaps at $ZERONAV_DATA"]
fn a_large_map_agrees_with_its_cells_on_external_data() {
    let file = external_data("rosmaps").join("nav2_100by100_15.yaml");
    agrees_with_its_cells(&file, [53, 97]);
}
