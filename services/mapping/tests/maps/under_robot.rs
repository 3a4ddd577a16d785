//! The cells under the robot are free, and only there.

use crate::support::{Room, config, description};
use zeronav_mapping::{Mapping, Observation};
use zeronav_msgs::map::{COST_LETHAL, FLAG_SENSED};
use zeronav_msgs::{Cell, Pose};

#[test]
fn only_the_cells_under_the_robot_of_now_are_cleared() {
    let mut room = Room::walled(160, 80, 2);
    let known = room.as_static_map();
    let mut mapping = Mapping::new(&config(&room), Some(&known), &description(), &[]).unwrap();
    let mut n = 0;
    let mut look = |mapping: &mut Mapping, room: &Room, at: Pose| {
        let (scan, ranges) = room.scan(&at);
        n += 1;
        mapping.take_in(&Observation {
            scan: &scan,
            ranges: &ranges,
            run_ns: n * 100_000_000,
            odom_from_base_first: at,
            odom_from_base: at,
            odometry_variance: [0.0; 3],
            goal: None,
            told: None,
        });
    };
    let (before, now) = (room.pose(40.5, 40.5, 0.0), room.pose(90.5, 40.5, 0.0));
    for _ in 0..3 {
        look(&mut mapping, &room, before);
    }
    look(&mut mapping, &room, now);
    // Something is put where the robot stood.
    room.fill(38, 38, 43, 43, true);
    for _ in 0..4 {
        look(&mut mapping, &room, now);
    }
    let geometry = *mapping.mapper().geometry();
    let cell = |x, y| mapping.mapper().cells()[geometry.index_of(Cell::new(x, y)).unwrap()];
    let face = cell(42, 40);
    assert!(
        face.flags & FLAG_SENSED != 0 && face.cost == COST_LETHAL,
        "{face:?}"
    );
    assert!(cell(90, 40).cost < COST_LETHAL);
}
