//! The map where the robot goes, and the map as a file.

use crate::support::{Room, config, description};
use zeronav_mapping::window::{WindowConfig, WindowMode};
use zeronav_mapping::{Mapping, Observation, all_tiles};
use zeronav_msgs::map::{COST_LETHAL, FLAG_UNKNOWN};
use zeronav_msgs::{GridGeometry, MapCell};
use zeronav_world::Occupancy;
use zeronav_world_files::map_file;

/// A robot that drives from the left half of a long room, which is all the map begins with, to
/// its right end.
fn drive(mode: WindowMode) -> (Room, Mapping, usize) {
    let mut room = Room::walled(480, 120, 3);
    room.fill(200, 50, 210, 60, true);
    let mut config = config(&room);
    if let Some([_, high]) = &mut config.area_m {
        high[0] -= 12.0;
    }
    config.window = WindowConfig {
        mode,
        margin_m: 2.0,
        tiles_max: 200,
    };
    let mut mapping = Mapping::new(&config, None, &description(), &[]).unwrap();
    let mut moves = 0;
    let mut tiles = Vec::new();
    for n in 0..80_u32 {
        let from = room.pose(40.5 + 5.0 * f64::from(n), 30.5, 0.0);
        let (scan, ranges) = room.scan(&from);
        mapping.take_in(&Observation {
            scan: &scan,
            ranges: &ranges,
            run_ns: u64::from(n) * 100_000_000,
            odom_from_base_first: from,
            odom_from_base: from,
            odometry_variance: [0.0; 3],
            goal: None,
            told: None,
        });
        tiles.clear();
        mapping.mapper_mut().take_dirty_tiles(&mut tiles);
        if mapping.take_moved() {
            moves += 1;
            // Everything is new to readers.
            assert_eq!(
                tiles,
                all_tiles(mapping.mapper().geometry()).collect::<Vec<_>>()
            );
        }
    }
    (room, mapping, moves)
}

fn at(mapping: &Mapping, room: &Room, x: f64, y: f64) -> Option<MapCell> {
    let cell = mapping
        .mapper()
        .geometry()
        .cell_at(room.pose(x, y, 0.0).point())?;
    mapping.mapper().view().get(cell)
}

#[test]
fn a_growing_map_holds_everything_that_was_seen() {
    let (room, mapping, moves) = drive(WindowMode::Growing);
    assert!(moves >= 2, "{moves}");
    // The box, the wall at the far end, and the free space where it began.
    assert_eq!(at(&mapping, &room, 200.5, 50.5).unwrap().cost, COST_LETHAL);
    assert_eq!(at(&mapping, &room, 477.5, 30.5).unwrap().cost, COST_LETHAL);
    let free = at(&mapping, &room, 40.5, 30.5).unwrap();
    assert_eq!((free.cost, free.flags), (0, 0));
}

#[test]
fn a_rolling_map_keeps_its_size_and_forgets_what_is_behind() {
    let (room, mapping, moves) = drive(WindowMode::Rolling);
    assert!(moves >= 2, "{moves}");
    let geometry: &GridGeometry = mapping.mapper().geometry();
    assert_eq!((geometry.width, geometry.height), (240, 120));
    assert_eq!(at(&mapping, &room, 40.5, 30.5), None);
    assert_eq!(at(&mapping, &room, 477.5, 30.5).unwrap().cost, COST_LETHAL);
}

#[test]
fn a_fixed_map_stays_where_it_is() {
    let (room, mapping, moves) = drive(WindowMode::Fixed);
    assert_eq!(moves, 0);
    assert_eq!(at(&mapping, &room, 477.5, 30.5), None);
}

#[test]
fn a_saved_map_is_loaded_again() {
    let (_, mapping, _) = drive(WindowMode::Growing);
    let map = mapping.mapper().as_static_map();
    let unknown = map.count(Occupancy::Unknown);
    assert!(unknown > 0 && map.count(Occupancy::Occupied) > 100);
    let flagged = mapping.mapper().cells().iter();
    let flagged = flagged
        .filter(|cell| cell.flags & FLAG_UNKNOWN != 0)
        .count();
    assert_eq!(unknown, flagged);
    let folder = tempfile::tempdir().unwrap();
    let file = map_file::save(&map, folder.path(), "map").unwrap();
    let loaded = map_file::load(&file).unwrap();
    assert_eq!(loaded.map.cells, map.cells);
    assert_eq!(loaded.warnings, []);
    let text = std::fs::read_to_string(&file).unwrap();
    assert!(text.contains("free_thresh: 0.196"), "{text}");
}
