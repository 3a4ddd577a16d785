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
mod journal;
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
use journal::{Journal, Order};
use report::Kind;
use row::Row;
use runner::{Runner, Stopped};
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use std::time::Instant;

/// Why a suite did not run to its end.
#[derive(Debug)]
pub enum SuiteError {
    /// Usage or configuration, in one line.
    Usage(String),
    /// Ctrl-C: everything is stopped, the report says what there is.
    Interrupted(Option<Box<Report>>),
    /// A file could not be written, in one line.
    Lost(String),
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
            Stopped::Lost(problem) => Self::Lost(problem),
            Stopped::Interrupted => Self::Interrupted(None),
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

/// Runs a suite, or what is left of one, and writes what it gave into a folder of its own.
///
/// # Errors
/// [`SuiteError`]; runs that fail are no error but rows of the report.
pub fn suite(arguments: &SuiteArgs, interrupted: &AtomicBool) -> Result<Report, SuiteError> {
    let Some(directory) = &arguments.resume else {
        return begin(arguments, interrupted, None);
    };
    let (order, journal) = Journal::resume(directory)?;
    let arguments = SuiteArgs {
        suite: order.suite.clone(),
        controller: order.controller.clone(),
        seeds: order.seeds,
        worlds: order.worlds.map(|[from, until]| from..until),
        noise: Noise::from_label(&order.noise).unwrap_or_default(),
        data: order.data.clone(),
        ..arguments.clone()
    };
    begin(&arguments, interrupted, Some((directory, &order, journal)))
}

fn begin(
    arguments: &SuiteArgs,
    interrupted: &AtomicBool,
    resumed: Option<(&Path, &Order, Journal)>,
) -> Result<Report, SuiteError> {
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
    let directory = match &resumed {
        Some((directory, ..)) => (*directory).to_owned(),
        None => suite_folder(&arguments.out, kind)?,
    };
    let scenarios = directory.join("scenarios");
    let setup = Setup {
        arguments,
        controller: arguments.controller.as_deref().or(kind.controller()),
        scenarios: &scenarios,
    };
    let order = Order::of(&setup)?;
    let mut journal = match resumed {
        Some((_, begun, journal)) if *begun == order => journal,
        Some(_) => {
            return Err(SuiteError::Usage(format!(
                "{} was begun with other binaries or data than are here now: run the suite again",
                directory.display()
            )));
        }
        None => Journal::begin(&directory, &order).map_err(SuiteError::Lost)?,
    };
    let runner = Runner::new(arguments, directory.join("runs"), interrupted)?;
    let cases = match kind {
        Kind::Barn => barn::cases(&setup, &worlds)?,
        Kind::Dynabarn => dynabarn::cases(&setup, &worlds)?,
        Kind::Pedestrians => pedestrians::cases(&setup, &worlds, &runner)?,
        Kind::Generated => generated::cases(&setup, &worlds)?,
        Kind::Folder => folder::cases(&setup, &worlds)?,
    };
    let ended = drive_rest(&runner, kind.label(), &cases, &mut journal);
    let rows: Vec<Row> = cases
        .iter()
        .filter_map(|case| journal.row(case).cloned())
        .collect();
    let report = Report::new(
        &setup,
        kind,
        cases.len(),
        rows,
        &directory,
        started.elapsed().as_secs_f64(),
        before.environment(),
    );
    report.leave().map_err(SuiteError::Lost)?;
    match ended {
        Ok(()) => {}
        Err(Stopped::Interrupted) => return Err(SuiteError::Interrupted(Some(Box::new(report)))),
        Err(other) => return Err(other.into()),
    }
    match report.refusal() {
        Some(problem) => Err(SuiteError::Usage(problem)),
        None => Ok(report),
    }
}

/// Runs the cases; their rows in the order of the cases.
fn drive(runner: &Runner<'_>, title: &str, cases: &[Case]) -> Result<Vec<Row>, Stopped> {
    let mut rows: Vec<Option<Row>> = vec![None; cases.len()];
    let all: Vec<&Case> = cases.iter().collect();
    runner.each(title, &all, |index, finish| {
        rows[index] = Some(Row::new(&cases[index], &finish));
        Ok(())
    })?;
    Ok(rows.into_iter().flatten().collect())
}

/// Makes the runs that the journal does not have yet.
fn drive_rest(
    runner: &Runner<'_>,
    title: &str,
    cases: &[Case],
    journal: &mut Journal,
) -> Result<(), Stopped> {
    let left: Vec<&Case> = cases
        .iter()
        .filter(|case| journal.row(case).is_none())
        .collect();
    runner.each(title, &left, |index, finish| {
        let case = left[index];
        journal.note(case, Row::new(case, &finish))
    })
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
