//! The other side of a ROS 2 network: programs with rclpy, each a process, and a robot whose hardware is the simulator.

use rustix::process::Signal;
use serde_json::Value;
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};
use tempfile::TempDir;
use zeronav_robot_sim::SimConfig;
use zeronav_scenario::Scenario;

use crate::python::rclpy;
use crate::{await_by_itself, binaries, send_signal, workspace};

/// Domains of ROS 2 for tests: some that nobody uses by default, each with ports that lie below those that the system
/// gives out.
const DOMAINS: core::ops::Range<u32> = 20..100;

/// How long a peer may take to leave: on a busy machine it takes its nodes down slowly.
const PATIENCE: Duration = Duration::from_secs(20);

/// A domain of ROS 2 that no other test of this program is in, and hardly one of another.
#[must_use]
pub fn domain() -> u32 {
    static NEXT: AtomicU32 = AtomicU32::new(0);
    let n = std::process::id().wrapping_mul(7) + NEXT.fetch_add(1, Ordering::Relaxed);
    DOMAINS.start + n % (DOMAINS.end - DOMAINS.start)
}

/// A scenario with the robot of a ROS domain in it: its folder, and the configuration of the robot's hardware.
/// What the scenario expects is left out.
///
/// # Panics
/// When they cannot be written.
#[must_use]
pub fn folder_of(text: &str, domain_id: u32, more: &str) -> (TempDir, PathBuf) {
    let folder = tempfile::tempdir().expect("a folder");
    // What the simulator alone can tell is asked of the robot's own side.
    let (text, _) = text.split_once("[expect]").expect("expectations");
    let text = format!(
        "{text}\n[expect]\noutcome = \"reached\"\n\n[services.robot]\nbinary = \"zeronav-ros2\"\n\
         config.ros.network = {{ domain_id = {domain_id}, range = \"localhost\" }}\n{more}\n"
    );
    std::fs::write(folder.path().join("it.toml"), text).expect("written");
    let config = hardware(folder.path());
    (folder, config)
}

/// Writes the world and the robot of the scenario in `folder` for the robot's hardware.
fn hardware(folder: &Path) -> PathBuf {
    let file = folder.join("it.toml").display().to_string();
    let scenario = Scenario::load(&file).expect("a scenario");
    let start = scenario.start;
    let config = SimConfig {
        start: [start.x_m, start.y_m, start.yaw_rad],
        world: scenario.world.clone(),
        robot: scenario.robot.clone(),
    };
    let path = folder.join("hardware.toml");
    let text = toml::to_string(&config).expect("TOML");
    std::fs::write(&path, text).expect("written");
    path
}

/// A program that says what happens to it, a JSON object a line.
pub struct Peer {
    process: Child,
    said: Arc<Mutex<Vec<Value>>>,
    reader: Option<JoinHandle<()>>,
}

impl Peer {
    /// Starts the script `name` in a domain of ROS 2.
    ///
    /// # Panics
    /// When it cannot be started.
    #[must_use]
    pub fn start(name: &str, domain_id: u32, arguments: &[&str]) -> Self {
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
    ///
    /// # Panics
    /// As [`Self::start`].
    #[must_use]
    pub fn robot(domain_id: u32, config: &Path, more: &[&str]) -> Self {
        let hardware = binaries().join("simulated_hardware");
        let hardware = hardware.display().to_string();
        let config = config.display().to_string();
        let arguments = [&[hardware.as_str(), &config], more].concat();
        Self::start("robot", domain_id, &arguments)
    }

    /// Tells it what to do.
    ///
    /// # Panics
    /// When it does not listen any more.
    pub fn order(&mut self, order: &Value) {
        let to = self.process.stdin.as_mut().expect("its input");
        writeln!(to, "{order}")
            .and_then(|()| to.flush())
            .expect("it listens");
    }

    /// All that it has said of this kind.
    ///
    /// # Panics
    /// When the thread that hears has panicked.
    #[must_use]
    pub fn said(&self, kind: &str) -> Vec<Value> {
        let said = self.said.lock().expect("the lines");
        said.iter()
            .filter(|it| it["kind"] == kind)
            .cloned()
            .collect()
    }

    /// The newest that it has said of this kind.
    ///
    /// # Panics
    /// As [`Self::said`].
    #[must_use]
    pub fn newest(&self, kind: &str) -> Option<Value> {
        let said = self.said.lock().expect("the lines");
        said.iter().rev().find(|it| it["kind"] == kind).cloned()
    }

    /// Waits until it says something of this kind that is as wanted.
    ///
    /// # Panics
    /// When it does not within a minute.
    #[allow(clippy::must_use_candidate, reason = "often it is only waited for")]
    pub fn wait_for(&self, kind: &str, wanted: impl Fn(&Value) -> bool) -> Value {
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
