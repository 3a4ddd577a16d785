//! One suite of its shards, which other machines may have driven.

use super::Folders;
use super::error::SuiteError;
use super::journal::{Contents, Journal, Order};
use super::kind::Kind;
use super::plan::{Setup, SuitePlan};
use super::ran::Ran;
use super::report::Report;
use super::row::{RUNS, Row};
use super::timing::Timing;
use std::collections::BTreeMap;
use std::ffi::OsStr;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
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

/// Makes one suite of the shards in `folders`, in a folder of its own. Its report is byte for byte that of the
/// suite that was not shared out, where every run was in lockstep.
///
/// # Errors
/// [`SuiteError`]: folders that are no shards of one suite, runs that are missing, and runs that are there twice.
pub fn merge(folders: &[PathBuf], plan: &SuitePlan) -> Result<Ran, SuiteError> {
    let before = Before::read();
    let parts = folders.iter().map(|folder| read(folder));
    let parts = parts.collect::<Result<Vec<Part<'_>>, String>>()?;
    let first = parts
        .first()
        .ok_or_else(|| "which shards? `zeronav suite merge FOLDER...`".to_owned())?;
    let planned = first.contents.planned.clone();
    let planned = planned.ok_or_else(|| {
        format!(
            "{}: it has no list of its runs: go on with it by --resume",
            first.folder.display()
        )
    })?;
    for part in &parts {
        check_same(first, part)?;
    }
    let mut found = gather(&parts)?;
    let mut rows: Vec<(String, Row)> = Vec::new();
    let mut missing = Vec::new();
    let mut homes = Vec::new();
    for name in &planned {
        match found.remove(name.as_str()) {
            Some((home, row)) => {
                rows.push((name.clone(), row.clone()));
                homes.push(home);
            }
            None => missing.push(name.as_str()),
        }
    }
    if !missing.is_empty() {
        return Err(SuiteError::Usage(said_missing(
            &parts,
            planned.len(),
            &missing,
        )));
    }
    if let Some((name, (home, _))) = found.pop_first() {
        return Err(SuiteError::Usage(format!(
            "{}: {name} is no run of this suite",
            home.display()
        )));
    }

    let order = Order {
        shard: None,
        ..first.order.clone()
    };
    let plan = order.plan(plan);
    let kind = Kind::of(&plan.suite);
    let folders = Folders::new(&plan.out, kind)?;
    let timings = parts.iter().map(|part| Timing::read(part.folder));
    let timings = timings.collect::<Result<Vec<Timing>, String>>()?;
    leave_runs(&folders, &rows, &homes).map_err(SuiteError::Lost)?;
    let mut journal = Journal::begin(&folders.all, &order).map_err(SuiteError::Lost)?;
    journal.plan(planned).map_err(SuiteError::Lost)?;
    for (name, row) in &rows {
        journal
            .note_as(name.clone(), row.clone())
            .map_err(SuiteError::Lost)?;
    }
    let rows: Vec<Row> = rows.into_iter().map(|(_, row)| row).collect();
    let longest_s = timings
        .iter()
        .map(|timing| timing.wall_s)
        .fold(0.0, f64::max);
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
    report.leave(&folders.all).map_err(SuiteError::Lost)?;
    timing.leave(&folders.all).map_err(SuiteError::Lost)?;
    Ok(Ran { report, timing })
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
        "other binaries drove it"
    } else if other.order != alike || other.contents.planned != first.contents.planned {
        "it is of another suite"
    } else {
        return Ok(());
    };
    let [first, other] = [first, other].map(|part| part.folder.display());
    Err(format!("{other}: {why} than {first}"))
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

/// Copies what the runs have left, and their scenarios.
fn leave_runs(folders: &Folders, rows: &[(String, Row)], homes: &[&Path]) -> Result<(), String> {
    for ((name, row), home) in rows.iter().zip(homes) {
        let at = |error: std::io::Error| format!("copying {name} of {}: {error}", home.display());
        let home = Folder::open(home).map_err(at)?;
        let scenario = name
            .rsplit_once("-seed")
            .map_or(name.as_str(), |(scenario, _)| scenario);
        let scenario = format!("{scenario}.toml");
        // A scenario has a run for each seed.
        let scenarios = home.inside("scenarios").map_err(at)?;
        if let Ok(mut file) = scenarios.existing(&scenario) {
            match folders.scenarios.new_file(&scenario) {
                Ok(mut copy) => {
                    std::io::copy(&mut file, &mut copy).map_err(at)?;
                }
                Err(error) if error.kind() == ErrorKind::AlreadyExists => {}
                Err(error) => return Err(at(error)),
            }
        }
        // A run that could not begin has none.
        if row.directory.is_some() {
            let from = home
                .inside(RUNS)
                .and_then(|runs| runs.inside(name))
                .map_err(at)?;
            copy(&from, &folders.runs.create(name).map_err(at)?, DEPTH_MAX).map_err(at)?;
        }
    }
    Ok(())
}

/// Copies all files and folders in `from`; links are errors.
fn copy(from: &Folder, into: &Folder, depth: usize) -> std::io::Result<()> {
    for name in from.names()? {
        let name = name.to_str().ok_or(ErrorKind::InvalidFilename)?;
        if Path::new(OsStr::new(name)).file_name().is_none() || depth == 0 {
            return Err(ErrorKind::InvalidFilename.into());
        }
        match from.inside(name) {
            Ok(folder) => copy(&folder, &into.create(name)?, depth - 1)?,
            Err(_) => {
                std::io::copy(&mut from.existing(name)?, &mut into.new_file(name)?)?;
            }
        }
    }
    Ok(())
}
