//! Recordings that are played to some seats.

use super::{diff, n, recorded, recording_of, refused};
use serde_json::Value;
use std::path::Path;
use zeronav_msgs::topics::{ControlRequest, MapUpdate, PlanPath, Topic};
use zeronav_tests::rooms::short_drive;
use zeronav_tests::{Zeronav, real_time_turn, zeronav};

/// The comparison of a recording with what came of it in open loop.
fn played(file: &Path, open: &str, more: &[&str], code: i32) -> Value {
    let path = file.display().to_string();
    let ended = zeronav(&[&["replay", &path, "--open", open, "--json"], more].concat());
    ended.expect(code)["comparison"].clone()
}

/// Messages that are equal on a topic.
fn equal_on(compared: &Value, topic: &str) -> u64 {
    let topics = compared["topics"].as_array().expect("topics");
    let found = topics.iter().find(|it| it["topic"] == topic);
    found.map_or(0, |it| n(&it["equal"]))
}

#[test]
fn a_recording_that_is_played_to_its_own_seats_gives_the_same_messages() {
    let original = zeronav(&["run", "door_closes", "--lockstep", "--json", "--record"]);
    assert_eq!(original.code(), 0, "{}", original.stderr);
    let file = recording_of(original.folder.path());
    for open in [
        "mapping",
        "global_planner",
        "local_planner",
        "collision_guard",
        "mapping,local_planner",
        "mapping,global_planner,local_planner,collision_guard",
    ] {
        let compared = played(&file, open, &[], 0);
        assert_eq!(compared["equal"], true, "{open}: {compared:#}");
        let topics = compared["topics"].as_array().expect("topics");
        let equal: u64 = topics.iter().map(|topic| n(&topic["equal"])).sum();
        assert!(equal > 100, "{open}: {compared:#}");
    }
    // Another parameter shows in its seat, and what is played stays as it was.
    let set = ["--set", "local_planner.controller=dwa"];
    let compared = played(&file, "local_planner", &set, 0);
    assert_eq!(compared["first"]["author"], "local_planner", "{compared:#}");
    assert_eq!(compared["first"]["topic"], ControlRequest::ROW.name);
    assert_eq!(equal_on(&compared, PlanPath::ROW.name), 0, "not compared");
    let path = file.display().to_string();
    let set = ["replay", &path, "--open", "mapping", set[0], set[1]];
    refused(&zeronav(&set), "local_planner is played from the recording");
    let robot = ["replay", &path, "--open", "robot"];
    refused(&zeronav(&robot), "what the robot senses is what is played");
}

#[test]
fn only_a_part_of_a_recording_is_played_and_compared() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = recorded(folder.path(), "it", "");
    let all = equal_on(
        &played(&file, "local_planner", &[], 0),
        ControlRequest::ROW.name,
    );
    let part = played(&file, "local_planner", &["--from", "1.0", "--to", "2.0"], 0);
    // Ticks 50 to 100 of 20 ms.
    assert_eq!(equal_on(&part, ControlRequest::ROW.name), 51, "{part:#}");
    assert!(all > 100, "{all}");
    let path = file.display().to_string();
    let none = [
        "replay", &path, "--open", "mapping", "--from", "3", "--to", "1",
    ];
    refused(&zeronav(&none), "nothing lies between them");
    // A part with nothing in it is not equal.
    for open in [&["--open", "mapping"][..], &[]] {
        let behind = ["replay", &path, "--json", "--from", "5000"];
        let ended = zeronav(&[&behind[..], open].concat());
        let compared = &ended.expect(1)["comparison"];
        assert_eq!(compared["equal"], false, "{compared:#}");
        assert_eq!(compared["compared"], false, "{compared:#}");
    }
}

/// Seats that were empty for a while, and taken by a successor, are so again.
#[test]
fn faults_in_a_recording_are_played_too() {
    let folder = tempfile::tempdir().expect("a folder");
    for role in ["mapping", "global_planner", "collision_guard"] {
        let fault = format!(
            "[[faults]]\nkind = \"kill\"\nservice = \"{role}\"\nbegins = {{ at_s = 1.0 }}\n"
        );
        let file = recorded(folder.path(), role, &fault);
        let compared = played(&file, "local_planner", &[], 0);
        assert_eq!(compared["equal"], true, "{role}: {compared:#}");
        assert!(
            equal_on(&compared, ControlRequest::ROW.name) > 100,
            "{compared:#}"
        );
    }
    // A seat that answers where the recorded process was dead differs there first.
    let fault =
        "[[faults]]\nkind = \"kill\"\nservice = \"local_planner\"\nbegins = { at_s = 2.0 }\n";
    let file = recorded(folder.path(), "own", fault);
    let compared = played(&file, "local_planner", &[], 1);
    assert_eq!(n(&compared["first"]["tick"]), 101, "{compared:#}");
}

#[test]
fn another_program_in_an_open_seat_is_compared_tick_by_tick() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = recorded(folder.path(), "it", "");
    let swap = ["--swap", "global_planner=straight_line_service"];
    let compared = played(&file, "global_planner", &swap, 0);
    assert_eq!(
        compared["first"]["author"], "global_planner",
        "{compared:#}"
    );
    assert_eq!(compared["first"]["topic"], PlanPath::ROW.name);
    // One that gives up is named, with the tick.
    let path = file.display().to_string();
    let swap = "--swap=local_planner=hangs_after_start";
    let ended = zeronav(&["replay", &path, "--open", "local_planner", swap]);
    assert_eq!(ended.code(), 3, "{}", ended.stderr);
    assert!(ended.stderr.contains("local_planner"), "{}", ended.stderr);
}

/// In real time scans come between ticks and answers when they can: it is played in ticks.
#[test]
fn a_recording_in_real_time_is_played_too() {
    let _turn = real_time_turn();
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("it.toml"), short_drive("")).expect("written");
    let arguments = ["run", "./it.toml", "--headless", "--record"];
    let real = Zeronav::start_in(folder, &arguments).finish();
    assert_eq!(real.code(), 0, "{}", real.stderr);
    let file = recording_of(real.folder.path());
    let path = file.display().to_string();
    // Mapping sees the same scans from the same places, whenever they came.
    let ended = zeronav(&["replay", &path, "--open", "mapping", "--json"]);
    let said = ended.json();
    let compared = &said["comparison"];
    assert!([0, 1].contains(&ended.code()), "{}", ended.stderr);
    assert!(equal_on(compared, MapUpdate::ROW.name) > 20, "{compared:#}");

    // Whatever it differs in from what was recorded, every playing is the same, from its first tick on.
    for open in [
        "collision_guard",
        "local_planner",
        "mapping,global_planner,local_planner",
    ] {
        let plays: Vec<_> = (0..3)
            .map(|_| zeronav(&["replay", &path, "--open", open]))
            .collect();
        let files = plays.iter().map(|ended| {
            assert!([0, 1].contains(&ended.code()), "{open}: {}", ended.stderr);
            recording_of(ended.folder.path())
        });
        let files: Vec<_> = files.collect();
        for again in &files[1..] {
            let compared = diff(&files[0], again, 0);
            assert_eq!(compared["equal"], true, "{open}: {compared:#}");
        }
    }
}
