//! Latency as users measure it: trials, the floor of the transport, delays put in on purpose. All
//! of this is real time, so the runs take turns; what is asserted are counts, order and lower
//! bounds, never how fast a busy machine is.

use serde_json::Value;
use std::path::PathBuf;
use zeronav_tests::results::{record::Row, trials};
use zeronav_tests::rooms::aisle_for_trials;
use zeronav_tests::{Zeronav, assert_latencies_add_up, leftovers, real_time_turn, zeronav};

#[test]
fn trials_come_with_percentiles_and_the_floor_of_the_transport() {
    let _turn = real_time_turn();
    let arguments = ["run", "./it.toml", "--trials", "4", "--headless", "--json"];
    let mut run = Zeronav::start_in(aisle_for_trials(), &arguments);
    let mut domains: Vec<PathBuf> = Vec::new();
    while !run.has_ended() {
        domains.extend(run.domains());
        std::thread::sleep(std::time::Duration::from_millis(20));
    }
    let result = run.finish().expect(0);
    assert_eq!(result["verdict"], "pass", "{result:#}");
    assert_eq!(result["outcome"], "trials_over");
    assert_eq!(result["contacts"], 0, "{result:#}");
    let latency = &result["latency"];
    for key in ["replanning", "event_to_motion"] {
        assert_eq!(latency[key]["n"], 4, "{latency:#}");
        assert_eq!(latency[key]["censored"], 0, "{latency:#}");
    }
    assert_latencies_add_up(latency);
    let floor = &latency["transport_floor"];
    let number = |value: &Value| value.as_f64().expect("a number");
    let n = number(&floor["n"]);
    assert!(n >= 60.0, "{floor:#}");
    for key in ["censored", "p50_us", "p90_us", "max_us"] {
        assert!(floor[key].is_number(), "{floor:#}");
    }
    // Fewer than a hundred do not tell it from the worst.
    assert_eq!(floor["p99_us"].is_number(), n >= 100.0, "{floor:#}");
    // A stack that thinks is slower than one that does not.
    assert!(number(&floor["p50_us"]) < number(&latency["replanning"]["p50_us"]));
    assert!(number(&latency["replanning_to_floor"]) > 1.0);
    let rounds = result["trials"]["rounds"].as_array().expect("rounds");
    let made: Vec<u64> = rounds
        .iter()
        .map(|round| round["trials"].as_u64().expect("a count"))
        .collect();
    assert_eq!(made, [2, 1, 1]);
    for round in rounds {
        check_disturbance(&round["disturbance"]);
    }
    let worst = result["trials"]["worst"].as_array().expect("worst trials");
    assert_eq!(worst.len(), 4, "all, of fewer than ten: {worst:#?}");
    let times: Vec<f64> = worst
        .iter()
        .map(|slow| number(&slow["replanning_us"]))
        .collect();
    assert!(times.is_sorted_by(|a, b| a >= b), "{times:?}");
    // The distribution rounds to a thousandth.
    let max_us = number(&latency["replanning"]["max_us"]);
    assert!((times[0] / max_us - 1.0).abs() < 0.002, "{worst:#?}");
    for slow in worst {
        assert!(number(&slow["hop"]["time_us"]) <= number(&slow["replanning_us"]));
        check_disturbance(&slow["disturbance"]);
    }
    check_tables(&result);
    // Three stacks and three rings, and nothing is left of any.
    domains.sort();
    domains.dedup();
    assert_eq!(domains.len(), 6, "{domains:?}");
    for root in &domains {
        assert!(leftovers(root).is_empty(), "{:?}", leftovers(root));
    }
}

/// The tables of the results page are filled from the result of four trials.
fn check_tables(result: &Value) {
    let latencies = trials::latency(result);
    let is_there = |at: usize| move |row: &Row| row.figures[at].value.is_some();
    assert!(latencies.rows.iter().all(is_there(3)), "{latencies:#?}");
    assert_eq!(latencies.rows[0].n, 4, "{latencies:#?}");
    let disturbance = trials::disturbance(result);
    assert_eq!(
        disturbance.rows.len(),
        3 * 5,
        "three rounds of five services"
    );
    for at in 0..disturbance.columns.len() {
        assert!(
            disturbance.rows.iter().all(is_there(at)),
            "{disturbance:#?}"
        );
    }
    let slowest = trials::slowest(result, 3);
    assert!(
        slowest.rows.len() == 3 && slowest.rows.iter().all(is_there(0)),
        "{slowest:#?}"
    );
}

/// Every service is in it, and what has to be counted was.
fn check_disturbance(disturbance: &Value) {
    let services = disturbance["services"].as_array().expect("services");
    let names: Vec<&str> = services
        .iter()
        .filter_map(|service| service["name"].as_str())
        .collect();
    let roles = [
        "robot",
        "mapping",
        "global_planner",
        "local_planner",
        "collision_guard",
    ];
    assert_eq!(names, roles, "{disturbance:#}");
    for service in services {
        // All of them answered at least once, and slept before it.
        assert!(service["processor_us"].as_f64() > Some(0.0), "{service:#}");
        assert!(
            service["voluntary_switches"].as_u64() > Some(0),
            "{service:#}"
        );
    }
    assert!(
        disturbance["load_end"].as_f64() > Some(0.0),
        "{disturbance:#}"
    );
    let steal = disturbance["steal"].as_f64().expect("steal");
    assert!((0.0..=1.0).contains(&steal), "{disturbance:#}");
}

/// The shortest way leads close around the front that is seen and cuts the hidden back, which comes
/// into sight when the robot drives around it. It does so at once and corrects its path later; an
/// answer that had to clear the back from the beginning came seconds late, or never.
#[test]
fn disc_is_answered_in_the_first_scan_that_shows_it() {
    let _turn = real_time_turn();
    let folder = tempfile::tempdir().expect("a folder");
    let scenario = r#"
title = "A disc appears 1.5 m ahead in a corridor"
base = ["turtlebot2"]
start = [1.5, 2.0, 0.0]
[world]
area_m = [[0.0, 0.0], [12.0, 4.0]]
resolution_m = 0.05
shapes = [
    { kind = "box", centre_m = [6.0, 0.4], size_m = [12.0, 0.2] },
    { kind = "box", centre_m = [6.0, 3.6], size_m = [12.0, 0.2] },
]
[[world.obstacles]]
name = "disc"
shape = { kind = "disc", centre_m = [5.5, 2.0], radius_m = 0.3 }
appears = { robot_near = { point_m = [5.5, 2.0], distance_m = 1.5 } }
[services.global_planner]
config.planner = "jps"
[run]
time_limit_s = 60.0
[[goals]]
pose = [7.0, 2.0, 0.0]
"#;
    std::fs::write(folder.path().join("disc.toml"), scenario).expect("written");
    let run = Zeronav::start_in(folder, &["run", "./disc.toml", "--headless", "--json"]);
    let result = run.finish().expect(0);
    assert_eq!(result["reached"], true, "{result:#}");
    assert_eq!(result["contacts"], 0, "{result:#}");
    let latency = &result["latency"];
    assert_eq!(latency["replanning"]["n"], 1, "{latency:#}");
    assert_eq!(latency["replanning"]["censored"], 0, "{latency:#}");
    assert_eq!(latency["revised"], 1, "{latency:#}");
    let replanning_us = latency["replanning"]["p50_us"].as_f64();
    assert!(replanning_us < Some(500_000.0), "{latency:#}");
}

/// Its lidar turns 5.5 times a second, so that hardly a scan falls on a tick of 20 ms. One that
/// waited for the next tick would be 10 ms old at the median when it is sent.
#[test]
fn in_real_time_a_scan_is_sent_when_it_is_captured() {
    let _turn = real_time_turn();
    let folder = tempfile::tempdir().expect("a folder");
    let scenario = r#"
title = "A TurtleBot 2 in an empty hall"
base = ["hall", "turtlebot2"]
start = [1.5, 4.0, 0.0]
[run]
time_limit_s = 60.0
[[goals]]
pose = [7.5, 4.0, 0.0]
"#;
    std::fs::write(folder.path().join("hall.toml"), scenario).expect("written");
    let run = Zeronav::start_in(folder, &["run", "./hall.toml", "--headless", "--json"]);
    let result = run.finish().expect(0);
    assert_eq!(result["reached"], true, "{result:#}");
    let latency = &result["latency"];
    assert_latencies_add_up(latency);
    let direct = latency["every_scan"]["direct"].as_array().expect("hops");
    assert_eq!(direct[0]["name"], "robot");
    assert!(direct[0]["n"].as_u64() > Some(40), "{direct:#?}");
    let robot_us = direct[0]["p50_us"].as_f64().expect("a median");
    assert!(robot_us < 5000.0, "sent after {robot_us} us: {latency:#}");
    eprintln!("reaction {} us", latency["reaction"]["p50_us"]);
}

#[test]
fn slow_trial_names_its_hop_and_its_service_off_the_processor() {
    let _turn = real_time_turn();
    let arguments = [
        "run",
        "./it.toml",
        "--trials",
        "1",
        "--inject",
        "global_planner=200ms",
        "--headless",
        "--json",
    ];
    let result = Zeronav::start_in(aisle_for_trials(), &arguments)
        .finish()
        .expect(0);
    assert_eq!(result["injected_us"]["global_planner"], 200_000.0);
    // Whoever looks for the cause finds the hop, and that its service did not compute meanwhile.
    let slow = &result["trials"]["worst"][0];
    assert_eq!(slow["hop"]["name"], "global_planner", "{slow:#}");
    let off_us = |name: &str| {
        let services = slow["disturbance"]["services"].as_array()?;
        let service = services.iter().find(|service| service["name"] == name)?;
        service["off_processor_us_max"].as_f64()
    };
    assert!(off_us("global_planner") >= Some(200_000.0), "{slow:#}");
    assert!(off_us("mapping") < Some(200_000.0), "{slow:#}");
}

#[test]
fn the_page_for_people_names_injected_delays() {
    let _turn = real_time_turn();
    let folder = tempfile::tempdir().expect("a folder");
    let scenario = "title = \"A second at rest\"\nbase = [\"warehouse\", \"porter\"]\n\
                    start = [3.0, 8.5, 0.0]\n[run]\ntime_limit_s = 1.0\n\
                    [expect]\noutcome = \"timeout\"\n";
    std::fs::write(folder.path().join("it.toml"), scenario).expect("written");
    let arguments = ["run", "./it.toml", "--headless", "--inject", "mapping=5ms"];
    let ended = Zeronav::start_in(folder, &arguments).finish();
    let said = "delays were injected: mapping 5.00 ms";
    assert!(
        ended.stdout.contains(said),
        "{}\n{}",
        ended.stdout,
        ended.stderr
    );
}

#[test]
fn a_hundred_updates_a_second_and_a_slow_planner_still_yield_paths() {
    let _turn = real_time_turn();
    let folder = tempfile::tempdir().expect("a folder");
    let scenario = r#"
title = "A lidar that is faster than the planner"
base = ["warehouse", "porter"]
start = [3.0, 8.5, 0.0]
[run]
tick_hz = 100.0
time_limit_s = 120.0
[restart]
hang_after_s = 10.0
[robot.lidar]
rate_hz = 100.0
[[goals]]
pose = [8.5, 6.425, 0.0]
"#;
    std::fs::write(folder.path().join("fast_lidar.toml"), scenario).expect("written");
    let result = Zeronav::start_in(
        folder,
        &[
            "run",
            "./fast_lidar.toml",
            "--inject",
            "global_planner=60ms",
            "--headless",
            "--json",
        ],
    )
    .finish()
    .expect(0);
    assert_eq!(result["reached"], true, "{result:#}");
    assert_eq!(result["contacts"], 0, "{result:#}");
    let plans = result["plans"].as_array().expect("plans");
    assert!(plans.iter().any(|plan| plan["status"] == "found"));
    assert_eq!(result["restarts"], serde_json::json!([]), "{result:#}");
}

#[test]
fn unmeasurable_requests_are_rejected_in_one_line() {
    let cases: [(&[&str], &str); 6] = [
        (&["open_aisle", "--trials", "3"], "[trials]"),
        (&["blocked_aisle", "--trials", "0"], "--trials"),
        (
            &["blocked_aisle", "--trials", "3", "--lockstep"],
            "--lockstep",
        ),
        (&["blocked_aisle", "--inject", "robot=5ms"], "robot"),
        (
            &["blocked_aisle", "--inject", "global_planner=5"],
            "ms or us",
        ),
        (
            &["blocked_aisle", "--inject", "wheels=5ms"],
            "global_planner",
        ),
    ];
    for (arguments, said) in cases {
        let mut line = vec!["run"];
        line.extend(arguments);
        let ended = zeronav(&line);
        assert_eq!(ended.code(), 2, "{arguments:?}: {}", ended.stderr);
        assert!(
            ended.stderr.contains(said),
            "{arguments:?}: {}",
            ended.stderr
        );
        assert!(!ended.folder.path().join("runs").exists(), "{arguments:?}");
    }
}
