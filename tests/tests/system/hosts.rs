//! Stacks whose seats are filled by two computers: the same run as on one, ways that are cut, late and lossy, and ends
//! of either side.

use rustix::process::Signal;
use serde_json::{Value, json};
use zeronav_tests::hosts::{Way, free_end, scenario, start};
use zeronav_tests::{
    Zeronav, await_by_itself, command, leftovers, real_time_turn, send_signal, services_of,
};

/// Waits until the base has told its services and has none left.
fn ends_with_its_services(base: Zeronav) {
    let roots = base.domains();
    let services = services_of(base.pid());
    base.signal(Signal::INT);
    let ended = base.finish();
    assert_eq!(ended.code(), 130, "{}", ended.stderr);
    for (pid, command) in services {
        assert!(!zeronav_tests::is_alive(pid), "{command} is left");
    }
    for root in roots {
        await_by_itself("nothing is left", || leftovers(&root).is_empty());
    }
}

#[test]
fn a_lockstep_run_on_two_hosts_is_the_run_on_one() {
    let text = scenario("blocked_aisle", &free_end());
    let run = |more: &[&str]| {
        let arguments = ["run", "scenario.toml", "--lockstep", "--headless", "--json"];
        start(command(), &text, &[&arguments[..], more].concat())
    };
    let alone = run(&[]).finish().expect(0);
    // In any order: the base comes later here, and serves a second run.
    let first = run(&["--host", "robot"]);
    let base = start(command(), &text, &["up", "scenario.toml", "--host", "base"]);
    for robot in [first, run(&["--host", "robot"])] {
        let result = robot.finish().expect(0);
        assert_eq!(result["run_hash"], alone["run_hash"], "{result:#}");
        assert_eq!(result["restarts"], json!([]), "{result:#}");
        let services = result["services"].as_array().expect("services");
        let remote = services
            .iter()
            .filter(|it| it["binary"] == "zeronav-remote-seat");
        assert_eq!(remote.count(), 3, "{result:#}");
    }
    ends_with_its_services(base);
}

/// Contacts and outcome of a drive.
fn safe_and_there(result: &Value) {
    assert_eq!(result["contacts"], 0, "{result:#}");
    assert_eq!(result["outcome"], "reached", "{result:#}");
}

#[test]
fn a_way_that_is_cut_brings_the_robot_to_rest_and_it_goes_on() {
    let _turn = real_time_turn();
    let mut way = Way::new();
    let text = scenario("blocked_aisle", Way::end());
    let base = start(
        way.zeronav(1),
        &text,
        &["up", "scenario.toml", "--host", "base"],
    );
    let arguments = [
        "run",
        "scenario.toml",
        "--host",
        "robot",
        "--headless",
        "--json",
    ];
    let mut robot = start(way.zeronav(0), &text, &arguments);
    let time_s = |run: &Zeronav| {
        let report = run.report().unwrap_or_default();
        report["time_s"].as_f64().unwrap_or(0.0)
    };
    for (at_s, cut_s) in [(3.0, 0.1), (6.0, 1.0), (11.0, 10.0)] {
        robot.wait_until("the robot is on its way", |run| time_s(run) > at_s);
        way.set(&json!({ "cut": true }));
        let until_s = time_s(&robot) + cut_s;
        robot.wait_until("the way was cut long enough", |run| time_s(run) > until_s);
        way.mend();
    }
    let result = robot.finish().expect(0);
    safe_and_there(&result);
    assert_eq!(result["restarts"], json!([]), "{result:#}");
    ends_with_its_services(base);
}

#[test]
fn late_lossy_and_narrow_ways_are_driven_over_without_a_contact() {
    let _turn = real_time_turn();
    let mut way = Way::new();
    let text = scenario("blocked_aisle", Way::end());
    let base = start(
        way.zeronav(1),
        &text,
        &["up", "scenario.toml", "--host", "base"],
    );
    let arguments = [
        "run",
        "scenario.toml",
        "--host",
        "robot",
        "--headless",
        "--json",
    ];
    way.set(&json!({ "loss": 0.02, "delay_s": 0.02, "jitter_s": 0.01 }));
    safe_and_there(&start(way.zeronav(0), &text, &arguments).finish().expect(0));
    // One Mbit/s is less than the map alone takes: the robot may stand.
    way.set(&json!({ "bytes_per_s": 125_000 }));
    let result = start(way.zeronav(0), &text, &arguments).finish().json();
    assert_eq!(result["contacts"], 0, "{result:#}");
    let outcome = result["outcome"].as_str().unwrap_or_default();
    assert!(
        ["reached", "stuck", "timeout"].contains(&outcome),
        "{result:#}"
    );
    ends_with_its_services(base);
}

#[test]
fn what_ends_on_the_other_host_is_started_again_there() {
    let _turn = real_time_turn();
    let text = scenario("unsealed", &free_end());
    let mut base = start(command(), &text, &["up", "scenario.toml", "--host", "base"]);
    let arguments = [
        "run",
        "scenario.toml",
        "--host",
        "robot",
        "--headless",
        "--json",
    ];
    let mut robot = start(command(), &text, &arguments);
    robot.wait_until("the robot is on its way", |run| {
        let report = run.report().unwrap_or_default();
        report["time_s"].as_f64().is_some_and(|time_s| time_s > 1.0)
    });
    let planner = |base: &Zeronav| {
        let services = services_of(base.pid());
        let planner = services
            .iter()
            .find(|(_, it)| it.contains("zeronav-global-planner"));
        planner.map(|(pid, _)| *pid)
    };
    let first = planner(&base).expect("a planner");
    assert!(send_signal(first, Signal::KILL));
    base.wait_until("another planner runs there", |base| {
        planner(base).is_some_and(|pid| pid != first)
    });
    let result = robot.finish().expect(0);
    safe_and_there(&result);
    assert_eq!(
        result["restarts"][0]["service"], "global_planner",
        "{result:#}"
    );
    ends_with_its_services(base);
}

#[test]
fn hosts_that_do_not_fit_say_so() {
    let text = scenario("unsealed", &free_end());
    let refused = |text: &str, arguments: &[&str], expected: &str| {
        let ended = start(command(), text, arguments).finish();
        assert_eq!(ended.code(), 2, "{}", ended.stderr);
        assert!(ended.stderr.contains(expected), "{}", ended.stderr);
    };
    let up = |host: &'static str| ["up", "scenario.toml", "--host", host];
    refused(&text, &up("bas"), "did you mean `base`?");
    refused(
        &zeronav_tests::shipped("unsealed"),
        &up("base"),
        "the scenario has no [hosts]",
    );
    let apart = text.replace("\"robot\", \"collision_guard\"", "\"robot\"");
    let apart = apart.replace("[\"mapping\"", "[\"collision_guard\", \"mapping\"");
    refused(
        &apart,
        &["check", "scenario.toml"],
        "stands beside the robot",
    );
}
