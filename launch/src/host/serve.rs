//! A host that fills its seats for the launch of another one, run after run, until it is interrupted.

use super::filled::Filled;
use crate::configs;
use crate::on_host::{LINK, LINK_PROGRAM};
use crate::prepare::Prepared;
use rustix::process::Signal;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::Stdio;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};
use zeronav_console::terminal::{complain, note};
use zeronav_msgs::role::Role;
use zeronav_shell::printable::printable;
use zeronav_shell::remote_seats::{FromLink, Line, ToLink, Wanted};
use zeronav_shell::{Domain, Peer};
use zeronav_supervise::child::Child;
use zeronav_supervise::descendants;
use zeronav_supervise::process::{Beginning, Process};
use zeronav_supervise::question::headline;
use zeronav_supervise::warden;

/// Launch's epoch in the domain of this host.
const EPOCH: u32 = 1;

/// Time between two looks.
const PAUSE: Duration = Duration::from_millis(5);

/// Time before a link that has ended is started again, and how long it may take to end.
const LINK_PAUSE: Duration = Duration::from_millis(500);
const LINK_LIMIT: Duration = Duration::from_secs(2);

/// Longest name of a run that is shown. [characters]
const RUN_CHARS: usize = 64;

/// Fills the seats of `host` whenever the launch of the other one wants them, until `interrupted`.
///
/// # Errors
/// One line when this host cannot do that.
pub(crate) fn serve(
    prepared: &Prepared,
    host: &str,
    interrupted: &Arc<AtomicBool>,
) -> Result<(), String> {
    warden::start();
    while !interrupted.load(Ordering::Relaxed) {
        serve_run(prepared, host, interrupted)?;
    }
    Ok(())
}

/// One run: a domain of its own.
fn serve_run(prepared: &Prepared, host: &str, interrupted: &Arc<AtomicBool>) -> Result<(), String> {
    let said = |error: zeronav_shell::StartError| error.to_string();
    let domain = Domain::create().map_err(said)?;
    let peer = Peer::join(domain, Role::Launch, EPOCH).map_err(said)?;
    warden::watch_domain(peer.domain().root());
    let topics = peer.create_topics().map_err(said)?;
    let private = peer.domain().folder().make_files_private();
    private.map_err(|error| error.to_string())?;
    let served = fill(prepared, host, &peer, interrupted);
    let strays = descendants::end(peer.domain().root());
    if !strays.is_empty() {
        tracing::warn!(pids = ?strays, "processes that services had started were ended");
    }
    drop(topics);
    let domain = peer.leave();
    let root = domain.root().to_owned();
    if let Err(error) = domain.close() {
        tracing::warn!(root = %root.display(), %error, "the domain could not be removed");
    }
    served
}

fn fill(
    prepared: &Prepared,
    host: &str,
    peer: &Peer,
    interrupted: &Arc<AtomicBool>,
) -> Result<(), String> {
    let mut filled = Filled::new(prepared, peer.domain())?;
    let mut link = Link::new(prepared, filled.root())?;
    let seats: Vec<&str> = prepared.binaries.keys().map(|role| role.label()).collect();
    note(&format!(
        "{host} waits for the robot's host; its seats: {}",
        seats.join(", ")
    ));
    let (mut wanted, mut is_over) = (News::default(), false);
    while !is_over && !interrupted.load(Ordering::Relaxed) {
        link.look(prepared, filled.root());
        if let Some(news) = link.exchange(&filled) {
            let is_another = news.run != wanted.run;
            // A link that was started again may hear another run first.
            is_over = news.over || is_another && !wanted.run.is_empty();
            if is_another && !is_over {
                note(&format!("{host} takes part in {}", shown(&news.run)));
            }
            if !is_over {
                wanted = news;
            }
        }
        filled.look(&wanted.seats, is_over);
        std::thread::sleep(PAUSE);
    }
    if is_over {
        note(&format!("{} is over", shown(&wanted.run)));
    }
    while !filled.is_empty() {
        filled.look(&[], true);
        link.exchange(&filled);
        std::thread::sleep(PAUSE);
    }
    link.stop();
    Ok(())
}

/// The name that another computer gives a run, as it may be shown.
fn shown(run: &str) -> String {
    let short: String = run.chars().take(RUN_CHARS).collect();
    printable(&short).into_owned()
}

/// What the link says.
#[derive(Debug, Default)]
struct News {
    run: String,
    seats: Vec<Wanted>,
    over: bool,
}

/// The process of the link, and the line to it.
struct Link {
    binary: PathBuf,
    config: PathBuf,
    process: Option<Process>,
    due: Instant,
    line: Option<Line>,
    told: Option<ToLink>,
    /// It was said that the process ends; cleared once it answers.
    has_complained: bool,
    folder: zeronav_shell::folder::Folder,
}

impl Link {
    fn new(prepared: &Prepared, root: &Path) -> Result<Self, String> {
        let none = || format!("no {LINK_PROGRAM}");
        let binary = prepared.companions.get(LINK).ok_or_else(none)?;
        let configs = configs::write_companions(&prepared.scenario, root)?;
        let config = configs.get(LINK).ok_or_else(none)?;
        let folder = zeronav_shell::folder::Folder::open(root);
        Ok(Self {
            binary: binary.clone(),
            config: config.clone(),
            process: None,
            due: Instant::now(),
            line: None,
            told: None,
            has_complained: false,
            folder: folder.map_err(|error| error.to_string())?,
        })
    }

    /// Starts the process, and again when it has ended.
    fn look(&mut self, prepared: &Prepared, root: &Path) {
        if let Some(process) = &mut self.process
            && let Some(status) = process.ended()
        {
            let how = Child::end_in_words(status);
            let said = process.log_tail(1).pop().unwrap_or_default();
            (self.process, self.line) = (None, None);
            self.due = Instant::now() + LINK_PAUSE;
            let log = prepared.log("link.log").path();
            self.complain(&format!(
                "the link has ended ({how}) and is started again: {}; see {}",
                printable(&headline(&said)),
                log.display()
            ));
        }
        if self.process.is_some() || Instant::now() < self.due {
            return;
        }
        let arguments: [OsString; 6] = [
            "--domain".into(),
            root.into(),
            "--config".into(),
            self.config.clone().into(),
            "--log-level".into(),
            prepared.log_level.clone().into(),
        ];
        let beginning = Beginning {
            name: LINK,
            binary: &self.binary,
            arguments: &arguments,
            root,
            log: &prepared.log("link.log"),
            stdin: Stdio::null(),
            stdout: None,
        };
        match Process::start(beginning, |_| {}) {
            Ok(process) => self.process = Some(process),
            Err(error) => {
                self.due = Instant::now() + LINK_PAUSE;
                self.complain(&error.to_string());
            }
        }
    }

    /// Says what is wrong, once until the link answers again.
    fn complain(&mut self, what: &str) {
        if !core::mem::replace(&mut self.has_complained, true) {
            complain(what);
        }
    }

    /// Tells the link what became of the seats; what it wants, when that is news.
    fn exchange(&mut self, filled: &Filled<'_>) -> Option<News> {
        if self.line.is_none() {
            self.line = Line::connect(&self.folder).ok();
            self.told = None;
            self.has_complained &= self.line.is_none();
        }
        let line = self.line.as_mut()?;
        let tell = ToLink::Filled {
            held: filled.held(),
        };
        let is_told = self.told.as_ref() == Some(&tell);
        let said = (if is_told { Ok(()) } else { line.send(&tell) })
            .and_then(|()| line.receive::<FromLink>());
        self.told = Some(tell);
        let Ok(said) = said else {
            self.line = None;
            return None;
        };
        said.into_iter().rev().find_map(|said| match said {
            FromLink::Wanted { run, seats, over } => Some(News { run, seats, over }),
            FromLink::Ended { .. } => None,
        })
    }

    /// Ends the process: it has no more to carry.
    fn stop(mut self) {
        if let Some(process) = &mut self.process {
            process.signal(Signal::TERM);
            process.wait(LINK_LIMIT);
        }
    }
}
