//! `zeronav suite recordings`: plays every recording in a folder to some seats, and says which give something else now,
//! and which seats have become slower.

use crate::bag::diff::in_words as difference_in_words;
use crate::output_args::OutputArgs;
use crate::replay::{NotCompared, ReplayArgs, open_seat};
use clap::Args;
use core::fmt::Write;
use serde::Serialize;
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use zeronav_console::arguments::seat;
use zeronav_console::exit::{EXIT_FAIL, EXIT_INTERRUPTED, EXIT_PASS};
use zeronav_console::interrupts::interrupts;
use zeronav_console::terminal::{complain, note, say, say_json, usage};
use zeronav_msgs::role::Role;
use zeronav_recorder::figures::{Figure, MEDIAN_ERROR, median_computing};
use zeronav_scenario::settings::DriverArgs;
use zeronav_shell::printable::printable;

/// The word for it on the command line.
pub(crate) const SUITE: &str = "recordings";

/// Over them in the help.
const HEADING: &str = "Of recordings";

/// Most recordings of one suite.
const FILES_MAX: usize = 10_000;

/// What only a suite of recordings takes.
#[derive(Debug, Clone, Default, Args)]
pub struct RecordingsArgs {
    /// The seats that are started, to which all else is played; without, all four behind the robot.
    #[arg(long, value_name = "ROLE[,ROLE]", value_delimiter = ',', value_parser = open_seat, help_heading = HEADING)]
    pub open: Vec<Role>,
    /// Another binary in one of these seats. May be given several times.
    #[arg(long, value_name = "ROLE=BINARY", value_parser = seat, help_heading = HEADING)]
    pub swap: Vec<(Role, PathBuf)>,
    /// Configure the seats by this scenario (its name or path) in place of the one in each recording.
    #[arg(long, value_name = "SCENARIO", help_heading = HEADING)]
    pub scenario: Option<String>,
    /// Exit code 1 when the median computing time of a seat is above this many times that in the recording.
    #[arg(long, value_name = "FACTOR", value_parser = factor, help_heading = HEADING)]
    pub slower: Option<f64>,
}

impl RecordingsArgs {
    /// True when any is given.
    pub(crate) fn is_given(&self) -> bool {
        let lists = self.open.is_empty() && self.swap.is_empty();
        let one = self.scenario.is_some() || self.slower.is_some();
        one || !lists
    }
}

/// A factor by which a time may grow.
fn factor(text: &str) -> Result<f64, String> {
    let factor: Option<f64> = text.parse().ok();
    let factor = factor.filter(|it| it.is_finite() && *it > 0.0);
    factor.ok_or_else(|| format!("`{text}` is no factor such as 1.5"))
}

/// Median computing time of a seat. [ms]
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
struct Computing {
    recorded_ms: Option<f64>,
    now_ms: Option<f64>,
}

impl Computing {
    /// Now per recorded.
    fn factor(self) -> Option<f64> {
        let both = self.now_ms.zip(self.recorded_ms);
        both.filter(|(_, before)| *before > 0.0)
            .map(|(now, before)| now / before)
    }
}

/// What became of a recording.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
enum Verdict {
    Equal,
    /// It holds nothing of what the seats send: the log of another robot.
    NothingToCompare,
    /// Where, in words.
    Differs(String),
    /// Why not, in words.
    NotPlayed(String),
}

/// A recording.
#[derive(Debug, Clone, Serialize)]
struct Row {
    file: String,
    verdict: Verdict,
    /// By the label of the seat.
    computing: BTreeMap<&'static str, Computing>,
    /// Median error of the place now, where the recording has the truth. [m]
    error_m: Option<f64>,
    /// The comparison, as `zeronav replay --json` has it.
    comparison: Value,
}

/// A suite of recordings.
#[derive(Debug)]
pub struct Plan<'a> {
    /// Where they are.
    pub folder: &'a Path,
    /// What only they take.
    pub arguments: &'a RecordingsArgs,
    /// Who drives.
    pub driver: &'a DriverArgs,
    /// What it shows.
    pub output: OutputArgs,
}

/// Plays them.
#[must_use]
pub fn recordings(plan: &Plan<'_>) -> ExitCode {
    let found = plan.files().and_then(|files| {
        plan.replay(Path::new("")).check_seats()?;
        Ok((files, interrupts()?))
    });
    let (files, interrupted) = match found {
        Ok(found) => found,
        Err(problem) => return usage(&problem),
    };
    let mut rows = Vec::new();
    for (n, file) in files.iter().enumerate() {
        if plan.output_is_shown() {
            note(&format!(
                "{} of {}: {}",
                n + 1,
                files.len(),
                printable(&file.display().to_string())
            ));
        }
        let row = plan.play(file, &interrupted);
        if interrupted.load(Ordering::Relaxed) {
            break;
        }
        rows.push(row);
    }
    if plan.output.json {
        say_json(&serde_json::json!({ "recordings": rows }));
    } else {
        say(&to_text(&rows));
    }
    if interrupted.load(Ordering::Relaxed) {
        complain(&format!(
            "interrupted after {} of {} recordings",
            rows.len(),
            files.len()
        ));
        return ExitCode::from(EXIT_INTERRUPTED);
    }
    ExitCode::from(if rows.iter().any(|row| plan.fails(row)) {
        EXIT_FAIL
    } else {
        EXIT_PASS
    })
}

impl Plan<'_> {
    fn output_is_shown(&self) -> bool {
        !self.output.headless && !self.output.json
    }

    /// The MCAP files in the folder, by name.
    fn files(&self) -> Result<Vec<PathBuf>, String> {
        let folder = self.folder;
        let mut files = Vec::new();
        self.check_out(folder)?;
        for entry in entries(folder)? {
            if entry.is_dir() {
                files.extend(entries(&entry)?.into_iter().filter(|it| is_recording(it)));
            } else if is_recording(&entry) {
                files.push(entry);
            }
            if files.len() > FILES_MAX {
                return Err(format!(
                    "{}: more than {FILES_MAX} recordings",
                    folder.display()
                ));
            }
        }
        if files.is_empty() {
            return Err(format!(
                "{}: no MCAP file is in it; `zeronav run --record` makes one, `zeronav import` makes one of the log of \
                 another robot",
                folder.display()
            ));
        }
        Ok(files)
    }

    /// What plays a recording.
    fn replay(&self, file: &Path) -> ReplayArgs {
        let open = if self.arguments.open.is_empty() {
            crate::open_loop::SEATS.to_vec()
        } else {
            self.arguments.open.clone()
        };
        ReplayArgs {
            file: file.to_owned(),
            open,
            swap: self.arguments.swap.clone(),
            from: None,
            to: None,
            equal: false,
            scenario: self.arguments.scenario.clone(),
            driver: self.driver.clone(),
            output: OutputArgs {
                headless: true,
                ..self.output.clone()
            },
        }
    }

    /// Accepts a folder for the runs that is not among the recordings: they would be found there the next time.
    fn check_out(&self, folder: &Path) -> Result<(), String> {
        let absolute = |path: &Path| path.canonicalize().or_else(|_| std::path::absolute(path));
        let paths = [folder, &self.output.out].map(absolute);
        match paths {
            [Ok(folder), Ok(out)] if folder == out => Err(format!(
                "the runs of this suite would land among its recordings, in {}: name another folder with --out",
                self.output.out.display()
            )),
            _ => Ok(()),
        }
    }

    fn play(&self, file: &Path, interrupted: &Arc<AtomicBool>) -> Row {
        let replay = self.replay(file);
        let mut row = Row {
            file: file.display().to_string(),
            verdict: Verdict::Equal,
            computing: BTreeMap::new(),
            error_m: None,
            comparison: Value::Null,
        };
        let beside = match replay.compared(interrupted) {
            Ok((_, beside)) => beside,
            Err(NotCompared { why, .. }) => {
                row.verdict = Verdict::NotPlayed(why);
                return row;
            }
        };
        let value = |second: bool, name: &str| value(&beside.figures[usize::from(second)], name);
        for role in replay.open {
            let name = median_computing(role);
            let computing = Computing {
                recorded_ms: value(false, &name),
                now_ms: value(true, &name),
            };
            row.computing.insert(role.label(), computing);
        }
        row.error_m = value(true, MEDIAN_ERROR);
        row.verdict = if beside.is_equal() {
            Verdict::Equal
        } else if beside.cannot_differ() {
            Verdict::NothingToCompare
        } else {
            Verdict::Differs(match &beside.comparison.first {
                Some(first) => difference_in_words(first),
                None => beside
                    .comparison
                    .incomplete
                    .iter()
                    .flatten()
                    .next()
                    .map_or_else(
                        || "nothing was compared".to_owned(),
                        |why| format!("not complete: {why}"),
                    ),
            })
        };
        row.comparison = beside.to_json();
        row
    }

    /// True for what a regression test is to fail with.
    fn fails(&self, row: &Row) -> bool {
        let is_changed = !self.arguments.swap.is_empty() || !self.driver.settings().is_empty();
        let is_slower = |computing: &Computing| {
            let limit = self.arguments.slower;
            computing
                .factor()
                .zip(limit)
                .is_some_and(|(factor, limit)| factor > limit)
        };
        match row.verdict {
            Verdict::NotPlayed(_) => true,
            Verdict::Differs(_) if !is_changed => true,
            _ => row.computing.values().any(is_slower),
        }
    }
}

fn value(figures: &[Figure], name: &str) -> Option<f64> {
    figures.iter().find(|figure| figure.name == name)?.value
}

fn is_recording(file: &Path) -> bool {
    file.extension().is_some_and(|it| it == "mcap") && file.is_file()
}

/// What is in a folder, by name.
fn entries(folder: &Path) -> Result<Vec<PathBuf>, String> {
    let wrong = |error: std::io::Error| format!("{}: {error}", folder.display());
    let mut entries = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(wrong)? {
        entries.push(entry.map_err(wrong)?.path());
    }
    entries.sort();
    Ok(entries)
}

fn to_text(rows: &[Row]) -> String {
    let mut text = String::new();
    let mut counts = [0_usize; 4];
    for row in rows {
        let (n, said) = match &row.verdict {
            Verdict::Equal => (0, "equal".to_owned()),
            Verdict::Differs(first) => (1, format!("differs: {first}")),
            Verdict::NothingToCompare => (2, "nothing to compare".to_owned()),
            Verdict::NotPlayed(why) => (3, format!("not played: {why}")),
        };
        counts[n] += 1;
        let _ = writeln!(text, "{}: {}", printable(&row.file), printable(&said));
        if let Some(error_m) = row.error_m {
            let _ = writeln!(text, "  median error of the place {error_m:.3} m");
        }
        for (role, computing) in &row.computing {
            let ms = |ms: Option<f64>| ms.map_or_else(|| "-".to_owned(), |ms| format!("{ms:.3}"));
            let factor = computing.factor();
            let factor = factor.map_or_else(String::new, |factor| format!("  x {factor:.2}"));
            let _ = writeln!(
                text,
                "  {role:<16} {:>9} -> {:>9} ms{factor}",
                ms(computing.recorded_ms),
                ms(computing.now_ms)
            );
        }
    }
    let [equal, differ, nothing, not_played] = counts;
    let _ = writeln!(
        text,
        "{} recordings: {equal} equal, {differ} differ, {nothing} with nothing to compare, {not_played} not played",
        rows.len()
    );
    text
}
