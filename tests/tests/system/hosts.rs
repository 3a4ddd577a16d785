//! Stacks whose seats are filled by two computers: the same run as on one, ways that are cut, late and lossy, and ends
//! of either side.

use rustix::process::Signal;
use serde_json::{Value, json};
use zeronav_tests::hosts::{
    OtherClock, Way, free_end, link_log, make_keys, scenario, split, start, start_with_keys,
};
use zeronav_tests::{
    Zeronav, await_by_itself, command, leftovers, quiet_turn, real_time_turn, send_signal,
    services_of,
};

const LOCKSTEP: [&str; 5] = ["run", "scenario.toml", "--lockstep", "--headless", "--json"];
const AS_ROBOT: [&str; 2] = ["--host", "robot"];
const DRIVE: [&str; 6] = [
    "run",
    "scenario.toml",
    "--headless",
    "--json",
    AS_ROBOT[0],
    AS_ROBOT[1],
];
const SERVE: [&str; 4] = ["up", "scenario.toml", "--host", "base"];

/// Run time of a drive. [s]
fn time_s(run: &Zeronav) -> f64 {
    let report = run.report().unwrap_or_default();
    report["time_s"].as_f64().unwrap_or(0.0)
}

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
    let run = |more: &[&str]| start(command(), &text, &[&LOCKSTEP[..], more].concat());
    let alone = run(&[]).finish().expect(0);
    // In any order: the base comes later here, and serves a second run.
    let first = run(&AS_ROBOT);
    let base = start(command(), &text, &SERVE);
    for robot in [first, run(&AS_ROBOT)] {
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

#[test]
fn a_stranger_with_keys_of_another_authority_is_heard_by_nobody() {
    let keys = tempfile::tempdir().expect("a folder");
    let [own, foreign] = ["own", "foreign"].map(|name| keys.path().join(name));
    make_keys(&own);
    make_keys(&foreign);
    // It trusts the base.
    std::fs::copy(own.join("ca.pem"), foreign.join("ca.pem")).expect("copied");
    let end = free_end().replace("tcp/", "tls/");
    let text = split("unsealed", &["mapping"], &end);
    let as_robot = [&LOCKSTEP[..], &AS_ROBOT].concat();
    let start = |keys, arguments: &[&str]| start_with_keys(command(), &text, keys, arguments);
    let alone = start(&own, &LOCKSTEP).finish().expect(0);
    let mut base = start(&own, &SERVE);
    let stranger = start(&foreign, &as_robot);
    base.wait_until("the base has rejected the stranger", |base| {
        link_log(base).contains("invalid peer certificate")
    });
    let result = start(&own, &as_robot).finish().expect(0);
    assert_eq!(result["run_hash"], alone["run_hash"], "{result:#}");
    let (of_base, of_stranger) = (link_log(&base), link_log(&stranger));
    assert_eq!(of_base.matches("takes part").count(), 1, "{of_base}");
    assert!(!of_stranger.contains("is there"), "{of_stranger}");
    stranger.signal(Signal::INT);
    let ended = stranger.finish();
    assert_eq!(ended.code(), 130, "{}", ended.stderr);
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
    // The load may fall while the way is cut: then the path leads around it for another cause.
    let text = scenario("blocked_aisle", Way::end()).replace("obstacle_replans_min = 1", "");
    let base = start(way.zeronav(1), &text, &SERVE);
    let mut robot = start(way.zeronav(0), &text, &DRIVE);
    let (cut, half) = (json!({ "cut": true }), json!({ "half": true }));
    for (how, at_s, cut_s) in [
        (&cut, 3.0, 0.1),
        (&cut, 5.0, 1.0),
        (&half, 8.0, 3.0),
        (&cut, 13.0, 10.0),
    ] {
        robot.wait_until("the robot is on its way", |run| time_s(run) > at_s);
        way.set(how);
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
    // The way is a program that other stacks would keep from forwarding.
    let _turn = quiet_turn();
    let mut way = Way::new();
    let text = scenario("unsealed", Way::end());
    let shorter = text.replace("time_limit_s = 90.0", "time_limit_s = 60.0");
    assert_ne!(shorter, text, "the scenario has another time limit");
    let text = shorter;
    let base = start(way.zeronav(1), &text, &SERVE);
    let late = json!({ "loss": 0.02, "delay_s": 0.02, "jitter_s": 0.01 });
    way.set(&late);
    let mut robot = start(way.zeronav(0), &text, &DRIVE);
    for (how, at_s) in [(&json!({ "loss": 0.2 }), 5.0), (&late, 10.0)] {
        robot.wait_until("the robot is on its way", |run| time_s(run) > at_s);
        way.set(how);
    }
    safe_and_there(&robot.finish().expect(0));
    // One Mbit/s is less than the map alone takes: the robot may stand.
    way.set(&json!({ "bytes_per_s": 125_000 }));
    let result = start(way.zeronav(0), &text, &DRIVE).finish().json();
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
    let mut base = start(command(), &text, &SERVE);
    let mut robot = start(command(), &text, &DRIVE);
    robot.wait_until("the robot is on its way", |run| time_s(run) > 1.0);
    let process = |base: &Zeronav, program: &str| {
        let services = services_of(base.pid());
        let found = services.iter().find(|(_, it)| it.contains(program));
        found.map(|(pid, _)| *pid)
    };
    let seats = |base: &Zeronav| -> Vec<(u32, String)> {
        let mut services = services_of(base.pid());
        services.retain(|(_, it)| !it.contains("zeronav-link "));
        services
    };
    // The program that stands in for it here is not what is meant.
    let (code, words) = ask(&robot, &["fault", "kill", "mapping"]);
    assert_ne!(code, 0, "{words}");
    assert!(words.contains("mapping is on base"), "{words}");
    let planner = process(&base, "zeronav-global-planner").expect("a planner");
    assert!(send_signal(planner, Signal::KILL));
    base.wait_until("another planner runs there", |base| {
        process(base, "zeronav-global-planner").is_some_and(|pid| pid != planner)
    });
    // What it fills goes on when its link is another one.
    let before = seats(&base);
    let link = process(&base, "zeronav-link ").expect("a link");
    assert!(send_signal(link, Signal::KILL));
    base.wait_until("another link takes part", |base| {
        link_log(base).matches("takes part").count() == 2
    });
    assert_eq!(seats(&base), before);
    // And when it has ended itself, another one begins anew.
    base.signal(Signal::KILL);
    drop(base);
    let base = start(command(), &text, &SERVE);
    let result = robot.finish().expect(0);
    safe_and_there(&result);
    let restarts = result["restarts"].as_array().expect("restarts");
    let mut restarted: Vec<&Value> = restarts.iter().map(|it| &it["service"]).collect();
    assert!(!restarted.is_empty(), "{result:#}");
    assert_eq!(restarted.remove(0), "global_planner", "{result:#}");
    restarted.sort_by_key(ToString::to_string);
    let all = ["global_planner", "local_planner", "mapping"];
    assert_eq!(restarted, all, "{result:#}");
    ends_with_its_services(base);
}

/// Exit code and words of a verb that is asked of this run.
fn ask(run: &Zeronav, verb: &[&str]) -> (i32, String) {
    let root = run.domains().pop().expect("a domain");
    let mut asked = command();
    let said = asked.args(verb).arg("--domain").arg(&root).output();
    let said = said.expect("zeronav starts");
    let words = [&said.stdout[..], &said.stderr].concat();
    let code = said.status.code().unwrap_or(-1);
    (code, String::from_utf8_lossy(&words).into_owned())
}

#[test]
fn a_seat_of_the_other_host_is_swapped_as_on_one() {
    let text = split("unsealed", &["mapping", "global_planner"], &free_end());
    let swap = "[[swaps]]\nservice = \"global_planner\"\nat_s = 2.0\nshadow_s = 1.0\nkeep_s = 1.0\n\
                config.planner = \"lazy_theta\"\n";
    let text = format!("{text}{swap}");
    let base = start(command(), &text, &SERVE);
    let run = |more: &[&str]| {
        let run = start(command(), &text, &[&LOCKSTEP[..], more].concat());
        let result = run.finish().expect(0);
        let swaps = result["swaps"].as_array().expect("swaps");
        assert_eq!(swaps.len(), 1, "{result:#}");
        assert_eq!(swaps[0]["state"], "swapped", "{result:#}");
        assert_eq!(result["restarts"], json!([]), "{result:#}");
        result
    };
    let (alone, on_two) = (run(&[]), run(&AS_ROBOT));
    assert_eq!(on_two["run_hash"], alone["run_hash"], "{on_two:#}");
    // The newcomer there has the keys of the one here: its paths are as much shorter.
    let shorter =
        |result: &Value| result["swaps"][0]["comparison"]["measures"]["length_ratio_max"].clone();
    assert!(shorter(&alone).as_f64() < Some(0.99), "{alone:#}");
    assert_eq!(shorter(&on_two), shorter(&alone));
    ends_with_its_services(base);
}

#[test]
fn what_the_other_host_cannot_swap_is_rejected_with_its_reason() {
    let _turn = real_time_turn();
    let text = scenario("unsealed", &free_end());
    let base = start(command(), &text, &SERVE);
    let up = ["up", "scenario.toml", "--headless", "--host", "robot"];
    let mut robot = start(command(), &text, &up);
    robot.wait_until("the stack stands", |run| {
        !run.domains().is_empty() && ask(run, &["status"]).0 == 0
    });
    let quick = ["--shadow", "0.5", "--keep", "0.5"];
    for (newcomer, expected) in [
        (&["/bin/sh"][..], "there without a folder"),
        (&["sh"], "names no `sh` for mapping, but zeronav-mapping"),
        (&["--set", "wrkers=1"], "wrkers"),
    ] {
        let (code, words) = ask(
            &robot,
            &[&["swap", "mapping"], newcomer, &quick[..]].concat(),
        );
        assert_ne!(code, 0, "{words}");
        assert!(words.contains(expected), "{words}");
    }
    let other = [
        "swap",
        "global_planner",
        "zeronav-global-planner",
        "--set",
        "planner=lazy_theta",
    ];
    let (code, words) = ask(&robot, &[&other[..], &quick[..]].concat());
    assert_eq!(code, 0, "{words}");
    robot.signal(Signal::INT);
    assert_eq!(robot.finish().code(), 130);
    ends_with_its_services(base);
}

/// How far a median may be from where it should be. [us]
const TOLERANCE_US: f64 = 20_000.0;

#[test]
fn delays_on_a_host_with_another_clock_are_found_in_their_hops() {
    let _turn = real_time_turn();
    let text = scenario("unsealed", &free_end());
    let clock = OtherClock::new();
    let base = start(clock.of(&command()), &text, &SERVE);
    let drive = |more: &[&str]| {
        let mut robot = start(command(), &text, &[&DRIVE[..], more].concat());
        robot.wait_until("the robot is on its way", |run| time_s(run) > 2.0);
        clock.set();
        let result = robot.finish().expect(0);
        safe_and_there(&result);
        assert_eq!(result["restarts"], json!([]), "{result:#}");
        let ahead_us = result["link"]["ahead_us"].as_f64().expect("an offset");
        assert!((ahead_us - 5.0e9).abs() < 1.0e6, "{ahead_us} us ahead");
        let uncertainty_us = result["link"]["uncertainty_us"].as_f64();
        assert!(
            uncertainty_us.is_some_and(|us| us < TOLERANCE_US),
            "{result:#}"
        );
        let hops = result["latency"]["every_scan"]["through_map"].clone();
        let hops = hops.as_array().cloned().expect("hops");
        let median = |hop: &Value| (hop["name"].clone(), hop["p50_us"].as_f64().expect("us"));
        hops.iter().map(median).collect::<Vec<_>>()
    };
    // The time of day is set in the middle of the first drive.
    let plain = drive(&[]);
    let delayed = drive(&[
        "--inject",
        "mapping=60ms",
        "--inject",
        "global_planner=40ms",
    ]);
    assert_eq!(plain.len(), delayed.len());
    for ((hop, before_us), (same, after_us)) in plain.iter().zip(&delayed) {
        assert_eq!(hop, same);
        // A scan whose odometry comes after it once waited for the next beat, 50 ms.
        assert!(*before_us < TOLERANCE_US, "{plain:?}");
        let expected_us = match hop.as_str() {
            Some("mapping") => 60_000.0,
            Some("global_planner") => 40_000.0,
            _ => 0.0,
        };
        let wrong_us = after_us - before_us - expected_us;
        assert!(
            wrong_us.abs() < TOLERANCE_US,
            "{hop}: {plain:?} {delayed:?}"
        );
    }
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
    let killed = "[[faults]]\nkind = \"kill\"\nservice = \"mapping\"\nbegins.at_s = 1.0\n";
    refused(
        &format!("{text}{killed}"),
        &["check", "scenario.toml"],
        "faults[0].service: mapping is not on robot",
    );
    refused(
        &text,
        &[&up("robot")[..], &["--set", "mapping.workers=1"]].concat(),
        "mapping: its process is on the other host",
    );
    let apart = text.replace("\"robot\", \"collision_guard\"", "\"robot\"");
    let apart = apart.replace("[\"mapping\"", "[\"collision_guard\", \"mapping\"");
    refused(
        &apart,
        &["check", "scenario.toml"],
        "stands beside the robot",
    );
}
