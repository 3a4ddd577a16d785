//! A robot of ROS 2 in the robot's seat.

use crate::recording::{read_by_others, recording_of};
use rustix::process::Signal;
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::Path;
use zeronav_tests::rooms::box_in_an_aisle;
use zeronav_tests::ros2::{Peer, domain, folder_of};
use zeronav_tests::{Zeronav, command, real_time_turn, send_signal, workspace, zeronav};

const FLAGS: [&str; 4] = ["run", "./it.toml", "--headless", "--json"];

/// The mount of the robot's lidar, which it says by `/tf_static`.
const LASER: [&str; 4] = ["--laser", "0", "0", "0"];

/// Where the robot is, and its contacts.
fn truth(robot: &Peer) -> ([f64; 2], f64) {
    let truth = robot.newest("truth").expect("the truth");
    let number = |key: &str| truth[key].as_f64().unwrap_or(f64::NAN);
    ([number("x"), number("y")], number("contacts"))
}

/// The goal of the scenario.
fn is_at_goal(robot: &Peer) {
    let ([x, y], contacts) = truth(robot);
    assert!((x - 12.0).hypot(y - 6.425) < 0.3, "{x} {y}");
    assert!(contacts.abs() < 0.5, "{contacts} contacts");
    let commands = robot.said("command");
    let last = commands.last().expect("commands");
    let stop = serde_json::json!(0.0);
    assert_eq!((&last["v"], &last["w"]), (&stop, &stop), "the last command");
}

/// What `zeronav doctor --ros2` finds of the robot of the scenario in `folder`, by what was looked at.
fn doctor(folder: &Path, code: i32) -> BTreeMap<String, Value> {
    let ended = command()
        .args(["doctor", "--ros2", "./it.toml", "--json"])
        .current_dir(folder)
        .output()
        .expect("the doctor");
    let said = String::from_utf8_lossy(&ended.stderr);
    assert_eq!(ended.status.code(), Some(code), "{said}");
    let findings: Value = serde_json::from_slice(&ended.stdout).expect("JSON");
    let checks = findings["checks"].as_array().expect("checks").iter();
    let name = |it: &Value| it["check"].as_str().expect("a name").to_owned();
    checks.map(|it| (name(it), it.clone())).collect()
}

/// A robot with a name space, stamped commands, 20 Hz of odometry and a clock that is an hour ahead, looked at by the
/// doctor, driven and recorded.
#[test]
fn a_robot_of_ros_2_is_driven_around_a_box_in_the_aisle() {
    let _turn = real_time_turn();
    let domain_id = domain();
    let more = "config.ros.scan_topic = \"/r2/sensors/scan\"\nconfig.ros.odom_topic = \"/r2/odom\"\n\
                config.ros.tf_topic = \"/r2/tf\"\nconfig.ros.tf_static_topic = \"/r2/tf_static\"\n\
                config.ros.cmd_vel_topic = \"/r2/cmd_vel\"\nconfig.ros.cmd_vel_stamped = true\n";
    let (folder, config) = folder_of(&box_in_an_aisle(), domain_id, more);
    let nobody = doctor(folder.path(), 1);
    assert_eq!(nobody["network"]["level"], "error", "{nobody:#?}");
    let topics = [
        ["--scan", "/r2/sensors/scan"],
        ["--odom", "/r2/odom"],
        ["--tf", "/r2/tf"],
        ["--tf-static", "/r2/tf_static"],
        ["--cmd-vel", "/r2/cmd_vel"],
        ["--tick-hz", "20"],
        ["--clock-ahead-s", "3600"],
    ];
    let more = [&LASER[..], topics.as_flattened(), &["--stamped"]].concat();
    let robot = Peer::robot(domain_id, &config, &more);
    robot.wait_for("truth", |_| true);
    let seen = doctor(folder.path(), 0);
    for (check, words) in [
        ("scan", "/r2/sensors/scan by /robot (best effort)"),
        ("odometry", "/r2/odom by /robot (reliable)"),
        ("transforms", "from laser to base_link"),
        ("clock", "s ahead of this system's"),
        ("wheels", "geometry_msgs/TwistStamped is heard by /robot"),
    ] {
        let text = seen[check]["seen"].as_str().expect("text");
        assert!(text.contains(words), "{check}: {text}");
    }
    let clock = seen["clock"]["seen"].as_str().expect("text");
    let ahead_s = clock.split(' ').find_map(|word| word.parse::<f64>().ok());
    let ahead_s = ahead_s.expect("a number");
    assert!((ahead_s - 3600.0).abs() < 1.0, "{clock}");
    let ended = Zeronav::start_in(folder, &[&FLAGS[..], &["--record"]].concat()).finish();
    let result = ended.expect(0);
    assert_eq!(result["outcome"], "reached", "{}", ended.stderr);
    is_at_goal(&robot);
    // Others read the recording of it.
    let read = read_by_others(&recording_of(ended.folder.path()));
    assert_eq!(read["odometry_is_equal"], true, "{read:#}");
    assert_eq!(read["folder"], read["decoded"], "{read:#}");
    for topic in ["/scan", "/odom", "/cmd_vel", "/map", "/plan"] {
        assert!(
            read["rosbags"][topic].as_u64() > Some(0),
            "{topic}: {read:#}"
        );
    }
}

#[test]
fn shipped_robots_are_accepted() {
    for name in ["turtlebot4", "jackal"] {
        let file = workspace().join(format!("services/ros2/robots/{name}.toml"));
        let ended = zeronav(&["check", &file.display().to_string()]);
        assert_eq!(ended.code(), 0, "{}", ended.stderr);
    }
}

#[test]
fn a_bridge_that_is_killed_stands_the_robot_and_goes_on_when_it_is_back() {
    let _turn = real_time_turn();
    let domain_id = domain();
    // A base obeys nothing that is older than its timeout.
    let more = "\n[restart]\nrobot = true\n";
    let (folder, config) = folder_of(&box_in_an_aisle(), domain_id, more);
    // Over a network that loses one message in twenty and is 50 ms late, either way.
    let network = ["--lose", "0.05", "--delay-ms", "50"];
    let robot = Peer::robot(domain_id, &config, &[&LASER[..], &network].concat());
    let mut run = Zeronav::start_in(folder, &FLAGS);
    for at_x_m in [5.5, 7.0] {
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
