//! The runs of this user that are in progress, and how a command finds the one that it is for.

use crate::control::request::{Reply, Request, RunReport};
use crate::control::socket;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use zeronav_shell::folder::Folder;
use zeronav_shell::{domain, printable};

/// Why [`find`] needs a root folder; no wait changes that.
pub(crate) const SEVERAL: &str = "several runs go on; name one with --domain (see `zeronav ps`)";

/// A run in progress, by its domain.
#[derive(Debug)]
pub(crate) struct Running {
    folder: Folder,
}

/// The runs that answer, with their root folders.
pub(crate) fn all() -> Vec<(PathBuf, RunReport)> {
    let answer = |root: &PathBuf| {
        let folder = Folder::open(root).ok()?;
        match socket::ask(&folder, &Request::Ps) {
            Ok(Reply::Run(report)) => Some(*report),
            _ => None,
        }
    };
    domain::all()
        .into_iter()
        .filter_map(|root| answer(&root).map(|report| (root, report)))
        .collect()
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
    pub(crate) fn ask(&self, request: &Request) -> Result<Reply, String> {
        match socket::ask(&self.folder, request) {
            Ok(Reply::Error(problem)) => Err(printable(&problem).into_owned()),
            Ok(reply) => Ok(reply),
            Err(error) => Err(self.refusal(&format!("no run answers: {error}"))),
        }
    }

    /// What the run says of itself.
    ///
    /// # Errors
    /// As [`Self::ask`].
    pub(crate) fn report(&self) -> Result<RunReport, String> {
        match self.ask(&Request::Ps)? {
            Reply::Run(report) => Ok(*report),
            _ => Err(self.refusal("the answer is not what was asked for")),
        }
    }

    /// A problem with this run, in one line.
    #[must_use]
    pub(crate) fn refusal(&self, problem: &str) -> String {
        format!("{}: {}", self.root().display(), printable(problem))
    }
}
