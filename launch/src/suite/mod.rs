//! `zeronav suite`: the worlds of a data set, or a folder of scenarios, one lockstep run after the
//! other on every core, and what came of them.
//!
//! Every run is a `zeronav run --lockstep` of its own, so it has its own domain, its own folder
//! with result and picture, and cannot take the others with it.

mod barn;
mod case;
mod csv_file;
mod data;
mod dynabarn;
mod folder;
mod generated;
mod hindsight;
mod junit;
mod noise;
mod oracle;
mod pedestrians;
mod report;
mod row;
mod runner;
mod score;
mod summary;
mod track;

pub use noise::Noise;
pub use report::Report;

use crate::cli::SuiteArgs;
use crate::environment::Before;
use crate::supervise::algorithms;
use crate::supervise::binaries::{self, Needed};
use case::Case;
use report::Kind;
use row::Row;
use runner::{Runner, Stopped};
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use std::time::Instant;

/// Why a suite did not run to its end.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum SuiteError {
    /// Usage or configuration, in one line.
    Usage(String),
    /// Ctrl-C: everything is stopped.
    Interrupted,
}

impl From<String> for SuiteError {
    fn from(problem: String) -> Self {
        Self::Usage(problem)
    }
}

impl From<Stopped> for SuiteError {
    fn from(stopped: Stopped) -> Self {
        match stopped {
            Stopped::Refused(problem) => Self::Usage(problem),
            Stopped::Interrupted => Self::Interrupted,
        }
    }
}

/// What all cases of a suite have in common.
#[derive(Debug, Clone, Copy)]
struct Setup<'a> {
    arguments: &'a SuiteArgs,
    /// Key of the local planner's controller; `None` = its own default, or the scenario's.
    controller: Option<&'a str>,
    /// Folder for the scenarios that are written.
    scenarios: &'a Path,
}

/// Runs a suite and writes what it gave into a folder of its own.
///
/// # Errors
/// [`SuiteError`]; runs that fail are no error but rows of the report.
pub fn suite(arguments: &SuiteArgs, interrupted: &AtomicBool) -> Result<Report, SuiteError> {
    let kind = Kind::of(&arguments.suite);
    let worlds = match kind {
        Kind::Barn => barn::worlds(arguments)?,
        Kind::Dynabarn => dynabarn::worlds(arguments)?,
        Kind::Pedestrians => pedestrians::worlds(arguments)?,
        Kind::Generated => generated::worlds(arguments),
        Kind::Folder => folder::worlds(arguments)?,
    };
    // A folder's scenarios may name whatever they want.
    binaries::refresh_under_cargo(match kind {
        Kind::Folder => Needed::Any,
        Kind::Barn | Kind::Dynabarn | Kind::Pedestrians | Kind::Generated => Needed::Stock,
    })?;
    // A folder's scenarios may have another local planner, with keys of its own.
    if let Some(key) = arguments
        .controller
        .as_deref()
        .filter(|_| kind != Kind::Folder)
    {
        algorithms::check_controller(key)?;
    }
    let before = Before::read();
    let started = Instant::now();
    let directory = suite_folder(&arguments.out, kind)?;
    let scenarios = directory.join("scenarios");
    let setup = Setup {
        arguments,
        controller: arguments.controller.as_deref().or(kind.controller()),
        scenarios: &scenarios,
    };
    let runner = Runner::new(arguments, directory.join("runs"), interrupted)?;
    let cases = match kind {
        Kind::Barn => barn::cases(&setup, &worlds)?,
        Kind::Dynabarn => dynabarn::cases(&setup, &worlds)?,
        Kind::Pedestrians => pedestrians::cases(&setup, &worlds, &runner)?,
        Kind::Generated => generated::cases(&setup, &worlds)?,
        Kind::Folder => folder::cases(&setup, &worlds)?,
    };
    let rows = drive(&runner, kind.label(), &cases)?;
    let report = Report::new(
        &setup,
        kind,
        rows,
        &directory,
        started.elapsed().as_secs_f64(),
        before.environment(),
    );
    report.leave()?;
    Ok(report)
}

/// Runs the cases; their rows in the order of the cases.
fn drive(runner: &Runner<'_>, title: &str, cases: &[Case]) -> Result<Vec<Row>, Stopped> {
    let finishes = runner.run(title, cases)?;
    Ok(cases
        .iter()
        .zip(&finishes)
        .map(|(case, finish)| Row::new(case, finish))
        .collect())
}

/// Makes the suite's own folder.
fn suite_folder(out: &Path, kind: Kind) -> Result<PathBuf, String> {
    let now = std::time::SystemTime::now()
        .duration_since(std::time::UNIX_EPOCH)
        .unwrap_or_default();
    let id = format!(
        "suite-{}-{}-{}",
        kind.label(),
        now.as_secs(),
        std::process::id()
    );
    let folder = out.join(id);
    for part in ["scenarios", "runs"] {
        std::fs::create_dir_all(folder.join(part))
            .map_err(|error| format!("making the suite's folder {}: {error}", folder.display()))?;
    }
    Ok(folder)
}
