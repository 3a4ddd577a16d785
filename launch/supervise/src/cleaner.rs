//! Has the registry of a domain cleaned after a death, without waiting for it.
//!
//! The cleaning itself is this program again, started as `zeronav clean ROOT`. Files that are corrupt
//! or lie on a slow disk may block or kill that process; launch only looks whether it has ended, and
//! kills it when its time is over.

use super::own_time::Patience;
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

/// Name of the subcommand.
pub const COMMAND: &str = "clean";

/// How long one cleaning may take, of its own time: one that gets no processor is not stuck.
const CLEANING_LIMIT: Duration = Duration::from_secs(1);

/// How long it may take in any case.
const WALL_LIMIT: Duration = Duration::from_secs(60);

/// A cleaning that was asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Ticket(u64);

/// See the module's description. Dropping it ends a cleaning that is under way.
#[derive(Debug)]
pub struct Cleaner {
    root: PathBuf,
    asked: Ticket,
    done: Ticket,
    under_way: Option<UnderWay>,
    /// Killed and not gone yet.
    killed: Vec<Child>,
    failed: bool,
}

/// A process that cleans.
#[derive(Debug)]
struct UnderWay {
    process: Child,
    since: Instant,
    patience: Patience,
    /// The last cleaning that was asked for when it was started.
    serves: Ticket,
}

impl UnderWay {
    /// True when it has taken too long.
    fn is_over(&mut self) -> bool {
        self.patience.is_over(CLEANING_LIMIT) || self.since.elapsed() > WALL_LIMIT
    }
}

impl Cleaner {
    /// A cleaner of the domain at `root`, with nothing to do.
    #[must_use]
    pub fn new(root: &Path) -> Self {
        Self {
            root: root.to_owned(),
            asked: Ticket(0),
            done: Ticket(0),
            under_way: None,
            killed: Vec::new(),
            failed: false,
        }
    }

    /// Asks for a cleaning that begins from now on.
    pub fn ask(&mut self) -> Ticket {
        self.asked.0 += 1;
        let ticket = self.asked;
        self.look();
        ticket
    }

    /// True once that cleaning has ended, in whatever way: one look, no waiting.
    pub fn is_done(&mut self, ticket: Ticket) -> bool {
        self.look();
        self.done >= ticket
    }

    /// True when a cleaning was killed or could not remove everything: files of the domain may be
    /// corrupt.
    #[must_use]
    pub fn has_failed(&self) -> bool {
        self.failed || self.done < self.asked
    }

    fn look(&mut self) {
        self.killed
            .retain_mut(|process| matches!(process.try_wait(), Ok(None)));
        if let Some(mut under_way) = self.under_way.take() {
            let failure = match under_way.process.try_wait() {
                Ok(Some(status)) => failure(status),
                Ok(None) if !under_way.is_over() => {
                    self.under_way = Some(under_way);
                    return;
                }
                Ok(None) => {
                    let _ = under_way.process.kill();
                    self.killed.push(under_way.process);
                    Some(format!("not done after {CLEANING_LIMIT:?}, killed"))
                }
                Err(error) => Some(error.to_string()),
            };
            self.end(under_way.serves, failure);
        }
        if self.done < self.asked {
            let serves = self.asked;
            match start(&self.root) {
                Ok(process) => {
                    self.under_way = Some(UnderWay {
                        patience: Patience::with(process.id()),
                        process,
                        since: Instant::now(),
                        serves,
                    });
                }
                Err(error) => self.end(serves, Some(error.to_string())),
            }
        }
    }

    fn end(&mut self, ticket: Ticket, failure: Option<String>) {
        self.done = ticket;
        if let Some(why) = failure {
            self.failed = true;
            let root = self.root.display();
            tracing::warn!(%root, why, "what a dead service left was not removed");
        }
    }
}

impl Drop for Cleaner {
    fn drop(&mut self) {
        let under_way = self.under_way.take().map(|under_way| under_way.process);
        for mut process in self.killed.drain(..).chain(under_way) {
            let _ = process.kill();
            let deadline = Instant::now() + CLEANING_LIMIT;
            while matches!(process.try_wait(), Ok(None)) && Instant::now() < deadline {
                std::thread::sleep(Duration::from_millis(1));
            }
        }
    }
}

/// Why a cleaning that has ended did not succeed.
fn failure(status: ExitStatus) -> Option<String> {
    (!status.success()).then(|| status.to_string())
}

fn start(root: &Path) -> std::io::Result<Child> {
    Command::new("/proc/self/exe")
        .arg(COMMAND)
        .arg(root)
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        // What the terminal sends to launch's group is not meant for it.
        .process_group(0)
        .spawn()
}

/// The cleaning itself; true when everything was removed.
#[must_use]
pub fn run(root: &Path) -> bool {
    let kill = Some(rustix::process::Signal::KILL);
    let _ = rustix::process::set_parent_process_death_signal(kill);
    zeronav_shell::cleaning::clean(root).is_ok()
}
