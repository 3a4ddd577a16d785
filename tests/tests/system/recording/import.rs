//! Logs of other robots: brought into the form of a recording, and played.

use super::{recording_of, refused};
use serde_json::Value;
use std::fmt::Write;
use std::path::Path;
use std::process::Command;
use zeronav_tests::data::external_data;
use zeronav_tests::python::readers;
use zeronav_tests::rooms::short_drive;
use zeronav_tests::{Zeronav, zeronav};

/// Imports `log` as `out`; what is said of it.
pub(super) fn imported(log: &Path, out: &Path) -> Value {
    let [log, out] = [log, out].map(|it| it.display().to_string());
    zeronav(&["import", &log, "--out", &out, "--json"]).expect(0)
}

/// Plays a recording to `open`; the figures of that. [m] and the like
fn played(file: &Path, open: &str, more: &[&str]) -> Vec<(String, Option<f64>)> {
    let path = file.display().to_string();
    let ended = zeronav(&[&["replay", &path, "--open", open, "--json"], more].concat());
    let said = ended.expect(0);
    let comparison = &said["comparison"];
    assert_eq!(comparison["compared"], false, "{comparison:#}");
    assert_eq!(comparison["equal"], false, "{comparison:#}");
    let figures = comparison["figures"]["b"].as_array().expect("figures");
    let figure = |it: &Value| {
        (
            it["name"].as_str().unwrap_or_default().to_owned(),
            it["value"].as_f64(),
        )
    };
    figures.iter().map(figure).collect()
}

fn of(figures: &[(String, Option<f64>)], name: &str) -> f64 {
    let found = figures.iter().find(|(it, _)| it == name);
    found
        .and_then(|(_, value)| *value)
        .unwrap_or_else(|| panic!("no {name}: {figures:?}"))
}

/// A drive of 3 m along the middle of a room of 8 m by 4 m, by wheels that count 2 % too much.
pub(super) fn carmen() -> String {
    let mut text = String::new();
    for n in 0..=60_u32 {
        let x_m = 1.0 + 0.05 * f64::from(n);
        let s = 0.1 * f64::from(n);
        writeln!(
            text,
            "ODOM {:.4} 0 0 0.5 0 0 {s:.3} host {s:.3}",
            1.02 * (x_m - 1.0)
        )
        .expect("text");
        if n % 2 == 1 {
            text += "FLASER 181";
            for beam in 0..181 {
                let angle = (f64::from(beam) - 90.0).to_radians();
                let ahead_m = (8.0 - x_m) / angle.cos().max(1e-9);
                let aside_m = 2.0 / angle.sin().abs().max(1e-9);
                write!(text, " {:.3}", ahead_m.min(aside_m)).expect("text");
            }
            writeln!(text, " {x_m:.4} 2 0 {x_m:.4} 2 0 {s:.3} host {s:.3}").expect("text");
        }
    }
    text
}

#[test]
fn a_carmen_log_is_played_to_mapping_and_planners() {
    let folder = tempfile::tempdir().expect("a folder");
    let (log, out) = (folder.path().join("it.log"), folder.path().join("it.mcap"));
    std::fs::write(&log, carmen()).expect("written");
    let said = imported(&log, &out);
    assert_eq!(said["format"], "CARMEN");
    assert!(said["scans"].as_u64() > Some(25), "{said:#}");
    let all = "mapping,global_planner,local_planner,collision_guard";
    let figures = played(&out, all, &[]);
    // Scans mend most of what the wheels count too much, 6 cm in the end.
    assert!(
        of(&figures, "largest error of the place") < 0.1,
        "{figures:?}"
    );
    assert!(of(&figures, "paths found") > 0.0, "{figures:?}");
    let again = [
        "import",
        &log.display().to_string(),
        "--out",
        &out.display().to_string(),
    ];
    refused(&zeronav(&again), "it exists; name another file");
    let named = [&again[..], &["--map", "/map"]].concat();
    refused(&zeronav(&named), "leave out --scan, --odometry and --map");
    std::fs::write(&log, "this is no log at all\n").expect("written");
    refused(&zeronav(&again), "no line begins with FLASER");
    // What cannot become a recording does not cost the one that is there.
    let before = std::fs::read(&out).expect("it");
    let late = "ODOM 0 0 0 0 0 0 1.0 h 1.0\nFLASER 3 1 2 3 0 0 0 0 0 0 1.5 h 1.5\n";
    std::fs::write(&log, late).expect("written");
    let replace = [&again[..], &["--force"]].concat();
    refused(
        &zeronav(&replace),
        "no scan lies between two odometry messages",
    );
    assert_eq!(std::fs::read(&out).expect("it"), before);
    let names = std::fs::read_dir(folder.path()).expect("it").count();
    assert_eq!(names, 2, "the log and the recording");
}

/// Makes a `.db3` of the channels of ROS in an MCAP file, as rosbag2 does.
const TO_SQLITE: &str = r#"
import sqlite3, sys
from mcap.reader import make_reader
db = sqlite3.connect(sys.argv[2])
db.execute("CREATE TABLE topics(id INTEGER PRIMARY KEY,name TEXT NOT NULL,type TEXT NOT NULL,"
           "serialization_format TEXT NOT NULL,offered_qos_profiles TEXT NOT NULL)")
db.execute("CREATE TABLE messages(id INTEGER PRIMARY KEY,topic_id INTEGER NOT NULL,timestamp INTEGER NOT NULL,"
           "data BLOB NOT NULL)")
ids = {}
with open(sys.argv[1], "rb") as stream:
    for schema, channel, message in make_reader(stream).iter_messages():
        if channel.message_encoding != "cdr":
            continue
        if channel.topic not in ids:
            ids[channel.topic] = len(ids) + 1
            row = (ids[channel.topic], channel.topic, schema.name, "cdr", "")
            db.execute("INSERT INTO topics VALUES(?,?,?,?,?)", row)
        row = (ids[channel.topic], message.log_time, message.data)
        db.execute("INSERT INTO messages(topic_id,timestamp,data) VALUES(?,?,?)", row)
db.commit()
"#;

#[test]
fn bags_of_ros_are_imported_from_both_of_their_formats() {
    let folder = tempfile::tempdir().expect("a folder");
    let place = folder.path().to_owned();
    std::fs::write(place.join("it.toml"), short_drive("")).expect("written");
    let arguments = ["run", "./it.toml", "--lockstep", "--headless", "--record"];
    let run = Zeronav::start_in(folder, &arguments).finish();
    assert_eq!(run.code(), 0, "{}", run.stderr);
    let bag = recording_of(run.folder.path());
    let db = place.join("it.db3");
    let made = Command::new(readers())
        .args(["-c", TO_SQLITE])
        .args([&bag, &db])
        .output()
        .expect("Python runs");
    assert!(
        made.status.success(),
        "{}",
        String::from_utf8_lossy(&made.stderr)
    );
    let outs = ["mcap", "db3"].map(|name| place.join(format!("{name}_imported.mcap")));
    let mut said = [imported(&bag, &outs[0]), imported(&db, &outs[1])];
    for it in &mut said {
        for file in ["recording", "map"] {
            assert!(it[file].is_string(), "{it:#}");
            it[file] = Value::Null;
        }
    }
    assert_eq!(said[0], said[1], "the same is in both");
    assert!(
        said[0]["corrected_poses"].as_u64() > Some(10),
        "{:#}",
        said[0]
    );
    let figures = played(&outs[1], "mapping", &[]);
    assert!(
        of(&figures, "largest error of the place") < 0.1,
        "{figures:?}"
    );
    map_goes_along(&place, &bag);
}

/// The map in a bag, which was imported as `db3_imported.mcap`, is that of the room, and mapping begins with it.
fn map_goes_along(place: &Path, bag: &Path) {
    let map = std::fs::read_to_string(place.join("db3_imported_map.yaml")).expect("a map");
    assert!(map.contains("resolution: 0.05"), "{map}");
    // Wherever both have gone to.
    let moved = place.join("moved");
    std::fs::create_dir(&moved).expect("a folder");
    for name in [
        "db3_imported.mcap",
        "db3_imported_map.yaml",
        "db3_imported_map.pgm",
    ] {
        std::fs::rename(place.join(name), moved.join(name)).expect("moved");
    }
    let file = moved.join("db3_imported.mcap");
    let figures = played(&file, "mapping,global_planner", &[]);
    assert!(of(&figures, "paths found") > 0.0, "{figures:?}");
    std::fs::remove_file(moved.join("db3_imported_map.pgm")).expect("removed");
    let replay = ["replay", &file.display().to_string(), "--open", "mapping"];
    refused(&zeronav(&replay), "db3_imported_map.pgm");
    // What is there already stays there.
    let again = [
        "import",
        &bag.display().to_string(),
        "--out",
        &file.display().to_string(),
    ];
    refused(&zeronav(&again), "it exists");
    std::fs::remove_file(&file).expect("removed");
    refused(&zeronav(&again), "db3_imported_map.yaml");
    assert!(!file.exists(), "no recording without its map");
    assert_eq!(zeronav(&[&again[..], &["--force"]].concat()).code(), 0);
}

#[test]
#[ignore = "needs rosmaps at $ZERONAV_DATA"]
fn mapping_keeps_the_pose_in_a_real_log_on_external_data() {
    let log = external_data("rosmaps").join("intel.gfs.log.gz");
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("it.mcap");
    let said = imported(&log, &out);
    assert_eq!(said["scans"], 906, "{said:#}");
    let figures = played(&out, "mapping", &["--to", "300"]);
    // It closes no loops: what it drifts in 100 m is shown, and no more than that is asked for.
    eprintln!("{figures:?}");
    assert!(
        of(&figures, "median error of the place") < 10.0,
        "{figures:?}"
    );
}
