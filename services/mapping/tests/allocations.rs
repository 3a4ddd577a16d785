//! Nothing is allocated per scan.

mod support;

use support::{Room, config, description};
use zeronav_casts::Cast;
use zeronav_mapping::localiser::CorrectionMode;
use zeronav_mapping::{Mapping, Observation};
use zeronav_msgs::obstacles::Obstacle;

/// A robot that drives a circle past a box that comes and goes, with tracking and pose correction
/// on: after the first round no scan allocates.
#[test]
fn no_scan_allocates_once_they_repeat_themselves() {
    let room = Room::walled(400, 400, 3);
    let mut with_box = room.clone();
    with_box.fill(240, 200, 250, 210, true);
    let mut config = config(&room);
    config.pose_correction.mode = CorrectionMode::On;
    let mut mapping =
        Mapping::new(&config, Some(&room.as_static_map()), &description(), &[]).unwrap();
    let mut tiles = Vec::with_capacity(1000);
    let mut obstacles: Vec<Obstacle> = Vec::with_capacity(200);
    let mut worst = 0;
    for n in 0..400_u64 {
        let angle = core::f64::consts::TAU * (n % 100).to_f64() / 100.0;
        let from = room.pose(
            200.0 + 20.0 * angle.cos(),
            180.0 + 20.0 * angle.sin(),
            angle,
        );
        let seen = if n % 20 < 10 { &room } else { &with_box };
        let (scan, ranges) = seen.scan(&from);
        let allocated = allocation_counter::measure(|| {
            mapping.take_in(&Observation {
                scan: &scan,
                ranges: &ranges,
                run_ns: n * 100_000_000,
                odom_from_base_first: from,
                odom_from_base: from,
                odometry_variance: [0.01; 3],
                goal: None,
                told: None,
            });
            tiles.clear();
            mapping.mapper_mut().take_dirty_tiles(&mut tiles);
            obstacles.clear();
            obstacles.extend(mapping.obstacles());
        });
        if n >= 200 {
            worst = worst.max(allocated.count_total);
        }
    }
    assert_eq!(worst, 0, "allocations in one scan");
}
