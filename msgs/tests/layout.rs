//! The wire does not change by accident: sizes, type names and schema hashes of every topic.
//!
//! A change here is a change of the contract: every service must be rebuilt, and the version
//! in the type's name goes up.

use std::fmt::Write;
use zeronav_msgs::header::{Header, Parents, Stamps};
use zeronav_msgs::map::{MapCell, MapInfo, MapTile};
use zeronav_msgs::message::Wire;
use zeronav_msgs::path::{Path, Waypoint};
use zeronav_msgs::span::Span;
use zeronav_msgs::topics::{
    MapKeyframe, RobotScan, SPANS, SimForesight, TaskZones, Topic, TopicRow, topics,
};

/// Name, bytes of header and fixed fields, bytes of an item, schema hash.
const GOLDEN: &[(&str, usize, usize, u64)] = &[
    ("robot/description", 272, 16, 0x4269_f1a2_e0ce_4de2),
    ("robot/scan", 160, 4, 0x7cad_df9d_db10_ba5c),
    ("robot/odometry", 200, 1, 0x539b_fa04_c81d_517b),
    ("map/update", 328, 4104, 0xc6a1_406d_687e_61c3),
    ("map/keyframe", 328, 4104, 0x1228_f06e_42e1_b3f0),
    ("map/obstacles", 136, 144, 0xea9d_1f73_e582_7ded),
    ("plan/path", 272, 24, 0x9874_6698_aac9_e113),
    ("plan/request", 144, 1, 0x904f_8c1a_2cb8_a816),
    ("task/goal", 144, 48, 0x91f1_3d6d_71f9_fd5b),
    ("task/status", 192, 24, 0x5c1b_eab4_fcb5_0bb2),
    ("task/pose", 192, 1, 0xd5e6_227b_7f2b_7155),
    ("task/zones", 152, 304, 0x69d4_f976_6967_9555),
    ("control/velocity_request", 192, 1, 0xbca4_0804_cf7a_583b),
    ("robot/velocity_command", 176, 1, 0x00d6_3076_348f_f2bd),
    ("run/clock", 160, 1, 0x2e21_d988_789a_fa53),
    ("run/control", 216, 56, 0x0832_878d_cde3_4582),
    ("sim/ground_truth", 216, 48, 0x1e53_b96e_6136_5535),
    ("sim/foresight", 160, 1064, 0x0c5d_3692_f458_0ad9),
    ("sim/placement", 136, 64, 0x7b6b_e608_2eb7_9558),
    ("debug/rollouts", 168, 112, 0x9c63_2191_d0f7_2eac),
    ("health/robot", 176, 1, 0x3479_845f_530e_b3c6),
    ("health/mapping", 176, 1, 0x714d_8d90_f316_78b8),
    ("health/global_planner", 176, 1, 0x807e_7f55_86b4_ce42),
    ("health/local_planner", 176, 1, 0x4f81_d396_ef28_bf9e),
    ("health/collision_guard", 176, 1, 0x708a_e803_c9a7_6d58),
    ("run/spans", 0, 152, 0x9070_cc0c_5473_c554),
];

#[test]
fn every_topic_is_as_it_was() {
    let actual: Vec<(&str, usize, usize, u64)> = topics()
        .iter()
        .map(|row| (row.name, row.envelope_bytes, row.item_bytes, row.schema))
        .collect();
    let print = |rows: &[(&str, usize, usize, u64)]| {
        let mut text = String::new();
        for (name, envelope, item, schema) in rows {
            let _ = writeln!(
                text,
                "    (\"{name}\", {envelope}, {item}, 0x{schema:016x}),"
            );
        }
        text
    };
    assert!(actual == GOLDEN, "the contract is now\n{}", print(&actual));
}

#[test]
fn fixed_offsets_that_other_languages_rely_on() {
    assert_eq!(size_of::<Header>(), 128);
    assert_eq!(core::mem::offset_of!(Header, schema), 4);
    assert_eq!(core::mem::offset_of!(Header, id), 16);
    assert_eq!(core::mem::offset_of!(Header, tick), 24);
    assert_eq!(core::mem::offset_of!(Header, run_ns), 32);
    assert_eq!(core::mem::offset_of!(Header, capture_ns), 40);
    assert_eq!(core::mem::offset_of!(Header, parents), 48);
    assert_eq!(core::mem::offset_of!(Header, stamps), 96);
    assert_eq!((size_of::<Parents>(), size_of::<Stamps>()), (48, 24));
    assert_eq!(size_of::<Span>(), 152);
    assert_eq!(
        (size_of::<MapCell>(), size_of::<MapTile>()),
        (4, 8 + 32 * 32 * 4)
    );
    assert_eq!(
        (
            size_of::<MapInfo>(),
            size_of::<Path>(),
            size_of::<Waypoint>()
        ),
        (200, 144, 24)
    );
    assert_eq!(Header::NAME, "zeronav.Header.v2");
}

#[test]
fn numbers_and_names_are_unique_and_every_schema_differs() {
    let rows = topics();
    assert_eq!(rows.len(), GOLDEN.len());
    for (n, row) in rows.iter().enumerate() {
        assert!(
            row.number < zeronav_msgs::topics::EVENT_NEED_KEYFRAME,
            "{}",
            row.name
        );
        for other in &rows[n + 1..] {
            assert_ne!(row.number, other.number, "{} and {}", row.name, other.name);
            assert_ne!(row.name, other.name);
            assert_ne!(row.schema, other.schema, "{} and {}", row.name, other.name);
        }
    }
}

#[test]
fn the_memory_of_a_default_run_fits_a_container() {
    // 600 x 400 cells, 360 beams, one writer per topic but five of spans. Nobody is told what will be, and there are no zones.
    let len = |row: &TopicRow| match row.number {
        number if number == MapKeyframe::ROW.number => 19 * 13,
        number if number == RobotScan::ROW.number => 360,
        _ => row.len_max,
    };
    let writers = |row: &TopicRow| match row.number {
        number if number == SPANS.number => 5,
        number if [SimForesight::ROW.number, TaskZones::ROW.number].contains(&number) => 0,
        _ => 1,
    };
    let bytes: usize = topics()
        .iter()
        .map(|row| row.segment_bytes(len(row)) * writers(row))
        .sum();
    eprintln!("{bytes} bytes");
    assert!(bytes < 24 << 20, "{bytes} bytes");
    // With a shadow in every seat it still fits Docker's 64 MB.
    assert!(2 * bytes < 64 << 20);
}
