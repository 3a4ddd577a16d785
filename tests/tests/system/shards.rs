//! Suites that several machines share: `--shard I/N` and `zeronav suite merge`.

mod engines;

use rustix::process::Signal;
use serde_json::Value;
use std::path::{Path, PathBuf};
use tempfile::TempDir;
use zeronav_tests::rooms::short_drive;
use zeronav_tests::{Zeronav, await_by_itself, background, binaries, children_of, is_alive};

/// What does not depend on the machine.
const RESULTS: [&str; 3] = ["suite.json", "runs.csv", "junit.xml"];

/// Runs of the whole suite.
const RUNS: usize = 9;

/// Shards that it is driven in.
const SHARDS: usize = 3;

/// A working folder with three scenarios, of which one fails by its time limit.
fn working_folder() -> TempDir {
    let folder = tempfile::tempdir().expect("a working folder");
    std::fs::create_dir(folder.path().join("scenarios")).expect("a folder");
    for (name, at_m, limit_s) in [("far", 0.6, 30.0), ("late", 0.5, 1.0), ("near", 0.55, 30.0)] {
        let shape = format!("{{ kind = \"box\", centre_m = [2.5, {at_m}], size_m = [0.4, 0.6] }}");
        let text = short_drive(&format!("resolution_m = 0.05\nshapes = [{shape}]"));
        let text = text.replace(
            "time_limit_s = 30.0",
            &format!("time_limit_s = {limit_s:?}"),
        );
        let file = folder.path().join(format!("scenarios/{name}.toml"));
        std::fs::write(file, text).expect("a file");
    }
    folder
}

/// Runs `zeronav suite` in the folder: its exit code, what it said, its report and the folder again.
struct Said {
    code: i32,
    stderr: String,
    report: Value,
    folder: TempDir,
}

fn suite(folder: TempDir, arguments: &[&str]) -> Said {
    let arguments = [&["suite"], arguments, &["--json"]].concat();
    let ended = Zeronav::start_in(folder, &arguments).finish();
    let report = serde_json::from_str(&ended.stdout).unwrap_or(Value::Null);
    Said {
        code: ended.code(),
        stderr: ended.stderr.clone(),
        report,
        folder: ended.folder,
    }
}

impl Said {
    /// The folder of the suite, in the working folder.
    fn directory(&self) -> String {
        assert_eq!(self.code, 0, "{}", self.stderr);
        self.report["directory"]
            .as_str()
            .expect("its folder")
            .to_owned()
    }
}

/// The suite's folder in `out` once one run of it has finished, as its arguments name it.
fn begun(suite: &Zeronav, out: &str) -> Option<String> {
    let entry = std::fs::read_dir(suite.folder.path().join(out)).ok()?;
    let made = entry.flatten().next()?.path();
    // What was asked for, the names of all runs, and a run.
    let journal = std::fs::read_to_string(made.join("runs.jsonl")).ok()?;
    let name = made.strip_prefix(suite.folder.path()).ok()?.to_str()?;
    (journal.lines().count() >= 3).then(|| name.to_owned())
}

fn read(folder: &Path, name: &str) -> String {
    std::fs::read_to_string(folder.join(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
}

/// Drives shard `index` into a folder of its own: the working folder, and the shard's in it.
fn shard(folder: TempDir, index: usize, more: &[&str]) -> (TempDir, String) {
    let (part, out) = (format!("{index}/{SHARDS}"), format!("shards/{index}"));
    let arguments = ["scenarios", "--seeds", "3", "--shard", &part, "--out", &out];
    let said = suite(folder, &[&arguments[..], more].concat());
    let directory = said.directory();
    assert_eq!(said.report["shard"], part.as_str());
    (said.folder, directory)
}

#[test]
fn shards_that_are_merged_equal_the_whole_byte_for_byte() {
    let whole = suite(
        working_folder(),
        &["scenarios", "--seeds", "3", "--out", "whole"],
    );
    let expected = whole.directory();
    let mut folder = whole.folder;
    let mut shards = Vec::new();
    for index in 1..=SHARDS {
        let (again, directory) = shard(folder, index, &[]);
        folder = again;
        shards.push(directory);
    }
    // In any order.
    let order = [&shards[2], &shards[0], &shards[1]].map(String::as_str);
    let merged = suite(
        folder,
        &[&["merge"], &order[..], &["--out", "merged"]].concat(),
    );
    let directory = merged.directory();
    assert_eq!(merged.report["summary"]["runs"], RUNS);
    assert_eq!(merged.report["summary"]["timeouts"], 3);
    assert_eq!(
        merged.report["shards"].as_array().map(Vec::len),
        Some(SHARDS)
    );
    let at = |directory: &str| merged.folder.path().join(directory);
    for name in RESULTS {
        assert!(
            read(&at(&directory), name) == read(&at(&expected), name),
            "{name} differs"
        );
    }
    // What the runs have left came along.
    for run in merged.report["runs"].as_array().expect("runs") {
        let own = at(&directory).join(run["directory"].as_str().expect("its folder"));
        assert!(own.join("result.json").is_file(), "{}", own.display());
        assert_eq!(
            own.join("report.html").is_file(),
            run["success"] == false,
            "{run:#}"
        );
    }
    let scenarios = read(&at(&directory), "scenarios/far.toml");
    assert_eq!(scenarios, read(&at(&expected), "scenarios/far.toml"));

    // Merged once more, alone and with a shard that is in it.
    let again = suite(merged.folder, &["merge", &directory, "--out", "again"]);
    let second = again.directory();
    for name in RESULTS {
        let [one, two] = [&second, &expected].map(|it| read(&again.folder.path().join(it), name));
        assert!(one == two, "{name} differs");
    }
    let doubled = suite(again.folder, &["merge", &directory, &shards[1]]);
    assert_eq!(doubled.code, 2);
    for part in ["is there twice", &directory, &shards[1]] {
        assert!(doubled.stderr.contains(part), "{part}: {}", doubled.stderr);
    }
}

#[test]
fn what_is_missing_is_named_with_its_shard() {
    let (folder, first) = shard(working_folder(), 1, &["--jobs", "2"]);
    let last = [
        "scenarios",
        "--seeds",
        "3",
        "--shard",
        "3/3",
        "--out",
        "last",
        "--jobs",
        "1",
        "--json",
    ];
    let (folder, second) = shard(folder, 2, &[]);
    // The last shard, the largest, is interrupted.
    let mut part = Zeronav::start_in(folder, &[&["suite"], &last[..]].concat());
    let mut name = None;
    part.wait_until("a run has finished", |part| {
        name = begun(part, "last");
        name.is_some()
    });
    part.signal(Signal::INT);
    let part = part.finish();
    assert_eq!(part.code(), 130, "{}", part.stderr);
    let name = name.expect("its folder");
    let all = ["merge", &first, &second, &name];
    let said = suite(part.folder, &all);
    assert_eq!(said.code, 2);
    for part in ["of 9 runs are missing", "(shard 3/3)", "--resume"] {
        assert!(said.stderr.contains(part), "{part}: {}", said.stderr);
    }
    assert!(!said.stderr.contains("(shard 1/3)"), "{}", said.stderr);
    assert_eq!(said.stderr.lines().count(), 1, "{}", said.stderr);
    // It goes on as the shard that it was begun as.
    let resumed = suite(said.folder, &["--resume", &name]);
    assert_eq!(resumed.report["shard"], "3/3", "{}", resumed.stderr);
    let merged = suite(resumed.folder, &all);
    assert_eq!(merged.report["summary"]["runs"], RUNS, "{}", merged.stderr);

    // Shards of another suite.
    let other = [
        "scenarios",
        "--seeds",
        "2",
        "--shard",
        "2/3",
        "--out",
        "other",
    ];
    let other = suite(merged.folder, &other);
    let name = other.directory();
    let said = suite(other.folder, &["merge", &first, &second, &name]);
    assert_eq!(said.code, 2);
    assert!(
        said.stderr.contains("is a shard of another suite"),
        "{}",
        said.stderr
    );
}

#[test]
fn what_cannot_be_shared_out_or_merged_is_said_in_one_line() {
    let folder = working_folder();
    let journal = "{\"suite\":\"x\"}\n";
    for (name, text) in [("empty", ""), ("foreign", journal)] {
        let place = folder.path().join(name);
        std::fs::create_dir(&place).expect("a folder");
        std::fs::write(place.join("runs.jsonl"), text).expect("a file");
    }
    let mut folder = Some(folder);
    for (arguments, why) in [
        (&["scenarios", "--shard", "0/3"][..], "0/3"),
        (&["scenarios", "--shard", "4/3"], "4/3"),
        (&["soak", "--shard", "1/3"], "--shard"),
        (&["generated", "--bound", "--shard", "1/3"], "--bound"),
        (&["--resume", "nowhere", "--shard", "1/3"], "--shard"),
        (&["merge"], "which shards?"),
        (&["merge", "nowhere"], "nowhere/runs.jsonl"),
        (&["merge", "scenarios"], "scenarios/runs.jsonl"),
        (&["merge", "empty"], "empty/runs.jsonl:1"),
        (&["merge", "foreign"], "foreign/runs.jsonl:1"),
        (&["merge", "empty", "--seeds", "2"], "--out alone"),
        (&["merge", "empty", "--shard", "1/2"], "--out alone"),
        (&["scenarios", "more"], "take folders"),
        (&["recordings"], "which recordings?"),
    ] {
        let said = suite(folder.take().expect("the folder"), arguments);
        assert_eq!(said.code, 2, "{arguments:?}: {}", said.stderr);
        assert!(said.stderr.contains(why), "{arguments:?}: {}", said.stderr);
        assert_eq!(
            said.stderr.lines().count(),
            1,
            "{arguments:?}: {}",
            said.stderr
        );
        folder = Some(said.folder);
    }
}

/// A journal that somebody else wrote names no file outside of its folder.
#[test]
fn names_in_a_foreign_journal_lead_nowhere() {
    let whole = suite(working_folder(), &["scenarios", "--out", "whole"]);
    let directory = whole.directory();
    let secret = whole.folder.path().join("secret");
    std::fs::create_dir(&secret).expect("a folder");
    std::fs::write(secret.join("result.json"), "{}").expect("a file");
    let journal = journal_of(&whole.folder, &directory);
    let text = std::fs::read_to_string(&journal).expect("the journal");
    std::fs::write(&journal, text.replace("far-seed1\"", "../../../secret\"")).expect("written");
    let said = suite(whole.folder, &["merge", &directory, "--out", "merged"]);
    assert_eq!(said.code, 2, "{}", said.stderr);
    assert!(
        said.stderr.contains("is not the name of a run"),
        "{}",
        said.stderr
    );
    assert_eq!(said.stderr.lines().count(), 1, "{}", said.stderr);
    assert!(!said.folder.path().join("merged").exists());
    // The name alone says where a run is.
    std::fs::write(
        journal_of(&said.folder, &directory),
        text.replace("runs/far-seed1", "../../secret"),
    )
    .expect("written");
    let said = suite(said.folder, &["merge", &directory, "--out", "merged"]);
    assert_eq!(
        said.report["runs"][0]["directory"], "runs/far-seed1",
        "{}",
        said.stderr
    );
}

fn journal_of(folder: &TempDir, directory: &str) -> PathBuf {
    folder.path().join(directory).join("runs.jsonl")
}

/// Runs end with their suite, which goes on as if nothing had been; one process at a time drives it.
#[test]
fn a_suite_that_is_killed_leaves_no_runs_and_goes_on() {
    let arguments = [
        "suite",
        "scenarios",
        "--seeds",
        "3",
        "--out",
        "killed",
        "--jobs",
        "2",
        "--json",
    ];
    let mut part = Zeronav::start_in(working_folder(), &arguments);
    let (mut runs, mut name) = (Vec::new(), None);
    part.wait_until("a run has finished, others go on", |part| {
        let children = children_of(part.pid()).into_iter();
        runs = children.map(|(pid, _)| pid).collect();
        name = begun(part, "killed");
        name.is_some() && !runs.is_empty()
    });
    // It must not be over before the other one looks.
    part.signal(Signal::STOP);
    let name = name.expect("its folder");
    let mut second = background(binaries().join("zeronav"));
    second
        .args(["suite", "--resume", &name])
        .current_dir(part.folder.path())
        .env_remove("CARGO");
    let refused = second.output().expect("it starts");
    let said = String::from_utf8_lossy(&refused.stderr);
    assert_eq!(refused.status.code(), Some(2), "{said}");
    assert!(said.contains("another process drives this suite"), "{said}");
    part.signal(Signal::KILL);
    let ended = part.finish();
    await_by_itself("its runs have ended", || {
        !runs.iter().any(|pid| is_alive(*pid))
    });
    let resumed = suite(ended.folder, &["--resume", &name]);
    assert_eq!(
        resumed.report["summary"]["runs"], RUNS,
        "{}",
        resumed.stderr
    );
    assert_eq!(resumed.report["summary"]["timeouts"], 3);
    for run in resumed.report["runs"].as_array().expect("runs") {
        assert_ne!(run["outcome"], Value::Null, "{run:#}");
    }
}

#[test]
fn two_runs_of_one_name_are_an_error() {
    let folder = working_folder();
    let far = std::fs::read_to_string(folder.path().join("scenarios/far.toml")).expect("it");
    let text = far.clone() + "[variants.b]\ntitle = \"b\"\n[variants.c]\ntitle = \"c\"\n";
    std::fs::write(folder.path().join("scenarios/far.toml"), text).expect("written");
    std::fs::write(folder.path().join("scenarios/far_b.toml"), far).expect("written");
    let said = suite(folder, &["scenarios"]);
    assert_eq!(said.code, 2, "{}", said.stderr);
    assert!(
        said.stderr.contains("two runs are called far_b-seed1"),
        "{}",
        said.stderr
    );
}

#[test]
fn a_run_has_a_folder_of_the_given_name_once() {
    let arguments = [
        "run",
        "scenarios/late.toml",
        "--lockstep",
        "--headless",
        "--json",
        "--folder",
        "mine",
    ];
    let first = Zeronav::start_in(working_folder(), &arguments).finish();
    let result = first.expect(1);
    assert_eq!(result["directory"], "runs/mine");
    assert!(first.folder.path().join("runs/mine/result.json").is_file());
    let second = Zeronav::start_in(first.folder, &arguments).finish();
    assert_eq!(second.code(), 2, "{}", second.stderr);
    assert!(
        second.stderr.contains("runs/mine: it is there already"),
        "{}",
        second.stderr
    );
    let arguments = [
        "run",
        "scenarios/late.toml",
        "--lockstep",
        "--headless",
        "--folder",
        "../mine",
    ];
    let outside = Zeronav::start_in(second.folder, &arguments).finish();
    assert_eq!(outside.code(), 2, "{}", outside.stderr);
    assert!(!outside.folder.path().join("mine").exists());
}
