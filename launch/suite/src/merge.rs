//! One suite of its shards, which other machines may have driven.

use super::error::SuiteError;
use super::journal::{Contents, Journal, Order};
use super::kind::Kind;
use super::plan::{Setup, SuitePlan};
use super::ran::Ran;
use super::report::Report;
use super::row::{RUNS, Row};
use super::timing::Timing;
use super::{Folders, SCENARIOS};
use std::collections::BTreeMap;
use std::io::{Error, ErrorKind};
use std::path::{Component, Path, PathBuf};
use zeronav_console::environment::Before;
use zeronav_files::Folder;

/// The word for it on the command line.
pub const WORD: &str = "merge";

/// Runs that an error names at most.
const NAMED_MAX: usize = 5;

/// Folders in the folder of a run, at most.
const DEPTH_MAX: usize = 4;

/// What one shard has left.
struct Part<'a> {
    folder: &'a Path,
    order: Order,
    contents: Contents,
}

/// A run of a shard.
struct Found<'a> {
    name: &'a str,
    /// Folder of its shard.
    home: &'a Path,
    row: Row,
}

/// Makes one suite of the shards in `folders`, in a folder of its own. Its report is byte for byte that of the
/// suite that was driven at once, where every run was in lockstep.
///
/// # Errors
/// [`SuiteError`]: folders that are no shards of one suite, missing and duplicate runs.
pub fn merge(folders: &[PathBuf], plan: &SuitePlan) -> Result<Ran, SuiteError> {
    let before = Before::read();
    let parts = read_all(folders)?;
    let first = parts
        .first()
        .ok_or_else(|| "which shards? `zeronav suite merge FOLDER...`".to_owned())?;
    let planned = planned(first)?;
    let runs = runs_of(&parts, planned)?;
    let timings = parts.iter().map(|part| {
        Timing::read(part.folder)
            .map_err(|error| format!("{error}; `zeronav suite --resume FOLDER` writes it"))
    });
    let timings = timings.collect::<Result<Vec<Timing>, String>>()?;
    let order = Order {
        shard: None,
        ..first.order.clone()
    };
    let plan = order.plan(plan);
    let kind = Kind::of(&plan.suite);
    let folders = Folders::new(&plan.out, kind)?;
    let lost = SuiteError::Lost;
    leave_runs(&folders, &runs)?;
    let mut journal = Journal::begin(&folders.all, &order).map_err(lost)?;
    journal.plan(planned.to_vec()).map_err(lost)?;
    for run in &runs {
        journal
            .note_as(run.name.to_owned(), run.row.clone())
            .map_err(lost)?;
    }
    let rows: Vec<Row> = runs.into_iter().map(|run| run.row).collect();
    let walls_s = timings.iter().map(|timing| timing.wall_s);
    let longest_s = walls_s.fold(0.0, f64::max);
    let timing = Timing {
        shards: timings,
        ..Timing::new(&rows, folders.all.path(), longest_s, before.environment())
    };
    let setup = Setup {
        plan: &plan,
        controller: plan.controller.as_deref(),
        scenarios: &folders.scenarios,
    };
    let report = Report::new(&setup, kind, rows.len(), rows);
    report.leave(&folders.all).map_err(lost)?;
    timing.leave(&folders.all).map_err(lost)?;
    match report.refusal() {
        Some(problem) => Err(SuiteError::Usage(problem)),
        None => Ok(Ran { report, timing }),
    }
}

/// All shards, which are of one suite; the first alone holds the list of all runs.
fn read_all(folders: &[PathBuf]) -> Result<Vec<Part<'_>>, String> {
    let mut parts: Vec<Part<'_>> = Vec::new();
    for folder in folders {
        let mut part = read(folder)?;
        if let Some(first) = parts.first() {
            check_same(first, &part)?;
            part.contents.planned = None;
        }
        parts.push(part);
    }
    Ok(parts)
}

/// The names of all runs of the suite.
fn planned<'a>(first: &'a Part<'_>) -> Result<&'a [String], String> {
    let folder = first.folder.display();
    let planned = first.contents.planned.as_deref().ok_or_else(|| {
        format!(
            "{folder}: it stopped before its runs were planned; continue it with `zeronav suite --resume FOLDER`"
        )
    })?;
    match planned.iter().find(|name| !is_plain(name)) {
        Some(name) => Err(format!("{folder}: `{name}` is not the name of a run")),
        None => Ok(planned),
    }
}

/// All runs of the suite, in its order.
fn runs_of<'a>(parts: &'a [Part<'_>], planned: &'a [String]) -> Result<Vec<Found<'a>>, String> {
    let mut found = gather(parts)?;
    let mut runs = Vec::new();
    let mut missing = Vec::new();
    for name in planned {
        match found.remove(name.as_str()) {
            Some((home, row)) => {
                let directory = row.directory.as_ref().map(|_| format!("{RUNS}/{name}"));
                let row = Row {
                    directory,
                    ..row.clone()
                };
                runs.push(Found { name, home, row });
            }
            None => missing.push(name.as_str()),
        }
    }
    if !missing.is_empty() {
        return Err(said_missing(parts, planned.len(), &missing));
    }
    match found.pop_first() {
        Some((name, (home, _))) => Err(format!(
            "{}: {name} is no run of this suite",
            home.display()
        )),
        None => Ok(runs),
    }
}

fn read(folder: &Path) -> Result<Part<'_>, String> {
    let (order, contents) = Journal::read(folder)?;
    if Kind::of(&order.suite) == Kind::Soak {
        return Err(format!("{}: a soak has no shards", folder.display()));
    }
    Ok(Part {
        folder,
        order,
        contents,
    })
}

/// Accepts shards of one suite, driven by one build. Their data may lie elsewhere on each machine.
fn check_same(first: &Part<'_>, other: &Part<'_>) -> Result<(), String> {
    let alike = Order {
        shard: other.order.shard,
        data: other.order.data.clone(),
        ..first.order.clone()
    };
    let why = if other.order.build != first.order.build {
        "was driven by other binaries than"
    } else if other.order != alike || other.contents.planned != first.contents.planned {
        "is a shard of another suite than"
    } else {
        return Ok(());
    };
    let [first, other] = [first, other].map(|part| part.folder.display());
    Err(format!("{other} {why} {first}"))
}

/// All runs with the folder of their shard.
fn gather<'a>(parts: &'a [Part<'_>]) -> Result<BTreeMap<&'a str, (&'a Path, &'a Row)>, String> {
    let mut found: BTreeMap<&str, (&Path, &Row)> = BTreeMap::new();
    for part in parts {
        for (name, row) in &part.contents.rows {
            if let Some((home, _)) = found.insert(name, (part.folder, row)) {
                let [home, other] = [home, part.folder].map(Path::display);
                return Err(format!("{name} is there twice: in {home} and in {other}"));
            }
        }
    }
    Ok(found)
}

/// Which runs are missing, and in which shards they would be.
fn said_missing(parts: &[Part<'_>], planned: usize, missing: &[&str]) -> String {
    let any = parts.iter().find_map(|part| part.order.shard);
    let named = missing.iter().take(NAMED_MAX).map(|name| match any {
        Some(shard) => format!("{name} (shard {})", shard.sibling(name)),
        None => (*name).to_owned(),
    });
    let named: Vec<String> = named.collect();
    let more = if missing.len() > NAMED_MAX {
        ", ..."
    } else {
        ""
    };
    format!(
        "{} of {planned} runs are missing: {}{more}; drive these shards, or go on with them by `zeronav suite \
         --resume FOLDER`",
        missing.len(),
        named.join(", ")
    )
}

/// True for a name that stands for nothing outside of a folder.
fn is_plain(name: &str) -> bool {
    let mut parts = Path::new(name).components();
    matches!((parts.next(), parts.next()), (Some(Component::Normal(part)), None) if part == name)
}

/// Copies what the runs have left, and their scenarios.
fn leave_runs(folders: &Folders, runs: &[Found<'_>]) -> Result<(), SuiteError> {
    for run in runs {
        let (name, shard) = (run.name, run.home.display());
        let reading =
            |error: std::io::Error| SuiteError::Usage(format!("{shard}: reading {name}: {error}"));
        let writing = |error: std::io::Error| {
            SuiteError::Lost(format!(
                "{}: writing {name}: {error}",
                folders.all.path().display()
            ))
        };
        let home = Folder::open(run.home).map_err(reading)?;
        let scenario = name
            .rsplit_once("-seed")
            .map_or(name, |(scenario, _)| scenario);
        let scenario = format!("{scenario}.toml");
        // A scenario has a run for each seed.
        let scenarios = home.inside(SCENARIOS).map_err(reading)?;
        if let Ok(mut file) = scenarios.existing(&scenario) {
            match folders.scenarios.new_file(&scenario) {
                Ok(mut copy) => {
                    std::io::copy(&mut file, &mut copy).map_err(writing)?;
                }
                Err(error) if error.kind() == ErrorKind::AlreadyExists => {}
                Err(error) => return Err(writing(error)),
            }
        }
        // A run that could not begin has none.
        if run.row.directory.is_some() {
            let from = home
                .inside(RUNS)
                .and_then(|runs| runs.inside(name))
                .map_err(reading)?;
            copy(
                &from,
                &folders.runs.create(name).map_err(writing)?,
                DEPTH_MAX,
            )
            .map_err(writing)?;
        }
    }
    Ok(())
}

/// Copies all files and folders in `from`; links are errors.
fn copy(from: &Folder, into: &Folder, depth: usize) -> std::io::Result<()> {
    for name in from.names()? {
        let place = || format!("{}/{}", from.path().display(), name.display());
        let name = name.to_str().filter(|name| is_plain(name));
        let name = name
            .ok_or_else(|| Error::other(format!("{}: a name that is not plain text", place())))?;
        if std::fs::symlink_metadata(from.here().join(name))?.is_dir() {
            if depth == 0 {
                return Err(Error::other(format!("{}: nested too deep", place())));
            }
            copy(&from.inside(name)?, &into.create(name)?, depth - 1)?;
        } else {
            let mut file = from
                .existing(name)
                .map_err(|error| Error::other(format!("{}: {error}", place())))?;
            std::io::copy(&mut file, &mut into.new_file(name)?)?;
        }
    }
    Ok(())
}
