//! `zeronav logs` on a real stack: everything that is logged, by time, through restarts.

use rustix::process::Signal;
use serde_json::Value;
use std::io::Write;
use std::path::PathBuf;
use zeronav_tests::{Zeronav, leftovers, real_time_turn, send_signal};

const SCENARIO: &str = "title = \"test\"\nbase = [\"warehouse\", \"porter\"]\n\
                        start = [4.0, 6.425, 0.0]\n\
                        [[goals]]\npose = [12.5, 6.425, 0.0]\n";

fn driving() -> (Zeronav, PathBuf) {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("it.toml"), SCENARIO).expect("written");
    let mut run = Zeronav::start_in(folder, &["run", "./it.toml", "--headless", "--json"]);
    run.wait_until("the robot is on its way", |run| {
        let report = run.report().unwrap_or_default();
        report["time_s"].as_f64().is_some_and(|time_s| time_s > 0.1)
    });
    let root = run.domains().pop().expect("a domain");
    (run, root)
}

fn logs(root: &std::path::Path, words: &[&str]) -> Zeronav {
    let root = root.to_str().expect("a path");
    Zeronav::start(&[&["logs", "--domain", root], words].concat())
}

#[test]
fn logs_of_all_services_come_by_time_through_a_restart_to_the_end() {
    let _turn = real_time_turn();
    let (mut run, root) = driving();
    let mut all = logs(&root, &["-f", "--json"]);
    all.wait_until("the beginning is shown", |logs| {
        logs.has_said("the run begins")
    });
    let own = logs(&root, &["collision_guard", "-f"]);
    let first = run.service("collision_guard").expect("the guard");

    // What terminals obey, and half a line, as a service that dies may leave it.
    let report = run.report().expect("a report");
    let folder = PathBuf::from(report["folder"].as_str().expect("the run's folder"));
    let file = std::fs::File::options()
        .append(true)
        .open(folder.join("logs/collision_guard.log"));
    let mut file = file.expect("the log");
    file.write_all(b"\x1b[2J bad \xff\n half a ")
        .expect("written");
    drop(file);
    assert!(send_signal(first, Signal::KILL));
    run.wait_until("the successor is there", |run| {
        let guard = run.service("collision_guard");
        guard.is_some_and(|pid| pid != first)
    });

    let result = run.finish().expect(0);
    assert_eq!(result["restarts"].as_array().map(Vec::len), Some(1));
    let all = all.finish();
    assert_eq!(
        (all.code(), all.stderr.as_str()),
        (0, "the run has ended\n")
    );
    let lines: Vec<Value> = all
        .stdout
        .lines()
        .map(|line| serde_json::from_str(line).expect("a JSON object per line"))
        .collect();
    for service in [
        "launch",
        "robot",
        "mapping",
        "global_planner",
        "local_planner",
        "collision_guard",
    ] {
        assert!(
            lines.iter().any(|line| line["service"] == service),
            "{service}: {}",
            all.stdout
        );
    }
    let said = |text: &str| {
        lines
            .iter()
            .any(|line| line["text"].as_str().is_some_and(|it| it.contains(text)))
    };
    assert!(said("the run ends"), "{}", all.stdout);
    let stamped = lines.iter().filter(|line| line["level"] == "info");
    assert!(stamped.clone().count() > 5);
    assert!(stamped.clone().all(|line| line["time"].is_string()));

    let own = own.finish();
    assert_eq!(own.code(), 0, "{}", own.stderr);
    assert!(
        own.stdout.contains("\\u{1b}[2J bad \u{fffd}\n"),
        "{}",
        own.stdout
    );
    assert!(own.stdout.contains(" half a "), "{}", own.stdout);
    assert!(!own.stdout.contains('\u{1b}'));
    assert_eq!(leftovers(&root), Vec::<PathBuf>::new());
}

#[test]
fn logs_so_far_are_in_the_order_of_their_times() {
    let _turn = real_time_turn();
    let (run, root) = driving();
    let ended = logs(&root, &["--json"]).finish();
    assert_eq!(ended.code(), 0, "{}", ended.stderr);
    let times: Vec<String> = ended
        .stdout
        .lines()
        .filter_map(|line| {
            let line: Value = serde_json::from_str(line).expect("a JSON object per line");
            line["time"].as_str().map(str::to_owned)
        })
        .collect();
    assert!(times.len() > 5, "{}", ended.stdout);
    assert!(times.is_sorted(), "{}", ended.stdout);
    let unknown = logs(&root, &["planer"]).finish();
    assert_eq!(unknown.code(), 2);
    assert_eq!(unknown.stderr.lines().count(), 1, "{}", unknown.stderr);
    drop(run);
}
