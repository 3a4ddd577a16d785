//! The other requests: what a stack is doing, and making it pause, step or end.

use super::cli::{
    CancelArgs, InitialPoseArgs, ObstacleArgs, ObstacleCommand, PoseArgs, Speed, SpeedArgs,
    StackArgs, StepArgs, WaitArgs, WaitFor,
};
use super::goal::follow;
use super::ps::processes;
use super::swap::in_words as swap_in_words;
use crate::control::request::{Request, RunReport};
use crate::running::{self, Running};
use core::fmt::Write;
use serde_json::json;
use std::process::ExitCode;
use std::time::{Duration, Instant};
use zeronav_console::exit::{EXIT_FAIL, EXIT_PASS};
use zeronav_console::terminal::{complain, say, say_json, usage};
use zeronav_observe::control::ObstacleChange;

/// Between two looks at a stack that is waited for.
const PAUSE: Duration = Duration::from_millis(50);

/// How long a stack may take to come to rest and end.
const END_LIMIT: Duration = Duration::from_secs(15);

/// The same for one that was asked and answers: its recorder alone may take 60 s to end its file.
const DOWN_LIMIT: Duration = Duration::from_secs(75);

/// `zeronav cancel`.
#[must_use]
pub fn cancel(arguments: &CancelArgs) -> ExitCode {
    let id = arguments.id;
    make(&arguments.stack, &Request::Cancel { id }, "cancelled")
}

/// `zeronav pause`.
#[must_use]
pub fn pause(arguments: &StackArgs) -> ExitCode {
    make(arguments, &Request::Pause, "paused")
}

/// `zeronav resume`.
#[must_use]
pub fn resume(arguments: &StackArgs) -> ExitCode {
    make(arguments, &Request::Resume, "resumed")
}

/// `zeronav step`.
#[must_use]
pub fn step(arguments: &StepArgs) -> ExitCode {
    let ticks = arguments.ticks;
    make(&arguments.stack, &Request::Step { ticks }, "stepped")
}

/// `zeronav speed`.
#[must_use]
pub fn speed(arguments: &SpeedArgs) -> ExitCode {
    let Speed(factor) = arguments.factor;
    make(&arguments.stack, &Request::Speed { factor }, "set")
}

/// `zeronav pose`.
#[must_use]
pub fn pose(arguments: &InitialPoseArgs) -> ExitCode {
    let PoseArgs { x, y, yaw } = arguments.at;
    let pose = [x, y, yaw];
    make(&arguments.stack, &Request::Pose { pose }, "placed")
}

/// `zeronav obstacle`.
#[must_use]
pub fn obstacle(arguments: &ObstacleArgs) -> ExitCode {
    let pose = |at: &PoseArgs| [at.x, at.y, at.yaw];
    let (name, change, done) = match &arguments.change {
        ObstacleCommand::Add {
            name,
            at,
            size,
            radius,
        } => {
            let size_m = match (size.as_deref(), radius) {
                (Some([x_m, y_m]), _) => [*x_m, *y_m],
                (_, radius) => [2.0 * radius.unwrap_or(0.0), 0.0],
            };
            let pose = pose(at);
            (name, ObstacleChange::Add { pose, size_m }, "added")
        }
        ObstacleCommand::Move { name, at } => {
            (name, ObstacleChange::Move { pose: pose(at) }, "moved")
        }
        ObstacleCommand::Remove { name } => (name, ObstacleChange::Remove, "removed"),
    };
    let name = name.clone();
    make(&arguments.stack, &Request::Obstacle { name, change }, done)
}

/// Makes a stack do something; `done` says that it did.
pub(super) fn make(arguments: &StackArgs, request: &Request, done: &str) -> ExitCode {
    let asked =
        running::find(arguments.domain.as_deref()).and_then(|stack| Ok(stack.ask(request)?));
    match asked {
        Ok(_) if arguments.json => say_json(&json!({ "done": done })),
        Ok(_) => say(&format!("{done}\n")),
        Err(problem) => return usage(&problem),
    }
    ExitCode::from(EXIT_PASS)
}

/// `zeronav down`: returns when the stack is gone. One that does not answer, or does not end, is
/// ended.
#[must_use]
pub fn down(arguments: &StackArgs) -> ExitCode {
    let stack = match running::find(arguments.domain.as_deref()) {
        Ok(stack) => stack,
        Err(problem) => return usage(&problem),
    };
    // One that is ending already goes on to.
    let asked = stack
        .report()
        .and_then(|report| match stack.ask(&Request::Down) {
            Err(problem) if problem.is_silent => Err(problem),
            _ => Ok(report.scenario),
        });
    let name = match asked {
        Ok(scenario) => scenario,
        Err(problem) if problem.is_silent => {
            complain(&problem.text);
            return end(arguments, &stack);
        }
        Err(problem) => return usage(&problem.text),
    };
    if !stack.wait_until_gone(DOWN_LIMIT) {
        complain(&format!(
            "{name} has not ended within {} s; see its log",
            DOWN_LIMIT.as_secs()
        ));
        return end(arguments, &stack);
    }
    say_down(arguments, &name, "down")
}

/// Ends a stack that does not end by itself.
fn end(arguments: &StackArgs, stack: &Running) -> ExitCode {
    match stack.end(END_LIMIT) {
        Ok(how) => say_down(arguments, &stack.root().display().to_string(), how),
        Err(problem) => {
            complain(&problem);
            ExitCode::from(EXIT_FAIL)
        }
    }
}

fn say_down(arguments: &StackArgs, name: &str, how: &str) -> ExitCode {
    if arguments.json {
        say_json(&json!({ "done": "down", "how": how }));
    } else if how == "down" {
        say(&format!("{name} is down\n"));
    } else {
        say(&format!("{name} is down, ended {how}\n"));
    }
    ExitCode::from(EXIT_PASS)
}

/// `zeronav status`.
#[must_use]
pub fn status(arguments: &StackArgs) -> ExitCode {
    let asked = running::find(arguments.domain.as_deref()).and_then(|stack| Ok(stack.report()?));
    match asked {
        Ok(report) if arguments.json => say_json(&report),
        Ok(report) => say(&in_words(&report)),
        Err(problem) => return usage(&problem),
    }
    ExitCode::from(EXIT_PASS)
}

fn in_words(report: &RunReport) -> String {
    let mut text = processes(report);
    if let Some([x_m, y_m, yaw_rad]) = report.estimate {
        let _ = writeln!(text, "  pose by the map {x_m:.2} {y_m:.2} {yaw_rad:.2}");
    }
    if let Some([x_m, y_m, yaw_rad]) = report.pose {
        let _ = write!(text, "  true pose {x_m:.2} {y_m:.2} {yaw_rad:.2}");
        if let Some(contacts) = report.contacts {
            let _ = write!(text, ", {contacts} contacts");
        }
        text.push('\n');
    }
    if let Some(goal) = &report.goal {
        let _ = write!(text, "  {}", goal.in_words());
    }
    if let Some(swap) = &report.swap {
        let _ = write!(text, "  {}", swap_in_words(swap));
    }
    if report.goals_waiting > 0 {
        let _ = writeln!(text, "  {} goals wait", report.goals_waiting);
    }
    text
}

/// `zeronav wait`.
#[must_use]
pub fn wait(arguments: &WaitArgs) -> ExitCode {
    let began = Instant::now();
    let limit = Duration::try_from_secs_f64(arguments.timeout).unwrap_or(Duration::MAX);
    loop {
        let seen = running::find(arguments.stack.domain.as_deref()).and_then(|stack| {
            let report = stack.report()?;
            Ok((stack, report))
        });
        let why = match (seen, arguments.what) {
            (Ok((_, report)), WaitFor::Ready) if report.ready => break,
            (Ok((_, report)), WaitFor::Ready) => format!("{} is starting", report.scenario),
            // A stack that may not have been started yet is waited for, nothing else is.
            (Err(problem), WaitFor::Ready) if problem != running::SEVERAL => problem,
            (Err(problem), _) => return usage(&problem),
            (Ok((_, report)), WaitFor::Idle) if !has_goals(&report) => break,
            (Ok(_), WaitFor::Idle) => "the robot has goals".to_owned(),
            (Ok((stack, report)), WaitFor::Goal) => match report.goal {
                Some(goal) => {
                    let rest = limit.saturating_sub(began.elapsed());
                    return follow(&stack, goal, arguments.stack.json, Some(rest));
                }
                None if report.goals_waiting > 0 => "the goals wait".to_owned(),
                None => {
                    return usage(
                        "the robot has no goal of a client; send one with `zeronav goal`",
                    );
                }
            },
        };
        if began.elapsed() > limit {
            complain(&format!("not within {} s: {why}", arguments.timeout));
            return ExitCode::from(EXIT_FAIL);
        }
        std::thread::sleep(PAUSE);
    }
    if arguments.stack.json {
        say_json(&json!({ "done": arguments.what.to_string() }));
    }
    ExitCode::from(EXIT_PASS)
}

fn has_goals(report: &RunReport) -> bool {
    report.task == "active" || report.goal.is_some() || report.goals_waiting > 0
}
