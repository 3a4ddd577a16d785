//! Two hosts on one machine: namespaces of the network, the way between them, and `zeronav` in each.

use crate::{Zeronav, command, shipped};
use serde_json::{Value, json};
use std::io::{BufRead, BufReader, Write};
use std::net::TcpListener;
use std::path::Path;
use std::process::{Child, ChildStdout, Command, Stdio};
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::SystemTime;
use zeronav_msgs::role::Role;

/// The program of the way.
const WAY: &str = include_str!("way.py");

/// Ways that this process has made.
static COUNT: AtomicU32 = AtomicU32::new(0);

/// The shipped scenario `name`, with the robot and its guard on one host and all else on the other, which listens at
/// `end`.
#[must_use]
pub fn scenario(name: &str, end: &str) -> String {
    split(name, &["mapping", "global_planner", "local_planner"], end)
}

/// The shipped scenario `name`, with these seats on the base, which listens at `end`, and the others on the robot. Where
/// that is one of TLS, the keys are in the folder `keys` beside the scenario.
#[must_use]
pub fn split(name: &str, on_base: &[&str], end: &str) -> String {
    let text = shipped(name);
    let seats = Role::SERVICES.map(Role::label).into_iter();
    let on_robot: Vec<&str> = seats.filter(|seat| !on_base.contains(seat)).collect();
    let keys = if end.starts_with("tls/") {
        "keys = \"keys\"\n"
    } else {
        ""
    };
    format!(
        "{text}\n[hosts.robot]\nseats = {on_robot:?}\n{keys}\
         [hosts.base]\nseats = {on_base:?}\nlisten = \"{end}\"\n{keys}"
    )
}

/// Makes keys for both hosts of this computer in the new folder.
///
/// # Panics
/// When `zeronav link keys` does not.
pub fn make_keys(folder: &Path) {
    let mut command = command();
    command.args(["link", "keys"]).arg(folder);
    command.args(["robot=127.0.0.1", "base=127.0.0.1"]);
    let made = command.output().expect("zeronav starts");
    assert!(
        made.status.success(),
        "{}",
        String::from_utf8_lossy(&made.stderr)
    );
}

/// An end on this computer that nobody listens at.
///
/// # Panics
/// When there is no port.
#[must_use]
pub fn free_end() -> String {
    let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
    format!("tcp/{}", listener.local_addr().expect("its address"))
}

/// Two network namespaces with a way between them that is as bad as asked.
#[derive(Debug)]
pub struct Way {
    process: Child,
    said: BufReader<ChildStdout>,
    names: [String; 2],
}

impl Way {
    /// Makes it.
    ///
    /// # Panics
    /// When this user may not make network namespaces, which is the administrator's right: CI runs as such.
    #[must_use]
    pub fn new() -> Self {
        Self::with(&[])
    }

    /// Makes one of a pair of the kernel's devices, which is always good and costs nothing.
    ///
    /// # Panics
    /// As [`Self::new`].
    #[must_use]
    pub fn plain() -> Self {
        Self::with(&["--plain"])
    }

    fn with(flags: &[&str]) -> Self {
        let n = COUNT.fetch_add(1, Ordering::Relaxed);
        let names =
            ["robot", "base"].map(|side| format!("zeronav-{}-{n}-{side}", std::process::id()));
        let mut process = Command::new("python3")
            .args(["-c", WAY])
            .args([&names[0], "10.77.0.1/24", &names[1], "10.77.0.2/24"])
            .args(flags)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .expect("python3 starts");
        let stdout = process.stdout.take().expect("its output");
        let mut way = Self {
            process,
            said: BufReader::new(stdout),
            names,
        };
        way.await_word("ready");
        way
    }

    fn await_word(&mut self, word: &str) {
        let mut line = String::new();
        self.said.read_line(&mut line).expect("a line");
        assert_eq!(
            line.trim(),
            word,
            "network namespaces need the administrator's rights, `ip` (iproute2) and /dev/net/tun"
        );
    }

    /// From now on it is like this, see `way.py`.
    ///
    /// # Panics
    /// When it is gone.
    pub fn set(&mut self, how: &Value) {
        let stdin = self.process.stdin.as_mut().expect("its input");
        writeln!(stdin, "{how}").expect("written");
        self.await_word("done");
    }

    /// A perfect way again.
    pub fn mend(&mut self) {
        self.set(&json!({}));
    }

    /// Where the base listens.
    #[must_use]
    pub fn end() -> &'static str {
        "tcp/10.77.0.2:7447"
    }

    /// `zeronav` on one of the two hosts: 0 the robot's, 1 the base.
    #[must_use]
    pub fn zeronav(&self, side: usize) -> Command {
        inside(&self.names[side], &command())
    }

    /// Names of the two namespaces: that of the robot and that of the base.
    #[must_use]
    pub fn names(&self) -> &[String; 2] {
        &self.names
    }
}

/// This command in a network namespace, without cargo and in this process's folder.
#[must_use]
pub fn inside(namespace: &str, command: &Command) -> Command {
    under("ip", &["netns", "exec", namespace], command)
}

/// This command as the rest of another one, without cargo and in this process's folder.
fn under(program: &str, arguments: &[&str], command: &Command) -> Command {
    let mut under = Command::new(program);
    under.args(arguments);
    under.arg(command.get_program()).args(command.get_args());
    under.env_remove("CARGO");
    under
}

/// The clocks of another computer: one that goes on is 5,000 s ahead, and the time of day can be set.
#[derive(Debug)]
pub struct OtherClock(tempfile::TempDir);

impl OtherClock {
    /// Makes them.
    ///
    /// # Panics
    /// Without a C compiler.
    #[must_use]
    pub fn new() -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        let source = folder.path().join("set_clock.c");
        std::fs::write(&source, include_str!("set_clock.c")).expect("written");
        let mut compile = Command::new("cc");
        compile.args(["-shared", "-fPIC", "-o"]);
        compile.arg(folder.path().join("set_clock.so")).arg(&source);
        assert!(compile.status().expect("cc starts").success());
        Self(folder)
    }

    /// This command on that computer, which is the administrator's right.
    #[must_use]
    pub fn of(&self, command: &Command) -> Command {
        let mut of = under("unshare", &["--time", "--monotonic", "5000"], command);
        of.env("LD_PRELOAD", self.0.path().join("set_clock.so"));
        of.env("ZERONAV_SET_CLOCK", self.0.path().join("set"));
        of
    }

    /// Sets its time of day an hour ahead.
    ///
    /// # Panics
    /// When it is not.
    pub fn set(&self) {
        std::fs::write(self.0.path().join("set"), "").expect("written");
        let mut date = Command::new("date");
        let said = self.of(date.arg("+%s")).output().expect("date starts");
        let said = String::from_utf8_lossy(&said.stdout).trim().parse::<u64>();
        let here = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH);
        let ahead_s = said
            .expect("seconds")
            .saturating_sub(here.expect("after 1970").as_secs());
        assert!((3590..3610).contains(&ahead_s), "{ahead_s} s ahead");
    }
}

impl Default for OtherClock {
    fn default() -> Self {
        Self::new()
    }
}

impl Default for Way {
    fn default() -> Self {
        Self::new()
    }
}

impl Drop for Way {
    fn drop(&mut self) {
        // It ends, and removes the namespaces, when nobody writes any more.
        drop(self.process.stdin.take());
        let _ = self.process.wait();
    }
}

/// Starts `zeronav` by this command in a folder with `scenario.toml` and the folder of keys.
///
/// # Panics
/// When those cannot be put there.
#[must_use]
pub fn start_with_keys(
    command: Command,
    scenario: &str,
    keys: &Path,
    arguments: &[&str],
) -> Zeronav {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("scenario.toml"), scenario).expect("written");
    std::os::unix::fs::symlink(keys, folder.path().join("keys")).expect("a link");
    Zeronav::start_by(command, folder, arguments)
}

/// What the link of a host has logged so far.
#[must_use]
pub fn link_log(host: &Zeronav) -> String {
    let runs = std::fs::read_dir(host.folder.path().join("runs"));
    let logs = runs.into_iter().flatten().flatten().map(|run| {
        let log = run.path().join("logs/link.log");
        std::fs::read_to_string(log).unwrap_or_default()
    });
    logs.collect()
}

/// Starts `zeronav` by this command in a folder with `scenario.toml`.
///
/// # Panics
/// When that cannot be written.
#[must_use]
pub fn start(command: Command, scenario: &str, arguments: &[&str]) -> Zeronav {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("scenario.toml"), scenario).expect("written");
    Zeronav::start_by(command, folder, arguments)
}
