//! `zeronav compare`: two scenarios, or one with two binaries in a seat, measured in turn round by
//! round on the same seeds, or driven in lockstep and compared message by message.

pub mod cli;
mod lockstep;

use crate::bag::diff::{DiffArgs, diff};
use crate::commands::{exit_code, explain};
use crate::drive::drive;
use crate::ending::Ending;
use crate::prepare::{Prepared, prepare};
use crate::run_plan::{RunPlan, Source};
use crate::trial_runner::Quota;
use crate::trials::{timing, usual_time};
use cli::CompareArgs;
use core::fmt::Write;
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use zeronav_casts::Cast;
use zeronav_console::artifacts;
use zeronav_console::environment;
use zeronav_console::exit::EXIT_PASS;
use zeronav_console::interrupts::interrupts;
use zeronav_console::terminal::{lose, note, say, say_json, usage};
use zeronav_measure::distribution::to_us;
use zeronav_measure::paired::{self, ROUNDS, Ratio};
use zeronav_measure::profile::{self, RoundProfile};
use zeronav_measure::{DEADLINE_NS, Event};
use zeronav_msgs::run::RunMode;

/// What `--json` prints and `comparison.json` holds.
#[derive(Debug, Serialize)]
struct Comparison {
    a: String,
    b: String,
    /// Rounds that both sides have finished.
    rounds: usize,
    rows: Vec<Row>,
    /// Folders with the logs.
    directories: [String; 2],
}

/// One latency of both sides.
#[derive(Debug, Serialize)]
struct Row {
    name: String,
    n: [usize; 2],
    /// Median over the rounds of their medians.
    p50_us: [Option<f64>; 2],
    /// The second side over the first.
    ratio: Option<f64>,
    interval: Option<[f64; 2]>,
    verdict: &'static str,
}

/// `zeronav compare`.
#[must_use]
pub fn compare(arguments: &CompareArgs) -> ExitCode {
    if let Some(runs) = recorded(arguments) {
        if arguments.lockstep || arguments.seed.is_some() {
            return usage("recorded runs are compared as they are, without --lockstep and --seed");
        }
        return diff(&runs);
    }
    if arguments.lockstep {
        return lockstep::compare(arguments);
    }
    match sides(arguments) {
        Ok(code) => code,
        Err(problem) => usage(&problem),
    }
}

/// Both sides, where they are recorded runs.
fn recorded(arguments: &CompareArgs) -> Option<DiffArgs> {
    let [a, b] = [&arguments.a, arguments.b.as_ref()?].map(PathBuf::from);
    let is_run = |run: &Path| run.join("result.json").is_file();
    let is_recording = |run: &Path| run.extension().is_some_and(|it| it == "mcap");
    let are_runs = [&a, &b].iter().all(|run| is_run(run) || is_recording(run));
    are_runs.then_some(DiffArgs {
        json: arguments.output.json,
        a,
        b,
        from: None,
        to: None,
    })
}

fn sides(arguments: &CompareArgs) -> Result<ExitCode, String> {
    let plan = |scenario: &str| {
        arguments.output.laid_over(RunPlan {
            trials: Some(arguments.trials),
            seed: arguments.seed,
            ..RunPlan::of(Source::Named(scenario.to_owned()), RunMode::RealTime)
        })
    };
    let first = prepare(&plan(&arguments.a))?;
    let other = RunPlan {
        // The same seeds on both sides.
        seed: Some(first.seed),
        binaries: arguments.swap.iter().cloned().collect(),
        ..plan(arguments.b.as_deref().unwrap_or(&arguments.a))
    };
    let second = prepare(&other).inspect_err(|_| forget(&first))?;
    let interrupted = interrupts()?;
    environment::warn_when_busy();
    note(&format!(
        "{} drives with {} trials in all: {}",
        2 * ROUNDS,
        2 * arguments.trials,
        usual_time(2 * u64::from(arguments.trials))
    ));
    let (rounds, ending) = turns([&first, &second], arguments.trials as usize, &interrupted)?;
    let mut b = second.scenario.name.clone();
    for (role, binary) in &arguments.swap {
        let _ = write!(b, ", {role} {}", binary.display());
    }
    let comparison = Comparison {
        a: first.scenario.name.clone(),
        b,
        rounds: rounds.len(),
        rows: profile::names().map(|name| row(name, &rounds)).collect(),
        directories: [&first, &second].map(|side| side.directory.display().to_string()),
    };
    keep(&comparison, &first);
    if let Some(ending) = &ending {
        explain(ending);
    }
    if arguments.output.json {
        say_json(&comparison);
    } else {
        say(&comparison.to_text());
    }
    let failed = ending.map(|ending| exit_code(&ending, false));
    Ok(failed.unwrap_or(ExitCode::from(EXIT_PASS)))
}

/// Removes the folder of a side that is not measured, which is empty.
fn forget(side: &Prepared) {
    let out = side.directory.parent();
    let empty = [
        Some(side.directory.join("logs")),
        Some(side.directory.clone()),
    ];
    for folder in empty.into_iter().flatten().chain(out.map(Path::to_owned)) {
        let _ = std::fs::remove_dir(folder);
    }
}

/// Makes the rounds of both sides in turn, the other side first in every second one. Ends with the
/// first drive that did not make its trials.
fn turns(
    sides: [&Prepared; 2],
    trials: usize,
    interrupted: &Arc<AtomicBool>,
) -> Result<(Vec<[RoundProfile; 2]>, Option<Ending>), String> {
    let mut rounds = Vec::new();
    let mut before = 0;
    for round in 0..ROUNDS {
        let n = trials / ROUNDS + usize::from(round < trials % ROUNDS);
        let mut both = [None, None];
        for side in [round % 2, 1 - round % 2] {
            let prepared = sides[side];
            let quota = Quota {
                n,
                seed: prepared.seed.wrapping_add(round as u64),
                before,
                total: 2 * trials,
                round: round + 1,
            };
            let driven = drive(prepared, Some(quota), interrupted)?;
            before += driven.trials.len();
            if driven.ending != Ending::TrialsOver {
                return Ok((rounds, Some(driven.ending)));
            }
            let events: Vec<Event> = driven.trials.into_iter().map(|it| it.event).collect();
            let records = &driven.collector.records;
            both[side] = Some(RoundProfile::of(&events, records, None, timing(prepared)));
        }
        if let [Some(a), Some(b)] = both {
            rounds.push([a, b]);
        }
    }
    Ok((rounds, None))
}

fn keep(comparison: &Comparison, first: &Prepared) {
    let text = serde_json::to_string_pretty(comparison).map_err(|error| error.to_string());
    let written =
        text.and_then(|text| artifacts::write_in(&first.folder, "comparison.json", &(text + "\n")));
    if let Err(problem) = written {
        lose(&problem);
    }
}

/// A latency of all rounds.
fn row(name: String, rounds: &[[RoundProfile; 2]]) -> Row {
    let times_ns = |round: &[RoundProfile; 2]| {
        let [a, b] = round.each_ref().map(|side| side.times_ns(&name));
        (a, b)
    };
    let times_ns: Vec<(Vec<u64>, Vec<u64>)> = rounds.iter().map(times_ns).collect();
    let ratio = paired::ratio(&times_ns);
    let middle_us = |middle_ns: Option<f64>| middle_ns.map(us);
    Row {
        n: [
            times_ns.iter().map(|(a, _)| a.len()).sum(),
            times_ns.iter().map(|(_, b)| b.len()).sum(),
        ],
        p50_us: [
            middle_us(paired::middle_ns(times_ns.iter().map(|(a, _)| a))),
            middle_us(paired::middle_ns(times_ns.iter().map(|(_, b)| b))),
        ],
        ratio: ratio.map(|ratio| ratio.ratio),
        interval: ratio.map(|ratio| ratio.interval),
        verdict: verdict(ratio, rounds.len()),
        name,
    }
}

fn verdict(ratio: Option<Ratio>, rounds: usize) -> &'static str {
    match ratio {
        None if rounds < ROUNDS => "too few rounds",
        None => "no ratio",
        Some(ratio) if ratio.is_no_difference() => "no difference",
        Some(ratio) if ratio.ratio > 1.0 => "slower",
        Some(_) => "faster",
    }
}

fn us(time_ns: f64) -> f64 {
    to_us(time_ns.round().to_u64())
}

impl Comparison {
    fn to_text(&self) -> String {
        let mut text = String::new();
        let _ = writeln!(text, "A {}\nB {}", self.a, self.b);
        let _ = writeln!(
            text,
            "{} rounds of each in turn, on the same seeds\n\n  {:<30} {:>6} {:>6} {:>10} {:>10}  {:<22} B is",
            self.rounds, "median [us]", "n of A", "n of B", "A", "B", "B / A, 95 % interval"
        );
        for row in self.rows.iter().filter(|row| row.n.iter().all(|n| *n > 0)) {
            let cell = |value: Option<f64>| {
                value.map_or_else(|| "-".to_owned(), |value| format!("{value:.0}"))
            };
            let ratio = row.ratio.zip(row.interval);
            let ratio = ratio.map_or_else(
                || "-".to_owned(),
                |(ratio, [low, high])| format!("{ratio:.3} [{low:.3}, {high:.3}]"),
            );
            let _ = writeln!(
                text,
                "  {:<30} {:>6} {:>6} {:>10} {:>10}  {ratio:<22} {}",
                row.name,
                row.n[0],
                row.n[1],
                cell(row.p50_us[0]),
                cell(row.p50_us[1]),
                row.verdict
            );
        }
        let _ = writeln!(
            text,
            "\n  each row by itself: of twenty rows without a difference one shows one by chance; \
             an unanswered sample counts as {:.0} s\n  {}\n  {}",
            zeronav_msgs::time::seconds(DEADLINE_NS),
            self.directories[0],
            self.directories[1]
        );
        text
    }
}
