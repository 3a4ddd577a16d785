//! The kit for whoever writes a seat: every stock service and every example keeps the contract, and each
//! program of a zoo breaks exactly the clause that it is made to break.

use serde_json::Value;
use std::process::Command;
use zeronav_tests::{Ended, Zeronav, binaries, quiet_turn};

/// Hostile messages for a program of the zoo.
const FEW: &str = "5000";

/// Hostile messages for a stock service: a fiftieth of what the kit sends without being asked.
const SOME: &str = "20000";

/// Kits that run side by side: they wait more than they compute.
const AT_A_TIME: usize = 7;

/// Starts the kit on a program.
fn start(role: &str, binary: &str, more: &[&str]) -> Zeronav {
    Zeronav::start(&[&["contract", role, binary, "--json"], more].concat())
}

/// The lines with this verdict, as `name: why`.
fn lines(report: &Value, verdict: &str) -> Vec<String> {
    let clauses = report["clauses"].as_array().expect("clauses");
    assert_eq!(clauses.len(), 22, "{report:#}");
    let wanted = clauses.iter().filter(|line| line["verdict"] == verdict);
    wanted
        .map(|line| format!("{}: {}", line["name"].as_str().unwrap_or("?"), line["why"]))
        .collect()
}

/// True where a process may have a /dev/shm of its own, which the clause `no_memory` needs.
fn has_namespaces() -> bool {
    let script = "mount -t tmpfs -o size=1m tmpfs /dev/shm";
    let mut command = Command::new("unshare");
    command.args(["--user", "--map-root-user", "--mount"]);
    let output = command.args(["sh", "-c", script]).output();
    output.is_ok_and(|output| output.status.success())
}

/// All clauses are kept, and none is left out that can be tested here.
fn assert_kept(ended: &Ended) -> Value {
    let report = ended.expect(0);
    assert_eq!(report["passes"], true, "{report:#}");
    assert_eq!(lines(&report, "failed"), Vec::<String>::new());
    let skipped = lines(&report, "skipped");
    let cannot: &[&str] = if has_namespaces() {
        &[]
    } else {
        &["no_memory"]
    };
    let names = skipped.iter().filter_map(|line| line.split(':').next());
    assert!(names.eq(cannot.iter().copied()), "{skipped:?}");
    report
}

const STOCK: [(&str, &str); 4] = [
    ("mapping", "zeronav-mapping"),
    ("global_planner", "zeronav-global-planner"),
    ("local_planner", "zeronav-local-planner"),
    ("collision_guard", "zeronav-collision-guard"),
];

#[test]
fn stock_services_and_the_example_keep_the_contract() {
    let _turn = quiet_turn();
    let mut runs: Vec<Zeronav> = STOCK
        .iter()
        .map(|(role, binary)| start(role, binary, &["--hostile", SOME]))
        .collect();
    let example = "straight_line_service";
    runs.push(start("global_planner", example, &["--hostile", SOME]));
    for run in runs {
        assert_kept(&run.finish());
    }
}

#[test]
#[ignore = "about a minute: a million hostile messages for each stock service"]
fn stock_services_survive_a_million_hostile_messages() {
    for (role, binary) in STOCK {
        let report = assert_kept(&start(role, binary, &[]).finish());
        assert_eq!(report["hostile_messages"], 1_000_000, "{report:#}");
        let ok = lines(&report, "ok");
        let line = ok.iter().find(|line| line.starts_with("hostile_input"));
        eprintln!("{role}: {}", line.expect("its line"));
    }
}

/// What a program of the zoo is made to break: fault, seat, clause. Some clauses are broken in two ways.
const ZOO: [(&str, &str, &str); 28] = [
    ("none", "local_planner", ""),
    ("help", "local_planner", "help"),
    ("help_flood", "local_planner", "help"),
    ("print_config", "local_planner", "print_config"),
    ("unknown_flag", "local_planner", "unknown_flag"),
    ("bad_config", "local_planner", "bad_config"),
    ("other_contract", "local_planner", "other_contract"),
    ("no_memory", "local_planner", "no_memory"),
    ("one_per_seat", "local_planner", "one_per_seat"),
    ("topics", "local_planner", "topics"),
    ("idle_output", "local_planner", "idle_output"),
    ("heartbeat", "local_planner", "heartbeat"),
    ("lockstep", "local_planner", "lockstep"),
    ("lockstep_twice", "local_planner", "lockstep"),
    ("records", "local_planner", "records"),
    ("records_unnamed", "local_planner", "records"),
    ("repeatable", "local_planner", "repeatable"),
    ("epoch", "local_planner", "epoch"),
    ("obeyed_only", "local_planner", "obeyed_only"),
    ("legal_output", "local_planner", "legal_output"),
    ("legal_output_nan", "local_planner", "legal_output"),
    ("legal_output_path", "global_planner", "legal_output"),
    ("latency", "local_planner", "latency"),
    ("lost_input", "local_planner", "lost_input"),
    ("hostile_input", "local_planner", "hostile_input"),
    ("bounded_memory", "local_planner", "bounded_memory"),
    ("stop", "local_planner", "stop"),
    ("orphan", "local_planner", "orphan"),
];

/// The zoo's program with a fault.
fn start_wrong(role: &str, fault: &str) -> Zeronav {
    let program = binaries().join("wrong_service").display().to_string();
    let fault = format!("FAULT={fault}");
    start(role, "env", &["--hostile", FEW, "--", &fault, &program])
}

#[test]
fn every_program_of_the_zoo_breaks_its_own_clause_and_no_other() {
    let _turn = quiet_turn();
    let namespaces = has_namespaces();
    for some in ZOO.chunks(AT_A_TIME) {
        let runs: Vec<Zeronav> = (some.iter())
            .map(|(fault, role, _)| start_wrong(role, fault))
            .collect();
        for ((fault, _, clause), run) in some.iter().zip(runs) {
            let ended = run.finish();
            let failed = lines(&ended.json(), "failed");
            let names = failed.iter().filter_map(|line| line.split(':').next());
            let expected = Some(*clause).filter(|clause| !clause.is_empty());
            let expected = expected.filter(|clause| *clause != "no_memory" || namespaces);
            assert!(names.eq(expected), "{fault}: {failed:#?}");
            let code = i32::from(expected.is_some());
            assert_eq!(ended.code(), code, "{fault}");
        }
    }
}

#[test]
fn the_robot_has_no_kit_and_wrong_arguments_are_named() {
    binaries();
    for (arguments, words) in [
        (&["contract", "robot", "zeronav-robot-sim"][..], "clock"),
        (&["contract", "mapper", "x"], "did you mean `mapping`?"),
        (&["contract", "mapping", "no-such-binary"], "no-such-binary"),
        (
            &[
                "contract",
                "mapping",
                "zeronav-mapping",
                "--config",
                "absent",
            ],
            "--config absent",
        ),
    ] {
        let ended = zeronav_tests::zeronav(arguments);
        assert_eq!(ended.code(), 2, "{}", ended.stderr);
        assert_eq!(ended.stderr.lines().count(), 1, "{}", ended.stderr);
        assert!(ended.stderr.contains(words), "{}", ended.stderr);
    }
}
