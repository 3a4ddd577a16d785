//! A run that launch cannot end: a service cuts off or overwrites shared memory, or launch is killed. The
//! run has a result that says so, and nothing is left.

use rustix::process::Signal;
use serde_json::Value;
use std::fs::File;
use std::os::unix::fs::{FileExt, OpenOptionsExt};
use std::path::{Path, PathBuf};
use zeronav_tests::up::Up;
use zeronav_tests::{await_by_itself, is_alive, leftovers, real_time_turn, send_signal};

/// A stack whose robot drives.
struct Driving {
    up: Up,
    folder: PathBuf,
    pids: Vec<u32>,
    mapping: u32,
}

impl Driving {
    fn start() -> Self {
        let mut up = Up::start(&["open_aisle"]);
        up.ask(&["goal", "27", "8.5", "0"], 0);
        up.stack.wait_until("the robot drives", |stack| {
            let report = stack.report().unwrap_or_default();
            report["goal"]["elapsed_s"].as_f64() > Some(1.0)
        });
        let report = up.status();
        let services = report["services"].as_array().expect("services").iter();
        let pid = |service: &Value| u32::try_from(service["pid"].as_u64().expect("an id"));
        let pids = services.map(|service| pid(service).expect("an id"));
        let folder = report["folder"].as_str().expect("a folder").into();
        Self {
            folder,
            pids: pids.collect(),
            mapping: up.stack.service("mapping").expect("it runs"),
            up,
        }
    }

    /// The segments with this suffix that mapping uses and has made, or made together with a reader: the
    /// middleware puts the ids of the processes into their names.
    fn segments_of_mapping(&self, suffix: &str) -> Vec<PathBuf> {
        let maps = std::fs::read_to_string(format!("/proc/{}/maps", self.mapping));
        let maps = maps.expect("its memory");
        let is_its = |path: &&str| {
            let name = path.strip_suffix(suffix).unwrap_or_default();
            let mut numbers = name.split('_').filter_map(|it| it.parse::<u128>().ok());
            numbers.any(|number| (number >> 64) & 0xffff_ffff == self.mapping.into())
        };
        let paths = maps
            .lines()
            .filter_map(|line| line.split_whitespace().nth(5));
        let mut segments: Vec<PathBuf> = paths.filter(is_its).map(PathBuf::from).collect();
        segments.dedup();
        assert!(!segments.is_empty(), "{maps}");
        segments
    }

    /// What is left once everything is over.
    fn end(self, code: Option<i32>) -> (String, Value) {
        let ended = self.up.stack.finish();
        assert_eq!(
            ended.status.code(),
            code,
            "{}{}",
            ended.stdout,
            ended.stderr
        );
        let file = self.folder.join("result.json");
        if code.is_none() {
            await_by_itself("a result is left", || file.exists());
        }
        let result = std::fs::read_to_string(file).expect("a result");
        let result: Value = serde_json::from_str(&result).expect("JSON");
        for pid in self.pids {
            await_by_itself("no process is left", || !is_alive(pid));
        }
        let root = Path::new(&self.up.root);
        await_by_itself("no memory is left", || leftovers(root).is_empty());
        (ended.stderr, result)
    }
}

/// A run that ended because `damage` was done to segments of mapping.
fn check(suffix: &str, damage: impl Fn(&File)) {
    let _turn = real_time_turn();
    let run = Driving::start();
    for segment in run.segments_of_mapping(suffix) {
        let file = File::options().write(true).open(segment);
        damage(&file.expect("a segment"));
    }
    let author = format!("mapping (pid {})", run.mapping);
    let (said, result) = run.end(Some(3));
    assert!(
        said.contains("launch cannot go on: its memory is damaged"),
        "{said}"
    );
    assert_eq!(result["outcome"], "memory_damaged", "{result:#}");
    let why = result["reason"].as_str().expect("a reason");
    for said in ["shared memory of", &author, "was cut off or overwritten"] {
        assert!(why.contains(said), "{why}");
    }
}

#[test]
fn a_service_that_cuts_off_its_memory_ends_the_run_with_its_name() {
    check(".data", |segment| segment.set_len(0).expect("cut off"));
}

#[test]
fn a_service_that_overwrites_its_memory_ends_the_run_with_its_name() {
    check(".connection", |segment| {
        let len = segment.metadata().expect("a size").len();
        let noise: Vec<u8> = (0..len)
            .map(|at| at.wrapping_mul(0x9e37_79b9).to_le_bytes()[1])
            .collect();
        segment.write_all_at(&noise, 0).expect("overwritten");
    });
}

/// The segment begins as it should, so that it does not look damaged.
#[test]
fn a_service_that_overwrites_its_memory_behind_the_beginning_ends_the_run_with_its_name() {
    check(".connection", |segment| {
        let len = segment.metadata().expect("a size").len();
        let noise: Vec<u8> = (0..len)
            .map(|at| at.wrapping_mul(0x9e37_79b9).to_le_bytes()[1])
            .collect();
        segment.write_all_at(&noise[8..], 8).expect("overwritten");
    });
}

#[test]
fn a_run_whose_launch_is_killed_has_a_result() {
    let _turn = real_time_turn();
    let run = Driving::start();
    run.up.stack.signal(Signal::KILL);
    let (_, result) = run.end(None);
    assert_eq!(result["outcome"], "launch_died", "{result:#}");
}

/// Launch would wait a minute for such a segment, and cannot see to it meanwhile.
#[test]
fn a_segment_that_a_killed_service_was_making_goes_while_launch_waits() {
    let _turn = real_time_turn();
    let mut run = Driving::start();
    let segment = PathBuf::from(format!("{}_a1_1.data", run.up.root));
    let mut options = File::options();
    options.write(true).create_new(true).mode(0o200);
    let made = options.open(&segment).expect("a half-made segment");
    run.up.stack.signal(Signal::STOP);
    drop(made);
    assert!(send_signal(run.mapping, Signal::KILL));
    await_by_itself("it is gone", || !segment.exists());
    run.up.stack.signal(Signal::CONT);
    let killed = run.mapping;
    run.up.stack.wait_until("mapping is back", |stack| {
        stack.service("mapping").is_some_and(|pid| pid != killed)
    });
    run.up.down();
}
