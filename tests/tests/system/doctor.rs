//! `zeronav doctor` on this machine: it removes what dead runs left, and nothing else.

use rustix::process::Signal;
use serde_json::Value;
use std::path::Path;
use zeronav_tests::{Zeronav, await_by_itself, leftovers, zeronav};

/// The names of the checks with their levels.
fn levels(report: &Value) -> Vec<(&str, &str)> {
    let checks = report["checks"].as_array().expect("checks");
    checks
        .iter()
        .map(|check| {
            (
                check["check"].as_str().expect("a name"),
                check["level"].as_str().expect("a level"),
            )
        })
        .collect()
}

#[test]
fn every_check_has_a_level_and_bad_ones_a_fix() {
    let ended = zeronav(&["doctor", "--json"]);
    let report = ended.json();
    let names: Vec<&str> = levels(&report).iter().map(|(name, _)| *name).collect();
    let expected = [
        "leftovers",
        "shared memory",
        "open files",
        "locked memory",
        "clock",
        "cores",
        "processor",
        "governor",
        "logind",
    ];
    assert_eq!(names, expected);
    let can_run = levels(&report).iter().all(|(_, level)| *level != "error");
    assert_eq!(report["can_run"], can_run);
    assert_eq!(ended.code(), i32::from(!can_run), "{}", ended.stderr);
    for check in report["checks"].as_array().expect("checks") {
        assert_eq!(check["fix"].is_null(), check["level"] == "ok", "{check:#}");
    }
    let text = zeronav(&["doctor"]).stdout;
    for name in expected {
        assert!(text.contains(&format!(" {name}: ")), "{name}: {text}");
    }
}

#[test]
fn domains_of_dead_runs_are_removed_and_living_ones_stay() {
    let mut living = Zeronav::start(&["run", "unsealed", "--headless", "--json"]);
    living.wait_until("it runs", |run| run.report().is_some());
    let root = living.domains().pop().expect("a domain");
    // A domain whose processes are all gone: a folder, a segment, a lock that nobody holds.
    let dead = Path::new("/dev/shm/zn_doctortest");
    let mut builder = std::fs::DirBuilder::new();
    std::os::unix::fs::DirBuilderExt::mode(&mut builder, 0o700);
    builder.create(dead).expect("a folder");
    let segment = dead.with_file_name("zn_doctortest_1.data");
    std::fs::write(&segment, b"old").expect("a segment");
    // And a segment that is left of a domain that is gone.
    let stray = dead.with_file_name("zn_doctorstra_1.data");
    std::fs::write(&stray, b"old").expect("a segment");

    let report = zeronav(&["doctor", "--json"]).json();
    let found = &report["checks"][0];
    assert_eq!(found["check"], "leftovers");
    assert_eq!(found["level"], "warning", "{found:#}");
    let fix = found["fix"].as_str().expect("a fix");
    assert!(fix.contains("/dev/shm/zn_doctorstra_1.data"), "{fix}");
    assert!(!dead.exists() && !segment.exists(), "{found:#}");
    assert!(stray.exists(), "nobody can know who uses it");
    std::fs::remove_file(&stray).expect("removed");
    assert!(root.exists());
    assert!(living.report().is_some(), "the living run goes on");

    living.signal(Signal::INT);
    let _ = living.finish();
    await_by_itself("nothing is left", || leftovers(&root).is_empty());
}
