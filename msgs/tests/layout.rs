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
use zeronav_msgs::topics::{MapKeyframe, RobotScan, SPANS, Topic, TopicRow, topics};

/// Name, bytes of header and fixed fields, bytes of an item, schema hash.
const GOLDEN: &[(&str, usize, usize, u64)] = &[
    ("robot/description", 264, 16, 0x2c91_0069_7c64_18bd),
    ("robot/scan", 160, 4, 0x3f49_5fbc_f312_b64a),
    ("robot/odometry", 200, 1, 0xa81a_5028_3e14_2917),
    ("map/update", 288, 4104, 0xa1d4_76a5_5b7a_a2fe),
    ("map/keyframe", 288, 4104, 0x7858_bd05_bd96_78ce),
    ("map/obstacles", 136, 136, 0x2712_c9b5_4150_e314),
    ("plan/path", 264, 24, 0x7930_d528_cdb7_bbdf),
    ("plan/request", 144, 1, 0xe8e8_e8d0_d733_8bbc),
    ("task/goal", 144, 48, 0x259f_c266_e8e8_0857),
    ("task/status", 168, 24, 0xe797_a159_e4e4_fd18),
    ("task/pose", 184, 1, 0x3cae_3d63_dd16_26bb),
    ("control/velocity_request", 192, 1, 0xff08_125d_0d81_f05c),
    ("robot/velocity_command", 176, 1, 0xaa99_3ae0_dc44_0063),
    ("run/clock", 160, 1, 0x67b6_becd_51d9_8eba),
    ("run/control", 144, 56, 0x5243_46b7_fcba_a353),
    ("sim/ground_truth", 216, 48, 0x827a_99fb_86dc_e923),
    ("sim/placement", 136, 64, 0xbe66_97bb_f00d_7904),
    ("health/robot", 176, 1, 0x94c1_620c_f083_362d),
    ("health/mapping", 176, 1, 0x801c_eaa2_f3c0_e523),
    ("health/global_planner", 176, 1, 0x36cf_66e2_6273_0491),
    ("health/local_planner", 176, 1, 0x2233_6336_f3b3_e545),
    ("health/collision_guard", 176, 1, 0x5cb6_8029_5ee9_6a43),
    ("run/spans", 0, 136, 0x4482_7d2d_f814_4749),
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
    assert_eq!(size_of::<Span>(), 136);
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
        (160, 136, 24)
    );
    assert_eq!(Header::NAME, "zeronav.Header.v1");
}

#[test]
fn numbers_and_names_are_unique_and_every_schema_differs() {
    let rows = topics();
    assert_eq!(rows.len(), 23);
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
    // 600 x 400 cells, 360 beams, one writer per topic but five of spans.
    let len = |row: &TopicRow| match row.number {
        number if number == MapKeyframe::ROW.number => 19 * 13,
        number if number == RobotScan::ROW.number => 360,
        _ => row.len_max,
    };
    let writers = |row: &TopicRow| match row.number {
        number if number == SPANS.number => 5,
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
