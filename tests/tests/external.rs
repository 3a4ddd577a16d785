//! A service that somebody started by hand leaves by itself when launch is gone.

use rustix::process::Signal;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};
use zeronav_tests::{Zeronav, binaries, is_alive, leftovers, zeronav};

/// Whoever has not left by then stays.
const WATCHDOG: Duration = Duration::from_secs(10);

/// A collision guard that was started by hand. Dropping it ends it.
struct Guard {
    process: Child,
    log: tempfile::NamedTempFile,
}

impl Guard {
    fn start(root: &Path) -> Self {
        let log = tempfile::NamedTempFile::new().expect("a file");
        let process = Command::new(binaries().join("zeronav-collision-guard"))
            .args(["--epoch", "1", "--domain"])
            .arg(root)
            .stdin(Stdio::null())
            .stderr(log.reopen().expect("a handle"))
            .spawn()
            .expect("the guard starts");
        Self { process, log }
    }

    /// Waits until it has left by itself: how, and what it logged.
    fn left(mut self) -> (ExitStatus, String) {
        let started = Instant::now();
        let status = loop {
            if let Some(status) = self.process.try_wait().expect("its state") {
                break status;
            }
            assert!(started.elapsed() < WATCHDOG, "the guard stays");
            std::thread::sleep(Duration::from_millis(5));
        };
        eprintln!("the guard left after {:?}", started.elapsed());
        let log = std::fs::read_to_string(self.log.path()).expect("its log");
        (status, log)
    }
}

impl Drop for Guard {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

/// A drive in lockstep whose guard was started by hand, and its domain.
fn driving() -> (Zeronav, PathBuf, Guard) {
    let mut run = Zeronav::start(&[
        "run",
        "unsealed",
        "--lockstep",
        "--headless",
        "--json",
        "--external",
        "collision_guard",
    ]);
    run.wait_until("the others run", |run| run.children().len() == 4);
    run.wait_until("they know their domain", |run| run.domains().len() == 1);
    let root = run.domains().pop().expect("a domain");
    let guard = Guard::start(&root);
    (run, root, guard)
}

#[test]
fn a_service_started_by_hand_leaves_when_launch_is_killed() {
    let (mut run, root, guard) = driving();
    run.wait_until("the robot is on its way", |run| {
        let report = run.report().unwrap_or_default();
        report["time_s"].as_f64().is_some_and(|time_s| time_s > 0.5)
    });
    assert!(is_alive(guard.process.id()));
    run.signal(Signal::KILL);
    let (status, log) = guard.left();
    assert_eq!(status.code(), Some(0), "{log}");
    assert!(log.contains("launch is gone"), "{log}");
    // Whoever died last may have been a child of launch: then the next command cleans up.
    assert_eq!(zeronav(&["list"]).code(), 0);
    assert_eq!(leftovers(&root), Vec::<PathBuf>::new());
}

#[test]
fn a_service_started_by_hand_leaves_after_the_run_and_takes_the_domain_with_it() {
    let (run, root, guard) = driving();
    let result = run.finish().expect(0);
    assert_eq!(result["reached"], true, "{result:#}");
    let (status, log) = guard.left();
    assert_eq!(status.code(), Some(0), "{log}");
    assert!(log.contains("launch is gone"), "{log}");
    assert_eq!(leftovers(&root), Vec::<PathBuf>::new());
}
