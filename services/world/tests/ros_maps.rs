//! Maps of the ROS world load as their authors meant them. The maps are not part of the project:
//! without the folder `../shared/data` beside the workspace this says so and passes.

use std::path::PathBuf;
use zeronav_msgs::{Cell, Pose};
use zeronav_world::map_file::{load, save};
use zeronav_world::{Footprint, Occupancy, World, WorldSpec};

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

fn folder() -> Option<PathBuf> {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data/rosmaps");
    if folder.is_dir() {
        return Some(folder);
    }
    eprintln!("SKIPPED: there are no maps in {}", folder.display());
    None
}

#[test]
fn every_map_loads_cell_by_cell() {
    let Some(folder) = folder() else { return };
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

#[test]
fn a_map_survives_being_saved() {
    let Some(folder) = folder() else { return };
    let map = load(&folder.join("turtlebot3_world.yaml")).unwrap().map;
    let saved = tempfile::tempdir().unwrap();
    let file = save(&map, saved.path(), "again").unwrap();
    assert_eq!(load(&file).unwrap().map, map);
}

#[test]
fn a_large_map_becomes_a_world_that_agrees_with_its_cells() {
    let Some(folder) = folder() else { return };
    let spec = WorldSpec::of_map(folder.join("nav2_100by100_15.yaml"));
    let (world, _) = World::load(&spec).unwrap();
    let map = world.static_map().unwrap();
    let area_m2: f64 = world
        .occupied_rectangles()
        .iter()
        .map(parry2d::bounding_volume::Aabb::volume)
        .sum();
    let cells_m2 = 597_917.0 * 0.05 * 0.05;
    assert!((area_m2 - cells_m2).abs() < 1e-6, "{area_m2} {cells_m2}");
    let disc = Footprint::disc(0.2).unwrap();
    for y in (7..2000).step_by(97) {
        for x in (3..2000).step_by(53) {
            let at = map.geometry.centre_of(Cell::new(x, y));
            // Around the disc, cell by cell.
            let mut touches = false;
            for dy in -5..=5 {
                for dx in -5..=5 {
                    let gap = |d: i32| (f64::from(d.abs()) * 0.05 - 0.025).max(0.0);
                    let occupied = map.get(Cell::new(x + dx, y + dy)) == Some(Occupancy::Occupied);
                    touches |= occupied && gap(dx).hypot(gap(dy)) <= 0.2;
                }
            }
            let pose = Pose::new(at.x, at.y, 0.0);
            assert_eq!(world.touches(&disc, &pose), touches, "cell {x} {y}");
        }
    }
}
