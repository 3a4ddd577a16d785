//! Messages of others, with all that bags contain.

use super::*;
use proptest::prelude::*;
use zeronav_ros_messages::{cdr, messages, view};

const MS: u64 = 1_000_000;

fn scan(ms: u64, ranges: &[f32]) -> Vec<u8> {
    let scan = messages::LaserScan {
        header: messages::Header {
            stamp: view::time(ms * MS),
            frame_id: "laser".into(),
        },
        angle_min: -1.0,
        angle_max: 1.0,
        angle_increment: 0.5,
        time_increment: 0.0,
        scan_time: 0.1,
        range_min: 0.1,
        range_max: 10.0,
        ranges: ranges.to_vec(),
        intensities: Vec::new(),
    };
    cdr(&scan).expect("CDR")
}

fn odometry(ms: u64, x_m: f64) -> Vec<u8> {
    let odometry = zeronav_msgs::odometry::Odometry {
        pose: Pose::new(x_m, 0.0, 0.5),
        ..Default::default()
    };
    cdr(&view::odometry(ms * MS, &odometry)).expect("CDR")
}

fn transform(ms: u64, parent: &'static str, child: &'static str, x_m: f64) -> Vec<u8> {
    let pose = Pose::new(x_m, 0.0, 0.0);
    cdr(&view::transform(ms * MS, parent, child, &pose)).expect("CDR")
}

/// A bag with these messages, logged one after the other.
fn bag(messages: &[(&str, &'static str, Vec<u8>)]) -> Result<Log, String> {
    let topics = Topics::default();
    let mut bag = Bag::new(&topics);
    for (n, (topic, kind, data)) in messages.iter().enumerate() {
        bag.take(topic, kind, n as u64 * MS, data);
    }
    bag.into_log()
}

fn good(more: Vec<(&'static str, &'static str, Vec<u8>)>) -> Log {
    let mut messages = vec![
        ("/odom", ODOMETRY, odometry(1000, 0.0)),
        ("/scan", SCAN, scan(1050, &[1.0, 2.0, 3.0])),
        ("/odom", ODOMETRY, odometry(1100, 1.0)),
    ];
    messages.extend(more);
    bag(&messages).expect("a log")
}

#[test]
fn scans_odometry_and_the_place_of_the_lidar_are_read() {
    let log = good(vec![(
        "/tf_static",
        TF,
        transform(0, "base_link", "laser", 0.2),
    )]);
    assert_eq!((log.scans.len(), log.odometry.len()), (1, 2));
    assert_eq!(log.scans[0].ns, 1050 * MS);
    assert!((log.laser.x_m - 0.2).abs() < 1e-12);
    assert!((log.odometry[1].pose.yaw_rad - 0.5).abs() < 1e-9);
    let without = good(Vec::new());
    assert!(
        without
            .report
            .assumed
            .iter()
            .any(|it| it.starts_with("the lidar (laser)"))
    );
}

#[test]
fn ranges_of_others_are_infinite_zero_or_no_numbers() {
    let ranges = [f32::INFINITY, f32::NAN, 0.0, -1.0, 12.0, 5.0];
    let log = good(vec![
        ("/scan", SCAN, scan(1060, &ranges)),
        ("/scan", SCAN, scan(1070, &[])),
    ]);
    let cleaned = &log.scans[1].ranges;
    assert!(cleaned[0].is_infinite() && cleaned[4].is_infinite());
    assert!(cleaned[1..4].iter().all(|it| it.is_nan()), "{cleaned:?}");
    assert_eq!(log.scans.len(), 2, "one without beams is none");
    assert_eq!(log.report.mended["messages that cannot be read"], 1);
}

#[test]
fn stamps_come_twice_and_clocks_jump() {
    let log = good(vec![
        ("/scan", SCAN, scan(1050, &[1.0])),
        // The clock is set back by an hour while the robot drives.
        ("/odom", ODOMETRY, odometry(500_000, 1.0)),
        ("/scan", SCAN, scan(500_040, &[1.0])),
        ("/odom", ODOMETRY, odometry(500_100, 2.0)),
    ]);
    let scans: Vec<u64> = log.scans.iter().map(|it| it.ns / MS).collect();
    assert_eq!(scans, [1050, 1190]);
    let mended: Vec<_> = log.report.mended.keys().copied().collect();
    assert_eq!(mended.len(), 2, "{mended:?}");
}

#[test]
fn odometry_may_be_a_transform_that_is_late() {
    let log = bag(&[
        ("/tf", TF, transform(1000, "odom", "base_link", 0.0)),
        ("/scan", SCAN, scan(1050, &[1.0])),
        ("/tf", TF, transform(1200, "odom", "base_link", 2.0)),
        ("/tf", TF, transform(1100, "odom", "base_link", 1.0)),
        ("/tf", TF, transform(900, "map", "odom", 10.0)),
    ])
    .expect("a log");
    let x_m: Vec<f64> = log.odometry.iter().map(|it| it.pose.x_m).collect();
    assert_eq!(x_m, [0.0, 1.0, 2.0]);
    // What a localiser said are corrected poses.
    assert!(
        (log.corrected[0].pose.x_m - 10.5).abs() < 1e-9,
        "{:?}",
        log.corrected
    );
}

#[test]
fn what_nothing_can_be_driven_with_is_refused() {
    let error = bag(&[("/scan", SCAN, scan(1050, &[1.0]))]).expect_err("no odometry");
    assert!(error.contains("without odometry"), "{error}");
    let error = bag(&[("/odom", ODOMETRY, odometry(1, 0.0))]).expect_err("no scan");
    assert!(error.contains(SCAN), "{error}");
    let two = [
        ("/a", SCAN, scan(1050, &[1.0])),
        ("/b", SCAN, scan(1050, &[1.0])),
        ("/odom", ODOMETRY, odometry(1, 0.0)),
    ];
    let error = bag(&two).expect_err("two lidars");
    assert!(error.contains("--scan (/a, /b)"), "{error}");
}

/// A map of 2 x 2 cells but for what `change` does.
fn map(change: impl FnOnce(&mut messages::OccupancyGrid)) -> Vec<u8> {
    let mut map = messages::OccupancyGrid {
        header: messages::Header {
            stamp: view::time(MS),
            frame_id: "map".into(),
        },
        info: messages::MapMetaData {
            map_load_time: view::time(MS),
            resolution: 0.05,
            width: 2,
            height: 2,
            origin: view::pose(&Pose::new(-1.0, 2.0, 0.5)),
        },
        data: vec![0, 100, -1, 50],
    };
    change(&mut map);
    cdr(&map).expect("CDR")
}

#[test]
fn a_map_is_read_with_its_place_and_its_turn() {
    let log = good(vec![("/map", MAP, map(|_| {}))]);
    let read = log.map.expect("a map");
    assert!(
        (read.resolution_m - 0.05).abs() < 1e-12,
        "{}",
        read.resolution_m
    );
    assert!(
        (read.corner.yaw_rad - 0.5).abs() < 1e-9,
        "{:?}",
        read.corner
    );
    assert_eq!(
        (read.size, &read.cells[..]),
        ((2, 2), &[0, 100, -1, 50][..])
    );
    let assumed = &log.report.assumed;
    assert!(
        assumed
            .iter()
            .any(|it| it.contains("begins in the frame of the map")),
        "{assumed:?}"
    );
    assert!(
        good(Vec::new())
            .report
            .missing
            .contains(&"no map".to_owned())
    );
}

#[test]
fn a_map_whose_numbers_cannot_be_is_none() {
    type Change = fn(&mut messages::OccupancyGrid);
    let bad: [Change; 8] = [
        |it| it.info.resolution = 0.0,
        |it| it.info.resolution = f32::NAN,
        |it| it.info.resolution = -0.05,
        |it| it.info.width = u32::MAX,
        |it| it.info.height = 0,
        |it| it.data.truncate(3),
        |it| it.info.origin.position.x = f64::INFINITY,
        |it| it.info.origin.orientation.z = f64::NAN,
    ];
    for (n, change) in bad.into_iter().enumerate() {
        let log = good(vec![("/map", MAP, map(change))]);
        assert!(log.map.is_none(), "{n}");
        assert_eq!(log.report.mended["messages that cannot be read"], 1, "{n}");
    }
}

#[test]
fn of_several_maps_the_one_that_is_meant_is_taken() {
    let wide = |it: &mut messages::OccupancyGrid| {
        (it.info.width, it.info.height) = (4, 1);
    };
    let of = |topics: &Topics, names: &[&str]| {
        let mut bag = Bag::new(topics);
        let good = [
            ("/odom", ODOMETRY, odometry(1000, 0.0)),
            ("/scan", SCAN, scan(1050, &[1.0])),
            ("/odom", ODOMETRY, odometry(1100, 1.0)),
        ];
        for (topic, kind, data) in good {
            bag.take(topic, kind, MS, &data);
        }
        for name in names {
            let data = if *name == "/map" {
                map(wide)
            } else {
                map(|_| {})
            };
            bag.take(name, MAP, MS, &data);
        }
        bag.into_log()
    };
    let any = Topics::default();
    let log = of(&any, &["/local_costmap", "/map", "/map"]).expect("a log");
    assert_eq!(log.map.expect("it").size, (4, 1));
    let assumed = &log.report.assumed;
    assert!(
        assumed
            .iter()
            .any(|it| it.contains("the last of 2 on /map")),
        "{assumed:?}"
    );
    let log = of(&any, &["/a", "/b"]).expect("a log");
    assert!(log.map.is_none());
    let missing = &log.report.missing;
    assert!(
        missing.iter().any(|it| it.contains("--map (/a, /b)")),
        "{missing:?}"
    );
    let named = Topics {
        map: Some("/b".to_owned()),
        ..Topics::default()
    };
    let log = of(&named, &["/a", "/b", "/map"]).expect("a log");
    assert_eq!(log.map.expect("it").size, (2, 2));
    let error = of(&named, &["/a"]).expect_err("none");
    assert!(error.contains("can be read is on /b"), "{error}");
    // Many others leave room for the one that is meant.
    let many = ["/c", "/d", "/e", "/f", "/map"];
    let log = of(&any, &many).expect("a log");
    assert_eq!(log.map.expect("it").size, (4, 1));
}

proptest! {
    #[test]
    fn no_bytes_make_it_panic(at in 0_usize..200, byte: u8, len in 0_usize..200) {
        for (kind, whole) in [(SCAN, scan(1050, &[1.0; 9])), (TF, transform(1, "a", "b", 1.0)), (MAP, map(|_| {}))] {
            let mut bytes = whole;
            let n = bytes.len();
            bytes[at % n] = byte;
            let cut = bytes[..len.min(n)].to_vec();
            let _ = bag(&[("/a", kind, bytes), ("/b", kind, cut)]);
        }
    }
}
