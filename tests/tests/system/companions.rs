//! Companions: processes beside a stack that may die as often as they like, and topics of a user's own.

use rustix::process::Signal;
use serde_json::Value;
use std::path::Path;
use std::process::Command;
use tempfile::TempDir;
use zeronav_msgs::Role;
use zeronav_msgs::user::{self, Form};
use zeronav_shell::{Domain, Peer, StartError, UserReader};
use zeronav_tests::python::{example, program};
use zeronav_tests::up::Up;
use zeronav_tests::{Stranger, Zeronav, executable, real_time_turn, send_signal, shipped, zeronav};

/// The name of the example's topic and its form.
const NEAREST: &str = "nearest";
const FORM: &str = "distance_m: f64, bearing_rad: f64";

/// A folder with the scenario `name`, and `more` behind it, as `it.toml`.
fn folder_with(name: &str, more: &str) -> TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    write(&folder, name, more);
    folder
}

fn write(folder: &TempDir, name: &str, more: &str) {
    let text = format!("{}\n{more}", shipped(name));
    std::fs::write(folder.path().join("it.toml"), text).expect("written");
}

/// The same with the Python example as the companion `watcher`.
fn folder_with_python(name: &str) -> TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    let binary = example(NEAREST, folder.path());
    let more = format!("[companions.watcher]\nbinary = \"{}\"\n", binary.display());
    write(&folder, name, &more);
    folder
}

/// A companion that does what the line of a shell says when it is not asked for its configuration.
fn script(folder: &Path, name: &str, line: &str) {
    let text = format!("#!/bin/sh\ncase \"$*\" in *--print-config*) exit 0;; esac\n{line}\n");
    executable(&folder.join(name), &text);
}

/// What the run says of a companion.
fn companion(report: &Value, name: &str) -> Option<Value> {
    let all = report["companions"].as_array()?;
    all.iter().find(|it| it["name"] == name).cloned()
}

/// What the companion `name` of a run has logged.
fn log_of(stack: &Zeronav, name: &str) -> String {
    let report = stack.report().unwrap_or_default();
    let folder = report["folder"].as_str().unwrap_or_default();
    let log = Path::new(folder).join(format!("logs/{name}.log"));
    std::fs::read_to_string(&log).unwrap_or_else(|error| format!("{}: {error}", log.display()))
}

/// The companion `watcher` runs or is started again.
fn still_there(stack: &Zeronav) {
    let report = stack.report().unwrap_or_default();
    let watcher = companion(&report, "watcher").unwrap_or_default();
    let log = || log_of(stack, "watcher");
    assert_ne!(watcher["state"], "ended", "{watcher:#}\n{}", log());
}

/// The topic of the example, read in the domain `root`.
struct Reading {
    reader: UserReader,
    peer: Peer,
    form: Form,
}

impl Reading {
    /// Joins the stack at `root`.
    fn of(root: &Path) -> Self {
        let domain = Domain::join(root).expect("the domain");
        let peer = Peer::join(domain, Role::Tap, 1).expect("a place");
        let form = Form::new(FORM).expect("a form");
        let reader = peer.user_reader(NEAREST, &form).expect("a reader");
        Self { reader, peer, form }
    }

    /// Waits until the companion has opened its ports.
    fn await_writer(&self, stack: &mut Zeronav) {
        stack.wait_until("the companion has a writer", |stack| {
            still_there(stack);
            let ports = self.peer.user_ports(NEAREST, &self.form);
            ports.expect("its ports")[0] > 0
        });
    }

    /// Waits for the next message of the companion `watcher`: its distance and bearing.
    fn next(&mut self, stack: &mut Zeronav) -> [f64; 2] {
        let mut message = None;
        stack.wait_until("the companion says something", |stack| {
            still_there(stack);
            message = self.reader.take(|view| view.items.to_vec());
            message.is_some()
        });
        let bytes = message.expect("a message");
        let (numbers, rest) = bytes.as_chunks::<8>();
        assert!(rest.is_empty() && numbers.len() == 2, "{bytes:?}");
        [numbers[0], numbers[1]].map(f64::from_le_bytes)
    }
}

/// Process id and number of starts of `watcher`.
fn watcher(run: &Zeronav) -> (Option<u32>, Option<u64>) {
    let watcher = companion(&run.report().unwrap_or_default(), "watcher").unwrap_or_default();
    let pid = watcher["pid"].as_u64().filter(|pid| *pid != 0);
    let pid = pid.and_then(|pid| u32::try_from(pid).ok());
    (pid, watcher["starts"].as_u64())
}

#[test]
fn a_companion_that_is_killed_changes_nothing() {
    let without = folder_with("door_closes", "");
    let flags = ["run", "./it.toml", "--headless", "--json", "--lockstep"];
    let without = Zeronav::start_in(without, &flags).finish().expect(0);
    assert_eq!(without["companions"], Value::Null, "{without:#}");

    // A seat that is left open holds the run until the companion is at work.
    let flags = [&flags[..], &["--external", "global_planner"]].concat();
    let mut run = Zeronav::start_in(folder_with_python("door_closes"), &flags);
    run.wait_until("the others run", |run| {
        run.report().is_some_and(|report| {
            report["services"]
                .as_array()
                .is_some_and(|all| all.len() == 4)
        })
    });
    let root = run.domains().pop().expect("a domain");
    let name = root.display().to_string();
    let ask = |words: &[&str]| {
        let ended = zeronav(&[words, &["--domain", &name]].concat());
        assert_eq!(ended.code(), 0, "{words:?}: {}", ended.stderr);
    };
    ask(&["pause"]);
    let planner = Stranger::start("zeronav-global-planner", &root, &["--epoch", "1"]);
    run.wait_until("it is ready", |run| {
        run.report().is_some_and(|report| report["ready"] == true)
    });
    let mut reading = Reading::of(&root);
    for _ in 0..2 {
        reading.await_writer(&mut run);
        ask(&["step", "100"]);
        let [distance_m, _] = reading.next(&mut run);
        assert!(distance_m > 0.0, "{distance_m}");
        let (pid, starts) = watcher(&run);
        assert!(send_signal(pid.expect("a process"), Signal::KILL));
        // While it is dead and while it starts.
        ask(&["step", "50"]);
        run.wait_until("it is started again", |run| {
            let (pid, next) = watcher(run);
            next > starts && pid.is_some()
        });
    }
    drop(reading);
    ask(&["resume"]);
    let with = run.finish().expect(0);
    assert_eq!(with["run_hash"], without["run_hash"], "{with:#}");
    assert_eq!(with["reproducible"], true, "{with:#}");
    assert_eq!(with["restarts"], serde_json::json!([]), "{with:#}");
    let watcher = &with["companions"][0];
    assert_eq!(watcher["name"], "watcher", "{watcher:#}");
    assert_eq!(watcher["binary"], NEAREST, "{watcher:#}");
    assert_eq!(watcher["starts"], 3, "{watcher:#}");
    assert_eq!(planner.left().0, 0);
}

/// What `logs` and `top` make of the companions of the test below.
fn logs_and_top_show_them(up: &Up) {
    let logged = up.ask(&["logs", "fails"], 0);
    assert_eq!(logged, "it cannot be\n".repeat(3));
    let unknown = up.ask(&["logs", "fials", "-f"], 2);
    assert!(
        unknown.contains("there are those of collision_guard"),
        "{unknown}"
    );
    assert!(unknown.contains(", fails,"), "{unknown}");
    let top = up.ask(&["top", "--once", "--json"], 0);
    let top: Value = serde_json::from_str(&top).expect("JSON");
    let shown = |name: &str| {
        let line = top["companions"].as_array().expect("companions").iter();
        line.clone()
            .find(|line| line["name"] == name)
            .expect("its line")
            .clone()
    };
    assert_eq!(shown("fails")["restarts"], 2, "{top:#}");
    assert_eq!(shown("fails")["state"], "ended", "{top:#}");
    assert!(shown("stays")["memory_bytes"].as_u64() > Some(0), "{top:#}");
}

#[test]
fn what_fails_is_started_again_within_its_budget_and_its_loss_is_a_line() {
    let more = "[companions.fails]\nbinary = \"./fails\"\nrestarts = 2\n\
                [companions.refuses]\nbinary = \"./refuses\"\n\
                [companions.done]\nbinary = \"./done\"\n\
                [companions.stays]\nbinary = \"./stays\"\n";
    let folder = folder_with("open_aisle", more);
    script(folder.path(), "fails", "echo it cannot be; exit 1");
    script(folder.path(), "refuses", "exit 2");
    script(folder.path(), "done", "exit 0");
    // It ignores that it is asked to end.
    script(
        folder.path(),
        "stays",
        "trap '' TERM; while :; do sleep 1; done",
    );
    let mut up = Up::start_in(folder, &["./it.toml", "--lockstep"]);
    up.ask(&["pause"], 0);
    up.stack.wait_until("three of them have ended", |stack| {
        let report = stack.report().unwrap_or_default();
        ["fails", "refuses", "done"]
            .iter()
            .all(|name| companion(&report, name).is_some_and(|it| it["state"] == "ended"))
    });
    let report = up.status();
    let starts = |name: &str| companion(&report, name).expect("a companion")["starts"].clone();
    let all = ["fails", "refuses", "done", "stays"].map(starts);
    assert_eq!(all, [3, 1, 1, 1].map(Value::from), "{report:#}");
    let listed = zeronav(&["ps"]).stdout;
    for name in ["fails", "stays"] {
        assert!(listed.contains(&format!("\n  {name} ")), "{listed}");
    }
    logs_and_top_show_them(&up);
    let said = up.ask(&["down"], 0);
    assert!(said.contains("is down"), "{said}");
    let ended = up.stack.finish();
    let result = ended.expect(0);
    let ends: Vec<(&str, &str)> = result["companions"]
        .as_array()
        .expect("companions")
        .iter()
        .map(|it| ["name", "end"].map(|key| it[key].as_str().unwrap_or("")))
        .map(|[name, end]| (name, end))
        .collect();
    let expected = [
        ("done", "exit code 0"),
        ("fails", "exit code 1"),
        ("refuses", "exit code 2"),
        ("stays", "did not stop when asked, killed"),
    ];
    assert_eq!(ends, expected, "{result:#}");
    assert_eq!(result["restarts"], serde_json::json!([]), "{result:#}");
    for line in [
        "companion fails is lost (exit code 1): its restarts are used up",
        "companion refuses is lost (exit code 2)",
        "companion done has ended",
    ] {
        assert!(
            ended.stderr.contains(line),
            "{line} is not in: {}",
            ended.stderr
        );
    }
    let folder = result["directory"].as_str().expect("a folder");
    let page = std::fs::read_to_string(ended.folder.path().join(folder).join("report.html"));
    let page = page.expect("the report");
    assert!(
        page.contains("Companions") && page.contains("refuses"),
        "no companions on the page"
    );
}

#[test]
fn a_python_companion_has_a_topic_of_its_own() {
    let _turn = real_time_turn();
    let mut up = Up::start_in(folder_with_python("open_aisle"), &["./it.toml"]);
    let root = up.root.clone();
    let mut reading = Reading::of(Path::new(&root));
    let [distance_m, bearing_rad] = reading.next(&mut up.stack);
    assert!((0.05..30.0).contains(&distance_m), "{distance_m}");
    assert!(bearing_rad.abs() < 7.0, "{bearing_rad}");
    assert_eq!(reading.reader.refused(), 0);

    let topic = user::full_name(NEAREST).expect("a name");
    let listed = zeronav(&["topics", "--domain", &root, "--json"]).json();
    let rows = listed["topics"].as_array().expect("topics");
    let row = rows.iter().find(|row| row["topic"] == topic.as_str());
    let row = row.unwrap_or_else(|| panic!("{listed:#}"));
    assert_eq!(row["form"], FORM, "{row:#}");
    assert_eq!([&row["writers"], &row["readers"]], [1, 1], "{row:#}");
    let echoed = up.lines(&["topics", "echo", &topic, "--number", "2"], 0);
    assert_eq!(echoed.len(), 2, "{echoed:?}");
    for line in &echoed {
        let record = &line["items"][0];
        assert!(record["distance_m"].as_f64() > Some(0.05), "{line:#}");
        assert!(record["bearing_rad"].is_number(), "{line:#}");
    }
    let rate = up.ask(&["topics", "hz", &topic, "--number", "3"], 0);
    assert!(rate.contains("3 messages"), "{rate}");
    let absent = user::full_name("farthest").expect("a name");
    let absent = up.ask(&["topics", "echo", &absent], 2);
    assert!(absent.contains("there is no topic"), "{absent}");

    // Another form is rejected by name, in Rust and in Python.
    let domain = Domain::join(Path::new(&root)).expect("the domain");
    let peer = Peer::join(domain, Role::Tap, 1).expect("a place");
    let other = Form::new("distance_m: f32").expect("a form");
    let error = peer.user_reader(NEAREST, &other).expect_err("another form");
    assert!(matches!(error, StartError::Contract { .. }), "{error}");
    let why = format!("topic {topic}: its form is \"{FORM}\"");
    assert!(error.to_string().contains(&why), "{error}");
    assert!(peer.user_writer(NEAREST, &other, 4).is_err());
    drop(peer);
    let text = "from zeronav import Companion, run\n\
        class Other(Companion):\n\
        \x20   def __init__(self, guest, config):\n\
        \x20       self.reader = guest.peer.user_reader('nearest', 'distance_m: f32')\n\
        run(Other)\n";
    let folder = tempfile::tempdir().expect("a folder");
    let mut other = Command::new(program("other", text, folder.path()));
    let output = other.args(["--domain", &root]).output().expect("it ran");
    let log = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(3), "{log}");
    assert!(log.contains(&why), "{why} is not in: {log}");

    drop(reading);
    let result = up.down();
    assert_eq!(result["companions"][0]["end"], "stopped", "{result:#}");
    assert_eq!(result["companions"][0]["starts"], 1, "{result:#}");
}

#[test]
fn companions_that_cannot_be_are_rejected_by_file_line_and_field() {
    let lines = shipped("open_aisle").lines().count() + 1;
    for (text, line, field, why) in [
        (
            "[companions.a]\nbinary = \"./absent\"",
            2,
            "a.binary",
            "no executable",
        ),
        (
            "[companions.a]\nbinary = \"absent\"",
            2,
            "a.binary",
            "no executable",
        ),
        ("[companions.a]\nrestarts = 1", 1, "a.binary", "is missing"),
        (
            "[companions.A]\nbinary = \"./good\"",
            1,
            "A",
            "a name is a letter a to z",
        ),
        (
            "[companions.mapping]\nbinary = \"./good\"",
            1,
            "mapping",
            "part of the stack",
        ),
        (
            "[companions.viewer]\nbinary = \"./good\"",
            1,
            "viewer",
            "part of the stack",
        ),
        (
            "[companions.a]\nbinary = \"./good\"\nrestarts = 101",
            3,
            "a.restarts",
            "0 to 100",
        ),
        (
            "[companions.a]\nbinary = \"./good\"\nrestart = 1",
            3,
            "a.restart",
            "`restarts`",
        ),
        (
            "[companions.a]\nbinary = \"./silent\"",
            2,
            "a.binary",
            "exit code 7",
        ),
        (
            "[companions.a]\nbinary = \"./nearest\"\nconfig.topc = \"b\"",
            3,
            "a.config.topc",
            "`topic`",
        ),
    ] {
        let folder = folder_with("open_aisle", text);
        script(folder.path(), "good", "exit 0");
        executable(&folder.path().join("silent"), "#!/bin/sh\nexit 7\n");
        if text.contains("nearest") {
            let _ = example(NEAREST, folder.path());
        }
        let ended = Zeronav::start_in(folder, &["run", "./it.toml", "--lockstep"]).finish();
        assert_eq!(ended.code(), 2, "{text}: {}", ended.stderr);
        let place = format!("it.toml:{}: companions.{field}: ", lines + line);
        assert!(
            ended.stderr.contains(&place),
            "{place} is not in: {}",
            ended.stderr
        );
        assert!(
            ended.stderr.contains(why),
            "{why} is not in: {}",
            ended.stderr
        );
    }
}
