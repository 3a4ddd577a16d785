//! What it costs to be watched: runs with and without a live page, in turn.

use super::bench::{Bench, Measured};
use super::extract::table;
use super::rounds;
use super::spread::Figure;
use crate::browser::Browser;
use crate::processes::domains_of;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Rounds; in each every condition has a run, and each begins one in turn.
const ROUNDS: usize = 5;

/// How long a stack, and a page, may take to be there.
const START_LIMIT: Duration = Duration::from_secs(30);

/// Ticks of the kernel's counters in a second, on every Linux that Rust supports.
const TICKS_PER_S: f64 = 100.0;

/// Who watches.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Watched {
    /// There is no viewer.
    No,
    /// By so many clients of a viewer that read what they are sent as fast as they can; of more than
    /// one the last never reads.
    ByClients(usize),
    /// By a page in Chromium, which draws in software.
    InBrowser,
}

const CONDITIONS: [(Watched, &str); 5] = [
    (Watched::No, "no viewer"),
    (Watched::ByClients(0), "a viewer, nobody looks"),
    (Watched::ByClients(1), "one client"),
    (Watched::ByClients(10), "ten clients, one of them stalled"),
    (
        Watched::InBrowser,
        "a page in Chromium without a screen or a GPU",
    ),
];

/// Medians, ratios to the run of the same round without a viewer, and the viewer's processor time.
pub(super) fn viewers(bench: &mut Bench) -> Result<Measured, String> {
    let names = CONDITIONS.map(|(_, name)| name);
    let mut loads: [Vec<f64>; CONDITIONS.len()] = Default::default();
    let mut rows = rounds::in_turn(ROUNDS, &names, |at| {
        let watched = CONDITIONS[at].0;
        let arguments = ["run", "blocked_aisle", "--trials", "20"];
        let (result, watchers) =
            bench.zeronav_beside(&arguments, |binaries, pid| match watched {
                Watched::No => Ok(None),
                _ => Watchers::start(binaries, pid, watched).map(Some),
            })?;
        loads[at].extend(watchers.map(Watchers::load).transpose()?);
        Ok(result)
    })?;
    for (row, loads) in rows.iter_mut().zip(&loads) {
        row.figures.push(Figure::median(loads));
    }
    let columns = [&rounds::COLUMNS[..], &["viewer [cores]"]].concat();
    Ok(Measured::tables(vec![table("watched by", &columns, rows)]))
}

/// A viewer and those who look at it.
struct Watchers {
    viewer: Child,
    /// The processor time that it had taken when it was seen last, over the time until then.
    load: JoinHandle<Option<f64>>,
    /// They end with the viewer.
    _clients: Vec<TcpStream>,
    _browser: Option<Browser>,
}

impl Watchers {
    fn start(binaries: &Path, run_pid: u32, watched: Watched) -> Result<Self, String> {
        let root = await_domain(run_pid)?;
        let mut viewer = Command::new(binaries.join("zeronav"))
            .args(["view", "--view-only", "--domain"])
            .arg(root)
            .env_remove("CARGO")
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .spawn()
            .map_err(|error| format!("zeronav view: {error}"))?;
        let mut link = String::new();
        if let Some(output) = viewer.stdout.take() {
            let read = BufReader::new(output).read_line(&mut link);
            read.map_err(|error| format!("zeronav view: {error}"))?;
        }
        let link = link.trim().to_owned();
        let host = link.trim_start_matches("http://").trim_end_matches('/');
        let mut clients = Vec::new();
        if let Watched::ByClients(n) = watched {
            for at in 0..n {
                let stream = look(host).map_err(|error| format!("{link}: {error}"))?;
                if at > 0 && at + 1 == n {
                    clients.push(stream);
                } else {
                    std::thread::spawn(move || drain(stream));
                }
            }
        }
        let pid = viewer.id();
        Ok(Self {
            viewer,
            load: std::thread::spawn(move || load_of(pid)),
            _clients: clients,
            _browser: (watched == Watched::InBrowser).then(|| Browser::open(&link)),
        })
    }

    /// Of the viewer, which has ended with the run. [cores]
    fn load(mut self) -> Result<f64, String> {
        let ended = self.viewer.wait();
        let status = ended.map_err(|error| format!("zeronav view: {error}"))?;
        if !status.success() {
            return Err(format!("zeronav view: {status}"));
        }
        let load = self.load.join().ok().flatten();
        load.ok_or_else(|| "the viewer's processor time is not known".to_owned())
    }
}

/// The domain of a run, once its robot is there.
fn await_domain(pid: u32) -> Result<PathBuf, String> {
    let began = Instant::now();
    while began.elapsed() < START_LIMIT {
        if let Some(root) = domains_of(pid).pop() {
            return Ok(root);
        }
        std::thread::sleep(Duration::from_millis(20));
    }
    Err("the stack does not start".to_owned())
}

/// Asks a viewer for its stream.
fn look(host: &str) -> std::io::Result<TcpStream> {
    let mut stream = TcpStream::connect(host)?;
    write!(
        stream,
        "GET /stream HTTP/1.1\r\nHost: {host}\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n\
         Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n"
    )?;
    Ok(stream)
}

fn drain(mut stream: TcpStream) {
    let mut bytes = vec![0; 1 << 16];
    while stream.read(&mut bytes).is_ok_and(|n| n > 0) {}
}

/// Processor time of a process over wall time, until it ends. [cores]
fn load_of(pid: u32) -> Option<f64> {
    let began = Instant::now();
    let mut load = None;
    while let Some(ticks) = processor_ticks(pid) {
        let elapsed_s = began.elapsed().as_secs_f64();
        if elapsed_s > 0.0 {
            load = Some(ticks / TICKS_PER_S / elapsed_s);
        }
        std::thread::sleep(Duration::from_millis(500));
    }
    load
}

/// User and system time; `None` when there is no such process, or it has ended. [ticks]
fn processor_ticks(pid: u32) -> Option<f64> {
    let stat = std::fs::read_to_string(format!("/proc/{pid}/stat")).ok()?;
    // The name in parentheses may hold anything; after it come the state and ten other words.
    let rest = stat.rsplit(") ").next()?;
    let words: Vec<&str> = rest.split(' ').collect();
    if words.first() == Some(&"Z") {
        return None;
    }
    let number = |at: usize| words.get(at)?.parse::<f64>().ok();
    Some(number(11)? + number(12)?)
}
