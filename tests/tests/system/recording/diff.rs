//! Two runs beside each other: `zeronav diff`, and what `zeronav compare` says of recordings and of lockstep.

use super::{n, recorded, recording_of, refused};
use serde_json::Value;
use std::path::Path;
use zeronav_msgs::topics::{PlanPath, Topic};
use zeronav_tests::rooms::short_drive;
use zeronav_tests::{Ended, Zeronav, zeronav};

/// A short drive in lockstep, with a recording in the run's own folder.
fn run(more: &[&str]) -> Ended {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("it.toml"), short_drive("")).expect("written");
    let arguments = ["run", "./it.toml", "--lockstep", "--headless", "--record"];
    let ended = Zeronav::start_in(folder, &[&arguments[..], more].concat()).finish();
    assert_eq!(ended.code(), 0, "{}", ended.stderr);
    ended
}

/// What `verb` prints of two runs as JSON.
fn said(verb: &[&str], a: &Path, b: &Path, code: i32) -> Value {
    let [a, b] = [a, b].map(|run| run.display().to_string());
    zeronav(&[verb, &[&a, &b, "--json"]].concat()).expect(code)
}

#[test]
fn folders_of_runs_and_files_are_compared_by_one_verb() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = recorded(folder.path(), "it", "");
    let (first, second) = (run(&[]), run(&["--set", "global_planner.planner=c_astar"]));
    let files = [&first, &second].map(|run| recording_of(run.folder.path()));
    let [a, b] = [0, 1].map(|run| files[run].parent().expect("a folder"));
    assert_eq!(said(&["diff"], a, &file, 0)["equal"], true);
    let differs = said(&["diff"], a, b, 1);
    assert_eq!(differs["first"]["author"], "global_planner", "{differs:#}");
    assert_eq!(differs["first"]["topic"], PlanPath::ROW.name, "{differs:#}");
    // Whatever they are called by.
    assert_eq!(said(&["bag", "diff"], &files[0], &files[1], 1), differs);
    assert_eq!(said(&["compare"], a, b, 1), differs);
    assert_eq!(said(&["compare"], &files[0], b, 1), differs);

    // A part of them.
    let tick = n(&differs["first"]["tick"]);
    let run_s = differs["first"]["run_s"].as_f64().expect("a time");
    let behind = format!("{}", run_s + 0.02);
    let part = said(&["diff", "--from", &behind], a, b, 1);
    assert!(n(&part["first"]["tick"]) > tick, "{part:#}");
    let [a, b] = [a, b].map(|run| run.display().to_string());
    let none = ["diff", &a, &b, "--from", "3", "--to", "1"];
    refused(&zeronav(&none), "nothing lies between them");
    let without = folder.path().display().to_string();
    refused(&zeronav(&["diff", &a, &without]), "--record");
}

#[test]
fn two_sides_that_drive_in_lockstep_are_compared_message_by_message() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("it.toml");
    std::fs::write(&file, short_drive("")).expect("written");
    let scenario = file.display().to_string();
    let same = zeronav(&["compare", &scenario, &scenario, "--lockstep", "--json"]).expect(0);
    assert_eq!(same["comparison"]["equal"], true, "{same:#}");
    assert_eq!(same["a"]["run_hash"], same["b"]["run_hash"], "{same:#}");
    let swap = "--swap=global_planner=straight_line_service";
    let ended = zeronav(&["compare", &scenario, swap, "--lockstep", "--headless"]);
    assert_eq!(ended.code(), 0, "{}", ended.stderr);
    let line = ended
        .stdout
        .lines()
        .find(|it| it.starts_with("first difference: "));
    let line = line.unwrap_or_else(|| panic!("{}", ended.stdout));
    assert!(line.contains("global_planner on plan"), "{line}");
    let both = ["compare", &scenario, swap, "--lockstep", "--trials", "6"];
    refused(&zeronav(&both), "--trials");
}
