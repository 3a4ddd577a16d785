//! One process per seat: a second one is rejected with a message that names the owner, a shadow is
//! never obeyed.

use rustix::process::Signal;
use serde_json::Value;
use std::path::{Path, PathBuf};
use zeronav_tests::{Ended, Stranger, Zeronav, leftovers, real_time_turn, send_signal};

/// Every role and its stock program.
const SERVICES: [(&str, &str); 5] = [
    ("robot", "zeronav-robot-sim"),
    ("mapping", "zeronav-mapping"),
    ("global_planner", "zeronav-global-planner"),
    ("local_planner", "zeronav-local-planner"),
    ("collision_guard", "zeronav-collision-guard"),
];

/// A few metres along an aisle.
const AISLE: &str = "title = \"test\"\nbase = [\"warehouse\", \"porter\"]\n\
                     start = [4.0, 6.425, 0.0]\n\
                     [[goals]]\npose = [12.5, 6.425, 0.0]\n";

fn start(more: &[&str]) -> Zeronav {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("it.toml"), AISLE).expect("written");
    let arguments = [&["run", "./it.toml", "--headless", "--json"], more].concat();
    Zeronav::start_in(folder, &arguments)
}

/// Waits until the robot has driven for `time_s`; the run's domain.
fn driving(run: &mut Zeronav, time_s: f64) -> PathBuf {
    run.wait_until("the robot is on its way", |run| {
        let report = run.report().unwrap_or_default();
        report["time_s"]
            .as_f64()
            .is_some_and(|now_s| now_s > time_s)
    });
    run.domains().pop().expect("a domain")
}

/// The configuration that a service of the run was started with.
fn config(root: &Path, role: &str) -> String {
    root.join(format!("{role}.toml")).display().to_string()
}

#[track_caller]
fn arrived(ended: &Ended) -> Value {
    let result = ended.expect(0);
    assert_eq!(result["reached"], true, "{result:#}");
    assert_eq!(result["contacts"], 0, "{result:#}");
    assert_eq!(result["restarts"], serde_json::json!([]), "{result:#}");
    result
}

/// A twin of every service is sent away with the owner's process id, and changes nothing. In
/// lockstep launch is held meanwhile, or the run would be over before.
fn twins(mode: &[&str]) -> Value {
    let mut run = start(mode);
    let root = driving(&mut run, 0.1);
    let owners = SERVICES.map(|(role, _)| run.service(role).expect("a service"));
    let held = !mode.is_empty();
    if held {
        run.signal(Signal::STOP);
    }
    let mut owners = owners.into_iter();
    let twins = SERVICES.map(|(role, binary)| {
        let owner = owners.next().expect("an owner");
        let config = config(&root, role);
        let flags = ["--epoch", "1", "--config", &config];
        (role, owner, Stranger::start(binary, &root, &flags))
    });
    for (role, owner, twin) in twins {
        let (code, log) = twin.left();
        assert_eq!(code, 2, "{role}: {log}");
        let said = format!("the seat of {role} is taken by process {owner}");
        assert!(log.contains(&said), "{role}: {log}");
        assert_eq!(log.lines().count(), 1, "{role}: {log}");
    }
    if held {
        run.signal(Signal::CONT);
    }
    let result = arrived(&run.finish());
    assert_eq!(leftovers(&root), Vec::<PathBuf>::new());
    result
}

#[test]
fn second_process_in_a_seat_is_rejected_with_the_owners_pid() {
    let _turn = real_time_turn();
    let _ = twins(&[]);
}

#[test]
fn second_processes_and_shadows_keep_the_lockstep_hash() {
    let alone = arrived(&start(&["--lockstep"]).finish());
    assert!(alone["run_hash"].is_string(), "{alone:#}");
    assert_eq!(alone["run_hash"], twins(&["--lockstep"])["run_hash"]);
    assert_eq!(alone["run_hash"], shadows(&["--lockstep"])["run_hash"]);
}

/// A shadow of every service hears and answers and is never obeyed. That of the local planner asks
/// for full speed.
fn shadows(mode: &[&str]) -> Value {
    let mut run = start(mode);
    let root = driving(&mut run, 0.1);
    let services: Vec<Option<u32>> = (SERVICES.iter().map(|(role, _)| run.service(role))).collect();
    run.signal(Signal::STOP);
    let mut shadows: Vec<Stranger> = Vec::new();
    for (role, binary) in SERVICES {
        let config = config(&root, role);
        let flags = ["--shadow", "--config", &config];
        shadows.push(Stranger::start(binary, &root, &flags));
    }
    shadows.push(Stranger::start("requests_full_speed", &root, &["--shadow"]));
    // They join while the run is held, and take part in the rest of it.
    std::thread::sleep(std::time::Duration::from_millis(500));
    run.signal(Signal::CONT);
    let result = arrived(&run.finish());
    for mut shadow in shadows {
        assert!(!services.contains(&Some(shadow.pid())));
        let log = shadow.log();
        assert!(!log.contains("ERROR"), "{log}");
        let (code, log) = shadow.left();
        assert_eq!(code, 0, "{log}");
        assert!(log.contains("launch is gone"), "it did not run with: {log}");
    }
    assert_eq!(leftovers(&root), Vec::<PathBuf>::new());
    result
}

#[test]
fn shadows_in_real_time_do_not_steer() {
    let _turn = real_time_turn();
    let _ = shadows(&[]);
}

#[test]
fn successors_seat_is_denied_to_every_epoch() {
    let _turn = real_time_turn();
    let mut run = start(&[]);
    let root = driving(&mut run, 0.2);
    let first = run.service("collision_guard").expect("the guard");
    assert!(send_signal(first, Signal::KILL));
    // In the middle of the restart and after it.
    let early = Stranger::start("zeronav-collision-guard", &root, &["--epoch", "2"]);
    run.wait_until("the successor is there", |run| {
        run.service("collision_guard")
            .is_some_and(|pid| pid != first)
    });
    let second = run.service("collision_guard").expect("the guard");
    let (code, log) = early.left();
    assert_eq!(code, 2, "{log}");
    assert!(
        log.contains("the seat of collision_guard is taken"),
        "{log}"
    );
    for epoch in ["1", "2", "3"] {
        let stale = Stranger::start("zeronav-collision-guard", &root, &["--epoch", epoch]);
        let (code, log) = stale.left();
        assert_eq!(code, 2, "{log}");
        assert!(log.contains(&format!("process {second}")), "{log}");
    }
    let result = run.finish().expect(0);
    assert_eq!(result["restarts"].as_array().map(Vec::len), Some(1));
    assert_eq!(result["contacts"], 0);
    assert_eq!(leftovers(&root), Vec::<PathBuf>::new());
}

#[test]
fn external_seat_goes_to_the_first_process_with_the_right_epoch() {
    let mut run = start(&["--lockstep", "--external", "collision_guard"]);
    run.wait_until("the others run", |run| run.children().len() == 4);
    let root = run.domains().pop().expect("a domain");
    let guard = |flags: &[&str]| Stranger::start("zeronav-collision-guard", &root, flags);

    let (code, log) = guard(&["--epoch", "7"]).left();
    assert_eq!(code, 2, "{log}");
    assert!(log.contains("expects --epoch 1"), "{log}");
    assert_eq!(log.lines().count(), 1, "{log}");
    let (code, log) = guard(&[]).left();
    assert_eq!(code, 2, "{log}");
    assert!(log.contains("--epoch <N>"), "{log}");
    // A shadow does not make the seat ready.
    let mut shadow = guard(&["--shadow"]);
    std::thread::sleep(std::time::Duration::from_millis(300));
    assert!(shadow.runs(), "{}", shadow.log());
    assert!(!run.has_ended());
    let report = run.report().expect("a report");
    assert_eq!(report["time_s"], 0.0, "{report:#}");

    let first = guard(&["--epoch", "1"]);
    driving(&mut run, 0.1);
    run.signal(Signal::STOP);
    let (code, log) = guard(&["--epoch", "1"]).left();
    assert_eq!(code, 2, "{log}");
    assert!(log.contains(&format!("process {}", first.pid())), "{log}");
    run.signal(Signal::CONT);
    let _ = arrived(&run.finish());
    for stays in [first, shadow] {
        let (code, log) = stays.left();
        assert_eq!(code, 0, "{log}");
    }
    assert_eq!(leftovers(&root), Vec::<PathBuf>::new());
}
