//! One paragraph in plain words: what the robot does, the stage that decided, what decided it, and
//! what would have to change.
//!
//! The stages are asked from the wheels back: the guard has the last word, so what it did is named
//! first; then what the local planner meant; then why the global planner has no path, or this one.

mod driving;
pub(super) mod words;

use super::around::Around;
use driving::driving;
use words::{age, failure, no_way, stale, waiting};
use zeronav_measure::result::moment::{Command, Moment, Path, Point, Request, Task};
use zeronav_msgs::command::{AGE_MS_MAX, Intervention, RequestCause, Validity};
use zeronav_msgs::path::PathStatus;
use zeronav_msgs::task::{EndReason, TaskState};
use zeronav_shell::printable;

/// [m/s] and [rad/s] below which a robot stands.
const STANDING: (f64, f64) = (0.005, 0.01);

/// The paragraph about a moment.
#[must_use]
pub(super) fn why(moment: &Moment, around: &Around) -> String {
    let mut said = vec![motion(moment)];
    for missing in &around.missing {
        said.push(format!("The {} {}.", service(&missing.role), missing.how));
    }
    for fault in &around.faults {
        said.push(format!(
            "A fault goes on that was made on purpose: {fault}."
        ));
    }
    said.push(decided(moment, around));
    said.extend(zone(moment));
    said.extend(inputs(moment));
    said.retain(|sentence| !sentence.is_empty());
    said.join(" ")
}

/// What the robot does.
fn motion(moment: &Moment) -> String {
    let at = format!("At {:.2} s", moment.time_s);
    let Some(command) = &moment.command else {
        return format!("{at} the collision guard has not answered yet.");
    };
    let (v_mps, w_radps) = (command.v_mps, command.w_radps);
    let turning = w_radps.abs() >= STANDING.1;
    if v_mps.abs() >= STANDING.0 {
        let way = if v_mps > 0.0 { "drives" } else { "drives back" };
        format!("{at} the robot {way} at {:.2} m/s.", v_mps.abs())
    } else if turning {
        let side = if w_radps > 0.0 { "left" } else { "right" };
        format!(
            "{at} the robot turns on the spot to the {side} at {:.2} rad/s.",
            w_radps.abs()
        )
    } else {
        format!("{at} the robot stands.")
    }
}

/// The stage that decided, what decided it, and what would have to change.
fn decided(moment: &Moment, around: &Around) -> String {
    if around.stopping {
        return "The run is ending: every stage brings the robot to rest.".to_owned();
    }
    if around.paused {
        return "Run time is paused: `zeronav resume` lets it go on.".to_owned();
    }
    let command = moment.command.as_ref();
    if let Some(sentence) = command.and_then(|command| guard(command, moment.request.as_ref())) {
        return sentence;
    }
    let Some(request) = &moment.request else {
        return "The local planner has asked for nothing yet.".to_owned();
    };
    planner(request, moment)
}

/// What the guard did, when it did something.
fn guard(command: &Command, request: Option<&Request>) -> Option<String> {
    let asked = request.map_or_else(String::new, |request| {
        format!(
            " of {:.2} m/s and {:.2} rad/s",
            request.v_mps, request.w_radps
        )
    });
    let sentence = match command.intervention {
        Intervention::None | Intervention::Clamped => {
            return (command.validity == Validity::NoRequest).then(|| {
                "No velocity request has come yet: the collision guard waits for the local \
                 planner's first one."
                    .to_owned()
            });
        }
        Intervention::RequestStale => {
            "The collision guard brakes because the velocity request is too old or missing: the \
             local planner must answer again."
                .to_owned()
        }
        Intervention::ScanStale => {
            let age = request.map_or_else(String::new, |request| {
                let [_, scan_ms, ..] = request.ages_ms;
                format!(" (the local planner's is {})", age(scan_ms))
            });
            format!(
                "The collision guard brakes because the scan is too old, missing, blind or \
                 frozen{age}: it lets the robot go on with the next scan that is not."
            )
        }
        Intervention::OdometryStale => {
            "The collision guard brakes because odometry is too old, missing or contradicts \
             itself: it lets the robot go on with the next odometry that is good."
                .to_owned()
        }
        Intervention::Refused => {
            "The collision guard brakes because the request is not usable, or the robot is not \
             described: the local planner must send finite numbers."
                .to_owned()
        }
        Intervention::ZoneSlowed => format!(
            "The collision guard slows down the request{asked}: the robot is in a zone with a speed \
             limit, or does not know whether it is. It lets the robot go faster outside."
        ),
        Intervention::ZoneStopped => format!(
            "The collision guard holds back the request{asked}: it leads into a keepout zone, or \
             farther in, or the robot does not know where it is among them. It lets the robot go where it gets out."
        ),
        Intervention::ZonesMissing => {
            "The collision guard brakes because zones were announced that have not come: launch \
             sends them again once a second."
                .to_owned()
        }
        Intervention::StoppedShort => format!(
            "The collision guard stops the robot: from the request{asked} no speed on that arc is \
             slow enough to stop in time. {} It goes on when that is gone or another arc is asked \
             for.",
            point(command.point.as_ref())
        ),
        Intervention::Slowed => format!(
            "The collision guard slows down the request{asked}. {} It lets the robot go faster \
             when that is farther from the way.",
            point(command.point.as_ref())
        ),
    };
    Some(sentence)
}

/// The point of the scan that decided.
fn point(point: Option<&Point>) -> String {
    let Some(point) = point else {
        return "Which point of the scan decided is not told.".to_owned();
    };
    let [x_m, y_m] = point.at_m;
    let clearance = if point.clearance_m < 0.0 {
        format!("{:.2} m inside the outline", -point.clearance_m)
    } else {
        format!("{:.2} m from the outline", point.clearance_m)
    };
    format!(
        "Beam {} decided: its point is {}, {clearance} on the way asked for.",
        point.beam,
        place([x_m, y_m])
    )
}

/// A place relative to the robot, in words. [m]
fn place([x_m, y_m]: [f64; 2]) -> String {
    let ahead = if x_m < 0.0 { "behind" } else { "ahead" };
    let side = if y_m < 0.0 { "right" } else { "left" };
    format!(
        "{:.2} m {ahead} and {:.2} m to the {side}",
        x_m.abs(),
        y_m.abs()
    )
}

/// What the local planner meant.
fn planner(request: &Request, moment: &Moment) -> String {
    let doubts = |task: &Task| task.waits() && task.reason == EndReason::PoseUnknown;
    if let Some(task) = moment.task.filter(doubts) {
        return format!("{}.", waiting(&task));
    }
    match request.validity {
        Validity::AtGoal => {
            "The robot has arrived: it is within the goal's tolerance. Another goal \
                             moves it."
                .to_owned()
        }
        Validity::Stopped => {
            "The task was cancelled, or the run is ending. Another goal moves it.".to_owned()
        }
        Validity::NoRequest => "The local planner has asked for nothing yet.".to_owned(),
        Validity::NoPath => no_path(moment.path.as_ref(), moment.task),
        Validity::Stale => stale(request),
        Validity::Blocked | Validity::Drive => driving(request, moment),
    }
}

/// Why there is no path to follow.
fn no_path(path: Option<&Path>, task: Option<Task>) -> String {
    match task.map(|task| (task.state, task)) {
        Some((TaskState::Reached, _)) => {
            return "The robot has arrived: every goal is reached. Another goal moves it."
                .to_owned();
        }
        Some((TaskState::Cancelled, _)) => {
            return "The task was cancelled. Another goal moves it.".to_owned();
        }
        Some((TaskState::Failed, task)) => {
            let why = failure(&task);
            return format!("The task has failed: {why}. Another goal moves the robot.");
        }
        Some((TaskState::Active, task)) if task.waits() => {
            return format!("{}.", waiting(&task));
        }
        _ => {}
    }
    let Some(path) = path else {
        return "The local planner waits for the global planner's first path.".to_owned();
    };
    match path.status {
        PathStatus::NoGoal => "There is no goal: `zeronav goal X Y YAW` gives one.".to_owned(),
        PathStatus::Found => {
            "The local planner waits for a path to its goal: the last one leads to another goal."
                .to_owned()
        }
        _ => format!(
            "The local planner has no path to follow and brakes: {}. The task fails when that lasts.",
            no_way(path)
        ),
    }
}

/// The zone that makes the robot slow, or stand.
fn zone(moment: &Moment) -> Option<String> {
    let zone = moment
        .zone
        .as_ref()
        .filter(|_| moment.zone_told().is_some())?;
    let name = printable(&zone.name);
    Some(match zone.limit_mps {
        Some(limit_mps) => format!("Slow: zone `{name}`, {limit_mps} m/s."),
        None if is_slowed(moment) => format!("Held back: zone `{name}`, keepout."),
        None => format!("Stopped: zone `{name}`, keepout."),
    })
}

/// True when the guard lets the robot go on, slower, before a keepout zone.
fn is_slowed(moment: &Moment) -> bool {
    moment.command.as_ref().is_some_and(|command| {
        command.intervention == Intervention::ZoneStopped
            && (command.v_mps, command.w_radps) != (0.0, 0.0)
    })
}

/// How old the inputs of the local planner are.
fn inputs(moment: &Moment) -> Option<String> {
    let request = moment.request.as_ref()?;
    let ages = request.ages_ms;
    if ages == [0; 4] && request.cause == RequestCause::None {
        return None;
    }
    let names = ["odometry", "scan", "map", "path"].iter().zip(ages);
    let told: Vec<String> = names
        .map(|(name, age_ms)| match age_ms {
            AGE_MS_MAX => format!("{name} missing"),
            age_ms => format!("{name} {age_ms} ms"),
        })
        .collect();
    Some(format!("Ages of the inputs: {}.", told.join(", ")))
}

fn service(role: &str) -> String {
    role.replace('_', " ")
}

#[cfg(test)]
mod task_tests;
#[cfg(test)]
mod tests;
#[cfg(test)]
mod zone_tests;
