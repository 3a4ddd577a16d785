//! What the system tests share: the real `zeronav`, run like a user would, with a watchdog.
//!
//! Every run has a domain and a working folder of its own, so tests run side by side and beside a
//! live stack. Runs in real time take turns, so that they leave each other the processors.

pub mod browser;
mod built;
#[path = "../data/folder.rs"]
pub mod data;
pub mod faults;
pub mod generated;
pub mod hosts;
mod processes;
pub mod python;
pub mod results;
pub mod rooms;
pub mod ros2;
mod said;
pub mod seats;
pub mod structure;
pub mod trace;
pub mod tracker_bench;
mod turns;
pub mod up;

pub use built::{background, binaries, command, copy_binary, executable, quick_profile, workspace};
pub use processes::{children_of, domains_of, services_of};
use rustix::process::{Pid, Signal, kill_process};
use serde_json::Value;
use std::fs::File;
use std::io::{BufRead, BufReader, Read, Seek, SeekFrom, Write};
use std::os::unix::net::UnixStream;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};
pub use turns::{Turn, quiet_turn, real_time_turn};

/// No run of a test takes longer; one that does hangs. Runs in lockstep have only what processor
/// time the others leave.
pub const WATCHDOG: Duration = Duration::from_secs(600);

/// What has not happened by then, on a machine with many tests beside it, never will.
const STRANGER_LIMIT: Duration = Duration::from_secs(60);

/// The text of a shipped scenario.
///
/// # Panics
/// When there is none of this name.
#[must_use]
pub fn shipped(name: &str) -> String {
    let file = workspace().join(format!("launch/scenarios/{name}.toml"));
    std::fs::read_to_string(&file).unwrap_or_else(|error| panic!("{}: {error}", file.display()))
}

/// Checks the `latency` of a run: no stamp before its predecessor, no record missing, and the robot's
/// second clock agrees with the hops.
///
/// # Panics
/// When it does not.
pub fn assert_latencies_add_up(latency: &Value) {
    let disorder = latency["hops_out_of_order"].as_object().expect("hops");
    assert_eq!(disorder.len(), 11, "{latency:#}");
    assert!(disorder.values().all(|n| n == 0), "{disorder:?}");
    assert!(latency["ways"].as_u64() > Some(20), "{latency:#}");
    assert_eq!(latency["ways_broken"], 0, "{latency:#}");
    let clock = &latency["second_clock"];
    assert_eq!(clock["end_to_end"]["n"], latency["ways"], "{clock:#}");
    assert_eq!(clock["beyond"], 0, "{clock:#}");
}

/// A started `zeronav`. Dropping it ends it.
#[derive(Debug)]
pub struct Zeronav {
    process: Child,
    stdout: File,
    stderr: File,
    /// Its working folder; `runs/` lies there.
    pub folder: tempfile::TempDir,
    started: Instant,
    _place: Option<turns::Place>,
}

/// A `zeronav` that has ended.
#[derive(Debug)]
pub struct Ended {
    /// How.
    pub status: ExitStatus,
    /// What it wrote for machines.
    pub stdout: String,
    /// What it wrote for people.
    pub stderr: String,
    /// Its working folder; `runs/` lies there.
    pub folder: tempfile::TempDir,
}

impl Zeronav {
    /// Starts `zeronav` with these arguments in a new working folder.
    ///
    /// # Panics
    /// When it cannot be started.
    #[must_use]
    pub fn start(arguments: &[&str]) -> Self {
        let folder = tempfile::tempdir().expect("a working folder");
        Self::start_in(folder, arguments)
    }

    /// Starts `zeronav` in a folder that holds what the test wrote there.
    ///
    /// # Panics
    /// When it cannot be started.
    #[must_use]
    pub fn start_in(folder: tempfile::TempDir, arguments: &[&str]) -> Self {
        let is_suite = arguments.first() == Some(&"suite");
        let needs_no_clock = is_suite || arguments.contains(&"--lockstep");
        let place = (needs_no_clock && !turns::has_turn()).then(turns::background_place);
        let command = if place.is_some() {
            built::background_command()
        } else {
            command()
        };
        Self::spawn(command, folder, arguments, place)
    }

    /// Starts it by a command that needs no more than the arguments.
    ///
    /// # Panics
    /// When it cannot be started.
    #[must_use]
    pub fn start_by(command: Command, folder: tempfile::TempDir, arguments: &[&str]) -> Self {
        Self::spawn(command, folder, arguments, None)
    }

    fn spawn(
        mut command: Command,
        folder: tempfile::TempDir,
        arguments: &[&str],
        place: Option<turns::Place>,
    ) -> Self {
        let stdout = tempfile::tempfile().expect("a file");
        let stderr = tempfile::tempfile().expect("a file");
        let process = command
            .args(arguments)
            .current_dir(folder.path())
            .stdin(Stdio::null())
            .stdout(stdout.try_clone().expect("a handle"))
            .stderr(stderr.try_clone().expect("a handle"))
            .spawn()
            .expect("zeronav starts");
        Self {
            process,
            stdout,
            stderr,
            folder,
            started: Instant::now(),
            _place: place,
        }
    }

    /// Its process id.
    #[must_use]
    pub fn pid(&self) -> u32 {
        self.process.id()
    }

    /// Sends it a signal.
    ///
    /// # Panics
    /// When it is gone.
    pub fn signal(&self, signal: Signal) {
        let pid = i32::try_from(self.pid())
            .ok()
            .and_then(Pid::from_raw)
            .expect("a process id");
        kill_process(pid, signal).expect("zeronav is there");
    }

    /// Its services: process id and command line. A child that was forked and does not run its
    /// service's program yet is none: it still has the command line of zeronav.
    #[must_use]
    pub fn children(&self) -> Vec<(u32, String)> {
        services_of(self.pid())
    }

    /// Process id of the service in the seat of `role`, as the run itself says.
    #[must_use]
    pub fn service(&self, role: &str) -> Option<u32> {
        let report = self.report()?;
        let services = report["services"].as_array()?;
        let seat = services.iter().find(|service| service["role"] == role)?;
        u32::try_from(seat["pid"].as_u64()?).ok()
    }

    /// Root folders of the domains that it made.
    #[must_use]
    pub fn domains(&self) -> Vec<PathBuf> {
        domains_of(self.pid())
    }

    /// What the run says of itself on its control socket; `None` before it listens.
    ///
    /// # Panics
    /// Never: whatever goes wrong is `None`.
    #[must_use]
    pub fn report(&self) -> Option<Value> {
        report_of(self.pid())
    }

    /// True once it has ended.
    pub fn has_ended(&mut self) -> bool {
        self.process.try_wait().is_ok_and(|status| status.is_some())
    }

    /// Waits until `condition` holds, looking every 5 ms.
    ///
    /// # Panics
    /// When it has not within the watchdog's time, or when zeronav has ended before.
    pub fn wait_until(&mut self, what: &str, mut condition: impl FnMut(&Self) -> bool) {
        while !condition(self) {
            if let Ok(Some(status)) = self.process.try_wait() {
                panic!(
                    "zeronav ended ({status}) before {what}:\n{}",
                    read(&mut self.stderr)
                );
            }
            assert!(
                self.started.elapsed() < WATCHDOG,
                "waited too long until {what}"
            );
            std::thread::sleep(Duration::from_millis(5));
        }
    }

    /// Waits for its end.
    ///
    /// # Panics
    /// When it has not ended within the watchdog's time.
    #[must_use]
    pub fn finish(mut self) -> Ended {
        let status = loop {
            if let Some(status) = self.process.try_wait().expect("its state") {
                break status;
            }
            if self.started.elapsed() > WATCHDOG {
                let _ = self.process.kill();
                panic!("zeronav hangs; it said:\n{}", read(&mut self.stderr));
            }
            std::thread::sleep(Duration::from_millis(5));
        };
        let folder = std::mem::replace(&mut self.folder, tempfile::tempdir().expect("a folder"));
        Ended {
            status,
            stdout: read(&mut self.stdout),
            stderr: read(&mut self.stderr),
            folder,
        }
    }
}

impl Drop for Zeronav {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

impl Ended {
    /// Its exit code.
    ///
    /// # Panics
    /// When a signal ended it.
    #[must_use]
    pub fn code(&self) -> i32 {
        self.status
            .code()
            .unwrap_or_else(|| panic!("ended by a signal: {}", self.stderr))
    }

    /// The object on its standard output.
    ///
    /// # Panics
    /// When there is none.
    #[must_use]
    pub fn json(&self) -> Value {
        serde_json::from_str(&self.stdout)
            .unwrap_or_else(|error| panic!("no JSON ({error}): {}\n{}", self.stdout, self.stderr))
    }

    /// The object, after the exit code was compared.
    ///
    /// # Panics
    /// When the exit code is another or there is no object.
    #[must_use]
    pub fn expect(&self, code: i32) -> Value {
        assert_eq!(self.code(), code, "{}\n{}", self.stdout, self.stderr);
        self.json()
    }
}

/// Runs `zeronav` with these arguments to its end.
#[must_use]
pub fn zeronav(arguments: &[&str]) -> Ended {
    Zeronav::start(arguments).finish()
}

/// A service that the test itself starts. Dropping it ends it.
#[derive(Debug)]
pub struct Stranger {
    process: Child,
    stderr: File,
}

impl Stranger {
    /// Starts the program `binary` in the domain `root` with these flags more.
    ///
    /// # Panics
    /// When it cannot be started.
    #[must_use]
    pub fn start(binary: &str, root: &Path, flags: &[&str]) -> Self {
        let stderr = tempfile::tempfile().expect("a file");
        let examples = binaries().join("examples");
        let is_example = built::EXAMPLES.contains(&binary);
        let folder = if is_example { &examples } else { binaries() };
        let process = Command::new(folder.join(binary))
            .arg("--domain")
            .arg(root)
            .args(flags)
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(stderr.try_clone().expect("a handle"))
            .spawn()
            .expect("the service starts");
        Self { process, stderr }
    }

    /// Its process id.
    #[must_use]
    pub fn pid(&self) -> u32 {
        self.process.id()
    }

    /// True while it runs.
    pub fn runs(&mut self) -> bool {
        self.process.try_wait().is_ok_and(|status| status.is_none())
    }

    /// What it has logged.
    pub fn log(&mut self) -> String {
        read(&mut self.stderr)
    }

    /// Waits until it has ended by itself: its exit code and what it logged.
    ///
    /// # Panics
    /// When it stays, or when a signal ended it.
    #[must_use]
    pub fn left(mut self) -> (i32, String) {
        let started = Instant::now();
        while self.runs() {
            assert!(
                started.elapsed() < STRANGER_LIMIT,
                "the service stays: {}",
                self.log()
            );
            std::thread::sleep(Duration::from_millis(5));
        }
        let status = self.process.wait().expect("its end");
        let log = self.log();
        let code = status
            .code()
            .unwrap_or_else(|| panic!("ended by a signal: {log}"));
        (code, log)
    }
}

impl Drop for Stranger {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

/// Sends `signal` to a process; false when it is gone.
#[must_use]
pub fn send_signal(pid: u32, signal: Signal) -> bool {
    let pid = i32::try_from(pid).ok().and_then(Pid::from_raw);
    pid.is_some_and(|pid| kill_process(pid, signal).is_ok())
}

/// What the run of this launch says of itself; `None` before it listens.
#[must_use]
pub fn report_of(pid: u32) -> Option<Value> {
    let root = domains_of(pid).pop()?;
    let mut stream = UnixStream::connect(root.join("control.sock")).ok()?;
    stream.set_read_timeout(Some(Duration::from_secs(5))).ok()?;
    stream.write_all(b"{\"command\":\"ps\"}\n").ok()?;
    let mut line = String::new();
    BufReader::new(&stream).read_line(&mut line).ok()?;
    let reply: Value = serde_json::from_str(&line).ok()?;
    reply.get("run").cloned()
}

/// True while a process with this id runs (a zombie does not).
#[must_use]
pub fn is_alive(pid: u32) -> bool {
    std::fs::read_to_string(format!("/proc/{pid}/stat"))
        .is_ok_and(|stat| !stat.rsplit(") ").next().unwrap_or("").starts_with('Z'))
}

/// Waits for what must happen by itself; prints how long it took.
///
/// # Panics
/// When it takes longer than a minute.
pub fn await_by_itself(what: &str, mut condition: impl FnMut() -> bool) {
    let started = Instant::now();
    while !condition() {
        assert!(
            started.elapsed() < STRANGER_LIMIT,
            "waited too long until {what}"
        );
        std::thread::sleep(Duration::from_millis(1));
    }
    eprintln!("{what} after {:?}", started.elapsed());
}

/// Everything in /dev/shm that belongs to the domain with this root folder.
#[must_use]
pub fn leftovers(root: &Path) -> Vec<PathBuf> {
    let prefix = root
        .file_name()
        .and_then(|name| name.to_str())
        .unwrap_or("?")
        .to_owned();
    std::fs::read_dir("/dev/shm")
        .into_iter()
        .flatten()
        .flatten()
        .filter(|entry| {
            entry
                .file_name()
                .to_str()
                .is_some_and(|name| name.starts_with(&prefix))
        })
        .map(|entry| entry.path())
        .collect()
}

fn read(file: &mut File) -> String {
    let mut bytes = Vec::new();
    let _ = file.seek(SeekFrom::Start(0));
    let _ = file.read_to_end(&mut bytes);
    String::from_utf8_lossy(&bytes).into_owned()
}
