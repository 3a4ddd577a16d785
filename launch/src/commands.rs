//! `zeronav run`, `zeronav up` and `zeronav suite`, and the exit codes that they end with.

use crate::background_load::BackgroundLoad;
use crate::doctor;
use crate::drive::{Driven, drive};
use crate::ending::{self, Ending};
use crate::host;
use crate::judge::{judge, judge_trials};
use crate::on_host;
use crate::prepare::{Prepared, prepare, scenario_of};
use crate::report::folder::Outcome;
use crate::run_plan::RunPlan;
use crate::show::page;
use crate::show::recording::{self, Recording};
use crate::{picture, record, report, stay_result, trials};
use serde::Serialize;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use zeronav_console::artifacts;
use zeronav_console::environment::Before;
use zeronav_console::exit::{
    EXIT_FAIL, EXIT_INTERRUPTED, EXIT_OUTPUT, EXIT_PASS, EXIT_SERVICE, EXIT_USAGE,
};
use zeronav_console::interrupts::interrupts;
use zeronav_console::terminal::{complain, lose, note, say, say_json, usage};
use zeronav_measure::result::RunResult;
use zeronav_measure::timings::Timings;
use zeronav_measure::trace::{About, trace};
use zeronav_msgs::run::RunMode;
use zeronav_shell::printable::printable;
use zeronav_suite;
use zeronav_suite::error::SuiteError;
use zeronav_suite::plan::SuitePlan;
use zeronav_suite::ran::Ran;
use zeronav_supervise::crash_result;
use zeronav_supervise::will::Will;

/// `zeronav run`: plan, prepare, drive, judge, show.
#[must_use]
pub fn run(plan: &RunPlan, json: bool) -> ExitCode {
    if let Some(code) = serve_host(plan) {
        return code;
    }
    let driven = interrupts().and_then(|interrupted| drive_and_judge(plan, &interrupted));
    match driven {
        Ok((result, code)) => {
            show(&result, json, page::to_text);
            code
        }
        Err(problem) => usage(&problem),
    }
}

/// Prepares, drives and judges a run or its trials, writes its folder, and says on standard error
/// why it could not go on; the result, and the exit code of `zeronav run`.
///
/// # Errors
/// One line when the run could not be started at all.
pub(crate) fn drive_and_judge(
    plan: &RunPlan,
    interrupted: &Arc<AtomicBool>,
) -> Result<(RunResult, ExitCode), String> {
    let prepared = prepare(plan)?;
    if let Some(trials) = plan.trials {
        note(&format!(
            "{trials} trials: {}",
            trials::usual_time(trials.into())
        ));
    }
    let before = Before::read();
    let unseen = Driven::unseen(Ending::LaunchDied);
    let will = leave_will(&prepared, &judge(&prepared, &unseen, before.environment()));
    let (driven, result, timings) = run_and_judge(&prepared, before, interrupted)?;
    if let Err(problem) = write_files(plan, &prepared, &driven, &result, timings) {
        lose(&problem);
    }
    drop(will);
    explain(&driven.ending);
    let code = exit_code(&driven.ending, result.verdict == "pass");
    Ok((result, code))
}

fn show<R: Serialize>(result: &R, json: bool, to_text: impl FnOnce(&R) -> String) {
    if json {
        say_json(result);
    } else {
        say(&to_text(result));
    }
}

/// What was seen of a run, its result, and the times of trials.
type Judged = (Driven, RunResult, Option<Timings>);

/// Drives the run or its trials, and judges what was seen. Of trials, the drive is the last one, and
/// their times are those of all.
fn run_and_judge(
    prepared: &Prepared,
    before: Before,
    interrupted: &Arc<AtomicBool>,
) -> Result<Judged, String> {
    let _burden = BackgroundLoad::start(prepared.load)?;
    let Some(wanted) = prepared.trials else {
        let driven = drive(prepared, None, interrupted)?;
        let result = judge(prepared, &driven, before.environment());
        return Ok((driven, result, None));
    };
    let mut trials = trials::make(prepared, wanted, interrupted)?;
    let driven = trials.drives.pop().ok_or("no trial was made")?;
    let result = judge_trials(prepared, &driven, &trials, before.environment());
    Ok((driven, result, Some(trials.timings)))
}

/// Leaves a result for the case that this process cannot end its run.
fn leave_will(prepared: &Prepared, result: &impl Serialize) -> Will {
    let text = serde_json::to_vec(result).unwrap_or_default();
    Will::leave(&prepared.folder, &text)
}

/// Fills the seats of a host for the launch of another one, until it is interrupted; `None` when the plan is for a
/// host that drives.
fn serve_host(plan: &RunPlan) -> Option<ExitCode> {
    let host = plan.host.as_deref()?;
    let is_beside = scenario_of(plan).and_then(|read| on_host::is_beside(&read.scenario, host));
    match is_beside {
        Ok(false) => return None,
        Ok(true) => {}
        Err(problem) => return Some(usage(&problem)),
    }
    let served = prepare(plan).and_then(|prepared| host::serve(&prepared, host, &interrupts()?));
    Some(match served {
        Ok(()) => {
            explain(&Ending::Interrupted);
            ExitCode::from(EXIT_INTERRUPTED)
        }
        Err(problem) => usage(&problem),
    })
}

/// `zeronav up`: prepare, drive to the goals of clients, until it is to end.
#[must_use]
pub fn up(plan: &RunPlan, json: bool) -> ExitCode {
    if let Some(danger) = doctor::logout_warning() {
        note(&format!("warning: {}", printable(&danger)));
    }
    if let Some(code) = serve_host(plan) {
        return code;
    }
    let before = Before::read();
    let driven = prepare(plan).and_then(|prepared| {
        let unseen = Driven::unseen(Ending::LaunchDied);
        let unseen = stay_result::of(&prepared, &unseen, before.environment());
        let will = leave_will(&prepared, &unseen);
        let driven = drive(&prepared, None, &interrupts()?)?;
        Ok((prepared, driven, will))
    });
    let (prepared, driven, will) = match driven {
        Ok(driven) => driven,
        Err(problem) => return usage(&problem),
    };
    let result = stay_result::of(&prepared, &driven, before.environment());
    let recording = record::of_stay(&prepared, &driven, &result.outcome);
    let written = write_result(&prepared, &result)
        .and_then(|()| write_trace(&prepared, &driven))
        .and_then(|()| write_recording(&prepared, &recording))
        .and_then(|()| {
            report::write(
                &prepared.folder,
                Outcome::Stay(Box::new(result.clone())),
                recording,
            )
        });
    drop(will);
    if let Err(problem) = written {
        lose(&problem);
    }
    explain(&driven.ending);
    show(&result, json, stay_result::to_text);
    exit_code(&driven.ending, true)
}

pub(crate) fn exit_code(ending: &Ending, pass: bool) -> ExitCode {
    ExitCode::from(match ending {
        Ending::Interrupted => EXIT_INTERRUPTED,
        // A service that says that its configuration is wrong.
        Ending::Died { code: Some(2), .. } => EXIT_USAGE,
        Ending::Died { .. }
        | Ending::NotReady(_)
        | Ending::Silent(_)
        | Ending::Stalled(_)
        | Ending::Deleted
        | Ending::LaunchDied => EXIT_SERVICE,
        Ending::Task(..)
        | Ending::Redirected
        | Ending::Timeout
        | Ending::TrialsOver
        | Ending::Down => {
            if pass {
                EXIT_PASS
            } else {
                EXIT_FAIL
            }
        }
    })
}

/// Writes the object that `--json` prints into the run's folder.
fn write_result(prepared: &Prepared, result: &impl Serialize) -> Result<(), String> {
    let json = serde_json::to_string_pretty(result).map_err(|error| error.to_string())?;
    artifacts::write_in(&prepared.folder, crash_result::FILE, &(json + "\n"))
}

/// Writes the recording and the still picture of it.
fn write_recording(prepared: &Prepared, recording: &Recording) -> Result<(), String> {
    let write = |name: &str, text: &str| artifacts::write_in(&prepared.folder, name, text);
    let json = serde_json::to_string(recording).map_err(|error| error.to_string())?;
    write(recording::FILE, &(json + "\n"))?;
    write(picture::STILL, &picture::still(recording))
}

/// Writes where the time of each scan went, in real time.
fn write_trace(prepared: &Prepared, driven: &Driven) -> Result<(), String> {
    if prepared.mode == RunMode::Lockstep {
        return Ok(());
    }
    let about = About {
        scenario: prepared.scenario.name.clone(),
        zero_ns: driven.zero_ns,
        pids: (driven.services.iter())
            .map(|service| (service.name.clone(), service.pid))
            .collect(),
    };
    let trace = trace(&driven.collector.records, &about)?;
    artifacts::write_in(&prepared.folder, "trace.json", &trace)
}

/// Writes what a run leaves in its folder.
fn write_files(
    plan: &RunPlan,
    prepared: &Prepared,
    driven: &Driven,
    result: &RunResult,
    timings: Option<Timings>,
) -> Result<(), String> {
    write_result(prepared, result)?;
    if prepared.mode == RunMode::Lockstep {
        let last_tick = driven.end_tick.saturating_sub(1);
        let answers = driven.collector.hash.to_csv(last_tick);
        artifacts::write_in(&prepared.folder, "answers.csv", &answers)?;
    }
    let mut recording = record::recording(prepared, driven, result, timings);
    let is_reported = !plan.report_failures_only || result.verdict != "pass";
    if !is_reported {
        recording.scene = None;
    }
    write_trace(prepared, driven)?;
    write_recording(prepared, &recording)?;
    if is_reported {
        report::write(
            &prepared.folder,
            Outcome::Run(Box::new(result.clone())),
            recording,
        )?;
    }
    Ok(())
}

/// Says on standard error why a run could not go on.
pub(crate) fn explain(ending: &Ending) {
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
        Ending::Stalled(role) => complain(&ending::stalled(*role)),
        Ending::Deleted => complain(&format!(
            "the shared memory of the stack was deleted in /dev/shm while it ran; everything is \
             stopped. {}",
            doctor::deletion()
        )),
        Ending::Interrupted => complain("interrupted, everything is stopped"),
        Ending::Task(..)
        | Ending::Redirected
        | Ending::Timeout
        | Ending::TrialsOver
        | Ending::LaunchDied
        | Ending::Down => {}
    }
}

/// `zeronav suite`.
#[must_use]
pub fn suite(plan: &SuitePlan, json: bool) -> ExitCode {
    match interrupts() {
        Ok(interrupted) => say_suite(zeronav_suite::suite(plan, &interrupted), json),
        Err(problem) => usage(&problem),
    }
}

/// `zeronav suite merge`.
#[must_use]
pub fn merge(shards: &[PathBuf], plan: &SuitePlan, json: bool) -> ExitCode {
    say_suite(zeronav_suite::merge::merge(shards, plan), json)
}

fn say_suite(ran: Result<Ran, SuiteError>, json: bool) -> ExitCode {
    match ran {
        Ok(ran) if json => say_json(&ran),
        Ok(ran) => say(&ran.to_text()),
        Err(SuiteError::Usage(problem)) => return usage(&problem),
        Err(SuiteError::Lost(problem)) => {
            lose(&problem);
            return ExitCode::from(EXIT_OUTPUT);
        }
        Err(SuiteError::Interrupted(ran)) => {
            match ran {
                Some(ran) if json => say_json(&ran),
                Some(ran) => say(&ran.to_text()),
                None => {}
            }
            complain("interrupted, every run is stopped");
            return ExitCode::from(EXIT_INTERRUPTED);
        }
    }
    ExitCode::from(EXIT_PASS)
}
