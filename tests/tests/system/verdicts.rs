//! A result says what happened, all of it, and the same every time.

use serde_json::Value;
use std::path::PathBuf;
use zeronav_msgs::topics::{PlanPath, Topic};
use zeronav_tests::{Ended, Zeronav, real_time_turn, rooms, zeronav};

/// A room for a robot that is given six seconds.
fn room() -> String {
    rooms::room([14.0, 6.0], [2.0, 3.0, 0.0], 6.0, "")
}

/// A cart that is pushed over the robot's start.
const CART: &str = r#"
[[world.obstacles]]
name = "cart"
shape = { kind = "box", centre_m = [2.0, 5.0], size_m = [0.5, 0.5] }
appears = { at_s = 0.0 }
waypoints_m = [[2.0, 0.6]]
speed_mps = 2.0
"#;

fn start(text: &str, arguments: &[&str]) -> Zeronav {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("it.toml"), text).expect("written");
    let all: Vec<&str> = ["run", "./it.toml"]
        .iter()
        .chain(arguments)
        .copied()
        .collect();
    Zeronav::start_in(folder, &all)
}

fn log(ended: &Ended, name: &str) -> String {
    let result = ended.json();
    let folder = result["directory"].as_str().expect("its folder");
    let file = ended.folder.path().join(folder).join("logs").join(name);
    std::fs::read_to_string(&file).unwrap_or_else(|error| panic!("{}: {error}", file.display()))
}

fn expectation<'a>(result: &'a Value, name: &str) -> &'a Value {
    let all = result["expectations"].as_array().expect("expectations");
    let found = all.iter().find(|one| one["name"] == name);
    found.unwrap_or_else(|| panic!("no expectation {name}: {result:#}"))
}

#[test]
fn a_contact_fails_the_run_unless_the_scenario_allows_it() {
    for (allowed, code, verdict) in [(0, 1, "fail"), (9, 0, "pass")] {
        let expect = format!("[expect]\noutcome = \"timeout\"\ncontacts_max = {allowed}\n");
        let text = room() + CART + &expect;
        let ended = start(&text, &["--lockstep", "--headless", "--json"]).finish();
        let result = ended.expect(code);
        assert_eq!(result["verdict"], verdict, "{result:#}");
        assert_eq!(result["outcome"], "timeout");
        let contacts = result["contacts"].as_u64().expect("a number");
        assert!(contacts > 0, "{result:#}");
        assert_eq!(expectation(&result, "contacts")["met"], verdict == "pass");
        let touches = result["touches"].as_array().expect("touches");
        assert_eq!(touches.len() as u64, contacts);
        assert_eq!(touches[0]["with"], "cart");
    }
}

#[test]
fn a_contact_fails_trials() {
    let _turn = real_time_turn();
    let trials = r#"
[[world.obstacles]]
name = "load"
shape = { kind = "box", centre_m = [7.0, 3.0], size_m = [0.5, 0.5] }
appears = { at_s = 1.0 }

[trials]
obstacle = "load"
goals = [{ pose = [2.0, 3.0, 3.1416] }, { pose = [12.0, 3.0, 0.0] }]
line_m = [[3.5, 3.0], [10.5, 3.0]]
ahead_m = 2.0
"#;
    // So near that it arrives before the first trial is over.
    let cart = CART.replace("[2.0, 5.0]", "[2.0, 3.8]");
    assert_ne!(cart, CART);
    let arguments = ["--trials", "1", "--headless", "--json"];
    let result = start(&(room() + &cart + trials), &arguments)
        .finish()
        .expect(1);
    assert_eq!(result["verdict"], "fail", "{result:#}");
    assert_eq!(expectation(&result, "contacts")["met"], false);
    assert_eq!(expectation(&result, "trials")["met"], true);
}

#[test]
fn a_stage_that_stops_answering_is_exit_code_3_and_too_long_a_path_is_named() {
    let text = room()
        + "[[goals]]\npose = [9.0, 3.0, 0.0]\n\
           [services.global_planner]\nbinary = \"too_many_waypoints\"\n";
    let mut run = start(&text, &["--lockstep", "--headless", "--json"]);
    run.wait_until("the planner says that it is degraded", |run| {
        run.report().is_some_and(|report| {
            let services = report["services"].as_array().cloned().unwrap_or_default();
            services
                .iter()
                .any(|one| one["role"] == "global_planner" && one["state"] == "degraded")
        })
    });
    let ended = run.finish();
    assert_eq!(ended.code(), 3, "{}", ended.stderr);
    assert_eq!(ended.json()["outcome"], "silent", "{}", ended.stdout);
    assert!(
        ended.stderr.contains("stopped answering"),
        "{}",
        ended.stderr
    );
    let log = log(&ended, "global_planner.log");
    let said = log.lines().filter(|line| line.contains("ERROR"));
    assert_eq!(said.count(), 1, "{log}");
    assert!(
        log.contains(PlanPath::ROW.name) && log.contains("len=3"),
        "{log}"
    );
}

/// Takes out of a result what the clock on the wall, the system or the folder says.
fn without_wall_clock(mut result: Value) -> Value {
    let whole = result.as_object_mut().expect("an object");
    for name in [
        "wall_s",
        "speed_factor",
        "environment",
        "directory",
        "shared_memory_bytes",
    ] {
        assert!(whole.remove(name).is_some(), "no {name}");
    }
    for service in whole["services"].as_array_mut().expect("services") {
        let service = service.as_object_mut().expect("an object");
        for name in ["memory_peak_bytes", "pid"] {
            assert!(service.remove(name).is_some(), "no {name}");
        }
    }
    result
}

#[test]
fn parallel_lockstep_runs_are_identical() {
    for scenario in ["crossing_walkers", "drop_box_1_2m"] {
        let arguments = ["run", scenario, "--lockstep", "--headless", "--json"];
        let runs: Vec<Zeronav> = (0..6).map(|_| Zeronav::start(&arguments)).collect();
        let mut first = None;
        for run in runs {
            let result = without_wall_clock(run.finish().expect(0));
            let first = first.get_or_insert_with(|| result.clone());
            for (name, value) in result.as_object().expect("an object") {
                assert_eq!(value, &first[name], "{name} of {scenario} differs");
            }
        }
    }
}

#[test]
fn nothing_near_is_null_and_one_replan_has_no_percentiles() {
    let text = room() + "[expect]\noutcome = \"timeout\"\n";
    let text = text.replace("time_limit_s = 6.0", "time_limit_s = 1.0");
    let result = start(&text, &["--lockstep", "--headless", "--json"])
        .finish()
        .expect(0);
    assert_eq!(result["clearance_m_min"], Value::Null, "{result:#}");
    let page = start(&text, &["--lockstep", "--headless"]).finish();
    assert_eq!(page.code(), 0, "{}", page.stderr);
    assert!(!page.stdout.contains("closest"), "{}", page.stdout);
}

#[test]
fn logs_tell_what_a_run_did() {
    let ended = zeronav(&["run", "blocked_aisle", "--lockstep", "--headless", "--json"]);
    let result = ended.expect(0);
    let folder = PathBuf::from(result["directory"].as_str().expect("its folder"));
    for (name, words) in [
        (
            "launch.log",
            &["the run begins", "started", "sent", "the run ends"][..],
        ),
        (
            "global_planner.log",
            &["cause=\"goal\"", "cause=\"obstacle\"", "cost="],
        ),
        (
            "local_planner.log",
            &["goal accepted", "goal ended", "reached"],
        ),
        ("mapping.log", &["the map begins"]),
        ("collision_guard.log", &["the guard begins"]),
        ("robot.log", &["the robot begins"]),
    ] {
        let text = log(&ended, name);
        for word in words {
            assert!(
                text.contains(word),
                "no `{word}` in {}/{name}:\n{text}",
                folder.display()
            );
        }
        // A line for a change and none for a tick: the drive has some two thousand of them.
        assert!(text.lines().count() < 400, "{name} is long:\n{text}");
    }
}
