//! `zeronav suite`: the worlds of a data set, or a folder of scenarios, one lockstep run after the
//! other on every core, and what came of them; or a soak of drives under faults.
//!
//! Every run is a `zeronav run` of its own, so it has its own domain, its own folder
//! with result and picture, and cannot take the others with it.

mod barn;
mod bound;
mod case;
mod csv_file;
mod data;
mod dynabarn;
pub mod error;
mod field;
mod folder;
mod future;
mod generated;
mod ground;
mod hindsight;
mod journal;
mod junit;
mod kidnapped;
mod kind;
mod left;
pub mod merge;
pub mod noise;
mod oracle;
mod pedestrians;
pub mod plan;
pub mod ran;
pub mod report;
mod row;
mod rows;
mod runner;
mod score;
pub mod shard;
mod soak;
mod soaked;
mod summary;
mod timing;
mod track;
mod turns;

use case::Case;
use data::WorldFile;
use error::SuiteError;
use journal::{Journal, Order};
use kind::Kind;
use plan::{Setup, SuitePlan};
use ran::Ran;
use report::Report;
use row::{RUNS, Row};
use rows::drive_rest;
use runner::{Runner, Stopped};
use soaked::verdict::{End, SoakReport};
use std::collections::BTreeSet;
use std::path::Path;
use std::sync::atomic::AtomicBool;
use std::time::Instant;
use timing::Timing;
use zeronav_console::artifacts;
use zeronav_console::environment::Before;
use zeronav_files::Folder;
use zeronav_supervise::algorithms;
use zeronav_supervise::binaries::{self, Needed};

/// Runs a suite, or what is left of one, and writes what it gave into a folder of its own.
///
/// # Errors
/// [`SuiteError`]; runs that fail are no error but rows of the report.
pub fn suite(plan: &SuitePlan, interrupted: &AtomicBool) -> Result<Ran, SuiteError> {
    if plan.resume.is_none() {
        check_words(plan)?;
    }
    if plan.bound {
        return plan_all(plan, interrupted);
    }
    let Some(directory) = &plan.resume else {
        return begin(plan, interrupted, None);
    };
    let (order, journal) = Journal::resume(directory)?;
    let plan = order.plan(plan);
    check_words(&plan)?;
    begin(&plan, interrupted, Some((directory, &order, journal)))
}

fn begin(
    plan: &SuitePlan,
    interrupted: &AtomicBool,
    resumed: Option<(&Path, &Order, Journal)>,
) -> Result<Ran, SuiteError> {
    let kind = Kind::of(&plan.suite);
    let worlds = worlds(kind, plan)?;
    check_binaries(kind, plan)?;
    let before = Before::read();
    let started = Instant::now();
    let folders = match &resumed {
        Some((directory, ..)) => Folders::again(directory)?,
        None => Folders::new(&plan.out, kind)?,
    };
    let directory = folders.all.path();
    let setup = Setup {
        plan,
        controller: plan.controller.as_deref(),
        scenarios: &folders.scenarios,
    };
    let order = Order::of(&setup)?;
    let mut journal = match resumed {
        Some((_, begun, journal)) if begun.is_same(&order) => journal,
        Some(_) => {
            return Err(SuiteError::Usage(format!(
                "{} was begun with other binaries or data than are here now: run the suite again",
                directory.display()
            )));
        }
        None => Journal::begin(&folders.all, &order).map_err(SuiteError::Lost)?,
    };
    let runner = Runner::new(plan, folders.runs.clone(), interrupted)?;
    let (cases, soaked, ended) = if kind == Kind::Soak {
        let driven = soak::drive(&runner.quiet(), &setup, &folders.all, &mut journal)?;
        let soaked = (driven.end, driven.used_s);
        (driven.cases, Some(soaked), driven.ended)
    } else {
        let mut cases = cases(kind, &setup, &worlds, &runner)?;
        let planned: Vec<String> = cases.iter().map(Case::name).collect();
        let mut seen = BTreeSet::new();
        if let Some(name) = planned.iter().find(|name| !seen.insert(*name)) {
            return Err(SuiteError::Usage(format!(
                "two runs are called {name}: rename one of the scenarios, or its variant"
            )));
        }
        if !journal.plan(planned).map_err(SuiteError::Lost)? {
            return Err(SuiteError::Usage(format!(
                "{} was begun with other worlds than are here now: run the suite again",
                directory.display()
            )));
        }
        if let Some(shard) = plan.shard {
            cases.retain(|case| shard.has(&case.name()));
        }
        let ended = drive_rest(&runner, kind.label(), &cases, &mut journal);
        (cases, None, ended)
    };
    let rows: Vec<Row> = cases
        .iter()
        .filter_map(|case| journal.row(case).cloned())
        .collect();
    let ran = leave(
        &setup,
        (cases.len(), rows, soaked),
        &folders.all,
        (&started, &before),
    )?;
    match ended {
        Ok(()) => {}
        Err(Stopped::Interrupted) => return Err(SuiteError::Interrupted(Some(Box::new(ran)))),
        Err(other) => return Err(other.into()),
    }
    // A shard may hold nothing but what cannot run.
    let refusal = ran.report.refusal().filter(|_| plan.shard.is_none());
    match refusal {
        Some(problem) => Err(SuiteError::Usage(problem)),
        None => Ok(ran),
    }
}

/// Plans a way through every run in place of driving it. The empty scenes of recorded people are
/// driven all the same: the scenarios depend on the time that it takes.
fn plan_all(plan: &SuitePlan, interrupted: &AtomicBool) -> Result<Ran, SuiteError> {
    let kind = Kind::of(&plan.suite);
    let worlds = worlds(kind, plan)?;
    if kind == Kind::Pedestrians {
        check_binaries(kind, plan)?;
    }
    let before = Before::read();
    let started = Instant::now();
    let folders = Folders::new(&plan.out, kind)?;
    let setup = Setup {
        plan,
        controller: None,
        scenarios: &folders.scenarios,
    };
    let runner = Runner::new(plan, folders.runs.clone(), interrupted)?;
    let cases = cases(kind, &setup, &worlds, &runner)?;
    let rows = bound::rows(&cases, runner.jobs(), plan.progress, interrupted)?;
    leave(
        &setup,
        (cases.len(), rows, None),
        &folders.all,
        (&started, &before),
    )
}

/// The report of so many cases, of which these have a row, in the suite's folder; of a soak with how it
/// ended and the wall time that it has used. [s]
fn leave(
    setup: &Setup<'_>,
    (n_cases, rows, soaked): (usize, Vec<Row>, Option<(End, f64)>),
    folder: &Folder,
    (started, before): (&Instant, &Before),
) -> Result<Ran, SuiteError> {
    let soak = soaked.map(|(end, used_s)| {
        let hours = setup.plan.hours.unwrap_or(soak::HOURS);
        let drives = rows.iter().filter_map(|row| row.soaked.as_deref().cloned());
        SoakReport::new(end, (hours, used_s), drives.collect())
    });
    let before_s = Timing::read(folder.path()).map_or(0.0, |timing| timing.wall_s);
    let timing = Timing::new(
        &rows,
        folder.path(),
        before_s + started.elapsed().as_secs_f64(),
        before.environment(),
    );
    let mut report = Report::new(setup, Kind::of(&setup.plan.suite), n_cases, rows);
    if let Some(soak) = soak {
        report = report.of_soak(soak);
    }
    report.leave(folder).map_err(SuiteError::Lost)?;
    timing.leave(folder).map_err(SuiteError::Lost)?;
    Ok(Ran { report, timing })
}

/// Accepts what fits the suite.
fn check_words(plan: &SuitePlan) -> Result<(), SuiteError> {
    let kind = Kind::of(&plan.suite);
    let is_soak = kind == Kind::Soak;
    let is_told = !plan.foresight.is_none();
    let why = if kind == Kind::Folder && is_told {
        "--perceive and --predict: the scenarios of a folder are judged by what they expect, and what \
         is judged is told nothing"
    } else if is_soak && (is_told || plan.bound || plan.seeds != 1) {
        "--perceive, --predict, --bound and --seeds: a soak has none of them; each of its drives has \
         the seed that is drawn from its number, and --worlds A..B picks some"
    } else if is_soak && plan.shard.is_some() {
        "--shard: the drives of a soak are endless; --worlds A..B picks some"
    } else if !is_soak && plan.hours.is_some() {
        "--hours: only a soak goes on until its time is used up"
    } else {
        return Ok(());
    };
    Err(SuiteError::Usage(why.to_owned()))
}

/// The worlds that the plan asks for.
fn worlds(kind: Kind, plan: &SuitePlan) -> Result<Vec<WorldFile>, String> {
    match kind {
        Kind::Barn => barn::worlds(plan),
        Kind::Dynabarn => dynabarn::worlds(plan),
        Kind::Pedestrians => pedestrians::worlds(plan),
        Kind::Generated => Ok(generated::worlds(plan)),
        Kind::Field => Ok(field::worlds(plan)),
        Kind::Kidnapped => kidnapped::worlds(plan),
        // Each of its drives draws its own.
        Kind::Soak => Ok(Vec::new()),
        Kind::Folder => folder::worlds(plan),
    }
}

/// The runs to make.
fn cases(
    kind: Kind,
    setup: &Setup<'_>,
    worlds: &[WorldFile],
    runner: &Runner<'_>,
) -> Result<Vec<Case>, SuiteError> {
    let cases = match kind {
        Kind::Barn => barn::cases(setup, worlds)?,
        Kind::Dynabarn => dynabarn::cases(setup, worlds)?,
        Kind::Pedestrians => pedestrians::cases(setup, worlds, runner)?,
        Kind::Generated => generated::cases(setup, worlds)?,
        Kind::Field => field::cases(setup, worlds)?,
        Kind::Kidnapped => kidnapped::cases(setup, worlds)?,
        // They are endless.
        Kind::Soak => Vec::new(),
        Kind::Folder => folder::cases(setup, worlds)?,
    };
    Ok(cases)
}

/// Builds the binaries under cargo and checks the controller's key. The scenarios of a folder may
/// name any binary, and their local planner may have keys of its own.
fn check_binaries(kind: Kind, plan: &SuitePlan) -> Result<(), String> {
    let is_folder = kind == Kind::Folder;
    binaries::refresh_under_cargo(if is_folder {
        Needed::Any
    } else {
        Needed::Stock
    })?;
    match plan.controller.as_deref() {
        Some(key) if !is_folder => algorithms::check_controller(key),
        _ => Ok(()),
    }
}

/// The folder of the scenarios in that of the suite.
const SCENARIOS: &str = "scenarios";

/// The suite's own folder and those in it.
struct Folders {
    all: Folder,
    scenarios: Folder,
    runs: Folder,
}

impl Folders {
    fn new(out: &Path, kind: Kind) -> Result<Self, String> {
        let all = artifacts::new_folder(out, &format!("suite-{}", kind.label()))?;
        Self::within(all, Folder::create)
    }

    /// Those of a suite that goes on.
    fn again(directory: &Path) -> Result<Self, String> {
        let all = Folder::open(directory).map_err(|error| artifacts::refused(directory, &error))?;
        Self::within(all, Folder::inside)
    }

    fn within(
        all: Folder,
        get: impl Fn(&Folder, &str) -> std::io::Result<Folder>,
    ) -> Result<Self, String> {
        let part = |name: &str| {
            let path = all.path().join(name);
            get(&all, name).map_err(|error| artifacts::refused(&path, &error))
        };
        Ok(Self {
            scenarios: part(SCENARIOS)?,
            runs: part(RUNS)?,
            all,
        })
    }
}
