//! A robot that is not where the stack takes it to be is told where it is, on the real processes.

use serde_json::Value;
use tempfile::TempDir;
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
