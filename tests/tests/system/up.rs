//! A stack that stays up: goals of clients, pause, step, and its end, on the real processes.

use serde_json::Value;
use std::path::{Path, PathBuf};
use std::time::Instant;
use zeronav_tests::up::Up;
use zeronav_tests::{leftovers, real_time_turn, zeronav};

/// Run time that a goal took. [s]
fn elapsed_s(lines: &[Value]) -> f64 {
    let last = lines.last().expect("a line");
    last["elapsed_s"].as_f64().expect("seconds")
}

fn outcomes(result: &Value) -> Vec<&str> {
    let goals = result["goals"].as_array().expect("goals");
    let outcomes = goals.iter().map(|goal| goal["outcome"].as_str());
    outcomes.map(|outcome| outcome.expect("a word")).collect()
}

#[test]
fn goals_of_two_clients_are_served_as_they_came_and_bad_ones_change_nothing() {
    let _turn = real_time_turn();
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().display().to_string();
    let mut up = Up::start(&["open_aisle", "--out", &out]);
    // Nobody drives a scenario's own goals.
    assert_eq!(up.status()["task"], "waiting");
    up.stack.wait_until("it says that it has no goal", |stack| {
        let report = stack.report().unwrap_or_default();
        let why = report["why"].as_str().unwrap_or_default();
        why.contains("There is no goal") && !why.contains("scan missing")
    });
    let first = up.lines(&["goal", "6", "8.5", "0"], 0);
    assert_eq!(first[0]["outcome"], "active", "{first:?}");
    // Where it can drive to is known from its first map on.
    let refused = ["goal", "13.0", "8.05", "0", "--domain", &up.root];
    let mut rack = String::new();
    up.stack.wait_until("a pose is offered", |_| {
        rack = zeronav(&refused).stderr;
        rack.contains("the nearest free pose is ")
    });
    let nearest = rack.split("the nearest free pose is ").nth(1);
    let nearest: Vec<&str> = nearest.expect(&rack).split([' ', ';']).take(3).collect();
    assert!(
        up.ask(&["goal", "900", "900", "0"], 2)
            .contains("not on the map")
    );
    let second = up.lines(&["goal", "4", "8.5", "3.14", "--wait"], 0);
    assert_eq!(second[0]["outcome"], "queued", "{second:?}");
    assert_eq!(second[0]["before"], 1, "{second:?}");
    let active = second.iter().find(|line| line["outcome"] == "active");
    assert!(active.is_some(), "no feedback: {second:?}");
    let last = second.last().expect("a line");
    assert_eq!(last["outcome"], "reached");
    assert!(last["elapsed_s"].as_f64() > Some(1.0), "{last}");
    // The pose that was offered in place of the rack can be driven to.
    let [x, y, yaw] = nearest[..] else {
        panic!("no pose: {rack}");
    };
    up.ask(&["goal", x, y, yaw, "--time-limit", "3"], 0);
    up.wait_for_outcome("the offered pose is driven to", "active");
    up.ask(&["wait", "goal"], 1);
    up.ask(&["wait", "idle"], 0);
    let result = up.down();
    assert_eq!(outcomes(&result), ["reached", "reached", "time_limit"]);
    assert_eq!(result["contacts"], 0);
    // Its latencies are those of a run.
    let reactions = result["latency"]["reaction"]["n"].as_u64();
    assert!(reactions > Some(20), "{}", result["latency"]);
    let left = Path::new(result["directory"].as_str().expect("a folder"));
    let trace = std::fs::read_to_string(left.join("trace.json")).expect("a trace");
    assert!(trace.contains("scan to wheel"));
    assert!(trace.contains("ray casting"), "its stages are timed");
    let report = std::fs::read_to_string(left.join("report.html")).expect("a report");
    assert!(report.contains("id=\"hops\""));
}

#[test]
fn a_goal_now_replaces_the_others_and_cancel_stops_the_robot() {
    let _turn = real_time_turn();
    let mut up = Up::start(&["open_aisle"]);
    assert!(up.ask(&["cancel"], 2).contains("no goal to cancel"));
    up.ask(&["goal", "27", "8.5", "0"], 0);
    up.ask(&["goal", "3", "8.5", "0"], 0);
    up.ask(&["goal", "6", "8.5", "0", "--now"], 0);
    assert_eq!(up.status()["goal"]["id"], 3);
    assert_eq!(up.status()["goals_waiting"], 0);
    up.ask(&["cancel", "9"], 2);
    up.ask(&["cancel"], 0);
    up.ask(&["wait", "idle"], 0);
    // The stack stays up, and a new local planner does not take the last task up again.
    up.ask(&["fault", "kill", "local_planner"], 0);
    up.stack.wait_until("a successor answers", |stack| {
        let report = stack.report().unwrap_or_default();
        let services = report["services"].as_array().cloned().unwrap_or_default();
        services.iter().any(|service| {
            service["role"] == "local_planner"
                && service["epoch"] == 2
                && service["state"] == "ready"
        })
    });
    let before = up.status()["tick"].as_u64();
    up.stack.wait_until("half a second passes", |stack| {
        let tick = stack.report().and_then(|report| report["tick"].as_u64());
        tick > before.map(|tick| tick + 25)
    });
    assert_eq!(up.status()["task"], "waiting");
    let result = up.down();
    assert_eq!(outcomes(&result), ["replaced", "replaced", "cancelled"]);
    assert_eq!(result["restarts"].as_array().map(Vec::len), Some(1));
}

/// Such as a real one, whose seat tells no ground truth.
#[test]
fn a_robot_without_ground_truth_gives_feedback_by_its_odometry() {
    let folder = tempfile::tempdir().expect("a folder");
    let text = "title = \"a real robot\"\nbase = [\"warehouse\", \"porter\"]\n\
        start = [4.0, 6.425, 0.0]\n\
        [services.robot]\nbinary = \"minimal_robot\"\nconfig.is_real = true\n";
    std::fs::write(folder.path().join("it.toml"), text).expect("written");
    let _turn = real_time_turn();
    let up = Up::start_in(folder, &["./it.toml"]);
    let lines = up.lines(&["goal", "12.5", "6.425", "0", "--wait"], 0);
    let rest_s = |line: &serde_json::Value| line["time_remaining_s"].as_f64();
    assert!(
        lines.iter().filter_map(rest_s).any(|rest_s| rest_s > 1.0),
        "{lines:?}"
    );
    let last = lines.last().expect("a line");
    assert_eq!(last["outcome"], "reached", "{lines:?}");
    assert!(elapsed_s(&lines) > 5.0, "{lines:?}");
    let status = up.status();
    assert_eq!(status["pose"], serde_json::Value::Null, "{status:#}");
    let x_m = status["estimate"][0].as_f64().expect("a pose by the map");
    assert!((x_m - 12.5).abs() < 0.5, "{status:#}");
    // It has to be asked to stop, too.
    up.ask(&["goal", "4", "6.425", "0"], 0);
    let _ = up.down();
}

#[test]
fn a_paused_lockstep_stack_does_the_ticks_that_it_is_told() {
    let mut up = Up::start(&["open_aisle", "--lockstep"]);
    assert!(up.ask(&["step"], 2).contains("not paused"));
    up.ask(&["pause"], 0);
    // It does what it may have begun, then it is still.
    let mut tick = u64::MAX;
    up.stack.wait_until("run time is held", |stack| {
        let now = stack.report().and_then(|report| report["tick"].as_u64());
        let now = now.unwrap_or_default();
        std::mem::replace(&mut tick, now) == now
    });
    let still = up.status()["tick"].as_u64().expect("a tick");
    up.ask(&["step", "7"], 0);
    up.stack.wait_until("seven ticks are done", |stack| {
        let tick = stack.report().and_then(|report| report["tick"].as_u64());
        tick == Some(still + 7)
    });
    up.ask(&["goal", "6", "8.5", "0"], 0);
    up.ask(&["resume"], 0);
    up.ask(&["wait", "goal"], 0);
    assert!(up.ask(&["resume"], 2).contains("not paused"));
    assert_eq!(outcomes(&up.down()), ["reached"]);
}

#[test]
fn a_lockstep_stack_goes_as_fast_as_it_is_told() {
    let started = Instant::now();
    let mut up = Up::start(&["open_aisle", "--lockstep"]);
    // Without a goal it goes in real time, but for the ticks that it begins with.
    up.stack.wait_until("two seconds are over", |stack| {
        let run_s = stack.report().and_then(|report| report["time_s"].as_f64());
        let wall_s = started.elapsed().as_secs_f64();
        assert!(run_s < Some(wall_s + 1.0), "{run_s:?} s after {wall_s} s");
        run_s > Some(2.0)
    });
    for wrong in ["0", "-1", "1000", "fast", "NaN"] {
        up.ask(&["speed", wrong], 2);
    }
    assert_eq!(up.status()["speed"], Value::Null);
    up.ask(&["speed", "2"], 0);
    assert_eq!(up.status()["speed"], 2.0);
    let began = Instant::now();
    let from = up.status()["tick"].as_u64().expect("a tick");
    let mut tick = 0;
    up.stack.wait_until("200 ticks are done", |stack| {
        let report = stack.report();
        tick = report.map_or(0, |report| report["tick"].as_u64().unwrap_or_default());
        tick >= from + 200
    });
    // A tick in 10 ms, after those that it had begun and those that it was behind.
    let most = 36 + began.elapsed().as_millis() / 10;
    let done = u128::from(tick - from);
    assert!(done <= most, "{done} ticks of {most}");
    up.ask(&["speed", "max"], 0);
    assert_eq!(up.status()["speed"], Value::Null);
    up.ask(&["goal", "6", "8.5", "0", "--wait"], 0);
    up.down();
    let up = Up::start(&["open_aisle"]);
    assert!(up.ask(&["speed", "2"], 2).contains("lockstep"));
    up.down();
}

#[test]
fn a_file_of_goals_is_driven_in_order_and_again() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("goals.toml");
    let text = "[[goals]]\npose = [5.0, 8.5, 0.0]\n[[goals]]\npose = [3.0, 8.5, 0.0]\n";
    std::fs::write(&file, text).expect("written");
    let file = file.display().to_string();
    let up = Up::start(&["open_aisle", "--lockstep"]);
    let lines = up.lines(&["goals", &file, "--wait"], 0);
    assert_eq!(lines[0]["goals_left"], 2, "{lines:?}");
    let twice = up.lines(
        &["goals", &file, "--loop", "--wait", "--time-limit", "30"],
        1,
    );
    assert_eq!(twice.last().expect("a line")["outcome"], "time_limit");
    std::fs::write(&file, text.replace("pose", "poze")).expect("written");
    let bad = up.ask(&["goals", &file], 2);
    assert!(bad.contains("goals.toml:2"), "{bad}");
    assert_eq!(outcomes(&up.down()), ["reached", "time_limit"]);
}

#[test]
fn a_map_and_a_robot_are_enough() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut pgm = b"P5\n100 60\n255\n".to_vec();
    let wall = |x: usize, y: usize| x < 2 || y < 2 || x > 97 || y > 57 || (x == 50 && y > 20);
    pgm.extend((0..60).flat_map(|y| (0..100).map(move |x| if wall(x, y) { 0 } else { 254 })));
    std::fs::write(folder.path().join("room.pgm"), pgm).expect("written");
    let yaml = "image: room.pgm\nresolution: 0.1\norigin: [0, 0, 0]\nnegate: 0\n\
                occupied_thresh: 0.65\nfree_thresh: 0.196\n";
    std::fs::write(folder.path().join("room.yaml"), yaml).expect("written");
    let robot = [
        "--map",
        "room.yaml",
        "--robot",
        "turtlebot3_burger",
        "--lockstep",
    ];
    let up = Up::start_in(folder, &robot);
    let pose = up.status()["pose"].clone();
    up.ask(&["goal", "8", "1", "0", "--wait"], 0);
    assert_ne!(up.status()["pose"], pose, "it did not move");
    let result = up.down();
    assert_eq!(outcomes(&result), ["reached"]);
    assert_eq!(result["scenario"], "room");
}

#[test]
fn obstacles_are_added_moved_and_removed_while_the_robot_drives() {
    let up = Up::start(&["open_aisle", "--lockstep"]);
    let on_it = ["obstacle", "add", "crate", "3", "8.5", "--radius", "0.2"];
    assert!(up.ask(&on_it, 2).contains("the robot is there"));
    let unknown = up.ask(&["obstacle", "move", "crate", "9", "6.4"], 2);
    assert!(unknown.contains("no obstacle crate"), "{unknown}");
    up.ask(&["pause"], 0);
    up.ask(&["goal", "27", "8.5", "0"], 0);
    // The straight way through the aisle is closed before the robot is there.
    up.ask(
        &["obstacle", "add", "other", "9", "8.5", "--radius", "0.2"],
        0,
    );
    let onto_it = up.ask(&["obstacle", "move", "other", "3", "8.5"], 2);
    assert!(onto_it.contains("the robot is there"), "{onto_it}");
    up.ask(&["obstacle", "remove", "other"], 0);
    let add = [
        "obstacle", "add", "crate", "11.3", "6.425", "--size", "0.8", "1.85",
    ];
    up.ask(&add, 0);
    assert!(up.ask(&add, 2).contains("is there already"));
    up.ask(&["resume"], 0);
    let there_s = elapsed_s(&up.lines(&["wait", "goal"], 0));
    // The way back is free again.
    up.ask(&["obstacle", "remove", "crate"], 0);
    let back_s = elapsed_s(&up.lines(&["goal", "3", "8.5", "3.14", "--wait"], 0));
    // It has to turn first, so that without the crate there it would take longer.
    assert!(there_s > back_s, "{there_s} s around, {back_s} s straight");
    let result = up.down();
    assert_eq!(outcomes(&result), ["reached", "reached"]);
    assert_eq!(result["contacts"], 0);
}

#[test]
fn services_that_crash_hang_or_answer_late_do_not_keep_the_robot_from_its_goal() {
    let _turn = real_time_turn();
    let mut up = Up::start(&["open_aisle"]);
    assert!(
        up.ask(&["fault", "kill", "robot"], 2)
            .contains("not restarted")
    );
    up.ask(&["fault", "kill", "nobody"], 2);
    assert!(
        up.ask(&["fault", "slow", "mapping=600ms"], 2)
            .contains("hang")
    );
    up.ask(&["goal", "8", "6.4", "0"], 0);
    up.ask(&["fault", "slow", "global_planner=20ms"], 0);
    up.ask(&["fault", "kill", "mapping"], 0);
    up.ask(&["fault", "stop", "collision_guard"], 0);
    for role in ["mapping", "collision_guard"] {
        up.stack.wait_until("a successor answers", |stack| {
            let report = stack.report().unwrap_or_default();
            let services = report["services"].as_array().cloned().unwrap_or_default();
            let newer = |service: &Value| service["role"] == role && service["epoch"] == 2;
            services.iter().any(newer)
        });
    }
    up.ask(&["fault", "heal", "global_planner"], 0);
    up.ask(&["wait", "goal"], 0);
    let result = up.down();
    assert_eq!(outcomes(&result), ["reached"]);
    assert_eq!(result["contacts"], 0);
    let restarts = result["restarts"].as_array().expect("restarts");
    let mut seats: Vec<&str> = restarts
        .iter()
        .filter_map(|one| one["service"].as_str())
        .collect();
    seats.sort_unstable();
    assert_eq!(seats, ["collision_guard", "mapping"]);
}

#[test]
fn a_wait_that_could_mean_several_stacks_ends_at_once() {
    let stacks = [(); 2].map(|()| Up::start(&["open_aisle", "--lockstep"]));
    for what in ["ready", "idle"] {
        let ended = zeronav(&["wait", what, "--timeout", "30"]);
        assert_eq!(ended.code(), 2, "{what}: {}", ended.stderr);
        assert!(ended.stderr.contains("--domain"), "{}", ended.stderr);
    }
    for up in stacks {
        up.down();
    }
}

#[test]
fn ctrl_c_brings_the_robot_to_rest_and_leaves_nothing() {
    let _turn = real_time_turn();
    let up = Up::start(&["open_aisle"]);
    up.ask(&["goal", "27", "8.5", "0"], 0);
    up.stack.signal(rustix::process::Signal::INT);
    let ended = up.stack.finish();
    let result = ended.expect(130);
    assert_eq!(result["outcome"], "interrupted");
    assert_eq!(leftovers(Path::new(&up.root)), Vec::<PathBuf>::new());
    let gone = zeronav(&["goal", "1", "1", "0", "--domain", &up.root]);
    assert_eq!(gone.code(), 2);
    assert!(gone.stderr.contains("no such folder"), "{}", gone.stderr);
}
