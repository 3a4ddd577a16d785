//! The shipped scenarios, driven by the real processes in lockstep.

use rustix::process::Signal;
use serde_json::Value;
use std::process::{Child, Command};
use zeronav_tests::rooms::box_in_an_aisle;
use zeronav_tests::{Ended, Zeronav, leftovers, zeronav};

fn lockstep(scenario: &str) -> Value {
    let ended: Ended = zeronav(&["run", scenario, "--lockstep", "--headless", "--json"]);
    let result = ended.expect(0);
    assert_eq!(result["verdict"], "pass", "{result:#}");
    assert_eq!(result["contacts"], 0, "{result:#}");
    assert!(result["latency"].is_null(), "lockstep has no latencies");
    result
}

fn causes(result: &Value) -> Vec<String> {
    let replans = result["replans"].as_array().expect("replans");
    replans
        .iter()
        .map(|replan| replan["cause"].as_str().expect("a cause").to_owned())
        .collect()
}

fn points(value: &Value) -> Vec<[f64; 2]> {
    serde_json::from_value(value.clone()).expect("points")
}

#[test]
fn blocked_aisle_replans_through_the_other_aisle() {
    let ended = zeronav(&["run", "blocked_aisle", "--lockstep", "--headless", "--json"]);
    let result = ended.expect(0);
    assert_eq!(result["verdict"], "pass", "{result:#}");
    assert_eq!(result["reached"], true);
    assert_eq!(result["contacts"], 0);
    assert!(
        causes(&result).iter().any(|cause| cause == "obstacle"),
        "{result:#}"
    );

    // The crate as the scenario file has it.
    let obstacle = obstacle_of("blocked_aisle");
    let crosses = |points: &[[f64; 2]]| points.windows(2).any(|pair| cuts(pair, obstacle));
    let plans = result["plans"].as_array().expect("plans");
    let plan = |cause: &str| {
        let plan = plans
            .iter()
            .find(|plan| plan["cause"] == cause)
            .expect("a plan");
        points(&plan["points_m"])
    };
    let track = points(&result["track_m"]);
    assert!(
        crosses(&plan("goal")),
        "the first path leads through the load"
    );
    assert!(
        !crosses(&plan("obstacle")),
        "the second path leads around the load"
    );
    assert!(!crosses(&track), "the robot drove through the load");
    let second_aisle = track
        .iter()
        .any(|[x, y]| (7.0..22.9).contains(x) && *y > 12.55);
    assert!(second_aisle, "the robot took the north aisle");
    for file in ["result.json", "run.svg"] {
        let folder = result["directory"].as_str().expect("a folder");
        let path = ended.folder.path().join(folder).join(file);
        assert!(
            path.metadata().is_ok_and(|meta| meta.len() > 500),
            "{}",
            path.display()
        );
    }
}

/// Lower left and upper right corner of the first obstacle of a scenario, a box.
fn obstacle_of(scenario: &str) -> [[f64; 2]; 2] {
    let file = zeronav_tests::workspace().join(format!("launch/scenarios/{scenario}.toml"));
    let table: toml::Table = std::fs::read_to_string(file)
        .expect("the scenario")
        .parse()
        .expect("TOML");
    let shape = &table["world"]["obstacles"][0]["shape"];
    let pair = |key: &str| -> [f64; 2] { shape[key].clone().try_into().expect("two numbers") };
    let (centre, size) = (pair("centre_m"), pair("size_m"));
    [
        [centre[0] - size[0] / 2.0, centre[1] - size[1] / 2.0],
        [centre[0] + size[0] / 2.0, centre[1] + size[1] / 2.0],
    ]
}

/// True when a segment meets an upright box (sampled every centimetre).
fn cuts(segment: &[[f64; 2]], [low, high]: [[f64; 2]; 2]) -> bool {
    let ([ax, ay], [bx, by]) = (segment[0], segment[1]);
    (0..=1000).map(|n| f64::from(n) / 1000.0).any(|t| {
        let (x, y) = (ax + t * (bx - ax), ay + t * (by - ay));
        x >= low[0] && x <= high[0] && y >= low[1] && y <= high[1]
    })
}

#[test]
fn open_aisle_needs_no_second_path() {
    let result = lockstep("open_aisle");
    assert_eq!(result["reached"], true);
    assert!(
        !causes(&result).iter().any(|cause| cause == "obstacle"),
        "{result:#}"
    );
}

#[test]
fn sealed_is_reported_unreachable_and_the_robot_stays() {
    let result = lockstep("sealed");
    assert_eq!(result["reached"], false);
    assert_eq!(result["outcome"], "unreachable");
}

#[test]
fn unsealed_is_reached() {
    assert_eq!(lockstep("unsealed")["reached"], true);
}

#[test]
fn closing_door_replans_through_the_other_one() {
    let result = lockstep("door_closes");
    assert!(
        causes(&result).iter().any(|cause| cause == "obstacle"),
        "{result:#}"
    );
    let through_the_south = |result: &Value| {
        let track = points(&result["track_m"]);
        track
            .iter()
            .any(|[x, y]| (7.9..8.1).contains(x) && *y < 4.5)
    };
    assert!(
        through_the_south(&result),
        "the south door is the only one left"
    );
    assert!(
        !through_the_south(&lockstep("unsealed")),
        "an open north door is the shorter way"
    );
}

/// Ends its processes when dropped.
struct Load(Vec<Child>);

impl Load {
    fn start() -> Self {
        let busy = || {
            Command::new("sh")
                .args(["-c", "while :; do :; done"])
                .spawn()
        };
        Self((0..4).map(|_| busy().expect("a busy loop")).collect())
    }
}

impl Drop for Load {
    fn drop(&mut self) {
        for child in &mut self.0 {
            let _ = child.kill();
            let _ = child.wait();
        }
    }
}

#[test]
fn the_same_seed_gives_the_same_run_whatever_the_load() {
    // Its load would disturb the others, and starve a run in the background.
    let _turn = zeronav_tests::quiet_turn();
    let hash = |seed: &str| {
        let arguments = [
            "run",
            "unsealed",
            "--lockstep",
            "--headless",
            "--json",
            "--seed",
            seed,
        ];
        let result = zeronav(&arguments).expect(0);
        result["run_hash"].as_str().expect("a hash").to_owned()
    };
    let first = hash("7");
    assert_eq!(first.len(), 16);
    let loaded = {
        let _load = Load::start();
        hash("7")
    };
    assert_eq!(first, loaded, "load or time changed the run");
    assert_ne!(first, hash("8"), "the seed changes nothing");
}

#[test]
fn real_time_run_replans_and_its_latencies_add_up() {
    let _turn = zeronav_tests::real_time_turn();
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("it.toml"), box_in_an_aisle()).expect("written");
    let arguments = ["run", "./it.toml", "--headless", "--json"];
    let result = Zeronav::start_in(folder, &arguments).finish().expect(0);
    assert_eq!(result["verdict"], "pass", "{result:#}");
    let latency = &result["latency"];
    assert_eq!(latency["replanning"]["n"], 1, "{latency:#}");
    assert_eq!(latency["replanning"]["censored"], 0, "{latency:#}");
    assert_eq!(latency["hops"].as_array().map(Vec::len), Some(11));
    assert!(
        latency["reaction"]["n"].as_u64().expect("a number") > 50,
        "{latency:#}"
    );
    zeronav_tests::assert_latencies_add_up(latency);
    // Printed, never asserted: this machine is shared.
    eprintln!("replanning {} us", latency["replanning"]["p50_us"]);
    let services = result["services"].as_array().expect("services");
    assert_eq!(services.len(), 5, "{result:#}");
    for service in services {
        let bytes = service["memory_peak_bytes"].as_u64().expect("bytes");
        assert!((1..60_000_000).contains(&bytes), "{service:#}");
    }
    assert!(result["shared_memory_bytes"].as_u64().expect("bytes") <= 64 << 20);
}

#[test]
fn external_goal_replaces_the_scenarios_goal() {
    let _turn = zeronav_tests::real_time_turn();
    let mut run = Zeronav::start(&["run", "open_aisle", "--headless", "--json"]);
    run.wait_until("every service runs", |run| run.children().len() == 5);
    let root = run.domains().pop().expect("a domain");
    let domain = root.to_str().expect("a path").to_owned();
    run.wait_until("the task is current", |_| {
        let ended = zeronav(&["ps", "--json"]);
        let runs = ended.expect(0);
        let runs = runs["runs"].as_array().cloned().unwrap_or_default();
        runs.iter()
            .any(|run| run["domain"] == domain.as_str() && run["task"] == "active")
    });
    let away = zeronav(&["goal", "900", "900", "0", "--domain", &domain]);
    assert_eq!(away.code(), 2, "{}", away.stderr);
    let start = start_of("open_aisle");
    let (x, y) = (start[0].to_string(), start[1].to_string());
    let sent = zeronav(&[
        "goal",
        &x,
        &y,
        "1.57",
        "--tolerance",
        "0.5",
        "--domain",
        &domain,
    ]);
    assert_eq!(sent.code(), 0, "{}", sent.stderr);
    // The scenario's own goal was not reached.
    let result = run.finish().expect(1);
    assert_eq!(result["outcome"], "redirected", "{result:#}");
    assert_eq!(result["reached"], false);
    assert_eq!(result["redirects"][0]["outcome"], "reached");
    assert!(
        result["driven_m"].as_f64().expect("metres") < 20.0,
        "it drove on: {result:#}"
    );
    let motion = result["motion"].as_array().expect("a track");
    let yaw_rad = motion.last().and_then(|at| at[3].as_f64());
    let yaw_rad = yaw_rad.expect("where it stood");
    assert!((yaw_rad - 1.57).abs() < 0.35, "it looked to {yaw_rad} rad");
    assert_eq!(leftovers(&root), Vec::<std::path::PathBuf>::new());
}

#[test]
fn goal_in_a_rack_is_rejected_and_the_run_continues() {
    let _turn = zeronav_tests::real_time_turn();
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("it.toml"), box_in_an_aisle()).expect("written");
    let arguments = ["run", "./it.toml", "--headless", "--json"];
    let mut run = Zeronav::start_in(folder, &arguments);
    let domain = domain_of_active(&mut run);
    let sent = zeronav(&["goal", "13.0", "8.05", "0", "--domain", &domain]);
    assert_eq!(sent.code(), 2, "{}{}", sent.stdout, sent.stderr);
    let why = "the robot finds no room within 0.25 m of (13, 8.05)";
    assert!(sent.stderr.contains(why), "{}", sent.stderr);
    let result = run.finish().expect(0);
    assert_eq!(result["reached"], true, "{result:#}");
    assert_eq!(result["redirects"], serde_json::json!([]), "{result:#}");
}

#[test]
fn unreachable_external_goal_falls_back_to_the_scenarios() {
    let _turn = zeronav_tests::real_time_turn();
    let folder = tempfile::tempdir().expect("a folder");
    let sealed = zeronav_tests::workspace().join("launch/scenarios/sealed.toml");
    let text = std::fs::read_to_string(sealed).expect("the scenario");
    // The same rooms with both doors shut; the scenario's own goal is in the room of the start.
    let (own, shut) = ("pose = [3.0, 5.5, 0.0]", "pose = [12.0, 4.5, 0.0]");
    let text = text
        .replace(shut, own)
        .replace("\"unreachable\"", "\"reached\"");
    assert!(text.contains(own), "{text}");
    // Nobody opens the doors.
    let text = format!("{text}\n[services.local_planner]\nconfig.task.blocked_goal_s = 1.0\n");
    std::fs::write(folder.path().join("it.toml"), text).expect("written");
    let mut run = Zeronav::start_in(folder, &["run", "./it.toml", "--headless", "--json"]);
    let domain = domain_of_active(&mut run);
    let sent = zeronav(&["goal", "12.0", "4.5", "0", "--domain", &domain]);
    assert_eq!(sent.code(), 0, "{}", sent.stderr);
    let result = run.finish().expect(0);
    assert_eq!(result["reached"], true, "{result:#}");
    let redirects = result["redirects"].as_array().expect("redirects");
    assert_eq!(redirects.len(), 1, "{result:#}");
    assert_eq!(redirects[0]["outcome"], "unreachable", "{result:#}");
}

/// The domain of `run`, once its task is active.
fn domain_of_active(run: &mut Zeronav) -> String {
    run.wait_until("the task is active", |run| {
        let report = run.report();
        report.is_some_and(|report| report["task"] == "active")
    });
    let domain = run.domains().pop().expect("a domain");
    domain.to_str().expect("a path").to_owned()
}

fn start_of(scenario: &str) -> [f64; 3] {
    let file = zeronav_tests::workspace().join(format!("launch/scenarios/{scenario}.toml"));
    let table: toml::Table = std::fs::read_to_string(file)
        .expect("the scenario")
        .parse()
        .expect("TOML");
    table["start"].clone().try_into().expect("three numbers")
}

#[test]
fn ctrl_c_stops_the_robot_and_then_everything() {
    let _turn = zeronav_tests::real_time_turn();
    let mut run = Zeronav::start(&["run", "open_aisle", "--headless", "--json"]);
    run.wait_until("every service runs", |run| run.children().len() == 5);
    let root = run.domains().pop().expect("a domain");
    let children = run.children();
    run.wait_until("the robot's scan is in shared memory", |_| {
        leftovers(&root).len() > 30
    });
    run.signal(Signal::INT);
    let ended = run.finish();
    assert_eq!(ended.code(), 130, "{}", ended.stderr);
    assert_eq!(ended.json()["outcome"], "interrupted");
    assert_eq!(leftovers(&root), Vec::<std::path::PathBuf>::new());
    for (pid, line) in children {
        assert!(!zeronav_tests::is_alive(pid), "{line} is still there");
    }
}

/// A cart that avoids nothing, at five timings. It may run into a stopped robot; the robot never runs
/// into it, and arrives.
#[test]
fn crossing_cart_is_given_way_at_any_time() {
    let shipped = lockstep("crossing_cart");
    assert_eq!(shipped["reached"], true, "{shipped:#}");
    let file = zeronav_tests::workspace().join("launch/scenarios/crossing_cart.toml");
    let text = std::fs::read_to_string(file).expect("the scenario");
    for from_y_m in [9.4, 9.8, 10.6, 11.0] {
        let moved = text
            .replace("[5.8, 10.2]", &format!("[5.8, {from_y_m}]"))
            .replace("contacts_max = 0", "contacts_max = 1");
        assert_ne!(moved, text);
        let folder = tempfile::tempdir().expect("a folder");
        std::fs::write(folder.path().join("it.toml"), moved).expect("written");
        let arguments = ["run", "./it.toml", "--lockstep", "--headless", "--json"];
        let result = Zeronav::start_in(folder, &arguments).finish().expect(0);
        assert_eq!(result["reached"], true, "from {from_y_m}: {result:#}");
        assert_eq!(result["contacts_moving"], 0, "from {from_y_m}: {result:#}");
    }
}

#[test]
fn planners_and_controllers_are_listed_one_per_line() {
    for (command, known) in [("planners", "c_astar"), ("controllers", "dwa")] {
        let listed = zeronav(&[command, "--json"]).expect(0);
        let rows = listed["algorithms"].as_array().expect("rows");
        assert!(rows.iter().any(|row| row["key"] == known), "{listed:#}");
        assert!(
            rows.iter()
                .all(|row| row["title"].as_str().is_some_and(|title| title.len() > 10)),
            "{listed:#}"
        );
        let text = zeronav(&[command]).stdout;
        assert_eq!(text.lines().count(), rows.len());
    }
}
