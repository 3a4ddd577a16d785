//! `zeronav goal` and `zeronav goals`: send the robot somewhere, and wait until it is there.

use super::cli::{GoalArgs, GoalsArgs, OrderArgs};
use crate::control::request::{GoalReport, Reply, Request};
use crate::running::{self, Running};
use std::process::ExitCode;
use std::time::{Duration, Instant};
use zeronav_console::exit::{EXIT_FAIL, EXIT_PASS};
use zeronav_console::terminal::{complain, say, say_json_line, usage};
use zeronav_msgs::Pose;
use zeronav_scenario::{GoalSpec, goals_in};

/// Between two questions about a goal.
const PAUSE: Duration = Duration::from_millis(100);

/// Questions in a row that a stack may leave without an answer.
const UNANSWERED_MAX: u32 = 5;

/// Between two lines about a goal.
const FEEDBACK: Duration = Duration::from_secs(1);

/// `zeronav goal`.
#[must_use]
pub fn goal(arguments: &GoalArgs) -> ExitCode {
    let goal = GoalSpec {
        pose: Pose::new(arguments.x, arguments.y, arguments.yaw),
        tolerance_m: arguments.tolerance,
        yaw_tolerance_rad: arguments.yaw_tolerance,
    };
    send(vec![goal], false, &arguments.order)
}

/// `zeronav goals`.
#[must_use]
pub fn goals(arguments: &GoalsArgs) -> ExitCode {
    match goals_in(&arguments.file) {
        Ok(goals) => send(goals, arguments.repeats, &arguments.order),
        Err(problem) => usage(&problem.to_string()),
    }
}

fn send(goals: Vec<GoalSpec>, repeats: bool, order: &OrderArgs) -> ExitCode {
    let request = Request::Goal {
        goals,
        repeats,
        time_limit_s: order.time_limit,
        now: order.now,
    };
    let stack = match running::find(order.stack.domain.as_deref()) {
        Ok(stack) => stack,
        Err(problem) => return usage(&problem),
    };
    let report = match ask(&stack, &request) {
        Ok(report) => report,
        Err(problem) => return usage(&problem),
    };
    tell(&report, order.stack.json);
    if order.wait {
        follow(&stack, report, order.stack.json, None)
    } else {
        ExitCode::from(EXIT_PASS)
    }
}

/// Says how a goal gets on until it is over, at most for `limit`. A client that ends before leaves
/// the goal as it is.
pub(super) fn follow(
    stack: &Running,
    mut report: GoalReport,
    json: bool,
    limit: Option<Duration>,
) -> ExitCode {
    let began = Instant::now();
    let mut told = began;
    let id = report.id;
    let mut unanswered = 0;
    while !report.is_over() {
        if limit.is_some_and(|limit| began.elapsed() > limit) {
            complain(&format!("goal {id} is not over within the time"));
            return ExitCode::from(EXIT_FAIL);
        }
        std::thread::sleep(PAUSE);
        let before = report.outcome.clone();
        report = match ask(stack, &Request::GoalStatus { id }) {
            Ok(report) => report,
            Err(_) if stack.root().exists() && unanswered < UNANSWERED_MAX => {
                unanswered += 1;
                continue;
            }
            Err(problem) => {
                complain(&format!(
                    "goal {id}: what became of it is not known; {problem}"
                ));
                return ExitCode::from(EXIT_FAIL);
            }
        };
        unanswered = 0;
        if report.outcome != before || told.elapsed() >= FEEDBACK {
            told = Instant::now();
            tell(&report, json);
        }
    }
    ExitCode::from(report.exit_code())
}

fn ask(stack: &Running, request: &Request) -> Result<GoalReport, String> {
    match stack.ask(request)? {
        Reply::Goal(report) => Ok(report),
        other => Err(stack.refusal(&format!("an unexpected answer: {other:?}"))),
    }
}

fn tell(report: &GoalReport, json: bool) {
    if json {
        say_json_line(report);
    } else {
        say(&report.in_words());
    }
}
