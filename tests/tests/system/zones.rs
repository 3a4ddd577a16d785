//! Zones on the real processes: around, out of, slow, live, and after the death of every service.

use serde_json::Value;
use std::path::Path;
use tempfile::TempDir;
use zeronav_tests::up::Up;
use zeronav_tests::{Ended, Zeronav, zeronav};

fn drive(scenario: &str) -> (Ended, Value) {
    let ended = zeronav(&["run", scenario, "--lockstep", "--headless", "--json"]);
    let result = ended.expect(0);
    assert_eq!(result["verdict"], "pass", "{result:#}");
    (ended, result)
}

fn track(result: &Value) -> Vec<[f64; 2]> {
    serde_json::from_value(result["track_m"].clone()).expect("a track")
}

fn is_in([x, y]: [f64; 2], [x0, y0, x1, y1]: [f64; 4]) -> bool {
    x > x0 && x < x1 && y > y0 && y < y1
}

/// Folder of a run, as a word.
fn folder_of(ended: &Ended, result: &Value) -> String {
    let folder = ended
        .folder
        .path()
        .join(result["directory"].as_str().expect("a folder"));
    folder.to_str().expect("a path").to_owned()
}

#[test]
fn a_closed_aisle_is_driven_around_and_a_slow_one_slowly() {
    let (ended, result) = drive("closed_aisle");
    let track = track(&result);
    assert!(!track.iter().any(|at| is_in(*at, [10.25, 5.0, 13.25, 8.0])));
    assert!(track.iter().any(|at| is_in(*at, [7.0, 12.5, 22.9, 14.6])));
    // 15.9 m at half a metre a second; at full speed it would be 30 s.
    assert!(
        result["time_s"].as_f64() > Some(45.0),
        "{}",
        result["time_s"]
    );
    let reasons = result["reasons"].as_array().expect("moments");
    let slow = reasons
        .iter()
        .find(|it| it["zone"]["name"] == "ramp")
        .expect("the ramp is named");
    assert_eq!(slow["zone"]["limit_mps"], 0.5);
    let time_s = slow["time_s"].as_f64().expect("a time") + 0.001;
    let told = zeronav(&["why", &folder_of(&ended, &result), &time_s.to_string()]).stdout;
    assert!(told.contains("Slow: zone `ramp`, 0.5 m/s."), "{told}");
    let picture = std::fs::read_to_string(Path::new(&folder_of(&ended, &result)).join("run.svg"));
    says(
        &picture.expect("a picture"),
        &["zone ramp, speed limit", "keepout</title>"],
    );
    // The planner slows down in time: the guard has nothing to do.
    let stops = reasons
        .iter()
        .filter(|it| it["command"]["intervention"] == "zone_stopped");
    assert_eq!(stops.count(), 0);
    // And it is the same again.
    assert_eq!(drive("closed_aisle").1["run_hash"], result["run_hash"]);
}

#[test]
fn a_robot_that_starts_in_a_zone_is_let_out_and_drives_around_it() {
    let (_, result) = drive("zone_around_robot");
    let track = track(&result);
    let inside: Vec<bool> = (track.iter())
        .map(|at| is_in(*at, [4.2, 1.8, 9.0, 6.2]))
        .collect();
    assert!(inside[0], "it starts inside");
    let out = inside.iter().position(|is_in| !is_in).expect("it gets out");
    assert!(
        inside[out..].iter().all(|is_in| !is_in),
        "and never in again"
    );
}

/// The zone fills a blind aisle from wall to wall: its nearest edge lies behind the wall at the robot's back.
#[test]
fn a_robot_in_a_blind_aisle_is_let_out_of_it() {
    let folder = TempDir::new().expect("a folder");
    std::fs::write(folder.path().join("it.toml"), BLIND_AISLE).expect("written");
    let arguments = ["run", "./it.toml", "--lockstep", "--headless", "--json"];
    let result = Zeronav::start_in(folder, &arguments).finish().expect(0);
    assert_eq!(result["verdict"], "pass", "{result:#}");
    assert_eq!(result["contacts"], 0);
    let track = track(&result);
    assert!(is_in(track[0], [0.2, 2.6, 6.0, 5.4]), "it starts inside");
}

/// Every service is killed on the way, one after the other.
#[test]
fn zones_survive_the_death_of_every_service() {
    let folder = TempDir::new().expect("a folder");
    let mut text = zeronav_tests::shipped("closed_aisle");
    for (role, at_s) in [
        ("mapping", 4.0),
        ("local_planner", 7.0),
        ("collision_guard", 10.0),
        ("global_planner", 13.0),
    ] {
        let fault = format!(
            "[[faults]]\nkind = \"kill\"\nservice = \"{role}\"\nbegins = {{ at_s = {at_s:?} }}\n"
        );
        text.push_str(&fault);
    }
    std::fs::write(folder.path().join("it.toml"), text).expect("written");
    let arguments = ["run", "./it.toml", "--lockstep", "--headless", "--json"];
    let result = Zeronav::start_in(folder, &arguments).finish().expect(0);
    assert_eq!(result["verdict"], "pass", "{result:#}");
    assert_eq!(
        result["restarts"].as_array().map(Vec::len),
        Some(4),
        "{result:#}"
    );
    assert!(
        !track(&result)
            .iter()
            .any(|at| is_in(*at, [10.25, 5.0, 13.25, 8.0]))
    );
    assert!(result["time_s"].as_f64() > Some(45.0));
}

const BLIND_AISLE: &str = r#"
title = "started in a closed blind aisle"
base = ["hall", "porter"]
start = [1.2, 4.0, 0.0]
goals = [{ pose = [11.5, 4.0, 0.0] }]
run = { time_limit_s = 60.0 }
expect = { outcome = "reached" }

[world]
shapes = [
    { kind = "box", centre_m = [0.1, 4.0], size_m = [0.2, 8.0] },
    { kind = "box", centre_m = [3.1, 2.5], size_m = [5.8, 0.2] },
    { kind = "box", centre_m = [3.1, 5.5], size_m = [5.8, 0.2] },
    { kind = "box", centre_m = [13.9, 4.0], size_m = [0.2, 8.0] },
]

[[zones]]
name = "store"
kind = "keepout"
polygon = [[0.2, 2.6], [6.0, 2.6], [6.0, 5.4], [0.2, 5.4]]
"#;

const HALL: &str = r#"
title = "zones by hand"
base = ["hall", "porter"]
start = [2.0, 4.0, 0.0]
"#;

fn up(arguments: &[&str]) -> Up {
    let folder = TempDir::new().expect("a folder");
    std::fs::write(folder.path().join("it.toml"), HALL).expect("written");
    let arguments: Vec<&str> = ["./it.toml"].iter().chain(arguments).copied().collect();
    Up::start_in(folder, &arguments)
}

#[track_caller]
fn says(text: &str, words: &[&str]) {
    for word in words {
        assert!(text.contains(word), "`{word}` is not in: {text}");
    }
}

#[test]
fn zones_are_added_listed_and_removed_while_the_stack_runs() {
    let up = up(&["--lockstep"]);
    assert_eq!(up.ask(&["zone", "list"], 0), "no zones\n");
    assert_eq!(
        up.ask(&["zone", "add", "wet floor", "8", "0", "12", "8"], 0),
        "added\n"
    );
    assert_eq!(
        up.ask(
            &["zone", "add", "ramp", "--limit", "0.2", "3", "0", "5", "8"],
            0
        ),
        "added\n"
    );
    let listed = up.ask(&["zone", "list"], 0);
    says(
        &listed,
        &[
            "wet floor",
            "keepout",
            "ramp",
            "at most 0.2 m/s",
            "(8, 0) (12, 0) (12, 8) (8, 8)",
        ],
    );
    // A goal inside is answered with the nearest pose outside, which can be driven to.
    // Before its first map it is not known where the robot can drive to.
    let answers = (0..500).map(|_| up.ask(&["goal", "10", "4", "0"], 2));
    let mut answers = answers.filter(|answer| answer.contains("the nearest free pose is 7."));
    let refused = answers.next().expect("a pose on the robot's side");
    says(
        &refused,
        &[
            "(10, 4) lies in the keepout zone `wet floor`",
            "the nearest free pose is 7.",
        ],
    );
    let near = refused
        .split("the nearest free pose is ")
        .nth(1)
        .expect("a pose");
    let pose: Vec<&str> = near.split([' ', ';', '\n']).take(3).collect();
    let lines = up.lines(&["goal", pose[0], pose[1], pose[2], "--wait"], 0);
    assert_eq!(lines.last().expect("a line")["outcome"], "reached");
    // Beyond it nothing is reachable.
    let refused = up.ask(
        &["goal", "13.2", "4", "0", "--time-limit", "20", "--wait"],
        1,
    );
    says(&refused, &["keepout zone"]);
    says(&up.ask(&["why"], 0), &["zone `wet floor`, keepout"]);
    assert_eq!(up.ask(&["zone", "remove", "wet floor"], 0), "removed\n");
    let lines = up.lines(&["goal", "13.2", "4", "0", "--wait"], 0);
    assert_eq!(lines.last().expect("a line")["outcome"], "reached");
    says(
        &up.ask(&["zone", "remove", "wet floor"], 2),
        &["there is no zone `wet floor`"],
    );
    let flat = ["zone", "add", "flat", "1", "1", "2", "1", "3", "1"];
    says(&up.ask(&flat, 2), &["enclose no area"]);
    assert_eq!(up.down()["contacts"], 0);
}

/// The robot drives when a zone is drawn around and in front of it: it gets out, and goes around.
#[test]
fn a_zone_that_appears_around_the_moving_robot_lets_it_out_only() {
    let mut up = up(&["--lockstep"]);
    let id = up.lines(&["goal", "12.5", "4", "0"], 0);
    assert!(!id.is_empty());
    up.stack.wait_until("it is under way", |stack| {
        let report = stack.report().unwrap_or_default();
        report["pose"][0].as_f64() > Some(4.0)
    });
    let zone = [
        "zone", "add", "spill", "3.2", "1.8", "8.5", "1.8", "8.5", "6.2", "3.2", "6.2",
    ];
    assert_eq!(up.ask(&zone, 0), "added\n");
    up.stack.wait_until("it arrives", |stack| {
        let report = stack.report().unwrap_or_default();
        report["pose"][0].as_f64() > Some(12.0)
    });
    let result = up.down();
    assert_eq!(result["contacts"], 0);
}

/// The guard is told of zones that it has not got: it stands until they come.
#[test]
fn a_zone_message_that_is_lost_opens_nothing() {
    let mut up = up(&[]);
    up.ask(&["zone", "add", "wet floor", "8", "0", "12", "8"], 0);
    // From now on all messages of zones are lost.
    up.ask(&["fault", "drop", "task/zones=1"], 0);
    up.ask(&["fault", "kill", "collision_guard"], 0);
    up.ask(&["goal", "6", "4", "0"], 0);
    up.stack
        .wait_until("the guard stands and says why", |stack| {
            let report = stack.report().unwrap_or_default();
            let why = report["why"].as_str().unwrap_or_default().to_owned();
            why.contains("zones were announced that have not come")
        });
    up.ask(&["fault", "heal"], 0);
    up.stack.wait_until("it has them and drives", |stack| {
        let report = stack.report().unwrap_or_default();
        report["pose"][0].as_f64() > Some(5.5)
    });
    let refused = up.ask(&["goal", "10", "4", "0"], 2);
    says(&refused, &["keepout zone `wet floor`"]);
    up.down();
}

/// A mask of a costmap filter, turned by a quarter about its origin.
#[test]
fn a_mask_is_laid_where_its_origin_says() {
    let folder = TempDir::new().expect("a folder");
    let yaml = "image: mask.pgm\nresolution: 0.5\norigin: [10.0, 1.0, 1.5707963267948966]\nnegate: 0\n\
                occupied_thresh: 0.65\nfree_thresh: 0.196\nmode: raw\ntype: 2\nmultiplier: 0.01\n";
    std::fs::write(folder.path().join("mask.yaml"), yaml).expect("written");
    // Twelve columns along map +y, four rows along map -x: 0.2 m/s in the upper two.
    let rows = [
        "20 ".repeat(12),
        "20 ".repeat(12),
        "0 ".repeat(12),
        "0 ".repeat(12),
    ];
    let image = format!("P2\n12 4\n255\n{}\n", rows.join("\n"));
    std::fs::write(folder.path().join("mask.pgm"), image).expect("written");
    let text = format!(
        "{HALL}[[goals]]\npose = [12.5, 4.0, 0.0]\n[[zones]]\nname = \"floor\"\nmask = \"mask.yaml\"\n"
    );
    std::fs::write(folder.path().join("it.toml"), text).expect("written");
    let arguments = ["run", "./it.toml", "--lockstep", "--headless", "--json"];
    let result = Zeronav::start_in(folder, &arguments).finish().expect(0);
    let reasons = result["reasons"].as_array().expect("moments");
    let first = reasons
        .iter()
        .find(|it| it["zone"]["name"] == "floor")
        .expect("it is named");
    assert_eq!(first["zone"]["limit_mps"], 0.2);
    // A metre, from x = 8 to 9, takes 5 s; all of the way would take 13 s.
    let time_s = result["time_s"].as_f64().expect("a time");
    assert!((15.5..20.0).contains(&time_s), "{time_s}");
}
