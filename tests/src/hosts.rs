//! Two hosts on one machine: namespaces of the network, the way between them, and `zeronav` in each.

use crate::{Zeronav, command, shipped};
use serde_json::{Value, json};
use std::io::{BufRead, BufReader, Write};
use std::net::TcpListener;
use std::process::{Child, ChildStdout, Command, Stdio};
use std::sync::atomic::{AtomicU32, Ordering};

/// The program of the way.
const WAY: &str = include_str!("way.py");

/// Ways that this process has made.
static COUNT: AtomicU32 = AtomicU32::new(0);

/// The shipped scenario `name`, with the robot and its guard on one host and all else on the other, which listens at
/// `end`.
#[must_use]
pub fn scenario(name: &str, end: &str) -> String {
    let text = shipped(name);
    format!(
        "{text}\n\
         [hosts.robot]\nseats = [\"robot\", \"collision_guard\"]\n\
         [hosts.base]\nseats = [\"mapping\", \"global_planner\", \"local_planner\"]\nlisten = \"{end}\"\n"
    )
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
        let n = COUNT.fetch_add(1, Ordering::Relaxed);
        let names =
            ["robot", "base"].map(|side| format!("zeronav-{}-{n}-{side}", std::process::id()));
        let mut process = Command::new("python3")
            .args(["-c", WAY])
            .args([&names[0], "10.77.0.1/24", &names[1], "10.77.0.2/24"])
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
        let zeronav = command();
        let mut command = Command::new("ip");
        command.args(["netns", "exec", &self.names[side]]);
        command.arg(zeronav.get_program()).env_remove("CARGO");
        command
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
