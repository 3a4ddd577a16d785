//! Goals that cannot be driven to: what is accepted, how it ends, and what is said of it, on the real
//! processes in lockstep.

use serde_json::Value;
use zeronav_tests::up::Up;
use zeronav_tests::{Zeronav, zeronav};

/// Two rooms with a wall between them whose door is 0.3 m wide; the porter's diameter is 0.5 m. In the
/// east there is a booth without a door, a metre from the wall.
const ROOMS: &str = r#"
title = "a door too narrow for the robot"
base = ["porter"]
[world]
area_m = [[0.0, 0.0], [10.0, 6.0]]
resolution_m = 0.05
shapes = [
    { kind = "box", centre_m = [5.0, 0.05], size_m = [10.0, 0.1] },
    { kind = "box", centre_m = [5.0, 5.95], size_m = [10.0, 0.1] },
    { kind = "box", centre_m = [0.05, 3.0], size_m = [0.1, 6.0] },
    { kind = "box", centre_m = [9.95, 3.0], size_m = [0.1, 6.0] },
    { kind = "box", centre_m = [5.02, 1.425], size_m = [0.1, 2.85] },
    { kind = "box", centre_m = [5.02, 4.575], size_m = [0.1, 2.85] },
    # The booth, 0.7 m of room inside, around (2, 1.5).
    { kind = "box", centre_m = [2.0, 1.1], size_m = [0.9, 0.1] },
    { kind = "box", centre_m = [2.0, 1.9], size_m = [0.9, 0.1] },
    { kind = "box", centre_m = [1.6, 1.5], size_m = [0.1, 0.9] },
    { kind = "box", centre_m = [2.4, 1.5], size_m = [0.1, 0.9] },
]
"#;

/// The scenario with these lines, in a folder.
fn folder(lines: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    let text = ROOMS.replace("[world]", &format!("{lines}\n[world]"));
    std::fs::write(folder.path().join("it.toml"), text).expect("written");
    folder
}

fn up(start: &str) -> Up {
    let lines = format!("start = {start}");
    Up::start_in(folder(&lines), &["./it.toml", "--lockstep"])
}

#[track_caller]
fn says(text: &str, words: &[&str]) {
    for word in words {
        assert!(text.contains(word), "`{word}` is not in: {text}");
    }
}

/// The three numbers behind these words.
#[track_caller]
fn pose_after<'a>(text: &'a str, words: &str) -> [&'a str; 3] {
    let (_, after) = text.split_once(words).unwrap_or_else(|| panic!("{text}"));
    let numbers: Vec<&str> = after.trim_start().split([' ', ';']).take(3).collect();
    numbers.try_into().expect("three numbers")
}

/// From afar, and from so near that the robot's own cell is within the inflation of the door's posts.
#[test]
fn a_door_too_narrow_is_proved_shut_from_afar_and_from_right_before_it() {
    for start in ["[2.5, 3.0, 0.0]", "[4.76, 3.0, 0.0]"] {
        let lines = format!("start = {start}\n[[goals]]\npose = [8.0, 3.0, 0.0]");
        let arguments = ["run", "./it.toml", "--lockstep", "--headless", "--json"];
        let ended = Zeronav::start_in(folder(&lines), &arguments).finish();
        let result = ended.json();
        assert_eq!(result["outcome"], "unreachable", "{start}: {result:#}");
        assert_eq!(result["recoveries"], 0, "{start}");
        let run = ended.folder.path();
        let run = run.join(result["directory"].as_str().expect("a folder"));
        let text = zeronav(&["why", run.to_str().expect("a path")]).stdout;
        says(
            &text,
            &["no way leads to the goal; the nearest way", "closed at ("],
        );
        says(&text, &[") by an obstacle of the static map."]);
        // The cells between the posts are its tightest.
        let (_, after) = text.split_once("closed at (").expect("a place");
        let (place, _) = after.split_once(')').expect("a place");
        let place: Vec<f64> = place.split(", ").filter_map(|it| it.parse().ok()).collect();
        assert!((place[0] - 5.02).abs() < 0.1, "{text}");
        assert!((place[1] - 3.0).abs() < 0.1, "{text}");
    }
}

/// A cart stands in the only door when the goal is given, and another one on the goal while the robot is on
/// its way there: both are waited for, with and without a static map.
#[test]
fn what_stands_in_the_only_door_or_on_the_goal_is_waited_for() {
    let carts = r#"
[[goals]]
pose = [8.0, 3.0, 0.0]
yaw_tolerance_rad = 3.15
[[world.obstacles]]
name = "in the door"
shape = { kind = "box", centre_m = [5.0, 3.0], size_m = [0.5, 0.7] }
appears = { at_s = 0.0 }
lasts_s = 13.0
[[world.obstacles]]
name = "on the goal"
shape = { kind = "disc", centre_m = [8.0, 3.0], radius_m = 0.35 }
appears = { at_s = 15.0 }
lasts_s = 12.0
"#;
    for static_map in [true, false] {
        let lines = format!("start = [2.5, 3.0, 0.0]\nstatic_map = {static_map}\n{carts}");
        let folder = folder(&lines);
        let file = folder.path().join("it.toml");
        let text = std::fs::read_to_string(&file).expect("the scenario");
        // The door is 0.9 m wide.
        let text = text
            .replace(
                "[5.02, 1.425], size_m = [0.1, 2.85]",
                "[5.02, 1.275], size_m = [0.1, 2.55]",
            )
            .replace(
                "[5.02, 4.575], size_m = [0.1, 2.85]",
                "[5.02, 4.725], size_m = [0.1, 2.55]",
            );
        std::fs::write(&file, text).expect("written");
        let arguments = ["run", "./it.toml", "--lockstep", "--headless", "--json"];
        let ended = Zeronav::start_in(folder, &arguments).finish();
        let result = ended.json();
        assert_eq!(result["outcome"], "reached", "{static_map}: {result:#}");
        assert_eq!(result["contacts"], 0, "{static_map}");
        let all = result["reasons"].as_array().expect("moments");
        // A path that has come is told before the wait is over.
        let waits = all.iter().filter(|it| it["path"]["status"] != "found");
        let waits = waits.filter(|it| it["task"]["waits_s"].as_u64() > Some(0));
        let waits: Vec<f64> = waits.filter_map(|it| it["time_s"].as_f64()).collect();
        let before = |time_s: f64| waits.iter().any(|wait| *wait < time_s);
        assert!(before(13.0), "{static_map}: {waits:?}");
        let second = waits.iter().find(|wait| **wait > 15.0);
        let second = second.unwrap_or_else(|| panic!("{static_map}: {waits:?}"));
        let run = ended.folder.path();
        let run = run.join(result["directory"].as_str().expect("a folder"));
        let run = run.to_str().expect("a path");
        let told = zeronav(&["why", run, &format!("{}", second + 0.001)]).stdout;
        let words = [
            "The robot waits for what is in its way to go",
            " s more, then the goal fails: ",
            "that the lidar saw",
        ];
        says(&told, &words);
    }
}

#[test]
fn the_end_of_a_goal_is_told_in_the_same_words_and_survives_the_local_planner() {
    let mut up = up("[2.5, 3.0, 0.0]");
    let lines = up.lines(&["goal", "8", "3", "0", "--wait"], 1);
    let last = lines.last().expect("a line");
    assert_eq!(last["outcome"], "unreachable", "{last}");
    let why = last["why"].as_str().expect("words").to_owned();
    says(&why, &["closed at (", ") by an obstacle of the static map"]);
    let told = up.ask(&["goal", "8", "3", "0", "--wait"], 1);
    says(&told, &["goal 2: unreachable, ", &why]);
    let sentence = format!("The task has failed: {why}. Another goal moves the robot.");
    says(&up.ask(&["why"], 0), &[&sentence]);
    says(up.status()["why"].as_str().expect("words"), &[&sentence]);
    // A successor knows nothing of the goal.
    up.ask(&["fault", "kill", "local_planner"], 0);
    up.stack.wait_until("a successor answers", |stack| {
        let report = stack.report().unwrap_or_default();
        let services = report["services"].as_array().cloned().unwrap_or_default();
        let newer = |service: &Value| {
            service["role"] == "local_planner"
                && service["epoch"] == 2
                && service["state"] == "ready"
        };
        services.iter().any(newer)
    });
    let tick = up.status()["tick"].as_u64();
    up.stack
        .wait_until("it has answered for two seconds", |stack| {
            let now = stack.report().and_then(|report| report["tick"].as_u64());
            now > tick.map(|tick| tick + 100)
        });
    says(&up.ask(&["why"], 0), &[&sentence]);
    says(up.status()["why"].as_str().expect("words"), &[&sentence]);
    // The next goal ends it.
    up.ask(
        &["goal", "3", "4", "0", "--yaw-tolerance", "3.15", "--wait"],
        0,
    );
    says(&up.ask(&["why"], 0), &["The robot has arrived"]);
    up.down();
}

#[test]
fn a_wide_tolerance_is_driven_to_where_it_can_be_reached_and_refused_where_the_map_has_no_cell() {
    let up = up("[3.5, 4.5, 0.0]");
    let any_yaw = ["--yaw-tolerance", "3.15"];
    // In the booth there is room, but no way in; outside of it is within the tolerance.
    let booth = ["goal", "2", "1.5", "0", "--tolerance"];
    let near = up.lines(&[&booth[..], &["0.05", "--wait"], &any_yaw].concat(), 1);
    assert_eq!(near.last().expect("a line")["outcome"], "unreachable");
    let wide = up.lines(&[&booth[..], &["1.0", "--wait"], &any_yaw].concat(), 0);
    assert_eq!(wide.last().expect("a line")["outcome"], "reached");
    // In the wall the nearest pose without contact is 0.30 m away, and the nearest cell's centre 0.345 m.
    let wall = ["goal", "5.02", "4.5", "0", "--tolerance"];
    let refused = up.ask(&[&wall[..], &["0.33"], &any_yaw].concat(), 2);
    says(
        &refused,
        &["the robot finds no room within 0.33 m of (5.02, 4.5)"],
    );
    // The pose that is offered can be driven to; the other side cannot, and is not offered.
    let [x, y, yaw] = pose_after(&refused, "the nearest free pose is");
    assert!(x.parse::<f64>().expect("a number") < 5.0, "{refused}");
    up.ask(&["goal", x, y, yaw, "--wait"], 0);
    up.ask(&[&wall[..], &["0.4", "--wait"], &any_yaw].concat(), 0);
    assert_eq!(up.down()["contacts"], 0);
}

#[test]
fn no_pose_is_offered_before_it_is_known_where_the_robot_can_drive_to() {
    let arguments = [
        "up",
        "./it.toml",
        "--lockstep",
        "--headless",
        "--external",
        "mapping",
    ];
    let mut stack = Zeronav::start_in(folder("start = [2.5, 3.0, 0.0]"), &arguments);
    stack.wait_until("it answers", |stack| stack.report().is_some());
    let root = stack.domains().pop().expect("a domain");
    let root = root.display().to_string();
    let refused = zeronav(&["goal", "-1", "-1", "0", "--domain", &root]);
    assert_eq!(refused.code(), 2, "{}", refused.stderr);
    says(
        &refused.stderr,
        &["(-1, -1) is not on the map; where it can drive to is not known"],
    );
    assert!(
        !refused.stderr.contains("nearest free pose"),
        "{}",
        refused.stderr
    );
    stack.signal(rustix::process::Signal::INT);
    let _ = stack.finish();
}
