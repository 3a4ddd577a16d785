//! A full /dev/shm and a full disk, in a mount namespace of their own, so that nothing else on the
//! machine is deprived of either.

use serde_json::Value;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use zeronav_tests::{binaries, real_time_turn};

/// Makes a /dev/shm of few inodes, then runs `zeronav`.
const FEW_INODES: &str = "mount -t tmpfs -o nr_inodes=300 tmpfs /dev/shm && \"$@\"; code=$?; \
                          ls /dev/shm > shm_left; exit $code";

/// Makes a /dev/shm and a run folder of their own, then runs `zeronav`.
const SCRIPT: &str = "mount -t tmpfs -o size=256m tmpfs /dev/shm && mkdir -p runs && \
                      mount -t tmpfs -o size=32m tmpfs runs && \"$@\"; code=$?; \
                      cp -r runs kept && ls /dev/shm > shm_left; exit $code";

/// A drive with these lines; its result.
fn drive(folder: &Path, mode: &[&str], lines: &str) -> Value {
    let text = format!(
        "title = \"full\"\nbase = [\"warehouse\", \"porter\"]\nstart = [4.0, 6.425, 0.0]\n\
         run.time_limit_s = 60.0\n[[goals]]\npose = [12.5, 6.425, 0.0]\n{lines}"
    );
    std::fs::write(folder.join("it.toml"), text).expect("written");
    let output = in_namespace(folder, SCRIPT, &[&["./it.toml", "--json"], mode].concat());
    let (said, errors) = (&output.stdout, &output.stderr);
    let (said, errors) = (
        String::from_utf8_lossy(said),
        String::from_utf8_lossy(errors),
    );
    assert_eq!(output.status.code(), Some(0), "{said}\n{errors}");
    let result: Value = serde_json::from_str(&said).expect("a result");
    assert_eq!(result["contacts"], 0, "{result:#}");
    assert_eq!(left_in_shm(folder), "");
    result
}

/// What `script` saw in its /dev/shm in the end.
fn left_in_shm(folder: &Path) -> String {
    let left = std::fs::read_to_string(folder.join("shm_left")).expect("a list");
    left.trim().to_owned()
}

/// `zeronav run` with these arguments by a script in a mount namespace of its own.
fn in_namespace(folder: &Path, script: &str, arguments: &[&str]) -> Output {
    let mut command = Command::new("unshare");
    // Who is root needs no user namespace, which a container may not have.
    if !rustix::process::geteuid().is_root() {
        command.args(["--user", "--map-root-user"]);
    }
    command
        .args(["--mount", "sh", "-c", script, "sh"])
        .arg(binaries().join("zeronav"))
        .args(["run", "--headless"])
        .args(arguments)
        .env_remove("CARGO")
        .current_dir(folder)
        .stdin(Stdio::null())
        .output()
        .expect("unshare, of the package util-linux")
}

/// A successor needs memory: its seat stays empty until there is some.
#[test]
fn a_stack_goes_on_without_free_shared_memory_and_a_successor_waits_for_it() {
    let _turn = real_time_turn();
    let folder = tempfile::tempdir().expect("a folder");
    let lines = "[[faults]]\nkind = \"fill_shm\"\nbegins = { at_s = 2.0 }\nlasts_s = 4.0\n\
                 [[faults]]\nkind = \"kill\"\nservice = \"mapping\"\nbegins = { at_s = 4.0 }\n";
    let result = drive(folder.path(), &[], lines);
    let faults = &result["faults"];
    assert_eq!(faults[0]["why"], Value::Null, "{faults}");
    let at_s = |name: &str| faults[0][name].as_f64().expect("a time");
    // Never early; late by what a busy machine takes.
    assert!((2.0..3.0).contains(&at_s("time_s")), "{faults}");
    let lasted_s = at_s("until_s") - at_s("time_s");
    assert!((lasted_s - 4.0).abs() < 0.1, "{faults}");
    let recovery_ms = faults[1]["recovery_ms"].as_f64().expect("an answer");
    assert!(recovery_ms > 1900.0, "{faults}");
}

#[test]
fn a_run_whose_disk_is_full_for_a_while_goes_on_and_leaves_its_result() {
    let folder = tempfile::tempdir().expect("a folder");
    let lines = "[[faults]]\nkind = \"disk_full\"\nbegins = { at_s = 2.0 }\nlasts_s = 6.0\n\
                 [[faults]]\nkind = \"kill\"\nservice = \"mapping\"\nbegins = { at_s = 3.0 }\n";
    let result = drive(folder.path(), &["--lockstep"], lines);
    assert_eq!(
        result["faults"][0]["why"],
        Value::Null,
        "{}",
        result["faults"]
    );
    assert_eq!(result["restarts"].as_array().map(Vec::len), Some(1));
    assert!(result["faults"][1]["recovery_ms"].as_f64() > Some(0.0));
    let runs = std::fs::read_dir(folder.path().join("kept")).expect("a folder");
    let run = runs.flatten().next().expect("a run").path();
    let text = std::fs::read_to_string(run.join("result.json")).expect("a result");
    let kept: Value = serde_json::from_str(&text).expect("whole");
    assert_eq!(kept["run_hash"], result["run_hash"]);
}

#[test]
fn too_few_inodes_are_named_before_anything_is_started() {
    let folder = tempfile::tempdir().expect("a folder");
    let output = in_namespace(folder.path(), FEW_INODES, &["open_aisle", "--lockstep"]);
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert!(
        said.contains("some 512 inodes in /dev/shm and 299 are free"),
        "{said}"
    );
    assert_eq!(left_in_shm(folder.path()), "");
}
