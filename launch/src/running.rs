//! The runs of this user that are in progress, and how a command finds the one that it is for.

use crate::control::request::{Reply, Request, RunReport};
use crate::control::socket;
use rustix::process::{Pid, PidfdFlags, Signal, pidfd_open, pidfd_send_signal};
use std::io::{Error, ErrorKind};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};
use zeronav_shell::folder::Folder;
use zeronav_shell::{control, domain, printable};

/// Why [`find`] needs a root folder; no wait changes that.
pub(crate) const SEVERAL: &str = "several runs go on; name one with --domain (see `zeronav ps`)";

/// Between two looks at a run that is to end.
const PAUSE: Duration = Duration::from_millis(50);

/// A run in progress, by its domain.
#[derive(Debug)]
pub(crate) struct Running {
    folder: Folder,
}

/// Why a run did not do what it was asked.
#[derive(Debug)]
pub(crate) struct Problem {
    /// In one line.
    pub text: String,
    /// It is in progress and does not answer.
    pub is_silent: bool,
}

impl Problem {
    const fn said(text: String) -> Self {
        Self {
            text,
            is_silent: false,
        }
    }
}

impl From<Problem> for String {
    fn from(problem: Problem) -> Self {
        problem.text
    }
}

/// A run in progress that does not say what it does.
#[derive(Debug)]
pub(crate) struct Silent {
    /// Process id of its launch.
    pub pid: Option<u32>,
    /// Why there is no answer, in words.
    pub why: String,
}

/// Every run in progress, with its root folder, whether or not it answers.
pub(crate) fn all() -> Vec<(PathBuf, Result<RunReport, Silent>)> {
    let look = |root: &PathBuf| {
        let folder = Folder::open(root).ok()?;
        let why = match socket::ask(&folder, &Request::Ps) {
            Ok(Reply::Run(report)) => return Some(Ok(*report)),
            Ok(Reply::Error(problem)) => printable(&problem).into_owned(),
            Ok(_) => "the answer is not what was asked for".to_owned(),
            Err(error) if is_no_run(&error) => return None,
            Err(error) => in_words(&error),
        };
        let pid = process(&folder).map(|pid| pid.as_raw_nonzero().get().unsigned_abs());
        Some(Err(Silent { pid, why }))
    };
    domain::all()
        .into_iter()
        .filter_map(|root| look(&root).map(|found| (root, found)))
        .collect()
}

/// The run that this process drives itself, once it answers.
pub(crate) fn own() -> Option<Running> {
    let mut folders = domain::all()
        .into_iter()
        .filter_map(|root| Folder::open(&root).ok());
    let own = rustix::process::getpid();
    folders
        .find(|folder| process(folder) == Some(own))
        .map(|folder| Running { folder })
}

/// True when nobody answers for the domain: its run is over or has not begun, or is another user's.
fn is_no_run(error: &Error) -> bool {
    use ErrorKind::{ConnectionRefused, NotFound, PermissionDenied};
    matches!(
        error.kind(),
        NotFound | ConnectionRefused | PermissionDenied
    )
}

/// The process that should answer.
fn process(folder: &Folder) -> Option<Pid> {
    control::answering_process(folder).ok()
}

fn in_words(error: &Error) -> String {
    if error.kind() == ErrorKind::WouldBlock {
        format!("no answer within {} s", control::PATIENCE.as_secs())
    } else {
        error.to_string()
    }
}

/// The run with this root folder; without one, the only run that goes on.
///
/// # Errors
/// One line when there is none, or more than one.
pub(crate) fn find(root: Option<&Path>) -> Result<Running, String> {
    let root = match root {
        Some(root) => root.to_owned(),
        None => match all().as_slice() {
            [(root, _)] => root.clone(),
            [] => {
                return Err(
                    "no run goes on; start one with `zeronav up` or `zeronav run SCENARIO`"
                        .to_owned(),
                );
            }
            _ => return Err(SEVERAL.to_owned()),
        },
    };
    match Folder::open(&root) {
        Ok(folder) => Ok(Running { folder }),
        Err(error) if error.kind() == ErrorKind::NotFound => Err(format!(
            "{}: no such folder; the run is over or was never started",
            root.display()
        )),
        Err(error) => Err(format!(
            "{}: not a run of this user: {error}",
            root.display()
        )),
    }
}

impl Running {
    /// Root folder of its domain.
    #[must_use]
    pub(crate) fn root(&self) -> &Path {
        self.folder.path()
    }

    /// Asks the run.
    ///
    /// # Errors
    /// What it says against the request, or one line when it does not answer.
    pub(crate) fn ask(&self, request: &Request) -> Result<Reply, Problem> {
        match socket::ask(&self.folder, request) {
            Ok(Reply::Error(problem)) => Err(Problem::said(printable(&problem).into_owned())),
            Ok(reply) => Ok(reply),
            Err(error) if is_no_run(&error) => Err(Problem::said(
                self.refusal(&format!("no run answers: {error}")),
            )),
            Err(error) => Err(Problem {
                text: self.refusal(&format!(
                    "{} from its launch, process {}: `zeronav down` ends it",
                    in_words(&error),
                    process(&self.folder).map_or_else(|| "?".to_owned(), |pid| pid.to_string())
                )),
                is_silent: true,
            }),
        }
    }

    /// What the run says of itself.
    ///
    /// # Errors
    /// As [`Self::ask`].
    pub(crate) fn report(&self) -> Result<RunReport, Problem> {
        match self.ask(&Request::Ps)? {
            Reply::Run(report) => Ok(*report),
            _ => Err(Problem::said(
                self.refusal("the answer is not what was asked for"),
            )),
        }
    }

    /// Waits until nothing of the run is left; false when it is still there after `limit`.
    pub(crate) fn wait_until_gone(&self, limit: Duration) -> bool {
        let began = Instant::now();
        while self.root().exists() {
            if began.elapsed() > limit {
                return false;
            }
            std::thread::sleep(PAUSE);
        }
        true
    }

    /// Ends a run that does not answer: lets its launch go on if it is stopped, asks it to end, and
    /// kills it when it has not within `limit`. The warden then ends what launch leaves behind.
    ///
    /// # Errors
    /// One line when it is still there.
    pub(crate) fn end(&self, limit: Duration) -> Result<&'static str, String> {
        let failed = |error: &Error| self.refusal(&format!("its launch was not found: {error}"));
        let pid = control::answering_process(&self.folder).map_err(|error| failed(&error))?;
        let process =
            pidfd_open(pid, PidfdFlags::empty()).map_err(|error| failed(&error.into()))?;
        // The id may have been given to another process in between.
        if control::answering_process(&self.folder).ok() != Some(pid) {
            return Err(self.refusal("its launch ended just now"));
        }
        for (signal, how) in [(Signal::TERM, "by SIGTERM"), (Signal::KILL, "by SIGKILL")] {
            let _ = pidfd_send_signal(&process, signal);
            let _ = pidfd_send_signal(&process, Signal::CONT);
            if self.wait_until_gone(limit) {
                return Ok(how);
            }
        }
        Err(self.refusal(&format!("still there after process {pid} was killed")))
    }

    /// A problem with this run, in one line.
    #[must_use]
    pub(crate) fn refusal(&self, problem: &str) -> String {
        format!("{}: {}", self.root().display(), printable(problem))
    }
}
