//! `zeronav replay`: drives a recorded lockstep run again and says where it begins to differ.

use crate::bag::diff::{Beside, beside};
use crate::bag::input::open;
use crate::commands::drive_and_judge;
use crate::output_args::OutputArgs;
use crate::recorder::RecordTo;
use crate::run_plan::{RunPlan, Source};
use clap::Args;
use serde_json::json;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use zeronav_console::arguments::seat;
use zeronav_console::exit::{EXIT_FAIL, EXIT_OUTPUT, EXIT_PASS};
use zeronav_console::interrupts::interrupts;
use zeronav_console::terminal::{complain, say, say_json, usage};
use zeronav_measure::result::RunResult;
use zeronav_msgs::role::Role;
use zeronav_msgs::run::RunMode;
use zeronav_recorder::file::{SCENARIO_BYTES_MAX, SCENARIO_TYPE, START};
use zeronav_recorder::read::{attachment, summary};
use zeronav_scenario::settings::DriverArgs;
use zeronav_shell::printable::printable;

/// Arguments of `zeronav replay`.
#[derive(Debug, Clone, Args)]
pub struct ReplayArgs {
    /// The MCAP file of a run with `--lockstep --record`.
    pub file: PathBuf,
    /// Another binary in a seat; it drives on its own from the first tick. May be given several times.
    #[arg(long, value_name = "ROLE=BINARY", value_parser = seat)]
    pub swap: Vec<(Role, PathBuf)>,
    /// Who drives.
    #[command(flatten)]
    pub driver: DriverArgs,
    /// What it shows.
    #[command(flatten)]
    pub output: OutputArgs,
}

/// What a recording says of how its run was driven.
struct Recorded {
    name: String,
    text: String,
    seed: u64,
}

/// `zeronav replay`: exit code 1 when the run differs although nothing in it was changed.
#[must_use]
pub fn replay(arguments: &ReplayArgs) -> ExitCode {
    let plan = match recorded(&arguments.file) {
        Ok(recorded) => arguments.plan(recorded),
        Err(problem) => return usage(&problem),
    };
    let driven = interrupts().and_then(|interrupted| drive_and_judge(&plan, &interrupted));
    let (result, code) = match driven {
        Ok(driven) => driven,
        Err(problem) => return usage(&problem),
    };
    let is_judged = [EXIT_PASS, EXIT_FAIL].map(ExitCode::from).contains(&code);
    let again = RecordTo::RunFolder.file(Path::new(&result.directory));
    let beside = if is_judged {
        beside(&arguments.file, &again)
    } else {
        Err(format!("not compared: {}", result.reason))
    };
    let beside = match beside {
        Ok(beside) => beside,
        Err(problem) => {
            if arguments.output.json {
                say_json(&json!({ "comparison": null, "result": result }));
            }
            complain(&printable(&problem));
            return if is_judged {
                ExitCode::from(EXIT_OUTPUT)
            } else {
                code
            };
        }
    };
    let is_changed = !arguments.swap.is_empty() || !plan.settings.is_empty();
    if arguments.output.json {
        say_json(&json!({ "comparison": beside.to_json(), "result": result }));
    } else {
        say(&to_text(arguments, &again, &result, &beside));
    }
    ExitCode::from(if beside.is_equal() || is_changed {
        EXIT_PASS
    } else {
        EXIT_FAIL
    })
}

fn to_text(arguments: &ReplayArgs, again: &Path, result: &RunResult, beside: &Beside) -> String {
    format!(
        "a: {}\nb: {} ({})\n{}",
        arguments.file.display(),
        again.display(),
        result.reason,
        beside.to_text()
    )
}

impl ReplayArgs {
    fn plan(&self, recorded: Recorded) -> RunPlan {
        let Recorded { name, text, seed } = recorded;
        let plan = RunPlan {
            record: Some(RecordTo::RunFolder),
            seed: Some(seed),
            binaries: self.swap.iter().cloned().collect(),
            settings: self.driver.settings(),
            ..RunPlan::of(Source::Text { name, text }, RunMode::Lockstep)
        };
        self.output.laid_over(plan)
    }
}

/// How the run in a recording was driven.
fn recorded(file: &Path) -> Result<Recorded, String> {
    let wrong = |why: &dyn core::fmt::Display| format!("{}: {why}", file.display());
    let (found, damage) = summary(open(file)?);
    if let Some(damage) = damage {
        let fix = "`zeronav bag recover` makes a whole file of what is there";
        return Err(wrong(&format!("{damage}; {fix}")));
    }
    let start = found.metadata.get(START);
    let field = |name: &str| {
        start
            .and_then(|fields| fields.get(name))
            .map(String::as_str)
    };
    match field("mode") {
        Some(mode) if mode == RunMode::Lockstep.label() => {}
        Some(_) => {
            let why = "it was recorded in real time, which nothing can drive again the same: \
                       `zeronav run SCENARIO --lockstep --record` makes one that can";
            return Err(wrong(&why));
        }
        None => return Err(wrong(&"zeronav-recorder has not written it")),
    }
    let most = usize::try_from(SCENARIO_BYTES_MAX).unwrap_or(usize::MAX);
    let attached = attachment(open(file)?, SCENARIO_TYPE, most).map_err(|error| wrong(&error))?;
    let (name, text) = attached.ok_or_else(|| {
        let why = "it holds no scenario: only a recording that `zeronav run --record` has made does, \
                   with no seat left to a process that was started by hand (--external)";
        wrong(&why)
    })?;
    let seed = field("seed").and_then(|seed| seed.parse().ok());
    Ok(Recorded {
        name: name.strip_suffix(".toml").unwrap_or(&name).to_owned(),
        text: String::from_utf8(text).map_err(|_| wrong(&"its scenario is no UTF-8"))?,
        seed: seed.ok_or_else(|| wrong(&"it does not say its seed"))?,
    })
}
