//! A robot that is not where the stack takes it to be is told where it is, on the real processes.

use serde_json::Value;
use std::path::Path;
use tempfile::TempDir;
use zeronav_tests::leftovers;
use zeronav_tests::up::Up;

/// A robot that is told before the drive that it is somewhere else.
const ROOMS: &str = r#"
title = "a robot that is told where it is"
base = ["two_rooms", "porter"]
start = [1.5, 4.5, 0.0]
[robot]
odometry = true
"#;

/// Farther from its start than mapping can find it again by itself.
const ELSEWHERE: [&str; 3] = ["4.0", "3.5", "0.8"];

/// Through the door, behind which the robot must really be.
const GOAL: [f64; 3] = [12.0, 4.5, 0.0];

fn start() -> Up {
    let folder = TempDir::new().expect("a folder");
    std::fs::write(folder.path().join("it.toml"), ROOMS).expect("written");
    let mut up = Up::start_in(folder, &["./it.toml", "--lockstep"]);
    up.stack.wait_until("the robot knows where it is", |stack| {
        let report = stack.report().unwrap_or_default();
        off(&report).is_some_and(|[place_m, _]| place_m < 0.1)
    });
    let [x_m, y_m, yaw_rad] = ELSEWHERE;
    assert_eq!(up.ask(&["pose", x_m, y_m, yaw_rad], 0), "placed\n");
    up.stack.wait_until("it is told wrongly", |stack| {
        let report = stack.report().unwrap_or_default();
        off(&report).is_some_and(|[place_m, yaw_rad]| place_m > 1.0 && yaw_rad > 0.5)
    });
    up
}

fn pose(report: &Value, key: &str) -> Option<[f64; 3]> {
    let pose = report[key].as_array()?;
    let number = |index: usize| pose.get(index)?.as_f64();
    Some([number(0)?, number(1)?, number(2)?])
}

/// How far the pose by the map is from the true one. [m, rad]
fn off(report: &Value) -> Option<[f64; 2]> {
    let (by_map, truth) = (pose(report, "estimate")?, pose(report, "pose")?);
    let turned = (by_map[2] - truth[2]).rem_euclid(core::f64::consts::TAU);
    Some([
        (by_map[0] - truth[0]).hypot(by_map[1] - truth[1]),
        turned.min(core::f64::consts::TAU - turned),
    ])
}

/// Waits until the pose by the map is the true one.
fn await_located(up: &mut Up, what: &str) {
    up.stack.wait_until(what, |stack| {
        let report = stack.report().unwrap_or_default();
        off(&report).is_some_and(|[place_m, yaw_rad]| place_m < 0.1 && yaw_rad < 0.05)
    });
}

/// Says where the robot is, as exactly as a person can.
fn tell(up: &Up) {
    let [x_m, y_m, yaw_rad] = pose(&up.status(), "pose").expect("a true pose");
    let words = [x_m + 0.1, y_m - 0.08, yaw_rad + 0.06].map(|number| number.to_string());
    let [x_m, y_m, yaw_rad] = words.each_ref().map(String::as_str);
    assert_eq!(up.ask(&["pose", x_m, y_m, yaw_rad], 0), "placed\n");
}

#[test]
fn a_robot_that_is_told_where_it_is_arrives() {
    let mut up = start();
    tell(&up);
    await_located(&mut up, "mapping has laid the scan on the map");
    let [x, y, yaw] = GOAL.map(|number| number.to_string());
    let lines = up.lines(&["goal", &x, &y, &yaw, "--wait"], 0);
    assert_eq!(lines.last().expect("a line")["outcome"], "reached");
    let [x_m, y_m, _] = pose(&up.status(), "pose").expect("a true pose");
    let beside_m = (x_m - GOAL[0]).hypot(y_m - GOAL[1]);
    assert!(beside_m < 0.4, "it is {beside_m} m from its goal");
    assert_eq!(up.down()["contacts"], 0);
}

/// Waits until a new mapping is in the seat.
fn await_successor(up: &mut Up) {
    up.stack.wait_until("a successor answers", |stack| {
        let report = stack.report().unwrap_or_default();
        let services = report["services"].as_array().cloned().unwrap_or_default();
        services.iter().any(|service| {
            service["role"] == "mapping" && service["epoch"] == 2 && service["state"] == "ready"
        })
    });
}

/// What launch remembers of the map is older than what the person said.
#[test]
fn a_pose_that_is_given_just_before_mapping_dies_is_not_lost() {
    let mut up = start();
    up.ask(&["pause"], 0);
    tell(&up);
    up.ask(&["fault", "kill", "mapping"], 0);
    up.ask(&["resume"], 0);
    await_successor(&mut up);
    let tick = up.status()["tick"].as_u64();
    up.stack.wait_until("it has taken in scans", |stack| {
        let now = stack.report().and_then(|report| report["tick"].as_u64());
        now > tick.map(|tick| tick + 50)
    });
    let [place_m, yaw_rad] = off(&up.status()).expect("poses");
    assert!(
        place_m < 0.3 && yaw_rad < 0.2,
        "{place_m} m, {yaw_rad} rad off"
    );
    let _ = up.down();
}

#[test]
fn a_new_mapping_knows_where_the_robot_was_said_to_be() {
    let mut up = start();
    tell(&up);
    await_located(&mut up, "mapping has laid the scan on the map");
    up.ask(&["fault", "kill", "mapping"], 0);
    await_successor(&mut up);
    let tick = up.status()["tick"].as_u64();
    up.stack.wait_until("it has taken in scans", |stack| {
        let now = stack.report().and_then(|report| report["tick"].as_u64());
        now > tick.map(|tick| tick + 50)
    });
    await_located(&mut up, "the successor has the robot in the same place");
    let _ = up.down();
}

#[test]
fn poses_where_the_robot_cannot_be_are_rejected_and_change_nothing() {
    let up = start();
    let before = off(&up.status()).expect("poses");
    let outside = up.ask(&["pose", "100", "4.5", "0"], 2);
    assert!(outside.contains("is not on the map"), "{outside}");
    let wall = up.ask(&["pose", "0.05", "4.5"], 2);
    assert!(wall.contains("would be in an obstacle"), "{wall}");
    assert!(wall.contains("the nearest free pose is"), "{wall}");
    up.ask(&["pose", "nan", "4.5"], 2);
    let after = off(&up.status()).expect("poses");
    assert!((before[0] - after[0]).abs() < 0.3, "{before:?} {after:?}");
    let _ = up.down();
}

/// Brings up a stack whose runs are in `runs`.
fn start_beside(runs: &TempDir, text: &str, more: &[&str]) -> Up {
    let folder = TempDir::new().expect("a folder");
    std::fs::write(folder.path().join("it.toml"), text).expect("written");
    let runs = runs.path().to_str().expect("a path");
    Up::start_in(
        folder,
        &[&["./it.toml", "--lockstep", "--out", runs], more].concat(),
    )
}

#[test]
fn a_stack_goes_on_where_the_last_one_was_left() {
    let runs = TempDir::new().expect("a folder");
    let file = runs.path().join("last-pose-it.json");
    let mut up = start_beside(&runs, ROOMS, &["--resume-pose"]);
    await_located(&mut up, "nothing was saved: it is where the scenario says");
    let [x, y, yaw] = ELSEWHERE;
    let lines = up.lines(&["goal", x, y, yaw, "--wait"], 0);
    assert_eq!(lines.last().expect("a line")["outcome"], "reached");
    let left = pose(&up.status(), "pose").expect("a true pose");
    up.down();
    let text = std::fs::read_to_string(&file).expect("the last pose");
    let saved: Value = serde_json::from_str(&text).expect("JSON");
    let saved = pose(&saved, "pose").expect("a pose");
    let off_m = (saved[0] - left[0]).hypot(saved[1] - left[1]);
    assert!(off_m < 0.1, "{saved:?}, not {left:?}");

    // It stands there, is told that it is 2 m away, and does not notice that by itself.
    let wrong = format!(
        "{}[services.mapping.config.localisation]\nlost_below = 0.0\nmap_from_odom = [2.0, 0.0, 0.0]\n",
        ROOMS.replace("[1.5, 4.5, 0.0]", &format!("{left:?}"))
    );
    let mut up = start_beside(&runs, &wrong, &["--resume-pose"]);
    await_located(&mut up, "it is where the last one was left");
    up.down();
    let place = |x_m: f64| format!("{{\"map\":{},\"pose\":[{x_m},0.0,0.0]}}", map_of(&text));
    for (text, why) in [
        (
            text.replace("\"map\":\"", "\"map\":\"0"),
            "is of another map",
        ),
        ("{\"pose\": [1".to_owned(), "EOF while parsing"),
        (place(1.0e3), "is not on the map"),
    ] {
        std::fs::write(&file, &text).expect("written");
        let mut up = start_beside(&runs, &wrong, &["--resume-pose"]);
        up.stack.wait_until("it is told as always", |stack| {
            let report = stack.report().unwrap_or_default();
            let time_s = report["time_s"].as_f64().unwrap_or_default();
            time_s > 2.0 && off(&report).is_some_and(|[place_m, _]| (1.5..2.5).contains(&place_m))
        });
        let root = up.root.clone();
        let said = up.ask(&["down"], 0);
        assert!(said.contains("is down"), "{said}");
        let ended = up.stack.finish();
        let line = ended
            .stderr
            .lines()
            .find(|line| line.contains("no pose is resumed"));
        assert!(
            line.is_some_and(|line| line.contains(why)),
            "{}",
            ended.stderr
        );
        assert!(leftovers(Path::new(&root)).is_empty());
        // It has not moved: what it was told is no news.
        assert_eq!(std::fs::read_to_string(&file).expect("the file"), text);
    }
}

/// The map of a file, in quotes.
fn map_of(text: &str) -> String {
    let saved: Value = serde_json::from_str(text).expect("JSON");
    saved["map"].to_string()
}
