//! `zeronav why`: why does it stand, slow down, turn back, take this way?

mod around;
pub mod cli;
pub(crate) mod live;
mod past;
mod sentence;

use crate::control::request::RunReport;
use crate::running;
use cli::WhyArgs;
use serde_json::json;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use zeronav_console::exit::EXIT_PASS;
use zeronav_console::terminal::{say, say_json, usage};
use zeronav_measure::result::RunResult;
use zeronav_measure::result::moment::{self, Moment, Task};
use zeronav_msgs::task::TaskState;

/// Where a run leaves its folder.
const RUNS: &str = "runs";

/// `zeronav why`.
#[must_use]
pub fn why(arguments: &WhyArgs) -> ExitCode {
    match run(arguments) {
        Ok(()) => ExitCode::from(EXIT_PASS),
        Err(problem) => usage(&problem),
    }
}

fn run(arguments: &WhyArgs) -> Result<(), String> {
    let json = arguments.stack.json;
    let Some((run, time_s)) = run_and_time(arguments)? else {
        let stack = running::find(arguments.stack.domain.as_deref())?;
        let (moment, around) = match arguments.ago {
            Some(ago_s) => live::ago(&stack, ago_s)?,
            None => live::now(&stack)?,
        };
        tell(&moment, &around, json);
        return Ok(());
    };
    let result = past::read(&run)?;
    if arguments.all {
        return all(&result, json);
    }
    let (moment, around) = past::at(&result, time_s)?;
    tell(&moment, &around, json);
    Ok(())
}

/// The run and the time that are asked for; `None` = the running stack.
fn run_and_time(arguments: &WhyArgs) -> Result<Option<(PathBuf, Option<f64>)>, String> {
    let Some(of) = &arguments.of else {
        return Ok(None);
    };
    let time_s = of.to_str().and_then(|text| cli::time(text).ok());
    match (time_s, arguments.time) {
        // A folder may be called like a number.
        (Some(time_s), None) if !of.exists() => {
            Ok(Some((past::newest(Path::new(RUNS))?, Some(time_s))))
        }
        (_, time_s) => Ok(Some((of.clone(), time_s))),
    }
}

/// Why the robot does what it does, for the report of a run: what its stages said last, and how it
/// moves by now.
#[must_use]
pub(crate) fn line(mut moment: Moment, now: &Now, report: &RunReport) -> String {
    let since_s = report.time_s - moment.time_s;
    moment.task = moment.task.map(|task| task.after(since_s));
    moment.time_s = report.time_s;
    if let (Some([v_mps, w_radps]), Some(command)) = (now.twist, &mut moment.command) {
        (command.v_mps, command.w_radps) = (v_mps, w_radps);
    }
    if let Some(request) = &mut moment.request {
        request.ages_ms = now.ages_ms;
    }
    if report.goal.is_none() && moment.task.is_none() {
        // That there is no goal the planner says before the first tick, which is kept nowhere.
        let none = moment::Path::of(&zeronav_msgs::path::Path::default(), None);
        moment.path = moment.path.or(none);
    }
    let around = around::Around {
        paused: report.paused,
        stopping: now.stopping,
        ..past::around(&report.restarts, &report.faults, report.time_s)
    };
    sentence::why(&moment, &around)
}

/// Why the robot did what it did at a moment of a run, as far as its stages have said it.
#[must_use]
pub(crate) fn in_words(moment: &Moment) -> String {
    sentence::why(moment, &around::Around::default())
}

/// Why a task has failed, or will when it has waited, as the report of a run says it; `None` when neither
/// is so.
#[must_use]
pub(crate) fn failure(task: &Task) -> Option<String> {
    let is_told = task.state == TaskState::Failed || task.waits();
    is_told.then(|| sentence::words::failure(task))
}

/// What a moment that is kept does not tell.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Now {
    /// The run is ending.
    pub stopping: bool,
    /// Speed [m/s] and yaw rate [rad/s] of the newest odometry.
    pub twist: Option<[f64; 2]>,
    /// Ages of odometry, scan, map and path at the newest request. [ms]
    pub ages_ms: [u16; 4],
}

fn tell(moment: &Moment, around: &around::Around, json: bool) {
    let text = sentence::why(moment, around);
    if json {
        say_json(&json!({ "why": text, "moment": moment, "missing": names(around) }));
    } else {
        say(&(text + "\n"));
    }
}

/// Seats of the services that do not answer.
fn names(around: &around::Around) -> Vec<&str> {
    let missing = around.missing.iter();
    missing.map(|missing| missing.role.as_str()).collect()
}

/// Every moment of a run.
fn all(result: &RunResult, json: bool) -> Result<(), String> {
    let mut told = Vec::new();
    for moment in &result.reasons {
        let (moment, around) = past::at(result, Some(moment.time_s.min(result.time_s)))?;
        told.push((sentence::why(&moment, &around), moment));
    }
    if json {
        let all: Vec<_> = told
            .iter()
            .map(|(why, moment)| json!({ "why": why, "moment": moment }))
            .collect();
        say_json(&json!({ "moments": all }));
        return Ok(());
    }
    for (why, _) in told {
        say(&(why + "\n"));
    }
    Ok(())
}
