//! `zeronav top` on a real stack: what it shows is so, it leaves no trace, and a terminal gets back
//! what it had.

use rustix::process::Signal;
use serde_json::Value;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use zeronav_msgs::topics::{
    DebugRollouts, MapKeyframe, RobotOdometry, SPANS, TaskPose, Topic, topics,
};
use zeronav_tests::up::Up;
use zeronav_tests::{Zeronav, children_of, leftovers, real_time_turn, send_signal, zeronav};

/// Far away along the aisle, so that the robot drives while it is looked at.
const GOAL: [&str; 6] = ["goal", "12.5", "6.425", "0", "--yaw-tolerance", "3.15"];

/// What a terminal is told when another screen takes its place, and when that is over.
const ENTER: &str = "\x1b[?1049h";
const LEAVE: &str = "\x1b[?1049l";

fn sample(up: &Up) -> Value {
    let said = up.ask(&["top", "--once", "--json"], 0);
    serde_json::from_str(&said).unwrap_or_else(|error| panic!("{error}: {said}"))
}

/// The line of a table with this value under `key`.
fn line<'a>(view: &'a Value, table: &str, key: &str, value: &str) -> &'a Value {
    let lines = view[table].as_array().expect("a table");
    let found = lines.iter().find(|line| line[key] == value);
    found.unwrap_or_else(|| panic!("no {value} in {view:#}"))
}

/// Readers of every topic.
fn readers(up: &Up) -> Vec<(String, u64)> {
    let list: Value = serde_json::from_str(&up.ask(&["topics", "--json"], 0)).expect("JSON");
    let rows = list["topics"].as_array().expect("topics");
    let reader = |row: &Value| {
        let name = row["topic"].as_str().expect("a name").to_owned();
        (name, row["readers"].as_u64().expect("a number"))
    };
    rows.iter().map(reader).collect()
}

#[test]
fn a_sample_shows_services_topics_latencies_and_what_happened() {
    let _turn = real_time_turn();
    let mut up = Up::start(&["open_aisle"]);
    let before = readers(&up);
    up.ask(&GOAL, 0);
    let first = up.stack.service("mapping").expect("its process");
    up.ask(&["fault", "kill", "mapping"], 0);
    up.stack.wait_until("mapping has a successor", |stack| {
        stack.service("mapping").is_some_and(|pid| pid != first)
    });
    up.stack.wait_until("it is ready", |stack| {
        let report = stack.report().unwrap_or_default();
        let services = report["services"].as_array().cloned().unwrap_or_default();
        let state = |role: &str| {
            services
                .iter()
                .any(|s| s["role"] == role && s["state"] == "ready")
        };
        state("mapping") && state("local_planner")
    });
    let view = sample(&up);
    assert_services(&view, &up);
    assert_topics(&view);
    assert_drive(&view);

    // Without a terminal it is a sample, too.
    let text = up.ask(&["top"], 0);
    assert!(text.starts_with("open_aisle  real_time  "), "{text}");
    for word in [
        "\nservice ",
        "\nmapping ",
        "\nreaction [us]: p50 ",
        "\ntop: cpu ",
    ] {
        assert!(text.contains(word), "{word}: {text}");
    }
    assert!(!text.contains('\x1b'), "{text}");
    assert_eq!(readers(&up), before, "it has given its places back");
    up.down();
}

/// Every service with its process; mapping was restarted once.
fn assert_services(view: &Value, up: &Up) {
    let names = [
        "robot",
        "mapping",
        "global_planner",
        "local_planner",
        "collision_guard",
    ];
    let services = view["services"].as_array().expect("services");
    let roles: Vec<&str> = services
        .iter()
        .filter_map(|line| line["role"].as_str())
        .collect();
    assert_eq!(roles, names);
    for role in names {
        let service = line(view, "services", "role", role);
        let restarts = u64::from(role == "mapping");
        assert_eq!(service["restarts"], restarts, "{service:#}");
        assert_eq!(service["epoch"], 1 + restarts, "{service:#}");
        let pid = u64::from(up.stack.service(role).expect("its process"));
        assert_eq!(service["pid"], pid, "{service:#}");
        assert!(
            service["memory_bytes"].as_u64() > Some(1_000_000),
            "{service:#}"
        );
        let cpu = service["cpu_percent"].as_f64().expect("two readings");
        assert!((0.0..=400.0).contains(&cpu), "{service:#}");
    }
}

/// Every topic with its rate and age.
fn assert_topics(view: &Value) {
    let shown = view["topics"].as_array().expect("topics");
    let names: Vec<&str> = shown
        .iter()
        .filter_map(|line| line["topic"].as_str())
        .collect();
    assert_eq!(
        names,
        topics().iter().map(|row| row.name).collect::<Vec<_>>()
    );
    let odometry = line(view, "topics", "topic", RobotOdometry::ROW.name);
    let hz = odometry["hz"].as_f64().expect("a rate");
    assert!(hz > 1.0, "{odometry:#}");
    let bytes_per_s = odometry["bytes_per_s"].as_f64().expect("a rate");
    let bytes = u32::try_from(RobotOdometry::ROW.envelope_bytes).expect("a size");
    assert!(
        (bytes_per_s - hz * f64::from(bytes)).abs() < 1e-6 * bytes_per_s,
        "{odometry:#}"
    );
    assert!(odometry["age_s"].is_f64(), "{odometry:#}");
    assert!(line(view, "topics", "topic", SPANS.name)["hz"].as_f64() > Some(1.0));
    // A latched message from before is no rate, but has an age; what never came has none.
    let keyframe = line(view, "topics", "topic", MapKeyframe::ROW.name);
    assert!(keyframe["age_s"].is_f64(), "{keyframe:#}");
    let pose = line(view, "topics", "topic", TaskPose::ROW.name);
    assert_eq!(pose["age_s"], Value::Null, "{pose:#}");
}

/// The drive, its latencies, and what happened.
fn assert_drive(view: &Value) {
    assert_eq!(view["run"]["scenario"], "open_aisle");
    assert_eq!(view["run"]["task"], "active", "{view:#}");
    assert!(view["reaction"]["n"].as_u64() > Some(0), "{view:#}");
    assert!(view["reaction"]["p50_us"].as_f64() > Some(0.0), "{view:#}");
    let happened = |kind: &str, words: &str| {
        let events = view["events"].as_array().expect("events");
        let text = |event: &Value| event["text"].as_str().unwrap_or("").to_owned();
        events
            .iter()
            .any(|event| event["kind"] == kind && text(event).contains(words))
    };
    assert!(happened("fault", "kill mapping"), "{view:#}");
    assert!(happened("restart", "mapping: "), "{view:#}");
    assert!(view["own"]["cpu_percent"].is_f64(), "{view:#}");
    assert!(
        view["own"]["memory_bytes"].as_u64() > Some(1_000_000),
        "{view:#}"
    );
}

/// Runs `zeronav top` on a terminal of its own until `end` ends it.
fn on_a_terminal(up: &mut Up, end: impl FnOnce(&mut Up, u32, &mut dyn Write)) -> Output {
    let program = zeronav_tests::binaries().join("zeronav");
    let line = format!("{} top --domain {}", program.display(), up.root);
    let before = readers(up);
    let mut terminal = Command::new("script")
        .args(["--quiet", "--return", "--command", &line, "/dev/null"])
        .env("TERM", "xterm")
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("script is part of Debian's base");
    up.stack.wait_until("it reads the stack", |_| {
        let list = zeronav(&["topics", "--json", "--domain", &up.root]).json();
        // The last one that it opens.
        let name = DebugRollouts::ROW.name;
        let row = line_of(&list, name);
        let known = before.iter().find(|(known, _)| known == name);
        row["readers"].as_u64() > known.map(|(_, readers)| *readers)
    });
    let mut keys = terminal.stdin.take().expect("its keyboard");
    let shell = children_of(terminal.id());
    let (pid, _) = shell.first().expect("the process on the terminal");
    // `script` runs the command by a shell, which may have become it.
    let inner = children_of(*pid).first().map_or(*pid, |(pid, _)| *pid);
    end(up, inner, &mut keys);
    // The keyboard stays until the end.
    let output = terminal.wait_with_output().expect("it ends");
    drop(keys);
    output
}

fn line_of<'a>(list: &'a Value, name: &str) -> &'a Value {
    let rows = list["topics"].as_array().expect("topics");
    rows.iter().find(|row| row["topic"] == name).expect("a row")
}

/// The terminal was taken once and given back, after which only `last` came.
fn assert_given_back(output: &Output, last: &str) {
    let said = String::from_utf8_lossy(&output.stdout);
    assert_eq!(said.matches(ENTER).count(), 1, "{said:?}");
    let (_, after) = said.split_once(LEAVE).unwrap_or_else(|| panic!("{said:?}"));
    assert!(!after.contains(ENTER), "{after:?}");
    assert!(after.contains(last), "{after:?}");
    assert!(
        after.contains("\x1b[?25h"),
        "the cursor is visible again: {after:?}"
    );
}

#[test]
fn a_terminal_gets_back_what_it_had_however_the_view_ends() {
    let _turn = real_time_turn();
    let mut up = Up::start(&["open_aisle"]);
    let before = readers(&up);
    let quit = on_a_terminal(&mut up, |_, _, keys| {
        keys.write_all(b"sq").expect("typed");
    });
    assert_eq!(quit.status.code(), Some(0), "{quit:?}");
    assert_given_back(&quit, "");
    let typed = on_a_terminal(&mut up, |_, _, keys| {
        keys.write_all(b"\x03").expect("typed");
    });
    assert_eq!(typed.status.code(), Some(130), "{typed:?}");
    assert_given_back(&typed, "");
    let asked = on_a_terminal(&mut up, |_, pid, _| {
        assert!(send_signal(pid, Signal::TERM));
    });
    assert_eq!(asked.status.code(), Some(130), "{asked:?}");
    assert_given_back(&asked, "");
    assert_eq!(readers(&up), before, "all places were given back");
    let over = on_a_terminal(&mut up, |up, _, _| {
        up.ask(&["down"], 0);
    });
    assert_eq!(over.status.code(), Some(0), "{over:?}");
    assert_given_back(&over, "the run has ended");
    let Up { stack, root } = up;
    assert_eq!(stack.finish().code(), 0);
    assert_eq!(leftovers(Path::new(&root)), Vec::<PathBuf>::new());
}

#[test]
fn mistakes_are_answered_in_one_line() {
    for words in [
        ["--domain", "/dev/shm/zn_nothing000"],
        ["--once", "--jsonl"],
    ] {
        let ended = Zeronav::start(&[&["top"][..], &words].concat()).finish();
        assert_eq!(ended.code(), 2, "{words:?}: {}", ended.stderr);
        assert_eq!(ended.stderr.lines().count(), 1, "{}", ended.stderr);
        assert_eq!(ended.stdout, "");
    }
}
