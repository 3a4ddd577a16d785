//! Latencies as a gate: what `zeronav latency` measures, asserts and keeps, the trace of its run, and
//! what it starts beside the stack. Never how fast a busy machine is.

use rustix::process::Signal;
use serde_json::Value;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use zeronav_msgs::role::Role;
use zeronav_msgs::stages::Stage;
use zeronav_tests::rooms::aisle_for_trials;
use zeronav_tests::trace::{check_stages, checked};
use zeronav_tests::{
    Ended, Zeronav, await_by_itself, children_of, is_alive, quiet_turn, real_time_turn,
};

/// The folder of the one run that was made.
fn run_of(ended: &Ended) -> PathBuf {
    let runs = std::fs::read_dir(ended.folder.path().join("runs")).expect("runs");
    let mut folders: Vec<PathBuf> = runs.flatten().map(|entry| entry.path()).collect();
    assert_eq!(folders.len(), 1, "{folders:?}");
    folders.remove(0)
}

/// Moves on in the folder of a command that has ended.
fn again(ended: Ended, arguments: &[&str]) -> Ended {
    Zeronav::start_in(ended.folder, arguments).finish()
}

fn number(value: &Value) -> f64 {
    value.as_f64().expect("a number")
}

#[test]
fn an_injected_delay_is_named_and_what_was_measured_is_a_baseline() {
    let _turn = real_time_turn();
    let asserted = "global_planner.p50 < 60ms, global_planner.p50 > 99ms, replanning.n >= 2";
    let arguments = [
        "latency",
        "./it.toml",
        "--trials",
        "2",
        "--inject",
        "global_planner=100ms",
        "--assert",
        asserted,
        "--save-baseline",
        "base.json",
        "--headless",
        "--json",
    ];
    let measured = Zeronav::start_in(aisle_for_trials(), &arguments).finish();
    let report = measured.expect(1);
    let cell = &report["cells"][0];
    assert_eq!(cell["verdict"], "pass", "{cell:#}");
    assert_eq!((&cell["trials"], &cell["rounds"]), (&2.into(), &2.into()));
    let assertions = report["assertions"].as_array().expect("assertions");
    let met: Vec<&Value> = assertions.iter().map(|one| &one["met"]).collect();
    assert_eq!(met, [false, true, true], "{assertions:#?}");
    // The slow hop is named, and nothing else.
    let complaints: Vec<&str> = measured
        .stderr
        .lines()
        .filter(|line| line.contains("is not met"))
        .collect();
    assert_eq!(complaints.len(), 1, "{}", measured.stderr);
    assert!(
        complaints[0].contains("global_planner.p50 < 60ms is not met: "),
        "{complaints:?}"
    );
    assert!(
        complaints[0].contains("(n 2), 10 Hz, idle"),
        "{complaints:?}"
    );
    check_rows(cell);
    check_trace(&run_of(&measured).join("trace.json"));
    check_baseline(measured);
}

/// What was measured is held against the baseline that it was saved as.
fn check_baseline(measured: Ended) {
    let run = run_of(&measured).display().to_string();
    let held = |before: Ended, asserted, code: i32| {
        let words = [
            "latency",
            &run,
            "--baseline",
            "base.json",
            "--assert",
            asserted,
        ];
        let ended = again(before, &words);
        assert_eq!(ended.code(), code, "{}\n{}", ended.stdout, ended.stderr);
        ended
    };
    // The run holds what was measured, so it is equal to itself.
    let same = held(measured, "reaction.p50 <= 1x, global_planner.p50 >= 1x", 0);
    assert!(
        same.stdout.contains("met      reaction.p50 <= 1x: 1.000x"),
        "{}",
        same.stdout
    );
    let slower = held(same, "global_planner.p50 < 0.99x", 1);
    assert!(
        slower
            .stderr
            .contains("global_planner.p50 < 0.99x is not met: 1.000x"),
        "{}",
        slower.stderr
    );
    // Two trials do not tell a 99th percentile.
    let untold = held(slower, "replanning.p99 < 1s", 1);
    assert!(
        untold
            .stderr
            .contains("cannot be said of 2 samples, it takes 100"),
        "{}",
        untold.stderr
    );
    // And what no measurement can change is rejected before.
    let asks = again(untold, &["latency", &run, "--trials", "3"]);
    assert_eq!(asks.code(), 2);
    assert!(
        asks.stderr.contains("--trials asks for a measurement"),
        "{}",
        asks.stderr
    );
}

/// Every latency has its interval, edges and commands were counted, and the kernel was asked.
fn check_rows(cell: &Value) {
    let rows = cell["rows"].as_array().expect("rows");
    let row = |name: &str| {
        let found = rows.iter().find(|row| row["name"] == name);
        found.unwrap_or_else(|| panic!("no {name}: {cell:#}"))
    };
    for name in [
        "reaction",
        "reaction_answered",
        "reaction_intended",
        "direct.robot",
        "through_map.mapping",
    ] {
        let row = row(name);
        assert!(row["n"].as_u64() > Some(20), "{row:#}");
        let [low, high] = [0, 1].map(|end| number(&row["p50_interval_us"][end]));
        let p50 = number(&row["p50_us"]);
        assert!(low <= p50 && p50 <= high, "{row:#}");
    }
    let n = |name: &str| row(name)["n"].as_u64();
    assert!(n("reaction_answered") <= n("reaction") && n("reaction") <= n("reaction_intended"));
    assert_eq!(n("replanning"), Some(2));
    assert!(row("replanning")["p99_us"].is_null());
    assert!(n("transport_floor") >= Some(20));
    assert_eq!(cell["edges"].as_array().map(Vec::len), Some(9));
    for edge in cell["edges"].as_array().expect("edges") {
        assert!(edge["sent"].as_u64() > Some(20), "{edge:#}");
        assert!(
            edge["superseded"].as_u64() < edge["sent"].as_u64(),
            "{edge:#}"
        );
    }
    assert!(
        cell["commands"]["n"].as_u64() > Some(100),
        "{:#}",
        cell["commands"]
    );
    assert_eq!(cell["disturbances"].as_array().map(Vec::len), Some(2));
    let lints = cell["lints"].as_array().expect("lints");
    let refused = |lint: &Value| {
        lint.as_str()
            .is_some_and(|lint| lint.contains("replanning, event_to_motion: 2 samples"))
    };
    assert!(lints.iter().any(refused), "{lints:#?}");
}

/// The trace of a real run: a scan can be followed to the wheels, a thread does one thing at a time, and
/// the big stages of each cycle are there.
fn check_trace(file: &Path) {
    let trace = checked(&std::fs::read_to_string(file).expect("a trace"));
    assert_eq!(
        trace.tracks.len(),
        15,
        "five processes, the wheels, nine edges"
    );
    let lengths = ["sttf", "sttttf"];
    assert!(
        trace
            .flows
            .iter()
            .all(|(_, kinds)| lengths.contains(&kinds.as_str())),
        "{:?}",
        trace.flows
    );
    assert!(trace.n_flows("scan to wheel") > 20 && trace.n_flows("new path") >= 1);
    check_stages(&trace);
    for (role, stage) in [
        (Role::Robot, Stage::Cast),
        (Role::Mapping, Stage::Integrate),
        (Role::Mapping, Stage::Clearance),
        (Role::LocalPlanner, Stage::Rollouts),
        (Role::LocalPlanner, Stage::Verify),
    ] {
        assert!(trace.count(role, stage.label()) > 20, "{role}: {stage:?}");
    }
    assert!(trace.count(Role::GlobalPlanner, Stage::Search.label()) >= 1);
}

#[test]
fn what_cannot_be_measured_or_asserted_is_said_before_anything_starts() {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("no_report.json"), "{\"format\": 1}").expect("written");
    std::fs::create_dir(folder.path().join("empty")).expect("a folder");
    let cases: [(&[&str], &str); 9] = [
        (
            &["blocked_aisle", "--assert", "replaning.p50 < 5ms"],
            "did you mean `replanning`",
        ),
        (
            &["blocked_aisle", "--assert", "reaction.p50 < 5"],
            "column 17",
        ),
        (
            &["blocked_aisle", "--assert", "reaction.p50 < 1.1x"],
            "add --baseline FILE",
        ),
        (
            &["blocked_aisle", "--assert", "replanning.p99 < 5ms"],
            "--trials 100",
        ),
        (
            &["blocked_aisle", "--baseline", "no_report.json"],
            "no_report.json is no report",
        ),
        (
            &["blocked_aisle", "--baseline", "nowhere.json"],
            "nowhere.json",
        ),
        (&["blocked_aisle", "--rate", "10,0"], "above 0 Hz"),
        (&["blocked_aisle", "--rate", "900"], "the lidar's 900 scans"),
        (&["empty"], "result.json"),
    ];
    let mut before = Zeronav::start_in(folder, &["latency", "--help"]).finish();
    for (arguments, said) in cases {
        let mut line = vec!["latency"];
        line.extend(arguments);
        let ended = again(before, &line);
        assert_eq!(ended.code(), 2, "{arguments:?}: {}", ended.stderr);
        assert!(
            ended.stderr.contains(said),
            "{arguments:?}: {}",
            ended.stderr
        );
        assert!(!ended.folder.path().join("runs").exists(), "{arguments:?}");
        before = ended;
    }
    // A mark stands under the place.
    let wrong = again(
        before,
        &["latency", "blocked_aisle", "--assert", "reaction.p50 < 5"],
    );
    let lines: Vec<&str> = wrong.stderr.lines().collect();
    assert_eq!(
        lines.last().map(|mark| mark.len()),
        Some(2 + 17),
        "{lines:?}"
    );
}

#[test]
fn what_keeps_the_machine_busy_ends_with_zeronav_whatever_ends_it() {
    let _turn = quiet_turn();
    for signal in [Signal::KILL, Signal::INT] {
        let arguments = [
            "latency",
            "blocked_aisle",
            "--trials",
            "1",
            "--load",
            "busy",
            "--headless",
        ];
        let mut run = Zeronav::start(&arguments);
        let busy = |run: &Zeronav| -> Vec<u32> {
            let children = children_of(run.pid()).into_iter();
            let is_busy = |line: &str| line.split(' ').nth(1) == Some("busy");
            children
                .filter(|(_, line)| is_busy(line))
                .map(|(pid, _)| pid)
                .collect()
        };
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        run.wait_until("a process per core computes", |run| {
            busy(run).len() == cores
        });
        let processes = busy(&run);
        run.signal(signal);
        await_by_itself("they have ended", || {
            processes.iter().all(|pid| !is_alive(*pid))
        });
    }
}

#[test]
fn two_sides_take_turns_and_what_was_measured_is_shown_after_an_interrupt() {
    let _turn = real_time_turn();
    let arguments = [
        "compare",
        "./it.toml",
        "--swap",
        "global_planner=zeronav-global-planner",
        "--trials",
        "6",
        "--headless",
        "--json",
    ];
    let mut run = Zeronav::start_in(aisle_for_trials(), &arguments);
    let mut domains = BTreeSet::new();
    run.wait_until("the second round begins", |run| {
        domains.extend(run.domains());
        domains.len() == 3
    });
    run.signal(Signal::INT);
    let ended = run.finish();
    let comparison = ended.expect(130);
    assert_eq!(comparison["rounds"], 1, "{comparison:#}");
    let b = comparison["b"].as_str().expect("a name");
    assert_eq!(b, "it, global_planner zeronav-global-planner");
    let rows = comparison["rows"].as_array().expect("rows");
    for name in ["reaction", "replanning"] {
        let row = rows.iter().find(|row| row["name"] == name).expect("a row");
        assert!(
            row["n"][0].as_u64() > Some(0) && row["n"][1].as_u64() > Some(0),
            "{row:#}"
        );
        assert!(row["ratio"].is_null(), "{row:#}");
        assert_eq!(row["verdict"], "too few rounds");
    }
    // A binary that is not there is found before anything starts.
    let wrong = again(
        ended,
        &[
            "compare",
            "./it.toml",
            "--swap",
            "mapping=./nowhere",
            "--out",
            "other",
        ],
    );
    assert_eq!(wrong.code(), 2, "{}", wrong.stderr);
    assert!(wrong.stderr.contains("nowhere"), "{}", wrong.stderr);
    assert!(!wrong.folder.path().join("other").exists());
}

#[test]
fn the_start_is_a_chain_from_the_command_to_the_first_motion() {
    let _turn = real_time_turn();
    let folder = tempfile::tempdir().expect("a folder");
    let scenario = "title = \"A metre\"\nbase = [\"warehouse\", \"porter\"]\n\
                    start = [3.0, 8.5, 0.0]\n[run]\ntime_limit_s = 60.0\n\
                    [[goals]]\npose = [4.0, 8.5, 0.0]\n";
    std::fs::write(folder.path().join("it.toml"), scenario).expect("written");
    let driven = Zeronav::start_in(folder, &["run", "./it.toml", "--headless", "--json"]).finish();
    let result = driven.expect(0);
    check_trace_exists(&run_of(&driven));
    let wall_ms = 1.0e3 * number(&result["wall_s"]);
    let shown = again(driven, &["start-up", "--json"]);
    let report = shown.expect(0);
    let motion_ms = number(&report["first_motion_ms"]);
    assert!(
        motion_ms > 0.0 && motion_ms < wall_ms + 60_000.0,
        "{report:#}"
    );
    let chain = report["critical_chain"].as_array().expect("a chain");
    let mut at_ms = 0.0;
    for stage in chain {
        assert!(
            (number(&stage["from_ms"]) - at_ms).abs() < 1.0e-6,
            "a gap before {stage:#}"
        );
        at_ms = number(&stage["to_ms"]);
    }
    assert!(
        (at_ms - motion_ms).abs() < 1.0e-6,
        "the chain adds up: {report:#}"
    );
    assert_eq!(
        chain.first().map(|stage| &stage["name"]),
        Some(&"scenario checked".into())
    );
    assert_eq!(
        chain.last().map(|stage| &stage["name"]),
        Some(&"first motion".into())
    );
    // Everything that has to happen has happened.
    let stages = report["stages"].as_array().expect("stages");
    assert_eq!(stages.len(), 3 + 5 + 5 + 1 + 7, "{stages:#?}");
    let page = again(shown, &["start-up"]);
    assert!(page.stdout.contains("critical chain"), "{}", page.stdout);
}

fn check_trace_exists(run: &Path) {
    let length = std::fs::metadata(run.join("trace.json")).map(|file| file.len());
    assert!(
        length.is_ok_and(|bytes| (10_000..20_000_000).contains(&bytes)),
        "{}",
        run.display()
    );
}
