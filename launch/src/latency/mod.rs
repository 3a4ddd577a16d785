//! `zeronav latency`: measures latencies with their intervals, or shows those of a run; what is
//! asserted of them decides the exit code.

mod assertion;
pub mod cli;
mod gate;
mod report;
mod table;

use crate::commands::drive_and_judge;
use crate::run_plan::{MachineLoad, RunPlan, Source};
use crate::trials::usual_time;
use assertion::Clause;
use cli::{LatencyArgs, TRIALS};
use report::{Cell, Report};
use std::path::Path;
use std::process::ExitCode;
use std::sync::atomic::Ordering;
use zeronav_console::artifacts;
use zeronav_console::environment;
use zeronav_console::exit::{EXIT_FAIL, EXIT_PASS};
use zeronav_console::interrupts::interrupts;
use zeronav_console::terminal::{complain, lose, note, say, say_json, usage};
use zeronav_measure::profile;
use zeronav_measure::result::RunResult;
use zeronav_msgs::run::RunMode;

/// What was measured, and the exit code of the first run that failed.
struct Measured {
    report: Report,
    failed: Option<ExitCode>,
}

/// `zeronav latency`.
#[must_use]
pub fn latency(arguments: &LatencyArgs) -> ExitCode {
    match gauge(arguments) {
        Ok(code) => code,
        Err(problem) => usage(&problem),
    }
}

fn gauge(arguments: &LatencyArgs) -> Result<ExitCode, String> {
    let rows: Vec<String> = profile::names().collect();
    let expression = arguments.assertion.as_deref();
    let clauses = expression.map(|text| Clause::parse_all(text, &rows));
    let clauses = clauses.transpose().map_err(|wrong| wrong.to_string())?;
    let clauses = clauses.unwrap_or_default();
    let baseline = arguments
        .baseline
        .as_deref()
        .map(Report::read)
        .transpose()?;
    let run = Path::new(&arguments.subject);
    let measured = if run.is_dir() {
        if let Some(flag) = arguments.measures() {
            return Err(format!(
                "{flag} asks for a measurement, but {} is the folder of a run",
                run.display()
            ));
        }
        gate::check_baseline(&clauses, baseline.as_ref(), &[])?;
        recorded(run)?
    } else {
        measure(arguments, &clauses, baseline.as_ref())?
    };
    finish(arguments, measured, &clauses, baseline.as_ref())
}

/// Holds the assertions against what was measured, shows it and keeps it.
fn finish(
    arguments: &LatencyArgs,
    measured: Measured,
    clauses: &[Clause],
    baseline: Option<&Report>,
) -> Result<ExitCode, String> {
    let Measured { mut report, failed } = measured;
    let held = gate::hold(clauses, &report.cells, baseline);
    // What was measured is shown, whatever is wrong with the baseline.
    if let Ok(held) = &held {
        report.assertions.clone_from(held);
    }
    if arguments.output.json {
        say_json(&report);
    } else {
        say(&report.to_text());
    }
    let missed: Vec<_> = held?.into_iter().filter(|one| !one.met).collect();
    if let Some(file) = &arguments.save_baseline {
        if failed.is_some() {
            complain(&format!("{} is not written: a run failed", file.display()));
        } else {
            save(&report, file);
        }
    }
    let busy = environment::busy().map_or_else(String::new, |busy| format!("; {busy}"));
    for one in &missed {
        complain(&format!(
            "{} is not met: {} (n {}), {} Hz, {}{busy}",
            one.clause, one.said, one.n, one.rate_hz, one.load
        ));
    }
    let code = if missed.is_empty() {
        EXIT_PASS
    } else {
        EXIT_FAIL
    };
    Ok(failed.unwrap_or(ExitCode::from(code)))
}

fn save(report: &Report, file: &Path) {
    let text = serde_json::to_string_pretty(report).map_err(|error| error.to_string());
    let written = text.and_then(|text| artifacts::write(file, &(text + "\n")));
    if let Err(problem) = written {
        lose(&problem);
    }
}

/// The latencies of a run that was driven before.
fn recorded(run: &Path) -> Result<Measured, String> {
    let mut result = RunResult::read(run)?;
    result.directory = run.display().to_string();
    let mut report = Report::new();
    report.cells.push(Cell::of(&result)?);
    Ok(Measured {
        report,
        failed: None,
    })
}

/// Makes the trials at every rate under every load.
fn measure(
    arguments: &LatencyArgs,
    clauses: &[Clause],
    baseline: Option<&Report>,
) -> Result<Measured, String> {
    environment::warn_when_busy();
    let trials = arguments.trials.unwrap_or(TRIALS);
    let rates_hz: Vec<Option<f64>> = match &arguments.rate[..] {
        [] => vec![None],
        rates_hz => rates_hz.iter().copied().map(Some).collect(),
    };
    let loads = match &arguments.load[..] {
        [] => &[MachineLoad::Idle][..],
        loads => loads,
    };
    let cells = rates_hz.iter().flat_map(|rate_hz| {
        let of_load = move |load: &MachineLoad| (*rate_hz, *load);
        loads.iter().map(of_load)
    });
    let cells: Vec<(Option<f64>, MachineLoad)> = cells.collect();
    let named: Vec<_> = cells
        .iter()
        .map(|(rate, load)| (*rate, load.label()))
        .collect();
    gate::check_baseline(clauses, baseline, &named)?;
    if let Some(problem) = gate::untold(clauses, trials) {
        return Err(problem);
    }
    let interrupted = interrupts()?;
    let mut measured = Measured {
        report: Report::new(),
        failed: None,
    };
    if cells.len() > 1 {
        let all = u64::from(trials) * cells.len() as u64;
        note(&format!("{all} trials in all: {}", usual_time(all)));
    }
    for (rate_hz, load) in cells {
        let plan = plan(arguments, trials, rate_hz, load);
        let (result, code) = drive_and_judge(&plan, &interrupted)?;
        measured.report.cells.push(Cell::of(&result)?);
        if code != ExitCode::SUCCESS {
            measured.failed.get_or_insert(code);
        }
        if interrupted.load(Ordering::Relaxed) {
            break;
        }
    }
    Ok(measured)
}

fn plan(arguments: &LatencyArgs, trials: u32, rate_hz: Option<f64>, load: MachineLoad) -> RunPlan {
    arguments.output.laid_over(RunPlan {
        trials: Some(trials),
        rate_hz,
        load,
        seed: arguments.seed,
        delays: arguments.inject.iter().copied().collect(),
        ..RunPlan::of(Source::Named(arguments.subject.clone()), RunMode::RealTime)
    })
}
