//! A service that gets no processor is no hung one: a lockstep run beside busy processes is the same run,
//! and in real time the result names it.

use std::process::{Child, Stdio};
use zeronav_tests::{Ended, Zeronav, command, quiet_turn};

/// Processes that compute as long as this is kept: two a core.
struct Burden(Vec<Child>);

impl Burden {
    fn start() -> Self {
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        let start = |_| {
            let mut busy = command();
            busy.args(["busy", "600"]).stdin(Stdio::piped());
            busy.spawn().expect("started")
        };
        Self((0..2 * cores).map(start).collect())
    }
}

impl Drop for Burden {
    fn drop(&mut self) {
        for process in &mut self.0 {
            let _ = process.kill();
            let _ = process.wait();
        }
    }
}

/// A drive of 3 m whose planner comes last when the processors are busy, and that would not wait long
/// for one that hangs.
fn start(mode: &[&str]) -> Zeronav {
    let folder = tempfile::tempdir().expect("a folder");
    let text = "title = \"starved\"\nbase = [\"warehouse\", \"porter\"]\nstart = [4.0, 6.425, 0.0]\n\
                run.time_limit_s = 60.0\n[[goals]]\npose = [7.0, 6.425, 0.0]\n\
                [restart]\nhang_after_s = 0.1\n\
                [services.global_planner.scheduling]\npolicy = \"batch\"\nnice = 15\n";
    std::fs::write(folder.path().join("it.toml"), text).expect("written");
    let arguments = [&["run", "./it.toml", "--headless", "--json"], mode].concat();
    Zeronav::start_in(folder, &arguments)
}

#[test]
fn a_lockstep_run_is_the_same_run_however_busy_the_machine_is() {
    // Its load would disturb the others, and starve a run in the background.
    let _turn = quiet_turn();
    let idle = start(&["--lockstep"]).finish().expect(0);
    let burden = Burden::start();
    let busy = [(); 2]
        .map(|()| start(&["--lockstep"]))
        .map(Zeronav::finish);
    drop(burden);
    for result in busy.iter().map(|ended: &Ended| ended.expect(0)) {
        assert_eq!(
            result["restarts"].as_array().map(Vec::len),
            Some(0),
            "{result:#}"
        );
        assert_eq!(result["run_hash"], idle["run_hash"]);
        assert_eq!(result["reproducible"], true, "{result:#}");
    }
}

/// What came of a drive in real time beside busy processes: it may have come too late for its goal.
#[test]
fn who_gets_no_processor_in_real_time_is_named_and_not_killed() {
    let _turn = quiet_turn();
    let _burden = Burden::start();
    let mut seen = Vec::new();
    // Which of the processes is kept waiting, and for how long, the kernel says.
    for _ in 0..5 {
        let result = start(&[]).finish().json();
        assert_eq!(result["restarts"], serde_json::json!([]), "{result:#}");
        let starved = result["starved"].as_array().cloned().unwrap_or_default();
        let planner = starved.iter().find(|it| it["service"] == "global_planner");
        if let Some(planner) = planner {
            assert!(planner["times"].as_u64() > Some(0), "{planner}");
            assert!(planner["longest_s"].as_f64() > Some(0.1), "{planner}");
            return;
        }
        seen.push(starved);
    }
    panic!("the planner was never starved: {seen:?}");
}
