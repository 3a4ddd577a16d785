//! Programs of the other side, each a process with rclpy.

use rustix::process::Signal;
use serde_json::Value;
use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};
use zeronav_tests::python::rclpy;
use zeronav_tests::{await_by_itself, binaries, send_signal, workspace};

/// Domains of ROS 2 for tests: some that nobody uses by default, each with ports that lie below those that the system
/// gives out.
const DOMAINS: core::ops::Range<u32> = 20..100;

/// How long a peer may take to leave.
const PATIENCE: Duration = Duration::from_secs(3);

/// A domain of ROS 2 that no other test of this program is in, and hardly one of another.
pub(super) fn domain() -> u32 {
    static NEXT: AtomicU32 = AtomicU32::new(0);
    let n = std::process::id().wrapping_mul(7) + NEXT.fetch_add(1, Ordering::Relaxed);
    DOMAINS.start + n % (DOMAINS.end - DOMAINS.start)
}

/// A program that says what happens to it, a JSON object a line.
pub(super) struct Peer {
    process: Child,
    said: Arc<Mutex<Vec<Value>>>,
    reader: Option<JoinHandle<()>>,
}

impl Peer {
    /// Starts the script `name` in a domain of ROS 2.
    pub(super) fn start(name: &str, domain_id: u32, arguments: &[&str]) -> Self {
        let script = workspace().join(format!("services/ros2/tests/peers/{name}.py"));
        let (python, interfaces) = rclpy();
        let mut process = Command::new(python)
            .arg(script)
            .args(arguments)
            .env("PYTHONPATH", interfaces)
            .env("ROS_DOMAIN_ID", domain_id.to_string())
            .env("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
            .env("RMW_IMPLEMENTATION", "rmw_fastrtps_cpp")
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .expect("a peer");
        let out = BufReader::new(process.stdout.take().expect("its output"));
        let said = Arc::new(Mutex::new(Vec::new()));
        let to = Arc::clone(&said);
        let reader = std::thread::spawn(move || {
            for line in out.lines().map_while(Result::ok) {
                if let Ok(value) = serde_json::from_str(&line) {
                    to.lock().expect("the lines").push(value);
                }
            }
        });
        Self {
            process,
            said,
            reader: Some(reader),
        }
    }

    /// A robot: the simulator with this configuration is its hardware.
    pub(super) fn robot(domain_id: u32, config: &Path, more: &[&str]) -> Self {
        let hardware = binaries().join("simulated_hardware");
        let hardware = hardware.display().to_string();
        let config = config.display().to_string();
        let arguments = [&[hardware.as_str(), &config], more].concat();
        Self::start("robot", domain_id, &arguments)
    }

    /// Tells it what to do.
    pub(super) fn order(&mut self, order: &Value) {
        let to = self.process.stdin.as_mut().expect("its input");
        writeln!(to, "{order}")
            .and_then(|()| to.flush())
            .expect("it listens");
    }

    /// All that it has said of this kind.
    pub(super) fn said(&self, kind: &str) -> Vec<Value> {
        let said = self.said.lock().expect("the lines");
        said.iter()
            .filter(|it| it["kind"] == kind)
            .cloned()
            .collect()
    }

    /// The newest that it has said of this kind.
    pub(super) fn newest(&self, kind: &str) -> Option<Value> {
        let said = self.said.lock().expect("the lines");
        said.iter().rev().find(|it| it["kind"] == kind).cloned()
    }

    /// Waits until it says something of this kind that is as wanted.
    pub(super) fn wait_for(&self, kind: &str, wanted: impl Fn(&Value) -> bool) -> Value {
        let mut found = None;
        await_by_itself(kind, || {
            found = self.said(kind).into_iter().find(&wanted);
            found.is_some()
        });
        found.expect("found")
    }
}

impl Drop for Peer {
    fn drop(&mut self) {
        // Asked first: Fast DDS leaves its shared memory behind when it is killed.
        drop(self.process.stdin.take());
        let _ = send_signal(self.process.id(), Signal::TERM);
        let asked = Instant::now();
        while asked.elapsed() < PATIENCE && matches!(self.process.try_wait(), Ok(None)) {
            std::thread::sleep(Duration::from_millis(10));
        }
        let _ = self.process.kill();
        let _ = self.process.wait();
        if let Some(reader) = self.reader.take() {
            let _ = reader.join();
        }
    }
}
