//! The control socket of a run: one JSON object per line, asked and answered.
//!
//! It lies in the domain's root folder, which only the same user can enter.

use serde::{Deserialize, Serialize};
use std::io::{BufRead, BufReader, Read, Write};
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::Path;
use std::time::Duration;

/// File name of the socket in the domain's root folder.
pub const SOCKET: &str = "control.sock";

/// Longest request line. [bytes]
const LINE_BYTES_MAX: u64 = 64 * 1024;

/// How long an asker waits for an answer.
const PATIENCE: Duration = Duration::from_secs(5);

/// What can be asked of a run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "command", rename_all = "snake_case", deny_unknown_fields)]
pub enum Request {
    /// The run and its processes.
    Ps,
    /// Drive to this pose now.
    Goal {
        /// `[x, y, yaw]`. [m, m, rad]
        pose: [f64; 3],
        /// How close counts. [m]
        tolerance_m: f64,
        /// How close the yaw must be; pi or more takes any. [rad]
        yaw_tolerance_rad: f64,
    },
}

/// One process of a run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ServiceReport {
    /// Its seat.
    pub role: String,
    /// Its process id.
    pub pid: u32,
    /// Which start of the seat it is.
    pub epoch: u32,
    /// What its heartbeat says.
    pub state: String,
    /// Its progress counter.
    pub progress: u64,
    /// Largest resident memory. [bytes]
    pub memory_peak_bytes: u64,
    /// File name of its binary.
    pub binary: String,
}

/// A run and its processes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RunReport {
    /// Its scenario.
    pub scenario: String,
    /// Its domain.
    pub domain: String,
    /// Process id of launch.
    pub pid: u32,
    /// `real_time` or `lockstep`.
    pub mode: String,
    /// Run time. [s]
    pub time_s: f64,
    /// State of the task.
    pub task: String,
    /// Its processes.
    pub services: Vec<ServiceReport>,
}

/// The answer to a request.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Reply {
    /// The answer to [`Request::Ps`].
    Run(RunReport),
    /// Done.
    Done,
    /// Not done, and why.
    Error(String),
}

/// The run's end of the socket.
#[derive(Debug)]
pub struct Server {
    listener: UnixListener,
}

impl Server {
    /// Opens the socket in `root`.
    ///
    /// # Errors
    /// What the system says.
    pub fn open(root: &Path) -> std::io::Result<Self> {
        let listener = UnixListener::bind(root.join(SOCKET))?;
        listener.set_nonblocking(true)?;
        Ok(Self { listener })
    }

    /// Answers whoever has asked since the last call. A silent or endless asker costs at most
    /// 100 ms and 64 kB.
    pub fn serve(&self, mut answer: impl FnMut(Request) -> Reply) {
        while let Ok((stream, _)) = self.listener.accept() {
            let _ = serve_one(&stream, &mut answer);
        }
    }
}

fn serve_one(
    stream: &UnixStream,
    answer: &mut impl FnMut(Request) -> Reply,
) -> std::io::Result<()> {
    stream.set_nonblocking(false)?;
    stream.set_read_timeout(Some(Duration::from_millis(100)))?;
    stream.set_write_timeout(Some(Duration::from_millis(100)))?;
    let mut line = String::new();
    BufReader::new(stream)
        .take(LINE_BYTES_MAX)
        .read_line(&mut line)?;
    let reply = match serde_json::from_str(&line) {
        Ok(request) => answer(request),
        Err(error) => Reply::Error(format!("not a request: {error}")),
    };
    let mut text = serde_json::to_string(&reply).map_err(std::io::Error::other)?;
    text.push('\n');
    let mut stream = stream;
    stream.write_all(text.as_bytes())
}

/// Asks the run in `root`.
///
/// # Errors
/// What the system says, or an answer that is none.
pub fn ask(root: &Path, request: &Request) -> std::io::Result<Reply> {
    let mut stream = UnixStream::connect(root.join(SOCKET))?;
    stream.set_read_timeout(Some(PATIENCE))?;
    stream.set_write_timeout(Some(PATIENCE))?;
    let mut text = serde_json::to_string(request).map_err(std::io::Error::other)?;
    text.push('\n');
    stream.write_all(text.as_bytes())?;
    let mut line = String::new();
    BufReader::new(&stream).take(1 << 20).read_line(&mut line)?;
    serde_json::from_str(&line).map_err(std::io::Error::other)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn requests_and_bad_lines_get_one_answer_each() {
        let folder = std::env::temp_dir().join(format!("zeronav-control-{}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("a temporary folder");
        let server = Server::open(&folder).expect("a socket");
        let asked = folder.clone();
        let asker = std::thread::spawn(move || {
            let good = ask(
                &asked,
                &Request::Goal {
                    pose: [1.0, 2.0, 0.0],
                    tolerance_m: 0.2,
                    yaw_tolerance_rad: 0.1,
                },
            );
            let mut stream = UnixStream::connect(asked.join(SOCKET)).expect("a connection");
            stream
                .write_all(b"{\"command\":\"fly\"}\n")
                .expect("written");
            let mut line = String::new();
            BufReader::new(&stream)
                .read_line(&mut line)
                .expect("an answer");
            (good, line)
        });
        let mut seen = Vec::new();
        while !asker.is_finished() {
            server.serve(|request| {
                seen.push(request);
                Reply::Done
            });
            std::thread::yield_now();
        }
        let (good, bad) = asker.join().expect("the asker ends");
        assert_eq!(good.expect("an answer"), Reply::Done);
        assert!(bad.contains("not a request"), "{bad}");
        assert_eq!(
            seen,
            [Request::Goal {
                pose: [1.0, 2.0, 0.0],
                tolerance_m: 0.2,
                yaw_tolerance_rad: 0.1,
            }]
        );
        std::fs::remove_dir_all(&folder).expect("removed");
    }
}
