//! What each command does, and the exit code that it ends with.

use crate::cli::{RunArgs, SuiteArgs};
use crate::ending::Ending;
use crate::environment::Before;
use crate::interrupts::interrupts;
use crate::prepare::{self, Prepared};
use crate::run::{self, Driven};
use crate::show::recording;
use crate::show::report::RunResult;
use crate::show::terminal::{complain, lose, note, say};
use crate::suite::{self, SuiteError};
use crate::trials::{self, Trials};
use std::process::ExitCode;
use zeronav_msgs::run::RunMode;
use zeronav_shell::printable::{printable, printable_json};

/// The scenario's expectations were met.
pub const EXIT_PASS: u8 = 0;
/// An expectation was not met.
pub const EXIT_FAIL: u8 = 1;
/// Usage or configuration.
pub const EXIT_USAGE: u8 = 2;
/// A service is beyond its budget.
pub const EXIT_SERVICE: u8 = 3;
pub use crate::show::terminal::EXIT_OUTPUT;
/// Interrupted.
pub const EXIT_INTERRUPTED: u8 = 130;

/// `zeronav run`.
#[must_use]
pub fn run(arguments: &RunArgs) -> ExitCode {
    let prepared = match prepare::prepare(arguments) {
        Ok(prepared) => prepared,
        Err(problem) => return usage(&problem),
    };
    let before = Before::read();
    let driven = match run_prepared(&prepared) {
        Ok(driven) => driven,
        Err(problem) => return usage(&problem),
    };
    let (driven, trials) = driven;
    let environment = before.environment();
    let result = match &trials {
        None => crate::result::result(&prepared, &driven, environment),
        Some(trials) => crate::result::of_trials(&prepared, &driven, trials, environment),
    };
    if let Err(problem) = leave(&prepared, &driven, &result) {
        lose(&problem);
    }
    explain(&driven.ending);
    if arguments.json {
        say_json(&result);
    } else {
        say(&result.to_text());
    }
    exit_code(&driven.ending, result.verdict == "pass")
}

/// The drive, or the last one of the trials and what they gave.
fn run_prepared(prepared: &Prepared) -> Result<(Driven, Option<Trials>), String> {
    let interrupted = interrupts()?;
    let Some(wanted) = prepared.trials else {
        return Ok((run::drive(prepared, None, &interrupted)?, None));
    };
    let mut trials = trials::make(prepared, wanted, &interrupted)?;
    let last = trials.drives.pop().ok_or("no trial was made")?;
    Ok((last, Some(trials)))
}

fn exit_code(ending: &Ending, pass: bool) -> ExitCode {
    ExitCode::from(match ending {
        Ending::Interrupted => EXIT_INTERRUPTED,
        // A service that says that its configuration is wrong.
        Ending::Died { code: Some(2), .. } => EXIT_USAGE,
        Ending::Died { .. } | Ending::NotReady(_) | Ending::Silent(_) => EXIT_SERVICE,
        Ending::Task(..) | Ending::Redirected | Ending::Timeout | Ending::TrialsOver if pass => {
            EXIT_PASS
        }
        Ending::Task(..) | Ending::Redirected | Ending::Timeout | Ending::TrialsOver => EXIT_FAIL,
    })
}

/// Writes what a run leaves in its folder.
fn leave(prepared: &Prepared, driven: &Driven, result: &RunResult) -> Result<(), String> {
    let write =
        |name: &str, text: String| crate::leave::write(&prepared.directory.join(name), &text);
    let json = serde_json::to_string_pretty(result).map_err(|error| error.to_string())?;
    write("result.json", json + "\n")?;
    if prepared.mode == RunMode::Lockstep {
        let last_tick = driven.end_tick.saturating_sub(1);
        write("answers.csv", driven.collector.hash.to_csv(last_tick))?;
    }
    if prepared.trials.is_none() {
        let recording = crate::record::recording(prepared, driven, result);
        let json = serde_json::to_string(&recording).map_err(|error| error.to_string())?;
        write(recording::FILE, json + "\n")?;
    }
    write(
        "run.svg",
        crate::result::picture(prepared, driven, result).to_svg(),
    )
}

/// Says on standard error why a run could not go on.
fn explain(ending: &Ending) {
    match ending {
        Ending::Died { role, how, log, .. } => {
            complain(&format!(
                "{role} ended during the run: {how}; the end of its log:"
            ));
            for line in log {
                note(&format!("  {}", printable(line)));
            }
        }
        Ending::NotReady(roles) => {
            let names: Vec<&str> = roles.iter().map(|role| role.label()).collect();
            complain(&format!("not ready in time: {}", names.join(", ")));
        }
        Ending::Silent(role) => complain(&format!("{role} stopped answering")),
        Ending::Interrupted => complain("interrupted, everything is stopped"),
        Ending::Task(..) | Ending::Redirected | Ending::Timeout | Ending::TrialsOver => {}
    }
}

/// `zeronav suite`.
#[must_use]
pub fn suite(arguments: &SuiteArgs) -> ExitCode {
    let interrupted = match interrupts() {
        Ok(interrupted) => interrupted,
        Err(problem) => return usage(&problem),
    };
    match suite::suite(arguments, &interrupted) {
        Ok(report) if arguments.json => say_json(&report),
        Ok(report) => say(&report.to_text()),
        Err(SuiteError::Usage(problem)) => return usage(&problem),
        Err(SuiteError::Lost(problem)) => {
            lose(&problem);
            return ExitCode::from(EXIT_OUTPUT);
        }
        Err(SuiteError::Interrupted(report)) => {
            match report {
                Some(report) if arguments.json => say_json(&report),
                Some(report) => say(&report.to_text()),
                None => {}
            }
            complain("interrupted, every run is stopped");
            return ExitCode::from(EXIT_INTERRUPTED);
        }
    }
    ExitCode::from(EXIT_PASS)
}

/// Complains in one line; the exit code of usage and configuration.
#[must_use]
pub fn usage(problem: &str) -> ExitCode {
    complain(problem);
    ExitCode::from(EXIT_USAGE)
}

pub(crate) fn say_json(value: &impl serde::Serialize) {
    match serde_json::to_string_pretty(value) {
        Ok(text) => say(&(printable_json(&text).into_owned() + "\n")),
        Err(error) => complain(&format!("no JSON form: {error}")),
    }
}
