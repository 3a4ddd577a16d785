//! `report.html`: one self-contained page about a run, and one that compares several.
//!
//! `folder` reads what a run left, `html` and `charts` write elements and figures, the other
//! modules a part of the page each. Text of scenarios, logs and folders is escaped where it is
//! written: a cell of a table is text unless this room has made it.

mod charts;
mod compare;
mod environment;
mod events;
pub(crate) mod folder;
mod html;
mod latencies;
pub(crate) mod messages;
mod page;
mod paired;
mod perfetto;
mod services;
mod summary;

use crate::show::recording::Recording;
use folder::{Outcome, RunFolder};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use zeronav_console::artifacts;
use zeronav_console::terminal::{lose, say, usage};
use zeronav_files::Folder;

/// Its name in the folder of a run.
const FILE: &str = "report.html";

/// Name of the page that compares runs.
const COMPARISON: &str = "comparison.html";

/// Most runs that are compared.
const RUNS_MAX: usize = 100;

/// Writes the report of the run whose folder is `run` into it.
///
/// # Errors
/// One line when it cannot be written.
pub(crate) fn write(run: &Folder, outcome: Outcome, recording: Recording) -> Result<(), String> {
    let folder = RunFolder {
        path: run.path().to_owned(),
        outcome,
        recording: Some(recording),
    };
    artifacts::write_in(run, FILE, &page::page(&folder))
}

/// `zeronav report`: one run has its report written again, several are compared.
#[must_use]
pub fn report(runs: &[PathBuf], out: Option<&Path>) -> ExitCode {
    if runs.len() > RUNS_MAX {
        return usage(&format!("{} runs; {RUNS_MAX} at most", runs.len()));
    }
    let mut folders = Vec::new();
    for run in runs {
        match RunFolder::read(run) {
            Ok(folder) => folders.push(folder),
            Err(problem) => return usage(&problem),
        }
    }
    let (file, text) = match folders.as_slice() {
        [run] => (run.path.join(FILE), page::page(run)),
        several => match compare::page(several) {
            Ok(text) => (PathBuf::from(COMPARISON), text),
            Err(problem) => return usage(&problem),
        },
    };
    let file = out.map_or(file, Path::to_owned);
    match artifacts::write(&file, &text) {
        Ok(()) => say(&format!("{}\n", file.display())),
        Err(problem) => lose(&problem),
    }
    ExitCode::SUCCESS
}
