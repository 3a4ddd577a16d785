//! `zeronav suite`: runs side by side, and what they leave.

use rustix::process::Signal;
use serde_json::Value;
use std::path::{Path, PathBuf};
use zeronav_tests::data::{external_data, shipped_data};
use zeronav_tests::rooms::short_drive;
use zeronav_tests::{Zeronav, children_of, domains_of, is_alive, leftovers, services_of, zeronav};

/// A drive past a box.
fn tiny() -> String {
    let shape = "{ kind = \"box\", centre_m = [2.5, 0.6], size_m = [0.4, 0.6] }";
    short_drive(&format!("resolution_m = 0.05\nshapes = [{shape}]"))
}

/// The same without a goal: it goes on until it is stopped.
fn endless() -> String {
    tiny()
        .replace("time_limit_s = 30.0", "time_limit_s = 100000.0")
        .replace("[[goals]]\npose = [4.5, 1.0, 0.0]\n", "")
}

/// A working folder with `scenarios/tiny.toml`.
fn working_folder(scenario: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a working folder");
    std::fs::create_dir(folder.path().join("scenarios")).expect("a folder");
    std::fs::write(folder.path().join("scenarios/tiny.toml"), scenario).expect("a file");
    folder
}

/// The folder that a report names.
fn directory(folder: &Path, report: &Value) -> PathBuf {
    folder.join(report["directory"].as_str().expect("its folder"))
}

#[test]
fn folder_runs_once_per_seed_and_writes_json_csv_and_junit() {
    let folder = working_folder(&tiny());
    let arguments = ["suite", "scenarios", "--seeds", "2", "--json"];
    let ended = Zeronav::start_in(folder, &arguments).finish();
    let report = ended.expect(0);
    let summary = &report["summary"];
    assert_eq!(summary["worlds"], 1);
    assert_eq!(summary["runs"], 2);
    assert_eq!(summary["success"], 1.0, "{report:#}");
    assert_eq!(summary["contacts_moving"], 0);
    assert_eq!(summary["contacts_standing"], 0);
    assert_eq!(summary["timeouts"], 0);
    // A folder has no benchmark, so no score is made up.
    assert_eq!(summary["score"], Value::Null);
    assert_eq!(summary["score_4ot"], Value::Null);
    let time_s = summary["mean_time_s"].as_f64().expect("seconds");
    assert!((3.0..15.0).contains(&time_s), "{time_s} s for 3.5 m");
    // From rest to 1 m/s and back: some acceleration comes and goes.
    let jerk_mps3 = summary["mean_jerk_mps3"].as_f64().expect("a jerk");
    assert!((0.05..5.0).contains(&jerk_mps3), "{jerk_mps3}");
    assert!(summary["interventions"].is_u64(), "{report:#}");
    // Nothing was in the way.
    assert_eq!(summary["recoveries"], 0, "{report:#}");
    // No pedestrians here, so there is no future that an oracle could know.
    assert_eq!(summary["unavoidable"], Value::Null);
    assert_eq!(summary["arrival"], 1.0);
    let ratio = summary["mean_path_ratio"].as_f64().expect("a ratio");
    assert!((0.95..1.5).contains(&ratio), "{ratio}");
    let runs = report["runs"].as_array().expect("runs");
    let seeds: Vec<u64> = runs.iter().filter_map(|run| run["seed"].as_u64()).collect();
    assert_eq!(seeds, [1, 2]);
    for run in runs {
        let own = directory(ended.folder.path(), &report)
            .join(run["directory"].as_str().expect("its folder"));
        for name in ["result.json", "run.svg"] {
            assert!(own.join(name).is_file(), "{}/{name}", own.display());
        }
    }

    let left = directory(ended.folder.path(), &report);
    let read = |name: &str| std::fs::read_to_string(left.join(name)).expect(name);
    let json: Value = serde_json::from_str(&read("suite.json")).expect("JSON");
    assert_eq!(json["summary"], report["summary"]);
    let csv = read("runs.csv");
    let lines: Vec<&str> = csv.lines().collect();
    assert_eq!(lines.len(), 3, "{csv}");
    assert!(
        lines[0].starts_with("world,class,seed,success,cause,"),
        "{csv}"
    );
    assert!(lines[1].starts_with("tiny,tiny,1,true,,"), "{csv}");
    assert!(lines[2].starts_with("tiny,tiny,2,true,,"), "{csv}");
    let junit = read("junit.xml");
    assert!(junit.contains("tests=\"2\" failures=\"0\""), "{junit}");
    assert_eq!(junit.matches("<testcase ").count(), 2, "{junit}");
}

#[test]
fn every_variant_of_a_scenario_is_a_world() {
    let variants = "[variants.near]\ngoals = [{ pose = [3.5, 1.0, 0.0] }]\n[variants.far]\n";
    let folder = working_folder(&(tiny() + variants));
    let report = Zeronav::start_in(folder, &["suite", "scenarios", "--json"])
        .finish()
        .expect(0);
    let runs = report["runs"].as_array().expect("runs");
    let worlds: Vec<&str> = runs
        .iter()
        .filter_map(|run| run["world"].as_str())
        .collect();
    assert_eq!(worlds, ["tiny_far", "tiny_near"]);
    assert_eq!(report["summary"]["success"], 1.0, "{report:#}");
    let driven_m = |index: usize| runs[index]["driven_m"].as_f64().expect("metres");
    assert!(driven_m(0) > driven_m(1) + 0.5, "{report:#}");
}

#[test]
fn failed_run_is_a_row_with_its_cause_and_not_a_suite_failure() {
    let late = tiny().replace("time_limit_s = 30.0", "time_limit_s = 1.0");
    let ended = Zeronav::start_in(working_folder(&late), &["suite", "scenarios", "--json"]);
    let ended = ended.finish();
    let report = ended.expect(0);
    assert_eq!(report["summary"]["success"], 0.0);
    assert_eq!(report["summary"]["timeouts"], 1);
    assert_eq!(report["runs"][0]["cause"], "timeout");
    let left = directory(ended.folder.path(), &report);
    let junit = std::fs::read_to_string(left.join("junit.xml")).expect("junit.xml");
    assert!(junit.contains("<failure message=\"timeout\">"), "{junit}");
}

#[test]
fn invalid_suites_end_with_one_line_and_exit_code_2() {
    for (arguments, why) in [
        (&["suite", "barn", "--data", "nowhere"][..], "nowhere/barn"),
        (&["suite", "no_such_folder"], "no_such_folder"),
        (&["suite", "barn", "--worlds", "5..5"], "5..5"),
        (&["suite", "generated", "--hours", "1"], "--hours"),
        (&["suite", "soak", "--hours", "0"], "more than 0"),
        (
            &["suite", "soak", "--hours", "1", "--seeds", "2"],
            "--seeds",
        ),
    ] {
        let ended = zeronav(arguments);
        assert_eq!(ended.code(), 2, "{}", ended.stderr);
        assert!(ended.stderr.contains(why), "{}", ended.stderr);
        assert!(!ended.folder.path().join("runs").exists(), "{arguments:?}");
    }
    // A configuration that no run can start with ends the suite, whatever else waits.
    let arguments = [
        "suite",
        "scenarios",
        "--controller",
        "no_such",
        "--seeds",
        "9",
    ];
    let ended = Zeronav::start_in(working_folder(&tiny()), &arguments).finish();
    assert_eq!(ended.code(), 2, "{}", ended.stderr);
    assert!(ended.stderr.contains("local_planner"), "{}", ended.stderr);
}

/// A recording of four people walking to and fro across the robot's path, 6 m each.
fn recording() -> String {
    let row = |(sample, id): (i32, i32)| {
        let (t, id) = (0.4 * f64::from(sample), f64::from(id));
        let gone_m = ((0.6 + 0.1 * id) * (t + 3.0 * id)) % 12.0;
        let (x, y) = (1.5 * id, 6.0 - (gone_m - 6.0).abs());
        format!("{t:.1},{id},{x:.3},{y:.3}")
    };
    let samples = (0..=75).flat_map(|sample| (1..=4).map(move |id| (sample, id)));
    let rows: Vec<String> = samples.map(row).collect();
    format!("t_s,id,x_m,y_m\n{}\n", rows.join("\n"))
}

#[test]
fn beam_passes_recorded_pedestrians() {
    let folder = tempfile::tempdir().expect("a working folder");
    let people = folder.path().join("data/pedestrians");
    std::fs::create_dir_all(&people).expect("a folder");
    std::fs::write(people.join("crossing.csv"), recording()).expect("a file");
    let arguments = [
        "suite",
        "pedestrians",
        "--data",
        "data",
        "--seeds",
        "2",
        "--controller",
        "beam",
        "--json",
    ];
    let report = Zeronav::start_in(folder, &arguments).finish().expect(0);
    assert_eq!(report["controller"], "beam");
    let summary = &report["summary"];
    assert_eq!(summary["runs"], 2);
    assert_eq!(summary["arrival"], 1.0, "{summary}");
    assert_eq!(summary["contacts_moving"], 0, "{summary}");
}

#[test]
fn invalid_world_is_a_row_and_the_others_run() {
    let folder = working_folder(&tiny());
    let tiny = tiny();
    let unknown = format!("{tiny}[services.local_planner.config]\ncontroller = \"no_such\"\n");
    std::fs::write(folder.path().join("scenarios/unknown.toml"), unknown).expect("a file");
    let arguments = ["suite", "scenarios", "--jobs", "2", "--json"];
    let report = Zeronav::start_in(folder, &arguments).finish().expect(0);
    let runs = report["runs"].as_array().expect("runs");
    assert_eq!(runs.len(), 2, "{report:#}");
    assert_eq!(runs[0]["success"], true, "{report:#}");
    let cause = runs[1]["cause"].as_str().expect("a cause");
    assert!(cause.contains("exit code 2"), "{cause}");
}

/// The only folder of a suite.
fn suite_folder(folder: &Path) -> Option<PathBuf> {
    let mut suites = std::fs::read_dir(folder.join("runs")).ok()?.flatten();
    suites.next().map(|entry| entry.path())
}

/// A report without what the clock on the wall and the folder say.
fn without_wall_clock(mut report: Value) -> Value {
    let whole = report.as_object_mut().expect("an object");
    for name in ["wall_s", "environment", "directory", "run_wall_s"] {
        assert!(whole.remove(name).is_some(), "no {name}");
    }
    report
}

#[test]
fn resumed_suite_equals_an_uninterrupted_one() {
    let arguments = [
        "suite",
        "scenarios",
        "--seeds",
        "5",
        "--jobs",
        "1",
        "--json",
    ];
    let mut suite = Zeronav::start_in(working_folder(&tiny()), &arguments);
    suite.wait_until("a run has finished", |suite| {
        suite_folder(suite.folder.path())
            .and_then(|folder| std::fs::read_to_string(folder.join("runs.jsonl")).ok())
            .is_some_and(|text| text.lines().count() >= 3)
    });
    suite.signal(Signal::INT);
    let ended = suite.finish();
    let partial = ended.expect(130);
    assert_eq!(partial["complete"], false, "{partial:#}");
    assert_eq!(partial["planned"], 5);
    let made = partial["runs"].as_array().expect("runs").len();
    assert!((1..5).contains(&made), "{made} runs");
    let folder = suite_folder(ended.folder.path()).expect("its folder");
    let left = std::fs::read_to_string(folder.join("suite.json")).expect("suite.json");
    let left: Value = serde_json::from_str(&left).expect("JSON");
    assert_eq!(left, without_wall_clock(partial));
    let name = folder.strip_prefix(ended.folder.path()).expect("inside");
    let name = name.to_str().expect("a name").to_owned();

    // Other arguments than those it was begun with are rejected.
    let arguments = ["suite", "--resume", &name, "--seeds", "7"];
    let refused = Zeronav::start_in(ended.folder, &arguments).finish();
    assert_eq!(refused.code(), 2, "{}", refused.stderr);
    let arguments = ["suite", "--resume", &name, "--json"];
    let resumed = Zeronav::start_in(refused.folder, &arguments).finish();
    let resumed = resumed.expect(0);
    assert_eq!(resumed["complete"], true);
    let arguments = ["suite", "scenarios", "--seeds", "5", "--json"];
    let whole = Zeronav::start_in(working_folder(&tiny()), &arguments).finish();
    let whole = whole.expect(0);
    assert_eq!(without_wall_clock(resumed), without_wall_clock(whole));
}

#[test]
fn interrupted_suite_stops_its_runs_and_cleans_up() {
    let arguments = ["suite", "scenarios", "--seeds", "2", "--jobs", "2"];
    let mut suite = Zeronav::start_in(working_folder(&endless()), &arguments);
    suite.wait_until("both runs drive", |suite| {
        let runs = children_of(suite.pid());
        runs.len() == 2 && runs.iter().all(|(run, _)| services_of(*run).len() == 5)
    });
    let runs = children_of(suite.pid()).into_iter();
    let runs: Vec<u32> = runs.map(|(run, _)| run).collect();
    let services: Vec<(u32, String)> = runs.iter().flat_map(|run| services_of(*run)).collect();
    let roots: Vec<PathBuf> = runs.iter().flat_map(|run| domains_of(*run)).collect();
    assert_eq!(roots.len(), 2, "each run has a domain of its own");
    suite.signal(Signal::TERM);
    let ended = suite.finish();
    assert_eq!(ended.code(), 130, "{}", ended.stderr);
    for pid in runs.iter().chain(services.iter().map(|(pid, _)| pid)) {
        assert!(!is_alive(*pid), "{pid} lives");
    }
    for root in &roots {
        assert_eq!(leftovers(root), Vec::<PathBuf>::new());
    }
}

/// Runs a world of BARN, which is passed, and compares its score with OT of the data's index. [s]
#[track_caller]
fn a_world_of_barn_has_its_score(data: &Path, world: &str, number: u32, ot_s: f64) {
    let data = data.to_str().expect("a path");
    let range = format!("{number}..{}", number + 1);
    let arguments = [
        "suite", "barn", "--data", data, "--worlds", &range, "--json",
    ];
    let report = zeronav(&arguments).expect(0);
    assert!(
        report["note"]
            .as_str()
            .expect("a note")
            .contains("no leaderboard entry")
    );
    assert_eq!(report["summary"]["worlds"], 1);
    let run = &report["runs"][0];
    assert_eq!(run["world"], world);
    assert_eq!(run["success"], true, "{report:#}");
    assert_eq!(run["cause"], Value::Null, "{report:#}");
    let score = run["score"].as_f64().expect("a score");
    let clock_s = run["clock_s"].as_f64().expect("seconds");
    let time_s = run["time_s"].as_f64().expect("seconds");
    assert!(clock_s > 4.0 && clock_s < time_s, "{clock_s} {time_s}");
    let golden = ot_s / clock_s.clamp(2.0 * ot_s, 8.0 * ot_s);
    assert!((score - golden).abs() < 1e-9, "{score}, not {golden}");
}

#[test]
fn a_shipped_world_of_barn_has_its_score() {
    a_world_of_barn_has_its_score(&shipped_data(""), "world_001", 1, 5.1225);
}

#[test]
#[ignore = "needs barn at $ZERONAV_DATA"]
fn a_world_of_barn_has_its_score_on_external_data() {
    a_world_of_barn_has_its_score(&external_data(""), "world_001", 1, 6.2156);
}

#[test]
fn shipped_dynabarn_and_pedestrian_worlds_run() {
    let data = shipped_data("");
    let data = data.to_str().expect("a path");
    for (suite, class) in [("dynabarn", "easy"), ("pedestrians", "hall")] {
        let arguments = ["suite", suite, "--data", data, "--worlds", "0..1", "--json"];
        let report = zeronav(&arguments).expect(0);
        let run = &report["runs"][0];
        assert_eq!(
            (&report["summary"]["runs"], &run["class"]),
            (&1.into(), &class.into())
        );
        assert_eq!(run["arrived"], true, "{report:#}");
        assert_eq!(report["summary"]["contacts_own_fault"], 0, "{report:#}");
        assert!(run["unavoidable"].is_u64(), "{report:#}");
    }
}

#[test]
fn a_bound_plans_ways_and_drives_nothing() {
    let data = shipped_data("");
    let data = data.to_str().expect("a path");
    let bound = ["suite", "dynabarn", "--bound", "--data", data, "--json"];
    let ended = zeronav(&bound);
    let report = ended.expect(0);
    assert_eq!(report["controller"], "bound (every future known)");
    assert_eq!(report["complete"], true);
    for run in report["runs"].as_array().expect("runs") {
        assert_eq!(run["success"], true, "{run:#}");
        assert_eq!(
            (&run["contacts_moving"], &run["unavoidable"]),
            (&0.into(), &0.into())
        );
        // 19 m at 2 m/s at most, the tolerance reached within the arena.
        assert!(run["time_s"].as_f64().expect("seconds") > 9.8, "{run:#}");
        assert!(run["clearance_m_min"].as_f64().expect("metres") > 0.0);
    }
    let left = directory(ended.folder.path(), &report);
    for name in ["suite.json", "runs.csv", "junit.xml"] {
        assert!(left.join(name).is_file(), "{name}");
    }
    let runs = std::fs::read_dir(left.join("runs")).expect("a folder");
    assert_eq!(runs.count(), 0, "nothing was driven");
    for more in [
        ["--controller", "beam"],
        ["--resume", "runs"],
        ["--perceive", "truth"],
    ] {
        let refused = zeronav(&[&bound[..], &more[..]].concat());
        assert_eq!(refused.code(), 2, "{}", refused.stderr);
    }
}

/// The environment names the folder when the flag does not, and an absent set is named with its
/// home and its layout.
#[test]
fn missing_data_set_names_its_source() {
    for (suite, home, layout) in [
        ("barn", "Daffan/the-barn-challenge", "worlds/world_NNN.csv"),
        ("dynabarn", "Daffan/the-barn-challenge", "world_NN.csv"),
        ("pedestrians", "Social-STGCNN", "NAME.csv"),
    ] {
        let ended = zeronav(&["suite", suite]);
        assert_eq!(ended.code(), 2, "{}", ended.stderr);
        for part in ["data/", home, layout, "--data", "ZERONAV_DATA", "generated"] {
            assert!(ended.stderr.contains(part), "{part}: {}", ended.stderr);
        }
        assert_eq!(ended.stderr.lines().count(), 1, "{}", ended.stderr);
    }
}

#[test]
fn generated_suite_needs_no_data_and_has_a_row_per_class() {
    let arguments = ["suite", "generated", "--worlds", "0..18", "--json"];
    let report = zeronav(&arguments).expect(0);
    assert_eq!(report["summary"]["runs"], 18);
    let groups = report["groups"].as_array().expect("classes");
    let names: Vec<&str> = groups
        .iter()
        .filter_map(|group| group["name"].as_str())
        .collect();
    assert_eq!(names.len(), 9, "{names:?}");
    assert_eq!((names[0], names[8]), ("orbits_1_easy", "walkers_3_hard"));
    for run in report["runs"].as_array().expect("runs") {
        assert!(run["run_hash"].is_string(), "{run:#}");
        let class = run["class"].as_str().expect("a class");
        assert_eq!(run["outcome"], "reached", "{run:#}");
        // A walker turns back when it likes, so a single run among walkers may be touched.
        if !class.ends_with("hard") && !class.starts_with("walkers") {
            assert_eq!(run["success"], true, "{run:#}");
        }
        assert_eq!(
            run["unavoidable"].is_null(),
            class.starts_with("static"),
            "{run:#}"
        );
    }
    for group in groups {
        let share = group["summary"]["success"].as_f64();
        assert!(share >= Some(0.5), "{group:#}");
    }
}

#[test]
fn field_suite_has_a_row_per_kind_and_says_where_there_is_a_way() {
    let arguments = ["suite", "field", "--worlds", "0..12", "--json"];
    let report = zeronav(&arguments).expect(0);
    assert_eq!(report["groups"].as_array().map(Vec::len), Some(12));
    assert_eq!(report["summary"]["wrong_arrivals"], 0);
    for run in report["runs"].as_array().expect("runs") {
        assert!(run["run_hash"].is_string(), "{run:#}");
        assert!(run["way_exists"].is_boolean(), "{run:#}");
        // Returns of rain at every fifth beam stop a robot for good: not solved.
        if run["class"] != "short_returns" {
            assert_eq!(run["success"], run["way_exists"], "{run:#}");
        }
    }
}
