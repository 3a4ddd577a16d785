//! A folder of recordings as a suite.

use super::{n, recorded, refused};
use serde_json::Value;
use std::path::Path;
use zeronav_tests::zeronav;

/// What a suite of the recordings in `folder` gives.
fn suite(folder: &Path, more: &[&str], code: i32) -> Vec<Value> {
    let path = folder.display().to_string();
    let ended = zeronav(&[&["suite", "recordings", &path, "--json"], more].concat());
    let report = ended.expect(code);
    report["recordings"].as_array().expect("recordings").clone()
}

#[test]
fn every_recording_of_a_folder_is_played_and_what_differs_is_named() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = recorded(folder.path(), "one", "");
    let inside = folder.path().join("of_others");
    std::fs::create_dir(&inside).expect("a folder");
    std::fs::copy(&file, inside.join("two.mcap")).expect("copied");
    let rows = suite(folder.path(), &[], 0);
    assert_eq!(rows.len(), 2, "{rows:#?}");
    for row in &rows {
        assert_eq!(row["verdict"], "equal", "{row:#}");
        let seats = row["computing"].as_object().expect("seats");
        assert_eq!(seats.len(), 4, "{row:#}");
        assert!(
            seats.values().all(|it| it["now_ms"].as_f64() > Some(0.0)),
            "{row:#}"
        );
        assert!(row["error_m"].as_f64().is_some(), "{row:#}");
    }
    // Nothing computes in a billionth of the time.
    suite(&inside, &["--slower", "1e-9"], 1);
    // What is changed on purpose may differ.
    let set = [
        "--open",
        "local_planner",
        "--set",
        "local_planner.controller=dwa",
    ];
    let rows = suite(&inside, &set, 0);
    let first = rows[0]["verdict"]["differs"]
        .as_str()
        .expect("a difference");
    assert!(first.contains("local_planner on "), "{first}");
    // One that cannot be played fails the suite, and the others are played.
    let bytes = std::fs::read(&file).expect("it");
    std::fs::write(folder.path().join("cut.mcap"), &bytes[..bytes.len() / 2]).expect("written");
    let rows = suite(folder.path(), &[], 1);
    let whys = rows
        .iter()
        .filter_map(|row| row["verdict"]["not_played"].as_str());
    let whys: Vec<&str> = whys.collect();
    assert!(whys.len() == 1 && whys[0].contains("cut.mcap"), "{whys:?}");
    let equal = rows.iter().filter(|row| row["verdict"] == "equal");
    assert_eq!(equal.count(), 2, "{rows:#?}");
    let compared = &rows[1]["comparison"]["topics"];
    assert!(
        compared
            .as_array()
            .expect("topics")
            .iter()
            .map(|it| n(&it["equal"]))
            .sum::<u64>()
            > 100
    );
}

#[test]
fn what_is_no_suite_of_recordings_is_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().display().to_string();
    for (arguments, why) in [
        (&["suite", "recordings"][..], "which recordings?"),
        (&["suite", "recordings", &path], "no MCAP file is in it"),
        (&["suite", "recordings", "/absent"], "/absent: "),
        (
            &["suite", "recordings", &path, "--out", &path],
            "name another folder with --out",
        ),
        (&["suite", "recordings", &path, "--seeds", "3"], "--seeds"),
        (
            &["suite", "generated", &path],
            "only `zeronav suite recordings FOLDER`",
        ),
        (
            &["suite", "recordings", &path, "--open", "robot"],
            "what the robot senses",
        ),
    ] {
        refused(&zeronav(arguments), why);
    }
}
