//! `zeronav compare --lockstep`: drives both sides in lockstep, records them, and says where they begin to differ.

use super::cli::CompareArgs;
use crate::bag::diff::{Beside, beside};
use crate::commands::drive_and_judge;
use crate::recorder::RecordTo;
use crate::run_plan::{RunPlan, Source};
use serde_json::json;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use zeronav_console::exit::{EXIT_FAIL, EXIT_PASS, EXIT_USAGE};
use zeronav_console::interrupts::interrupts;
use zeronav_console::terminal::{complain, say, say_json};
use zeronav_measure::result::RunResult;
use zeronav_msgs::run::RunMode;
use zeronav_recorder::compare::Scope;
use zeronav_shell::printable::printable;

/// Why nothing is compared: in a line, and the exit code.
struct NotCompared(String, ExitCode);

impl From<String> for NotCompared {
    fn from(why: String) -> Self {
        Self(why, ExitCode::from(EXIT_USAGE))
    }
}

/// Drives both sides and compares what was recorded of them.
pub(super) fn compare(arguments: &CompareArgs) -> ExitCode {
    match both(arguments) {
        Ok((results, beside)) => {
            if arguments.output.json {
                let [a, b] = &results;
                say_json(&json!({ "comparison": beside.to_json(), "a": a, "b": b }));
            } else {
                say(&to_text(&results, &beside));
            }
            ExitCode::from(EXIT_PASS)
        }
        Err(NotCompared(why, code)) => {
            complain(&printable(&why));
            code
        }
    }
}

fn both(arguments: &CompareArgs) -> Result<([RunResult; 2], Beside), NotCompared> {
    let interrupted = interrupts()?;
    let plan = |scenario: &str| {
        arguments.output.laid_over(RunPlan {
            record: Some(RecordTo::RunFolder),
            seed: arguments.seed,
            ..RunPlan::of(Source::Named(scenario.to_owned()), RunMode::Lockstep)
        })
    };
    let a = driven(&plan(&arguments.a), &interrupted)?;
    let second = RunPlan {
        // The same seed on both sides.
        seed: Some(a.seed),
        binaries: arguments.swap.iter().cloned().collect(),
        ..plan(arguments.b.as_deref().unwrap_or(&arguments.a))
    };
    let b = driven(&second, &interrupted)?;
    let [first, second] = [&a, &b].map(file_of);
    let beside = beside(&Scope::default(), &first, &second)?;
    Ok(([a, b], beside))
}

/// A run that came to its end, whether it passed or failed.
fn driven(plan: &RunPlan, interrupted: &Arc<AtomicBool>) -> Result<RunResult, NotCompared> {
    let (result, code) = drive_and_judge(plan, interrupted)?;
    if [EXIT_PASS, EXIT_FAIL].map(ExitCode::from).contains(&code) {
        return Ok(result);
    }
    let why = format!("not compared: {}: {}", result.scenario, result.reason);
    Err(NotCompared(why, code))
}

/// The recording that a run has left.
fn file_of(result: &RunResult) -> PathBuf {
    RecordTo::RunFolder.file(Path::new(&result.directory))
}

fn to_text(results: &[RunResult; 2], beside: &Beside) -> String {
    let line = |(name, result): (&str, &RunResult)| {
        format!(
            "{name}: {} ({})\n",
            file_of(result).display(),
            result.reason
        )
    };
    let lines: String = ["a", "b"].into_iter().zip(results).map(line).collect();
    lines + &beside.to_text()
}
