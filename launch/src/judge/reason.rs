//! The verdict of a run in words.

use crate::drive::Driven;
use crate::ending::{self, Ending};
use crate::prepare::Prepared;
use zeronav_measure::result::Expectation;
use zeronav_msgs::role::Role;
use zeronav_msgs::task::{EndReason, TaskState};

/// Why the run passed or failed, in words.
pub(super) fn reason(
    prepared: &Prepared,
    driven: &Driven,
    met: bool,
    expectations: &[Expectation],
) -> String {
    let ending = &driven.ending;
    let what = match ending {
        Ending::Task(TaskState::Reached, _) => "the robot reached its goal".to_owned(),
        Ending::Task(TaskState::Cancelled, _) => "the task was cancelled".to_owned(),
        Ending::Task(_, EndReason::Unreachable) => "the goal is unreachable".to_owned(),
        Ending::Task(_, EndReason::GoalBlocked) => {
            "the goal is unreachable: no free pose within its tolerance".to_owned()
        }
        Ending::Task(_, reason) => match driven.collector.totals.stuck_cause() {
            Some(cause) => {
                let recoveries = driven
                    .collector
                    .totals
                    .task
                    .map_or(0, |task| task.recoveries);
                format!("the robot gave up: {reason} ({cause}) after {recoveries} recoveries")
            }
            None => format!("the robot gave up: {reason}"),
        },
        Ending::Redirected => {
            "the robot reached a goal that was given by hand, not the scenario's".to_owned()
        }
        Ending::Timeout => {
            format!(
                "not done within {} s of run time",
                prepared.scenario.run.time_limit_s
            )
        }
        Ending::TrialsOver => "all trials were made".to_owned(),
        Ending::Died { role, how, .. } => format!("{role} ended during the run: {how}"),
        Ending::NotReady(roles) => format!("not ready in time: {}", names(roles)),
        Ending::Silent(role) => format!("{role} stopped answering"),
        Ending::Stalled(role) => ending::stalled(*role),
        Ending::Deleted => "the shared memory of the stack was deleted".to_owned(),
        Ending::LaunchDied => {
            "launch was killed or has crashed; what it had seen of the run is lost".to_owned()
        }
        Ending::Interrupted => "interrupted".to_owned(),
        Ending::Down => "ended by `zeronav down`".to_owned(),
    };
    let missed: Vec<String> = expectations
        .iter()
        .filter(|expectation| !expectation.met && expectation.name != "outcome")
        .map(|expectation| format!("{}: {}", expectation.name, expectation.actual))
        .collect();
    let reason = match (met, ending) {
        (true, Ending::Task(TaskState::Reached, _) | Ending::TrialsOver) => what,
        (true, _) => format!("{what}, as the scenario expects"),
        (false, _) if missed.is_empty() => what,
        (false, _) => format!("{what}; {}", missed.join("; ")),
    };
    match prepared.scenario.foresight.label() {
        Some(told) => format!("{reason}; told what moves ({told}): no result of the stack"),
        None => reason,
    }
}

fn names(roles: &[Role]) -> String {
    roles
        .iter()
        .map(|role| role.label())
        .collect::<Vec<_>>()
        .join(", ")
}
