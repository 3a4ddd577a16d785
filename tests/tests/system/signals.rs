//! Every signal that asks to stop: the robot comes to rest, the result is written, nothing is left.

use rustix::process::Signal;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};
use zeronav_msgs::role::Role;
use zeronav_msgs::topics::GroundTruth;
use zeronav_shell::roster_reader::RosterReader;
use zeronav_shell::{Domain, Peer};
use zeronav_tests::{
    Zeronav, await_by_itself, children_of, leftovers, real_time_turn, services_of, workspace,
};

/// Signals that stop.
const STOPS: [Signal; 4] = [Signal::HUP, Signal::QUIT, Signal::TERM, Signal::INT];

/// Starts a drive and waits until the robot is on its way; its domain.
fn driving(more: &[&str]) -> (Zeronav, PathBuf) {
    let arguments = [&["run", "unsealed", "--headless", "--json"], more].concat();
    let mut run = Zeronav::start(&arguments);
    run.wait_until("the robot is on its way", |run| {
        let report = run.report().unwrap_or_default();
        report["time_s"].as_f64().is_some_and(|time_s| time_s > 0.3)
    });
    let root = run.domains().pop().expect("a domain");
    (run, root)
}

/// The run has ended in good order.
#[track_caller]
fn interrupted(run: Zeronav, root: &Path, signal: Signal) {
    let ended = run.finish();
    let result = ended.expect(130);
    assert_eq!(result["outcome"], "interrupted", "{signal:?}: {result:#}");
    assert_eq!(result["contacts"], 0, "{signal:?}: {result:#}");
    let directory = result["directory"].as_str().expect("a folder");
    let file = ended.folder.path().join(directory).join("result.json");
    let written = std::fs::read_to_string(&file).expect("the result is written");
    assert!(written.contains("interrupted"), "{signal:?}: {written}");
    for service in result["services"].as_array().expect("services") {
        assert_eq!(service["end"], "stopped", "{signal:?}: {service:#}");
    }
    assert_eq!(leftovers(root), Vec::<PathBuf>::new(), "{signal:?}");
}

#[test]
fn every_signal_stops_a_run_in_lockstep() {
    for signal in STOPS {
        let (run, root) = driving(&["--lockstep"]);
        run.signal(signal);
        interrupted(run, &root, signal);
    }
}

#[test]
fn every_signal_stops_a_run_in_real_time_with_the_robot_stopped() {
    let _turn = real_time_turn();
    for signal in STOPS {
        let (mut run, root) = driving(&[]);
        let peer = Peer::join(Domain::join(&root).expect("the domain"), Role::Tap, 1);
        let peer = peer.expect("guests are welcome");
        let mut roster = RosterReader::open(&peer).expect("the roster");
        let mut truths = peer.stream::<GroundTruth>().expect("the truth");
        let mut speeds_mps = Vec::new();
        let mut listen = move |speeds_mps: &mut Vec<f64>| {
            roster.poll();
            truths.drain(roster.roster(), |view| speeds_mps.push(view.meta.v_mps));
        };
        run.wait_until("the robot drives", |_| {
            listen(&mut speeds_mps);
            speeds_mps.last().is_some_and(|v_mps| *v_mps > 0.2)
        });
        run.signal(signal);
        let started = Instant::now();
        while !run.has_ended() && started.elapsed() < Duration::from_secs(10) {
            listen(&mut speeds_mps);
        }
        listen(&mut speeds_mps);
        let last_mps = speeds_mps.last().expect("a speed");
        assert!(last_mps.abs() < 0.01, "{signal:?}: {last_mps} m/s");
        drop(listen);
        let _ = peer.leave().close();
        interrupted(run, &root, signal);
    }
}

#[test]
fn a_hangup_stops_a_suite() {
    let folder = tempfile::tempdir().expect("a folder");
    let scenario = workspace().join("launch/scenarios/unsealed.toml");
    std::fs::create_dir(folder.path().join("worlds")).expect("a folder");
    for copy in ["a", "b", "c"] {
        let file = folder.path().join(format!("worlds/{copy}.toml"));
        std::fs::copy(&scenario, file).expect("a scenario");
    }
    let mut suite = Zeronav::start_in(folder, &["suite", "./worlds", "--json"]);
    // Each run is a zeronav of its own.
    let services = |suite: &Zeronav| -> Vec<String> {
        let runs = children_of(suite.pid()).into_iter();
        runs.flat_map(|(pid, _)| services_of(pid))
            .map(|(_, line)| line)
            .collect()
    };
    suite.wait_until("a run goes on", |suite| !services(suite).is_empty());
    let roots: Vec<PathBuf> = (services(&suite).iter())
        .filter_map(|line| line.split(" --domain ").nth(1)?.split(' ').next())
        .map(PathBuf::from)
        .collect();
    suite.signal(Signal::HUP);
    let ended = suite.finish();
    assert_eq!(ended.code(), 130, "{}", ended.stderr);
    for root in roots {
        assert_eq!(leftovers(&root), Vec::<PathBuf>::new());
    }
}

/// The first Ctrl-C waits for a service that does not let go; the second one does not.
#[test]
fn a_second_interrupt_forces_the_end_and_nothing_is_left() {
    let _turn = real_time_turn();
    let folder = tempfile::tempdir().expect("a folder");
    let scenario = "title = \"test\"\nbase = [\"warehouse\", \"porter\"]\n\
                    start = [4.0, 6.425, 0.0]\n\
                    [[goals]]\npose = [9.9, 6.425, 0.0]\n\
                    [services.local_planner]\nbinary = \"ignores_sigterm\"\n";
    std::fs::write(folder.path().join("it.toml"), scenario).expect("written");
    let mut run = Zeronav::start_in(folder, &["run", "./it.toml", "--headless", "--json"]);
    run.wait_until("the run goes on", |run| {
        let report = run.report().unwrap_or_default();
        report["time_s"].as_f64().is_some_and(|time_s| time_s > 0.1)
    });
    let root = run.domains().pop().expect("a domain");
    run.signal(Signal::INT);
    std::thread::sleep(Duration::from_millis(700));
    assert!(!run.has_ended(), "it waits for the one that stays");
    run.signal(Signal::INT);
    let started = Instant::now();
    assert_eq!(run.finish().code(), 130);
    assert!(started.elapsed() < Duration::from_millis(500));
    await_by_itself("nothing is left", || leftovers(&root).is_empty());
}
