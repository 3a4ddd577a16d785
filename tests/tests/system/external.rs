//! A service that was started by hand exits by itself when launch is gone.

use rustix::process::Signal;
use std::path::PathBuf;
use zeronav_tests::{Stranger, Zeronav, await_by_itself, is_alive, leftovers, real_time_turn};

/// A drive in lockstep whose guard was started by hand, and its domain.
fn driving() -> (Zeronav, PathBuf, Stranger) {
    let mut run = Zeronav::start(&[
        "run",
        "unsealed",
        "--lockstep",
        "--headless",
        "--json",
        "--external",
        "collision_guard",
    ]);
    run.wait_until("the others run", |run| run.children().len() == 4);
    run.wait_until("they know their domain", |run| run.domains().len() == 1);
    let root = run.domains().pop().expect("a domain");
    let guard = Stranger::start("zeronav-collision-guard", &root, &["--epoch", "1"]);
    (run, root, guard)
}

#[test]
fn external_service_exits_when_launch_is_killed() {
    let (mut run, root, guard) = driving();
    run.wait_until("the robot is on its way", |run| {
        let report = run.report().unwrap_or_default();
        report["time_s"].as_f64().is_some_and(|time_s| time_s > 0.5)
    });
    assert!(is_alive(guard.pid()));
    run.signal(Signal::KILL);
    let (code, log) = guard.left();
    assert_eq!(code, 0, "{log}");
    assert!(log.contains("launch is gone"), "{log}");
    await_by_itself("nothing is left", || leftovers(&root).is_empty());
}

#[test]
fn external_service_exits_after_the_run_and_removes_the_domain() {
    let (run, root, guard) = driving();
    let result = run.finish().expect(0);
    assert_eq!(result["reached"], true, "{result:#}");
    let services = result["services"].as_array().expect("services");
    let seat = services
        .iter()
        .find(|seat| seat["name"] == "collision_guard");
    let seat = seat.expect("the guard's seat");
    assert_eq!(seat["binary"], "zeronav-collision-guard", "{seat:#}");
    assert_eq!(seat["pid"], guard.pid(), "{seat:#}");
    assert_eq!(seat["external"], true, "{seat:#}");
    let (code, log) = guard.left();
    assert_eq!(code, 0, "{log}");
    assert!(log.contains("launch is gone"), "{log}");
    assert_eq!(leftovers(&root), Vec::<PathBuf>::new());
}

#[test]
fn external_service_restarts_with_the_next_epoch() {
    let _turn = real_time_turn();
    let mut run = Zeronav::start(&[
        "run",
        "unsealed",
        "--headless",
        "--json",
        "--external",
        "collision_guard",
    ]);
    run.wait_until("the others run", |run| run.children().len() == 4);
    let root = run.domains().pop().expect("a domain");
    let guard = |epoch| Stranger::start("zeronav-collision-guard", &root, &["--epoch", epoch]);
    let first = guard("1");
    run.wait_until("the robot is on its way", |run| {
        let report = run.report().unwrap_or_default();
        report["time_s"].as_f64().is_some_and(|time_s| time_s > 0.5)
    });
    assert_eq!(run.service("collision_guard"), Some(first.pid()));
    drop(first);
    run.wait_until("the next epoch is expected", |_| {
        let (code, log) = guard("1").left();
        assert_eq!(code, 2, "{log}");
        log.contains("expects --epoch 2")
    });
    let second = guard("2");
    let result = run.finish().expect(0);
    assert_eq!(result["reached"], true, "{result:#}");
    assert_eq!(result["contacts"], 0, "{result:#}");
    assert_eq!(result["restarts"][0]["service"], "collision_guard");
    let services = result["services"].as_array().expect("services");
    assert!(services.iter().any(|seat| seat["pid"] == second.pid()));
    assert_eq!(second.left().0, 0);
    assert_eq!(leftovers(&root), Vec::<PathBuf>::new());
}
