//! Tools of ROS 2 beside the stack: what they see, and their goals.

use rustix::process::Signal;
use serde_json::{Value, json};
use std::time::Duration;
use zeronav_tests::python::distro;
use zeronav_tests::ros2::{Peer, domain};
use zeronav_tests::up::Up;
use zeronav_tests::{await_by_itself, real_time_turn, send_signal, shipped};

/// Statuses of `action_msgs/GoalStatus`.
const SUCCEEDED: u64 = 4;
const CANCELED: u64 = 5;
const ABORTED: u64 = 6;

/// A stack with a simulated robot and the companion, in a domain of ROS 2.
fn stack(domain_id: u32) -> Up {
    let folder = tempfile::tempdir().expect("a folder");
    let text = shipped("open_aisle");
    let (text, _) = text.split_once("[[goals]]").expect("goals");
    let text = format!(
        "{text}\n[companions.ros2]\nbinary = \"zeronav-ros2-companion\"\nconfig.distro = \"{}\"\n\
         config.robot_topics = true\nconfig.network = {{ domain_id = {domain_id}, range = \"localhost\" }}\n",
        distro()
    );
    std::fs::write(folder.path().join("it.toml"), text).expect("written");
    Up::start_in(folder, &["./it.toml"])
}

/// Process id of the companion.
fn companion(up: &Up) -> u32 {
    let report = up.stack.report().expect("a report");
    let all = report["companions"].as_array().expect("companions");
    let pid = all.iter().find(|it| it["name"] == "ros2");
    let pid = pid.and_then(|it| it["pid"].as_u64()).expect("a process");
    u32::try_from(pid).expect("a process id")
}

fn go(client: &mut Peer, name: &str, pose: [f64; 3]) {
    client.order(&json!({ "order": "go", "name": name, "pose": pose }));
}

/// How the goal `name` ended: status and error code.
fn end(client: &Peer, name: &str) -> (u64, u64) {
    let result = client.wait_for("result", |it| it["name"] == name);
    let number = |key: &str| result[key].as_u64().unwrap_or(u64::MAX);
    (number("status"), number("code"))
}

fn is_accepted(client: &Peer, name: &str) -> Value {
    client.wait_for("accepted", |it| it["name"] == name)["accepted"].clone()
}

// long: one drive, because a stack takes seconds to start
#[test]
fn clients_of_nav2_see_the_stack_and_drive_it() {
    let _turn = real_time_turn();
    let domain_id = domain();
    let up = stack(domain_id);
    let mut client = Peer::start("client", domain_id, &[]);
    client.wait_for("ready", |_| true);
    for node in ["bt_navigator", "amcl"] {
        client.order(&json!({ "order": "state", "node": node }));
        let state = client.wait_for("state", |it| it["node"] == node);
        assert_eq!(state["label"], "active", "{state}");
    }
    // What RViz shows, and who comes late sees it as well.
    let map = client.wait_for("map", |_| true);
    let late = Peer::start("client", domain_id, &[]);
    let again = late.wait_for("map", |_| true);
    assert_eq!(
        [&map["width"], &map["height"]],
        [&again["width"], &again["height"]]
    );
    assert!(map["occupied"].as_u64() > Some(100), "{map}");
    // The costs around the robot, which stands at 3, 8.5 beside a rack.
    let costs = client.wait_for("costs", |it| it["obstacle"].as_u64() > Some(10));
    assert_eq!(costs["frame"], "map", "{costs}");
    let (side, corner) = (&costs["side"][0], &costs["corner"][0]);
    assert!(
        (side.as_f64().expect("a side") - 6.0).abs() < 0.2,
        "{costs}"
    );
    assert!(
        corner.as_f64().is_some_and(|x_m| x_m.abs() < 0.2),
        "{costs}"
    );
    for kind in ["inscribed", "between"] {
        assert!(costs[kind].as_u64() > Some(10), "{costs}");
    }
    for names in [["map", "odom"], ["odom", "base_link"]] {
        client.wait_for("tf", |it| [&it["parent"], &it["child"]] == names);
    }

    // To a pose, with feedback on the way; the newest goal takes the place of the one before.
    let (far, at) = ([27.0, 8.5, 0.0], |x_m: f64| [x_m, 8.5, 0.0]);
    go(&mut client, "far", far);
    assert_eq!(is_accepted(&client, "far"), true);
    client.wait_for("feedback", |it| {
        it["name"] == "far" && it["left"].as_f64() < Some(25.0)
    });
    client.wait_for("plan", |it| {
        it["frame"] == "map" && it["n"].as_u64() > Some(1)
    });
    go(&mut client, "near", at(4.0));
    assert_eq!(end(&client, "far").0, ABORTED, "another took its place");
    assert_eq!(end(&client, "near"), (SUCCEEDED, 0));

    // Cancelled, impossible, and in another frame.
    go(&mut client, "away", far);
    client.wait_for("feedback", |it| it["name"] == "away");
    client.order(&json!({ "order": "cancel", "name": "away" }));
    assert_eq!(client.wait_for("cancelling", |_| true)["n"], 1);
    assert_eq!(end(&client, "away").0, CANCELED);
    go(&mut client, "outside", [-400.0, 0.0, 0.0]);
    assert_eq!(end(&client, "outside"), (ABORTED, 204));
    client.order(&json!({ "order": "go", "name": "odom", "pose": at(3.0), "frame": "odom" }));
    assert_eq!(is_accepted(&client, "odom"), false);

    // Several poses, and waypoints.
    client.order(&json!({ "order": "through", "name": "through", "poses": [at(5.0), at(6.0)] }));
    assert_eq!(end(&client, "through"), (SUCCEEDED, 0));
    client.order(&json!({ "order": "waypoints", "name": "round", "poses": [at(5.0), at(4.0)] }));
    assert_eq!(end(&client, "round"), (SUCCEEDED, 0));

    // A flood on the topic of goals: the newest counts, and the stack drives on.
    client.order(&json!({ "order": "goal_pose", "pose": far, "times": 5_000 }));
    client.order(&json!({ "order": "goal_pose", "pose": at(6.0) }));
    let is_there = |it: &Value| it["x"].as_f64().is_some_and(|x| x > 5.8);
    let before = client.said("pose").len();
    await_by_itself("the newest goal is reached", || {
        client.said("pose").iter().skip(before).any(is_there)
    });
    go(&mut client, "after", at(5.0));
    assert_eq!(end(&client, "after"), (SUCCEEDED, 0));

    // Killed, the companion comes back, and clients find it.
    let (maps, pid) = (client.said("map").len(), companion(&up));
    assert!(send_signal(pid, Signal::KILL));
    await_by_itself("the map is there again", || {
        client.said("map").len() > maps && companion(&up) != pid
    });
    // Goals by topic: a request for an action may go to the one that is gone while its lease lasts.
    let before = client.said("pose").len();
    let is_there = |it: &Value| it["x"].as_f64().is_some_and(|x| x < 4.4);
    await_by_itself("a goal is reached", || {
        client.order(&json!({ "order": "goal_pose", "pose": at(4.0) }));
        std::thread::sleep(Duration::from_millis(500));
        client.said("pose").iter().skip(before).any(is_there)
    });
    let report = up.down();
    assert_eq!(report["contacts"].as_u64().unwrap_or(0), 0, "{report:#}");
}
