//! `zeronav topics` on a real stack: what it shows is what is sent, and the stack does not notice.

use rustix::process::Signal;
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use zeronav_msgs::topics::{
    MapKeyframe, MapUpdate, PlanPath, PlanRequests, RobotCommand, RobotDescription, RobotOdometry,
    RobotScan, RunClockTopic, SPANS, SimForesight, TaskState, TaskZones, Topic, topics,
};
use zeronav_tests::{Ended, Zeronav, leftovers, quiet_turn, real_time_turn, zeronav};

const ODOMETRY: &str = RobotOdometry::ROW.name;
const SCAN: &str = RobotScan::ROW.name;
const COMMAND: &str = RobotCommand::ROW.name;
const CLOCK: &str = RunClockTopic::ROW.name;
const PATH: &str = PlanPath::ROW.name;
const DESCRIPTION: &str = RobotDescription::ROW.name;
const UPDATE: &str = MapUpdate::ROW.name;
const STATUS: &str = TaskState::ROW.name;
const KEYFRAME: &str = MapKeyframe::ROW.name;
const REQUEST: &str = PlanRequests::ROW.name;

/// Up and down an aisle: a drive of some minutes, of some seconds in lockstep.
fn start(more: &[&str]) -> Zeronav {
    start_with(10, more)
}

/// So many legs along an aisle.
fn start_with(legs: usize, more: &[&str]) -> Zeronav {
    let goals = (0..legs).map(|leg| {
        let x_m = if leg % 2 == 0 { 12.5 } else { 5.0 };
        format!("[[goals]]\npose = [{x_m}, 6.425, 0.0]\nyaw_tolerance_rad = 3.15\n")
    });
    let text = "title = \"test\"\nbase = [\"warehouse\", \"porter\"]\n\
                start = [4.0, 6.425, 0.0]\n"
        .to_owned()
        + &goals.collect::<String>();
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("it.toml"), text).expect("written");
    let arguments = [&["run", "./it.toml", "--headless", "--json"], more].concat();
    Zeronav::start_in(folder, &arguments)
}

/// Waits until the robot drives; the run's domain.
fn driving(run: &mut Zeronav) -> PathBuf {
    run.wait_until("the robot is on its way", |run| {
        let report = run.report().unwrap_or_default();
        report["time_s"].as_f64().is_some_and(|time_s| time_s > 0.1)
    });
    run.domains().pop().expect("a domain")
}

fn tap(root: &Path, words: &[&str]) -> Zeronav {
    let root = root.to_str().expect("a path");
    Zeronav::start(&[&["topics", "--domain", root], words].concat())
}

/// What a tap says that ends by itself.
fn tapped(root: &Path, words: &[&str]) -> Ended {
    let ended = tap(root, words).finish();
    assert_eq!(ended.code(), 0, "{words:?}: {}", ended.stderr);
    ended
}

fn lines(ended: &Ended) -> Vec<Value> {
    let parse = |line| serde_json::from_str(line).expect("a JSON object per line");
    ended.stdout.lines().map(parse).collect()
}

/// Writers and readers of every topic.
fn ports(root: &Path) -> BTreeMap<String, (u64, u64)> {
    let list = tapped(root, &["--json"]).json();
    let rows = list["topics"].as_array().expect("topics");
    rows.iter()
        .map(|row| {
            let number = |key: &str| row[key].as_u64().expect("a number");
            let name = row["topic"].as_str().expect("a name").to_owned();
            (name, (number("writers"), number("readers")))
        })
        .collect()
}

/// The count in an identity such as `1:17`.
fn count(id: &Value) -> u64 {
    let (_, count) = id
        .as_str()
        .and_then(|id| id.split_once(':'))
        .expect("an id");
    count.parse().expect("a count")
}

#[test]
fn messages_come_decoded_in_order_and_with_their_units() {
    let _turn = real_time_turn();
    let mut run = start_with(1, &[]);
    let root = driving(&mut run);

    let odometry = lines(&tapped(&root, &["echo", ODOMETRY, "-n", "20", "--json"]));
    assert_eq!(odometry.len(), 20);
    for (n, pair) in odometry.windows(2).enumerate() {
        let step = count(&pair[1]["header"]["id"]) - count(&pair[0]["header"]["id"]);
        assert_eq!(
            step,
            1 + pair[1]["missed"].as_u64().expect("a number"),
            "{n}"
        );
        assert!(pair[1]["header"]["tick"].as_u64() > pair[0]["header"]["tick"].as_u64());
    }
    let last = odometry.last().expect("a message");
    assert_eq!(last["header"]["role"], "robot");
    assert!(last["fields"]["pose"]["x_m"].as_f64().expect("metres") > 0.0);
    assert_eq!(last["units"]["fields.pose.x_m"], "m");
    assert_eq!(last["units"]["fields.v_mps"], "m/s");
    assert_eq!(last["units"]["header.stamps.published_ns"], "ns");
    assert_eq!(last["units"]["header.id"], "id");

    // Every number of the message has its unit.
    let units = last["units"].as_object().expect("units");
    for part in ["header", "fields"] {
        for path in paths(part, &last[part]) {
            assert!(units.contains_key(&path), "{path} has no unit");
        }
    }

    let scan = lines(&tapped(&root, &["echo", SCAN, "-n", "1", "--json"]));
    let beams = scan[0]["items"].as_array().expect("ranges");
    assert_eq!(
        beams.len() as u64,
        scan[0]["fields"]["n_beams"].as_u64().expect("beams")
    );
    assert_eq!(scan[0]["units"]["items"], "m");

    let command = tapped(&root, &["echo", COMMAND, "-n", "1"]).stdout;
    assert!(command.contains("  validity: drive\n"), "{command}");
    assert!(command.contains(" m/s\n"), "{command}");
    assert!(command.contains(" rad/s\n"), "{command}");

    let spans = lines(&tapped(&root, &["echo", SPANS.name, "-n", "50", "--json"]));
    let author = |role: &str| spans.iter().any(|span| span["items"][0]["role"] == role);
    for role in [
        "robot",
        "mapping",
        "global_planner",
        "local_planner",
        "collision_guard",
    ] {
        assert!(author(role), "no record of {role}");
    }
    let result = run.finish().expect(0);
    assert_eq!(result["reached"], true, "{result:#}");
    assert_eq!(leftovers(&root), Vec::<PathBuf>::new());
}

/// The paths of the numbers and words below `value`.
fn paths(path: &str, value: &Value) -> Vec<String> {
    match value.as_object() {
        None => vec![path.to_owned()],
        Some(fields) => fields
            .iter()
            .flat_map(|(name, value)| paths(&format!("{path}.{name}"), value))
            .collect(),
    }
}

#[test]
fn rates_are_those_of_the_stack() {
    let _turn = quiet_turn();
    let mut run = start(&[]);
    let root = driving(&mut run);
    let hz = lines(&tapped(&root, &["hz", ODOMETRY, "-n", "100", "--json"]));
    let all = hz.last().expect("a line about all");
    assert_eq!(all["messages"], 100, "{all:#}");
    assert!(hz.len() >= 2, "a line every second");
    let clock = lines(&tapped(&root, &["echo", CLOCK, "-n", "1", "--json"]));
    let tick_ns = clock[0]["fields"]["tick_ns"].as_f64().expect("a period");
    let wanted_hz = 1.0e9 / tick_ns;
    let measured_hz = all["hz"].as_f64().expect("a rate");
    assert!(
        (measured_hz / wanted_hz - 1.0).abs() < 0.05,
        "{measured_hz} Hz"
    );
    let bw = lines(&tapped(&root, &["bw", ODOMETRY, "-n", "50", "--json"]));
    let all = bw.last().expect("a line about all");
    let row = topics().into_iter().find(|row| row.name == ODOMETRY);
    let bytes = row.expect("odometry").envelope_bytes;
    assert_eq!(all["message_bytes"]["max"], bytes, "{all:#}");
    drop(run);
}

#[test]
fn table_shows_every_topic_and_who_is_there() {
    let _turn = real_time_turn();
    let mut run = start_with(1, &[]);
    let root = driving(&mut run);
    let ports_now = ports(&root);
    let names: Vec<&str> = topics().iter().map(|row| row.name).collect();
    assert_eq!(ports_now.len(), names.len());
    for name in &names {
        let (writers, readers) = ports_now[*name];
        // What will be is told in runs that measure, and zones where there are any.
        let wanted = match *name {
            name if name == SPANS.name => 5,
            name if [SimForesight::ROW.name, TaskZones::ROW.name].contains(&name) => 0,
            _ => 1,
        };
        assert_eq!(writers, wanted, "{name}");
        assert!(readers <= 7, "{name} has {readers} readers");
    }
    let text = tapped(&root, &[]).stdout;
    assert_eq!(text.lines().count(), names.len() + 1, "{text}");
    let scan = text.lines().find(|line| line.starts_with(SCAN));
    let scan = scan.expect("the scan's line");
    for word in [
        "zeronav.Scan.v1",
        "robot",
        "latest",
        "32",
        "160 + 4 each, 4096 at most",
    ] {
        assert!(scan.contains(word), "{word}: {scan}");
    }

    // A guest that is asked to go leaves its place.
    let mut guest = tap(&root, &["echo", PATH, "--json"]);
    guest.wait_until("it has joined", |_| {
        ports(&root)[PATH].1 == ports_now[PATH].1 + 1
    });
    guest.signal(Signal::INT);
    let ended = guest.finish();
    assert_eq!(ended.code(), 130, "{}", ended.stderr);
    assert_eq!(ports(&root)[PATH], ports_now[PATH]);

    // Guests that are killed do not: but there is always a place for the next.
    for _ in 0..14 {
        let mut guest = tap(&root, &["echo", DESCRIPTION, "--json"]);
        guest.wait_until("it shows the description", |guest| guest.has_said("\n"));
        drop(guest);
    }
    tapped(&root, &["echo", DESCRIPTION, "-n", "1"]);
    let result = run.finish().expect(0);
    assert_eq!(result["reached"], true, "{result:#}");
    assert_eq!(result["restarts"], serde_json::json!([]), "{result:#}");
    assert_eq!(leftovers(&root), Vec::<PathBuf>::new());
}

#[test]
fn taps_keep_the_lockstep_hash_and_end_with_the_run() {
    let alone = start(&["--lockstep"]).finish().expect(0);
    let mut run = start(&["--lockstep"]);
    let root = driving(&mut run);
    let names = [SCAN, UPDATE, PATH, STATUS, SPANS.name];
    let taps = names.map(|name| (name, tap(&root, &["echo", name, "--json"])));
    // One that stands still holds nothing that anybody waits for.
    let mut frozen = tap(&root, &["echo", KEYFRAME, "--json"]);
    frozen.wait_until("it shows the map", |tap| tap.has_said("\n"));
    frozen.signal(Signal::STOP);
    let result = run.finish().expect(0);
    assert_eq!(result["reached"], true, "{result:#}");
    assert!(alone["run_hash"].is_string(), "{alone:#}");
    assert_eq!(alone["run_hash"], result["run_hash"]);
    frozen.signal(Signal::CONT);
    let ended = frozen.finish();
    assert_eq!(ended.code(), 0, "{}", ended.stderr);
    for (name, tap) in taps {
        let ended = tap.finish();
        assert_eq!(ended.code(), 0, "{name}: {}", ended.stderr);
        assert_eq!(ended.stderr, "the run has ended\n", "{name}");
        assert!(!lines(&ended).is_empty(), "{name}");
    }
    assert_eq!(leftovers(&root), Vec::<PathBuf>::new());
}

#[test]
fn mistakes_are_answered_in_one_line() {
    let misspelt = format!("{SCAN}n");
    let gone = ["--domain", "/dev/shm/zn_nothing000"];
    for (words, said) in [
        (vec!["topics"], "no such folder"),
        (vec!["topics", "hz", SCAN], "no such folder"),
        (vec!["topics", "echo", &misspelt], SCAN),
        (vec!["topics", "echo", SCAN, "-n", "0"], "0"),
    ] {
        let ended = zeronav(&[&words[..], &gone].concat());
        assert_eq!(ended.code(), 2, "{words:?}: {}", ended.stderr);
        assert!(ended.stderr.contains(said), "{words:?}: {}", ended.stderr);
        assert_eq!(ended.stderr.lines().count(), 1, "{}", ended.stderr);
        assert_eq!(ended.stdout, "");
    }
}

#[test]
fn closed_pipe_ends_a_tap_quietly() {
    let _turn = real_time_turn();
    let mut run = start(&[]);
    let root = driving(&mut run);
    let program = zeronav_tests::binaries().join("zeronav");
    // Nobody asks for a plan: the end of the reader is seen without a message.
    for topic in [ODOMETRY, REQUEST] {
        let script = format!(
            "{{ {} topics echo {topic} --domain {}; echo code $? >&2; }} | head -n 1 & \
             read_pid=$!; sleep 1; kill $read_pid 2>/dev/null; wait",
            program.display(),
            root.display()
        );
        let output = std::process::Command::new("sh")
            .args(["-c", &script])
            .output();
        let output = output.expect("a shell");
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(said, "code 0\n", "{topic}");
    }
    drop(run);
}
