//! How the figures of the READMEs are made: experiments, what they gave, and the pages from that.
//!
//! `experiments` says what is measured, `bench` runs it, `extract` and `trials` take the figures
//! out of the results, `record` keeps them in `tests/results.json`, and `page` writes them into
//! `tests/RESULTS.md` and into the marked blocks of the READMEs.

pub mod bench;
mod big_map;
mod bridge;
pub mod experiments;
pub mod extract;
mod faults;
mod hosts;
mod kidnapped;
mod latencies;
pub mod page;
mod paired;
mod printed;
pub mod record;
mod rounds;
mod shards;
pub mod spread;
mod standing;
mod suites;
mod tracker;
pub mod trials;
mod viewing;

use crate::workspace;
use bench::Bench;
use experiments::{EXPERIMENTS, Experiment};
use record::{Record, Records};
use std::path::{Path, PathBuf};
use std::time::Instant;

/// The stored records.
#[must_use]
pub fn records_file() -> PathBuf {
    workspace().join("tests").join("results.json")
}

/// The page with every record.
#[must_use]
pub fn page_file() -> PathBuf {
    workspace().join("tests").join("RESULTS.md")
}

/// Every README of the project.
#[must_use]
pub fn readmes() -> Vec<PathBuf> {
    let folders = ["", "launch", "msgs", "services", "tests", "tests/data"];
    let mut files: Vec<PathBuf> = folders.iter().map(|one| workspace().join(one)).collect();
    let services = std::fs::read_dir(workspace().join("services"));
    files.extend(
        services
            .into_iter()
            .flatten()
            .flatten()
            .map(|entry| entry.path()),
    );
    for file in &mut files {
        file.push("README.md");
    }
    files.retain(|file| file.is_file());
    files.sort();
    files
}

/// The experiments with these keys; without any, those that are made by default.
///
/// # Errors
/// One line about a key that is not there.
pub fn chosen(keys: &[String]) -> Result<Vec<&'static Experiment>, String> {
    if keys.is_empty() {
        return Ok(EXPERIMENTS.iter().filter(|one| one.by_default).collect());
    }
    keys.iter()
        .map(|key| {
            let found = EXPERIMENTS.iter().find(|one| one.key == key);
            found.ok_or_else(|| format!("no experiment is called `{key}`; see `list`"))
        })
        .collect()
}

/// Makes experiments, stores each as soon as it is over, and renders the pages.
///
/// # Errors
/// One line for each experiment that failed; the others are stored.
pub fn measure(experiments: &[&Experiment], data: Option<PathBuf>) -> Result<(), String> {
    let mut bench = Bench::new(data)?;
    let commit = bench::commit()?;
    let mut failures = Vec::new();
    for experiment in experiments {
        eprintln!("{}: about {} min", experiment.key, experiment.minutes);
        match make(experiment, &mut bench, &commit) {
            Ok(record) => {
                let mut records = record::load(&records_file())?;
                records.insert(experiment.key.to_owned(), record);
                record::store(&records_file(), &records)?;
                render(&records)?;
            }
            Err(problem) => {
                eprintln!("{}: failed: {problem}", experiment.key);
                failures.push(format!("{}: {problem}", experiment.key));
            }
        }
    }
    if failures.is_empty() {
        Ok(())
    } else {
        Err(failures.join("\n"))
    }
}

fn make(experiment: &Experiment, bench: &mut Bench, commit: &str) -> Result<Record, String> {
    let before = zeronav_console::environment::Before::read();
    let started = Instant::now();
    bench.commands.clear();
    let measured = (experiment.make)(bench)?;
    Ok(Record {
        commit: commit.to_owned(),
        date: bench::date()?,
        commands: bench.commands.clone(),
        wall_s: started.elapsed().as_secs_f64().round(),
        machine: bench::machine(before)?,
        tables: measured.tables,
        text: measured.text,
    })
}

/// Writes the page and the blocks of the READMEs.
///
/// # Errors
/// One line naming the file.
pub fn render(records: &Records) -> Result<(), String> {
    write(&page_file(), &page::page(records))?;
    for file in readmes() {
        let name = |error: &dyn core::fmt::Display| format!("{}: {error}", file.display());
        let text = std::fs::read_to_string(&file).map_err(|error| name(&error))?;
        let new = page::filled(&text, records).map_err(|error| name(&error))?;
        if new != text {
            write(&file, &new)?;
        }
    }
    Ok(())
}

fn write(file: &Path, text: &str) -> Result<(), String> {
    std::fs::write(file, text).map_err(|error| format!("writing {}: {error}", file.display()))
}
