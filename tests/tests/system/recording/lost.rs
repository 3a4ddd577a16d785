//! Recorders that are killed and disks that are full: what came before is there, and nobody claims more.

use super::{info, n};
use rustix::process::{Pid, Resource, Rlimit, Signal, prlimit};
use serde_json::Value;
use std::path::Path;
use std::process::{Command, Stdio};
use zeronav_msgs::topics::{RobotOdometry, Topic};
use zeronav_tests::up::Up;
use zeronav_tests::{Zeronav, await_by_itself, binaries, send_signal, zeronav};

/// Messages of the robot in what `zeronav bag info` says.
fn odometry(info: &Value) -> u64 {
    let name = format!("zeronav/{}", RobotOdometry::ROW.name);
    let channels = info["channels"].as_array();
    let mut channels = channels.map_or(&[][..], |all| all).iter();
    channels
        .find(|channel| channel["topic"] == *name)
        .map_or(0, |channel| n(&channel["messages"]))
}

/// What a run says of its recorder.
fn recorder(run: &Zeronav) -> Option<Value> {
    let report = run.report()?;
    let all = report["companions"].as_array()?.clone();
    all.into_iter().find(|it| it["name"] == "recorder")
}

/// What can be read of a file that is still written.
fn so_far(file: &Path) -> Value {
    let read = zeronav(&["bag", "info", "--json", &file.display().to_string()]);
    serde_json::from_str(&read.stdout).unwrap_or_default()
}

/// A recovered file holds at least `ticks` messages of the robot, and says that it is not whole.
fn recovers(file: &Path, ticks: u64) {
    let out = file.with_extension("whole.mcap");
    let [path, to] = [file, &out].map(|it| it.display().to_string());
    let recovered = zeronav(&["bag", "recover", &path, "--out", &to]);
    assert_eq!(recovered.code(), 0, "{}", recovered.stderr);
    let info = info(&out, 0);
    assert!(
        odometry(&info) >= ticks,
        "{ticks} ticks were in it: {info:#}"
    );
    assert_eq!(info["valid"], false, "{info:#}");
}

#[test]
fn a_recorder_that_is_killed_at_any_moment_leaves_what_it_has_flushed() {
    for kill in 0..5 {
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("it.mcap");
        let mut stack = Up::start_in(folder, &["open_aisle", "--lockstep", "--record=it.mcap"]);
        stack.ask(&["pause"], 0);
        stack.ask(&["step", "40"], 0);
        let mut flushed = 0;
        await_by_itself("ticks are flushed", || {
            flushed = odometry(&so_far(&file));
            flushed >= 40
        });
        // In the middle of what comes next.
        stack.ask(&["step", &(1 + 14 * kill).to_string()], 0);
        let pid = recorder(&stack.stack).map(|it| n(&it["pid"]));
        let pid = pid.and_then(|pid| u32::try_from(pid).ok());
        assert!(send_signal(pid.expect("a recorder"), Signal::KILL));
        stack.stack.wait_until("it is noticed", |run| {
            recorder(run).is_some_and(|it| it["state"] == "ended")
        });
        stack.ask(&["step", "1"], 0);
        recovers(&file, flushed);
        stack.down();
    }
}

#[test]
fn a_recorder_outlives_launch_and_ends_its_file_whenever_that_is_killed() {
    for kill in 0..5 {
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("it.mcap");
        let arguments = [
            "run",
            "blocked_aisle",
            "--lockstep",
            "--headless",
            "--record=it.mcap",
        ];
        let mut run = Zeronav::start_in(folder, &arguments);
        let mut tick = 0;
        // Of more than 2000.
        let wanted = 1 + 90 * kill;
        let recorded = |run: &Zeronav| {
            let root = run.domains().pop()?;
            let bytes = std::fs::read(root.join("recorded")).ok()?;
            Some((u64::from_le_bytes(bytes.try_into().ok()?), root))
        };
        let mut root = None;
        run.wait_until("some ticks are recorded", |run| {
            if let Some((ticks, its)) = recorded(run) {
                tick = ticks;
                root = Some(its);
            }
            tick >= wanted
        });
        run.signal(Signal::KILL);
        let root = root.expect("a domain");
        await_by_itself("everything has ended", || !root.exists());
        let found = info(&file, 0);
        assert!(odometry(&found) + 1 >= tick, "{tick}: {found:#}");
        // The recorder lost nothing, and knows that the run had no end.
        let path = file.display().to_string();
        let beside = zeronav(&["bag", "diff", &path, &path, "--json"]).expect(1);
        let why = beside["incomplete"]["a"].as_str().unwrap_or_default();
        assert!(why.contains("ended before the run did"), "{beside:#}");
        assert_eq!(beside["equal"], false);
        assert_eq!(beside["first"], Value::Null);
        drop(run);
    }
}

#[test]
fn a_file_that_may_not_grow_any_more_ends_with_why_and_the_run_goes_on() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("it.mcap");
    let mut stack = Up::start_in(folder, &["open_aisle", "--lockstep", "--record=it.mcap"]);
    stack.ask(&["pause"], 0);
    stack.ask(&["step", "60"], 0);
    let mut flushed = 0;
    await_by_itself("ticks are flushed", || {
        flushed = odometry(&so_far(&file));
        flushed >= 60
    });
    let pid = recorder(&stack.stack)
        .map(|it| n(&it["pid"]))
        .expect("a recorder");
    let pid = i32::try_from(pid).ok().and_then(Pid::from_raw);
    let most = std::fs::metadata(&file).expect("it").len() + (40 << 10);
    let limit = Rlimit {
        current: Some(most),
        maximum: Some(most),
    };
    prlimit(pid, Resource::Fsize, limit).expect("a limit");
    let mut n_steps = 0;
    stack.stack.wait_until("the recorder gives up", |run| {
        let ended = zeronav(&["step", "50", "--domain", &stack.root]);
        assert_eq!(ended.code(), 0, "{}", ended.stderr);
        n_steps += 1;
        recorder(run).is_some_and(|it| it["state"] == "ended")
    });
    stack.ask(&["step", "5"], 0);
    let found = info(&file, 0);
    assert!(odometry(&found) >= flushed, "{flushed}: {found:#}");
    assert_eq!(found["valid"], false);
    let why = found["why"].as_str().unwrap_or_default();
    assert!(
        why.contains("the file could be written no longer: "),
        "{why}"
    );
    assert!(why.contains("File too large"), "{why}");
    let result = stack.down();
    let all = result["companions"].as_array().expect("companions");
    let recorder = all.iter().find(|it| it["name"] == "recorder").expect("it");
    assert!(recorder.to_string().contains("exit code 1"), "{recorder:#}");
}

/// Runs what follows with a small disk of its own in `disk`, and keeps what was on it.
const SMALL_DISK: &str = "mkdir disk && mount -t tmpfs -o size=600k tmpfs disk && \"$@\"; code=$?; \
                          cp -r disk kept; exit $code";

#[test]
fn a_full_disk_leaves_a_file_that_says_so_and_the_run_reaches_its_goal() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut command = Command::new("unshare");
    if !rustix::process::geteuid().is_root() {
        command.args(["--user", "--map-root-user"]);
    }
    let output = command
        .args(["--mount", "sh", "-c", SMALL_DISK, "sh"])
        .arg(binaries().join("zeronav"))
        .args(["run", "blocked_aisle", "--lockstep", "--headless", "--json"])
        .arg("--record=disk/it.mcap")
        .env_remove("CARGO")
        .current_dir(folder.path())
        .stdin(Stdio::null())
        .output()
        .expect("unshare, of the package util-linux");
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{said}");
    let result: Value = serde_json::from_slice(&output.stdout).expect("a result");
    assert_eq!(result["outcome"], "reached", "{result:#}");
    assert!(said.contains("No space left on device"), "{said}");
    let found = info(&folder.path().join("kept/it.mcap"), 0);
    assert_eq!(found["valid"], false, "{found:#}");
    let why = found["why"].as_str().unwrap_or_default();
    assert!(why.contains("No space left on device"), "{why}");
}
