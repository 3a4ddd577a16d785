//! A robot of ROS 2 in the robot's seat.

use super::peer::{Peer, domain};
use rustix::process::Signal;
use std::path::{Path, PathBuf};
use tempfile::TempDir;
use zeronav_robot_sim::SimConfig;
use zeronav_scenario::Scenario;
use zeronav_tests::{Zeronav, real_time_turn, send_signal, shipped};

/// The shipped scenario `name` with the robot of a ROS domain in it: its folder, and the configuration of the robot's
/// hardware.
fn folder_of(name: &str, domain_id: u32, more: &str) -> (TempDir, PathBuf) {
    let folder = tempfile::tempdir().expect("a folder");
    let text = shipped(name);
    // What the simulator alone can tell is asked of the robot's own side.
    let (text, _) = text.split_once("[expect]").expect("expectations");
    let text = format!(
        "{text}\n[expect]\noutcome = \"reached\"\n\n[services.robot]\nbinary = \"zeronav-ros2\"\n\
         config.ros.network = {{ domain_id = {domain_id}, range = \"localhost\" }}\n{more}\n"
    );
    std::fs::write(folder.path().join("it.toml"), text).expect("written");
    let config = hardware(folder.path());
    (folder, config)
}

/// Writes the world and the robot of the scenario in `folder` for the robot's hardware.
fn hardware(folder: &Path) -> PathBuf {
    let file = folder.join("it.toml").display().to_string();
    let scenario = Scenario::load(&file).expect("a scenario");
    let start = scenario.start;
    let config = SimConfig {
        start: [start.x_m, start.y_m, start.yaw_rad],
        world: scenario.world.clone(),
        robot: scenario.robot.clone(),
    };
    let path = folder.join("hardware.toml");
    let text = toml::to_string(&config).expect("TOML");
    std::fs::write(&path, text).expect("written");
    path
}

const FLAGS: [&str; 4] = ["run", "./it.toml", "--headless", "--json"];

/// The mount of the robot's lidar, which it says by `/tf_static`.
const LASER: [&str; 4] = ["--laser", "0", "0", "0"];

/// Where the robot is, and its contacts.
fn truth(robot: &Peer) -> ([f64; 2], f64) {
    let truth = robot.newest("truth").expect("the truth");
    let number = |key: &str| truth[key].as_f64().unwrap_or(f64::NAN);
    ([number("x"), number("y")], number("contacts"))
}

/// The goal of the shipped scenario.
fn is_at_goal(robot: &Peer) {
    let ([x, y], contacts) = truth(robot);
    assert!((x - 27.0).hypot(y - 8.5) < 0.3, "{x} {y}");
    assert!(contacts.abs() < 0.5, "{contacts} contacts");
    let commands = robot.said("command");
    let last = commands.last().expect("commands");
    let stop = serde_json::json!(0.0);
    assert_eq!((&last["v"], &last["w"]), (&stop, &stop), "the last command");
}

#[test]
fn a_robot_of_ros_2_is_driven_around_a_load_in_the_aisle() {
    let _turn = real_time_turn();
    let domain_id = domain();
    let (folder, config) = folder_of("blocked_aisle", domain_id, "");
    // Its clock is an hour ahead.
    let more = [&LASER[..], &["--clock-ahead-s", "3600"]].concat();
    let robot = Peer::robot(domain_id, &config, &more);
    let ended = Zeronav::start_in(folder, &FLAGS).finish();
    let result = ended.expect(0);
    assert_eq!(result["outcome"], "reached", "{}", ended.stderr);
    is_at_goal(&robot);
}

#[test]
fn a_bridge_that_is_killed_stands_the_robot_and_goes_on_when_it_is_back() {
    let _turn = real_time_turn();
    let domain_id = domain();
    // A base obeys nothing that is older than its timeout.
    let more = "\n[restart]\nrobot = true\n";
    let (folder, config) = folder_of("blocked_aisle", domain_id, more);
    let robot = Peer::robot(domain_id, &config, &LASER);
    let mut run = Zeronav::start_in(folder, &FLAGS);
    for at_x_m in [5.0, 7.0] {
        robot.wait_for("truth", |it| it["x"].as_f64().is_some_and(|x| x > at_x_m));
        let pid = run.service("robot").expect("the bridge");
        assert!(send_signal(pid, Signal::KILL));
        run.wait_until("another bridge", |run| {
            run.service("robot").is_some_and(|now| now != pid)
        });
    }
    // Stopped, it is taken for hung, and the robot stands meanwhile.
    robot.wait_for("truth", |it| it["x"].as_f64().is_some_and(|x| x > 8.0));
    let pid = run.service("robot").expect("the bridge");
    assert!(send_signal(pid, Signal::STOP));
    let ended = run.finish();
    let result = ended.expect(0);
    assert_eq!(result["outcome"], "reached", "{}", ended.stderr);
    let restarts = result["restarts"].as_array().map_or(0, Vec::len);
    assert!(restarts >= 3, "{restarts} restarts: {}", ended.stderr);
    is_at_goal(&robot);
}
