//! Recordings: read by two independent implementations, honest about what is missing, and never in the way of
//! a run.

mod bisect;
mod content;
mod debug;
mod diff;
mod import;
mod lost;
mod open_loop;
mod stored;
mod suite;
mod trials;
mod view;

use rustix::process::Signal;
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::Command;
use zeronav_msgs::topics::{ControlRequest, RobotOdometry, Topic, topics};
use zeronav_tests::python::readers;
use zeronav_tests::rooms::short_drive;
use zeronav_tests::{Ended, Zeronav, real_time_turn, send_signal, workspace, zeronav};

/// The only file in the only run of a folder that is called so.
pub(super) fn recording_of(folder: &Path) -> PathBuf {
    let runs = std::fs::read_dir(folder.join("runs")).expect("runs");
    let runs: Vec<PathBuf> = runs.flatten().map(|run| run.path()).collect();
    assert_eq!(runs.len(), 1, "{runs:?}");
    runs[0].join("recording.mcap")
}

/// What two readers of others say of a recording.
pub(super) fn read_by_others(file: &Path) -> Value {
    let script = workspace().join("tests/src/read_recording.py");
    let read = Command::new(readers())
        .arg(script)
        .arg(file)
        .arg(RobotOdometry::ROW.name)
        .output()
        .expect("Python runs");
    let said = String::from_utf8_lossy(&read.stderr);
    assert!(read.status.success(), "{}: {said}", file.display());
    serde_json::from_slice(&read.stdout).expect("JSON")
}

/// What `zeronav bag info` says of a recording.
fn info(file: &Path, code: i32) -> Value {
    zeronav(&["bag", "info", "--json", &file.display().to_string()]).expect(code)
}

fn n(value: &Value) -> u64 {
    match value {
        Value::String(text) => text.parse().unwrap_or_else(|_| panic!("{text}: no number")),
        value => value.as_u64().unwrap_or(0),
    }
}

#[test]
fn a_lockstep_run_is_recorded_whole_and_others_read_it() {
    let ended = zeronav(&["run", "door_closes", "--lockstep", "--json", "--record"]);
    let result = ended.expect(0);
    let plain = zeronav(&["run", "door_closes", "--lockstep", "--json"]).expect(0);
    assert_eq!(
        result["run_hash"], plain["run_hash"],
        "a recorder changes nothing"
    );
    let file = recording_of(ended.folder.path());
    let read = read_by_others(&file);
    let verdict = &read["metadata"]["zeronav"];
    assert_eq!(read["profile"], "ros2");
    assert_eq!(read["odometry_is_equal"], true, "{read:#}");
    assert!(read["moved_m"].as_f64() > Some(1.0), "{read:#}");
    // Both readers and this build count the same.
    let counts = &read["counts"];
    let all = read["decoded"].as_object().expect("topics of ROS");
    assert!(all.len() >= 12, "{all:#?}");
    for (topic, decoded) in all {
        assert_eq!(decoded, &counts[topic], "{topic}");
        assert_eq!(decoded, &read["rosbags"][topic], "{topic}");
    }
    // So does a reader that takes the run's folder as a bag of rosbag2.
    assert_eq!(read["folder"], read["decoded"], "{read:#}");
    assert_eq!(read["folder_qos"]["/map"][0], "transient_local", "{read:#}");
    assert_eq!(read["folder_qos"]["/scan"][0], "volatile", "{read:#}");
    let info = info(&file, 0);
    for channel in info["channels"].as_array().expect("channels") {
        let topic = channel["topic"].as_str().expect("a name");
        assert_eq!(channel["messages"], counts[topic], "{topic}");
    }
    // What the file says of itself is true of it.
    let mut missed = 0;
    for row in topics() {
        let in_file = n(&counts[format!("zeronav/{}", row.name)]);
        assert_eq!(in_file, n(&verdict[format!("{}.messages", row.name)]));
        missed += n(&verdict[format!("{}.missed", row.name)]);
        missed += n(&verdict[format!("{}.before_first", row.name)]);
    }
    assert_eq!(n(&verdict["missed"]), missed);
    assert_eq!(verdict["valid"] == "true", missed == 0, "{verdict:#}");
    assert_eq!(info["valid"], missed == 0, "{info:#}");
    assert_eq!(missed, 0, "launch waits for the recorder: {verdict:#}");
    let ticks = n(&counts[format!("zeronav/{}", RobotOdometry::ROW.name)]);
    assert_eq!(n(&counts["/odom"]), ticks);
    assert!(
        ended.stderr.contains("messages, complete"),
        "{}",
        ended.stderr
    );
}

fn refused(ended: &Ended, what: &str) {
    let said = ended.stderr.trim();
    assert_eq!(ended.code(), 2, "{said}");
    assert!(said.contains(what), "{said}");
    assert_eq!(said.lines().count(), 1, "{said}");
}

#[test]
fn a_run_that_cannot_be_recorded_does_not_begin() {
    for (file, why) in [
        ("/proc/x.mcap", "recording to /proc/x.mcap: "),
        ("/absent/x.mcap", "recording to /absent/x.mcap: "),
    ] {
        let record = format!("--record={file}");
        let ended = zeronav(&["run", "open_aisle", "--lockstep", &record]);
        let begins = "zeronav: --record: the recorder does not work (exit code 1: ";
        refused(&ended, &format!("{begins}{why}"));
    }
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("mine.mcap"), "mine").expect("written");
    let arguments = ["run", "open_aisle", "--lockstep", "--record=mine.mcap"];
    let ended = Zeronav::start_in(folder, &arguments).finish();
    refused(&ended, "it exists; name another file");
    let text = std::fs::read_to_string(ended.folder.path().join("mine.mcap"));
    assert_eq!(text.ok().as_deref(), Some("mine"));
}

#[test]
fn what_a_killed_recorder_has_left_is_made_whole_and_the_run_goes_on() {
    let _turn = real_time_turn();
    let folder = tempfile::tempdir().expect("a folder");
    let arguments = ["up", "open_aisle", "--headless", "--json", "--record"];
    let mut stack = Zeronav::start_in(folder, &arguments);
    let recorder = |stack: &Zeronav| {
        let report = stack.report()?;
        let all = report["companions"].as_array()?.clone();
        all.into_iter().find(|it| it["name"] == "recorder")
    };
    let is_ready = |stack: &Zeronav| stack.report().is_some_and(|it| it["ready"] == true);
    stack.wait_until("it is ready", is_ready);
    let file = recording_of(stack.folder.path());
    let size = |file: &Path| std::fs::metadata(file).map_or(0, |it| it.len());
    // Some flushes, and more than a hundred messages: on a busy machine those come slowly.
    let enough_bytes = 150_000;
    let (mut flushes, mut last) = (0, size(&file));
    stack.wait_until("it records", |_| {
        let now = size(&file);
        flushes += u32::from(now > last);
        last = last.max(now);
        flushes >= 4 && last > enough_bytes
    });
    let pid = recorder(&stack)
        .map(|it| n(&it["pid"]))
        .expect("a recorder");
    let pid = u32::try_from(pid).expect("a process id");
    assert!(send_signal(pid, Signal::KILL));
    stack.wait_until("it is noticed", |stack| {
        recorder(stack).is_some_and(|it| it["state"] == "ended")
    });
    assert!(is_ready(&stack), "the run goes on");
    stack.signal(Signal::TERM);
    let ended = stack.finish();
    assert!(
        ended.stderr.contains("companion recorder is lost"),
        "{}",
        ended.stderr
    );
    // A cut file says so, with its place, and what is whole of it is made a file again.
    let path = file.display().to_string();
    let cut = zeronav(&["bag", "info", "--json", &path]);
    assert_eq!(cut.code(), 2, "{}", cut.stderr);
    assert!(
        cut.stderr.contains(&format!("{path}: byte ")),
        "{}",
        cut.stderr
    );
    let before = cut.json();
    assert_eq!(before["valid"], false);
    let out = ended.folder.path().join("whole.mcap");
    let arguments = ["bag", "recover", &path, "--out", &out.display().to_string()];
    let recovered = zeronav(&arguments);
    assert_eq!(recovered.code(), 0, "{}", recovered.stderr);
    let after = info(&out, 0);
    assert_eq!(after["messages"], before["messages"], "{after:#}");
    assert_eq!(after["valid"], false);
    assert!(n(&after["messages"]) > 100, "{after:#}");
    let read = read_by_others(&out);
    assert_eq!(read["odometry_is_equal"], true, "{read:#}");
    refused(&zeronav(&arguments), "it exists; name another file");
    assert_eq!(zeronav(&[&arguments[..], &["--force"]].concat()).code(), 0);
}

#[test]
fn what_is_no_recording_is_refused_in_one_line() {
    let folder = tempfile::tempdir().expect("a folder");
    let junk = folder.path().join("junk.mcap");
    std::fs::write(&junk, b"this is no recording at all, and long enough").expect("written");
    let path = junk.display().to_string();
    for verb in ["info", "recover"] {
        refused(&zeronav(&["bag", verb, &path]), &format!("{path}: byte "));
        refused(&zeronav(&["bag", verb, "/absent.mcap"]), "/absent.mcap: ");
    }
}

/// The comparison that `zeronav bag diff` prints as JSON.
fn diff(a: &Path, b: &Path, code: i32) -> Value {
    let [a, b] = [a, b].map(|file| file.display().to_string());
    zeronav(&["bag", "diff", &a, &b, "--json"]).expect(code)
}

#[test]
fn a_recorded_run_is_driven_again_and_what_was_changed_is_found_where_it_begins() {
    let original = zeronav(&["run", "door_closes", "--lockstep", "--json", "--record"]);
    let result = original.expect(0);
    let file = recording_of(original.folder.path());
    let path = file.display().to_string();
    let again = zeronav(&["replay", &path, "--json"]);
    let same = again.expect(0);
    assert_eq!(same["comparison"]["equal"], true, "{same:#}");
    assert_eq!(same["result"]["run_hash"], result["run_hash"]);
    let compared = same["comparison"]["topics"].as_array().expect("topics");
    let equal: u64 = compared.iter().map(|topic| n(&topic["equal"])).sum();
    assert!(equal > 2500, "{compared:#?}");
    // The scenario in the run's folder says the same without those that it builds on.
    let scenario = file
        .with_file_name("door_closes.toml")
        .display()
        .to_string();
    let plain = zeronav(&["run", &scenario, "--lockstep", "--json"]).expect(0);
    assert_eq!(plain["run_hash"], result["run_hash"]);

    // A change of one parameter shows first in its own seat, and no difference is no surprise then.
    let set = "local_planner.controller=dwa";
    let changed = zeronav(&["replay", &path, "--set", set, "--json"]);
    let differs = changed.expect(0);
    let first = &differs["comparison"]["first"];
    assert_eq!(first["author"], "local_planner", "{first:#}");
    assert_eq!(first["topic"], ControlRequest::ROW.name, "{first:#}");
    let other = recording_of(changed.folder.path());
    assert_eq!(&diff(&file, &other, 1)["first"], first);
    assert_eq!(diff(&file, &file, 0)["equal"], true);
    let figure = |of: &str| {
        let figures = differs["comparison"]["figures"][of].as_array();
        let mut figures = figures.expect("figures").iter();
        let speed = figures.find(|figure| figure["name"] == "mean speed");
        speed
            .and_then(|figure| figure["value"].as_f64())
            .expect("a speed")
    };
    assert!(figure("a") > 0.3 && figure("b") > 0.3, "{differs:#}");
}

/// Drives `more` than a short drive in lockstep; its recording in `folder`.
fn recorded(folder: &Path, name: &str, more: &str) -> PathBuf {
    let file = |end: &str| folder.join(format!("{name}.{end}"));
    std::fs::write(file("toml"), short_drive(more)).expect("written");
    let record = format!("--record={}", file("mcap").display());
    let scenario = file("toml").display().to_string();
    let ended = zeronav(&["run", &scenario, "--lockstep", "--headless", &record]);
    assert_eq!(ended.code(), 0, "{}", ended.stderr);
    file("mcap")
}

#[test]
fn a_fault_is_found_at_its_tick() {
    let folder = tempfile::tempdir().expect("a folder");
    let fault =
        "[[faults]]\nkind = \"kill\"\nservice = \"local_planner\"\nbegins = { at_s = 2.0 }\n";
    let drive = |name: &str, more: &str| recorded(folder.path(), name, more);
    let compared = diff(&drive("plain", ""), &drive("fault", fault), 1);
    let first = &compared["first"];
    // The process is killed once it has answered tick 100: the next answer is that of a successor.
    assert_eq!(n(&first["tick"]), 101, "{first:#}");
    assert_eq!(first["author"], "local_planner", "{first:#}");
}

#[test]
fn what_cannot_be_driven_again_is_refused_in_one_line() {
    let _turn = real_time_turn();
    let folder = tempfile::tempdir().expect("a folder");
    let short = short_drive("");
    std::fs::write(folder.path().join("short.toml"), short).expect("written");
    let arguments = ["run", "short.toml", "--headless", "--record"];
    let real = Zeronav::start_in(folder, &arguments).finish();
    assert_eq!(real.code(), 0, "{}", real.stderr);
    let path = recording_of(real.folder.path()).display().to_string();
    refused(&zeronav(&["replay", &path]), "it was recorded in real time");
    let junk = real.folder.path().join("junk.mcap");
    std::fs::write(&junk, b"this is no recording at all, and long enough").expect("written");
    let junk = junk.display().to_string();
    refused(&zeronav(&["replay", &junk]), &format!("{junk}: byte "));
    refused(
        &zeronav(&["bag", "diff", &path, &junk]),
        &format!("{junk}: byte "),
    );
    refused(
        &zeronav(&["bag", "check", &junk]),
        &format!("{junk}: byte "),
    );
    refused(
        &zeronav(&["bag", "diff", "/absent.mcap", &path]),
        "/absent.mcap: ",
    );

    // Tables of it.
    let tables = real.folder.path().join("tables");
    let arguments = [
        "bag",
        "export",
        &path,
        "--csv",
        &tables.display().to_string(),
    ];
    let exported = zeronav(&arguments);
    assert_eq!(exported.code(), 0, "{}", exported.stderr);
    let info = info(Path::new(&path), 0);
    let channels = info["channels"].as_array().expect("channels");
    let name = format!("zeronav/{}", RobotOdometry::ROW.name);
    let odometry = channels.iter().find(|it| it["topic"] == *name);
    let messages = n(&odometry.expect("odometry")["messages"]);
    let table = std::fs::read_to_string(tables.join("robot-odometry.csv")).expect("a table");
    let mut lines = table.lines();
    let heads = lines.next().expect("heads");
    assert!(heads.contains(",meta.v_mps [m/s],"), "{heads}");
    assert_eq!(lines.clone().count() as u64, messages);
    let columns = heads.split(',').count();
    assert!(
        lines.all(|line| line.split(',').count() == columns),
        "{heads}"
    );
    refused(&zeronav(&arguments), "it is not empty; name another folder");
    let other = real.folder.path().join("other").display().to_string();
    let arguments = [
        "bag", "export", &path, "--csv", &other, "--topic", "no/such",
    ];
    refused(&zeronav(&arguments), "no message on no/such is in it");
    assert!(!Path::new(&other).exists(), "nothing is left of it");
    let arguments = ["bag", "export", &junk, "--csv", &other];
    refused(&zeronav(&arguments), &format!("{junk}: byte "));
    assert!(!Path::new(&other).exists(), "nothing is left of it");
    // Items that are numbers alone have a name.
    let ranges = std::fs::read_to_string(tables.join("robot-scan.items.csv")).expect("ranges");
    assert_eq!(ranges.lines().next(), Some("message,item,value"));
}
