//! What helpers of the contract say, against values worked out by hand.

use std::f64::consts::FRAC_PI_2;
use zeronav_msgs::command::{VelocityCommand, VelocityRequest};
use zeronav_msgs::header::Id;
use zeronav_msgs::health::reason_labels;
use zeronav_msgs::map::{MapInfo, MapTile, clearance_mm, tiles_of};
use zeronav_msgs::odometry::Odometry;
use zeronav_msgs::path::{Path, PathCause, PathStatus, Waypoint};
use zeronav_msgs::scan::Scan;
use zeronav_msgs::seats::SEATS;
use zeronav_msgs::stages::Stage;
use zeronav_msgs::task::PoseEstimate;
use zeronav_msgs::topics::{
    ControlRequest, Discipline, HEALTH, MapKeyframe, PlanPath, RobotCommand, RobotDescription,
    RobotOdometry, RobotScan, SPANS, ScanEnvelope, Topic, TopicRow, decode, health_of, seal,
};
use zeronav_msgs::{Cell, GridGeometry, Header, MapCell, Pose, Refusal, Role};

#[test]
fn identities_hold_epoch_and_count() {
    let id = Id::new(3, 5);
    assert_eq!((id.0, id.epoch(), id.count()), ((3 << 40) + 5, 3, 5));
    assert_eq!(
        (id.next(), id.to_string()),
        (Id::new(3, 6), "3:5".to_owned())
    );
    assert!(id.is_some() && !Id::NONE.is_some());
    let last = Id::new(u32::MAX >> 8, (1 << 40) - 1);
    assert_eq!((last.epoch(), last.count()), (u32::MAX >> 8, (1 << 40) - 1));
    assert_eq!(
        Id::new(1, (1 << 40) + 7).count(),
        7,
        "a count beyond its bits stays out of the epoch"
    );
}

#[test]
fn poses_compose_and_measure() {
    // Cosine 0.8, sine 0.6.
    let pose = Pose::new(1.0, 2.0, 3.0_f64.atan2(4.0));
    let there = pose.transform(nalgebra::Point2::new(3.0, 0.5));
    assert!((there.x - 3.1).abs() < 1e-12 && (there.y - 4.2).abs() < 1e-12);
    assert!((pose.distance_m(&Pose::new(4.0, 6.0, 1.0)) - 5.0).abs() < 1e-12);
    let estimate = PoseEstimate {
        map_from_base: Pose::new(5.0, 1.0, FRAC_PI_2),
        odom_from_base: Pose::new(2.0, 0.0, 0.0),
        ..PoseEstimate::default()
    };
    let map_from_odom = estimate.map_from_odom();
    let again = map_from_odom.then(&estimate.odom_from_base);
    assert!(again.distance_m(&estimate.map_from_base) < 1e-12);
    assert!((map_from_odom.yaw_rad - FRAC_PI_2).abs() < 1e-12);
    assert!((map_from_odom.x_m - 5.0).abs() < 1e-12 && (map_from_odom.y_m + 1.0).abs() < 1e-12);
}

#[test]
fn a_path_knows_its_length_and_planner() {
    let waypoint = |x_m, y_m| Waypoint {
        x_m,
        y_m,
        ..Waypoint::default()
    };
    let waypoints = [waypoint(1.0, 1.0), waypoint(4.0, 5.0), waypoint(4.0, 7.0)];
    let path = Path::new(
        "theta_star",
        PathStatus::Found,
        PathCause::Obstacle,
        9,
        &waypoints,
    );
    assert!((path.length_m - 7.0).abs() < 1e-12 && (path.cost - 7.0).abs() < 1e-12);
    assert_eq!(
        (path.n_waypoints, path.goal, path.planner()),
        (3, 9, "theta_star")
    );
    assert_eq!(
        (path.status(), path.cause()),
        (Some(PathStatus::Found), Some(PathCause::Obstacle))
    );
    assert_eq!(path.check(&waypoints), Ok(()));
    let long = Path {
        planner: Path::planner_bytes("a planner with a very long key"),
        ..path
    };
    assert_eq!(long.planner(), "a planner with a very lo");
    let foreign = Path {
        planner: [0xff; 24],
        ..path
    };
    assert_eq!(foreign.planner(), "");
}

#[test]
fn reasons_and_roles_have_words() {
    assert_eq!(reason_labels(0), [""; 0]);
    assert_eq!(reason_labels(0b1000_0101), ["scan", "map", "too_long"]);
    assert_eq!(Role::from_label("local_planner"), Some(Role::LocalPlanner));
    assert_eq!(Role::from_label("nobody"), None);
    assert_eq!(Role::Robot.doorbell(), "doorbell/robot");
    for (role, row) in Role::SERVICES.iter().zip(&HEALTH) {
        assert_eq!(health_of(*role).map(|row| row.name), Some(row.name));
    }
    assert!(health_of(Role::Launch).is_none());
}

/// Buffer, that of a service, borrowed, history, writers, pool.
fn numbers(row: &TopicRow) -> [usize; 6] {
    [
        row.buffer(),
        row.service_buffer(),
        row.borrowed(),
        row.history(),
        row.writers_max(),
        row.pool(),
    ]
}

#[test]
fn every_discipline_has_its_memory() {
    // A pool holds the buffer, what 12 readers borrow, the history, and two to write.
    assert_eq!(numbers(RobotScan::ROW), [32, 2, 2, 0, 4, 32 + 24 + 2]);
    assert_eq!(
        numbers(RobotDescription::ROW),
        [32, 2, 2, 1, 4, 32 + 24 + 1 + 2]
    );
    assert_eq!(numbers(&SPANS), [1024, 1024, 1, 0, 16, 1024 + 12 + 2]);
    assert_eq!(numbers(MapKeyframe::ROW), [2, 2, 2, 1, 4, 4]);
    assert_eq!(PlanPath::ROW.discipline, Discipline::Latest);
    // 64 + 160 + 10 x 4 up to the next 8, 58 times.
    assert_eq!(RobotScan::ROW.segment_bytes(10), 58 * (64 + 160 + 40));
    assert_eq!(RobotScan::ROW.segment_bytes(9), 58 * (64 + 160 + 40));
    assert_eq!(RobotScan::ROW.segment_bytes(0), 58 * (64 + 160));
}

#[test]
fn a_seat_writes_what_bears_its_name_alone() {
    let written = SEATS.iter().map(|seat| {
        let names: Vec<_> = seat.writes().iter().map(|row| row.name).collect();
        (seat.role, names)
    });
    let guard = written
        .clone()
        .find(|(role, _)| *role == Role::CollisionGuard);
    assert_eq!(
        guard,
        Some((Role::CollisionGuard, vec![RobotCommand::ROW.name]))
    );
    let planner = written
        .clone()
        .find(|(role, _)| *role == Role::GlobalPlanner);
    assert_eq!(
        planner,
        Some((Role::GlobalPlanner, vec![PlanPath::ROW.name]))
    );
}

#[test]
fn tiles_cover_the_map_and_are_cut_at_its_edge() {
    let geometry = GridGeometry {
        width: 40,
        height: 32,
        resolution_m: 0.1,
        ..GridGeometry::default()
    };
    assert_eq!(tiles_of(&geometry), (2, 1));
    let tile = MapTile {
        tile_x: 1,
        ..MapTile::default()
    };
    let rect = tile.rect(&geometry);
    assert_eq!((rect.min, rect.max), (Cell::new(32, 0), Cell::new(40, 32)));
    // What lies beyond the edge is unknown.
    let cells = vec![
        MapCell {
            cost: 7,
            flags: 1,
            clearance_mm: 9
        };
        geometry.len()
    ];
    let mut filled = tile;
    filled.fill_from(&geometry, &cells);
    for (n, cell) in filled.cells.iter().enumerate() {
        let expected = if n % 32 < 8 {
            cells[0]
        } else {
            MapCell::unknown(0)
        };
        assert_eq!(*cell, expected, "cell {n}");
    }
    // Far beyond the map there is nothing to copy.
    let beside = MapTile {
        tile_x: u32::MAX >> 1,
        tile_y: 3,
        ..tile
    };
    assert_eq!(beside.copy_to(&geometry, &mut cells.clone()), None);
    let last = |part, parts| {
        MapInfo {
            part,
            parts,
            ..MapInfo::default()
        }
        .is_last_part()
    };
    assert_eq!([last(0, 1), last(0, 2), last(1, 2)], [true, false, true]);
}

#[test]
fn clearances_are_rounded_down_and_saturate() {
    for (clearance_m, limit_mm, expected) in [
        (0.0, 500, 0),
        (-0.1, 500, 0),
        (0.1239, 500, 123),
        // 0.29 x 1000 is 289.99999999999994
        (0.29, 500, 290),
        (0.5, 500, 500),
        (0.7, 500, 500),
        (99.0, u16::MAX, u16::MAX),
    ] {
        assert_eq!(
            clearance_mm(clearance_m, limit_mm),
            expected,
            "{clearance_m} m"
        );
    }
}

#[test]
fn every_stage_has_its_words() {
    let words = |role| {
        Stage::of(role)
            .iter()
            .map(|stage| stage.label())
            .collect::<Vec<_>>()
    };
    assert_eq!(words(Role::Robot), ["step", "ray casting"]);
    assert_eq!(
        words(Role::Mapping),
        ["localise", "track", "ray casting", "clearance"]
    );
    assert_eq!(
        words(Role::GlobalPlanner),
        ["map", "search", "smooth", "settle"]
    );
    assert_eq!(
        words(Role::LocalPlanner),
        ["prepare", "look", "rollouts", "verify"]
    );
}

/// Whatever is changed after a message was sealed, its reader notices.
#[test]
fn a_sealed_message_is_rejected_once_it_was_changed() {
    let row = RobotScan::ROW;
    let header = Header {
        role: Role::Robot.code(),
        schema: u32::try_from(row.schema & 0xffff_ffff).expect("32 bits"),
        id: Id::new(1, 1).0,
        ..Header::default()
    };
    let scan = Scan {
        n_beams: 1,
        angle_increment_rad: 0.1,
        range_m_max: 10.0,
        ..Scan::default()
    };
    let sealed = seal::<RobotScan>(header, scan, &[1.0]);
    let check = |envelope: &ScanEnvelope, range_m| decode::<RobotScan>(row, envelope, &[range_m]);
    assert_eq!(check(&sealed, 1.0), Ok(()));
    let wrong = Err(Refusal::Checksum);
    assert_eq!(check(&sealed, 1.5), wrong);
    let mut other = sealed;
    other.meta.sensor = 1;
    assert_eq!(check(&other, 1.0), wrong);
    other = sealed;
    other.header.tick = 1;
    assert_eq!(check(&other, 1.0), wrong);
}

/// A message of fixed fields alone is not accepted with an item behind them.
#[test]
fn topics_without_items_refuse_items() {
    fn check<T: Topic<Item = u8>>(meta: T::Meta) {
        let row = T::ROW;
        let header = Header {
            role: row.writers[0].code(),
            schema: u32::try_from(row.schema & 0xffff_ffff).expect("32 bits"),
            id: Id::new(1, 1).0,
            ..Header::default()
        };
        let decoded = |items: &[u8]| decode::<T>(row, &seal::<T>(header, meta, items), items);
        assert_eq!(decoded(&[]), Ok(()), "{}", row.name);
        assert_eq!(decoded(&[0]), Err(Refusal::Length("items")), "{}", row.name);
    }
    check::<RobotOdometry>(Odometry::default());
    check::<ControlRequest>(VelocityRequest::default());
    check::<RobotCommand>(VelocityCommand::default());
}
