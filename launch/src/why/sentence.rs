//! One paragraph in plain words: what the robot does, the stage that decided, what decided it, and
//! what would have to change.
//!
//! The stages are asked from the wheels back: the guard has the last word, so what it did is named
//! first; then what the local planner meant; then why the global planner has no path, or this one.

use super::around::Around;
use crate::result::moment::{Command, Moment, Path, Point, Request, Task};
use zeronav_msgs::command::{
    AGE_MS_MAX, Intervention, PlannerInput, RecoveryReason, RequestCause, Validity,
};
use zeronav_msgs::path::{PathBlock, PathCause, PathStatus};
use zeronav_msgs::task::{EndReason, StuckCause, TaskState};

/// [m/s] and [rad/s] below which a robot stands.
const STANDING: (f64, f64) = (0.005, 0.01);

/// [m/s] below its limit at which a robot is still getting faster.
const SPEEDING_UP_MPS: f64 = 0.02;

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
    match task.map(|task| (task.state, task.reason, task.stuck)) {
        Some((TaskState::Reached, ..)) => {
            return "The robot has arrived: every goal is reached. Another goal moves it."
                .to_owned();
        }
        Some((TaskState::Cancelled, ..)) => {
            return "The task was cancelled. Another goal moves it.".to_owned();
        }
        Some((TaskState::Failed, reason, stuck)) => return failed(reason, stuck, path),
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

/// Why a task has failed.
fn failed(reason: EndReason, stuck: StuckCause, path: Option<&Path>) -> String {
    let why = match (reason, stuck) {
        (EndReason::Stuck, StuckCause::Blocked) => {
            "the robot got stuck, because no motion was admissible".to_owned()
        }
        (EndReason::Stuck, StuckCause::NoProgress) => {
            "the robot got stuck: it moved, but came no closer to its goal".to_owned()
        }
        (EndReason::Stuck, StuckCause::TooManyAttempts) => {
            "the robot got stuck: every attempt of its recovery was made".to_owned()
        }
        (EndReason::Stuck, StuckCause::None) => "the robot got stuck".to_owned(),
        (EndReason::Replaced, _) => "a later task took its place".to_owned(),
        _ => match path.filter(|path| path.status != PathStatus::Found) {
            Some(path) => no_way(path),
            None => reason.label().replace('_', " "),
        },
    };
    format!("The task has failed: {why}. Another goal moves the robot.")
}

/// Why the global planner has no path, and what would have to change.
fn no_way(path: &Path) -> String {
    let at = |[x_m, y_m]: [f64; 2]| format!("({x_m:.2}, {y_m:.2})");
    let cut = match path.block {
        PathBlock::PathBefore => {
            format!(
                "; the last path was cut at {}, which would have to open",
                at(path.block_m)
            )
        }
        _ => String::new(),
    };
    let what = match path.status {
        PathStatus::Unreachable => {
            format!("the global planner has proved that no way leads to the goal{cut}")
        }
        PathStatus::UnreachableCorner => format!(
            "the global planner has proved that only a way that cuts an obstacle's corner leads \
             to the goal{cut}"
        ),
        PathStatus::StartBlocked => format!(
            "the robot's own cell at {} is in an obstacle and no free cell is near",
            at(path.block_m)
        ),
        PathStatus::StartOutsideMap => {
            "the robot is not on the map: `zeronav pose` says where it is".to_owned()
        }
        PathStatus::GoalBlocked => format!(
            "the goal's cell at {} is in an obstacle and no cell within its tolerance is free",
            at(path.block_m)
        ),
        PathStatus::GoalOutsideMap => {
            format!("the goal at {} is not on the map", at(path.block_m))
        }
        PathStatus::DeadEnd => format!("the planner {} gave up in a dead end{cut}", path.planner),
        PathStatus::OutOfBudget => {
            format!(
                "the planner {} spent its budget before it found a way{cut}",
                path.planner
            )
        }
        PathStatus::TooLong => "the path has more corners than a message holds".to_owned(),
        PathStatus::NoGoal | PathStatus::Found => "there is none".to_owned(),
    };
    format!("{what} ({})", path.status)
}

fn stale(request: &Request) -> String {
    let [odometry_ms, scan_ms, map_ms, path_ms] = request.ages_ms;
    let (name, topic, age_ms) = match request.input {
        PlannerInput::Odometry => ("odometry", "the robot", odometry_ms),
        PlannerInput::Scan => ("the scan", "the robot", scan_ms),
        PlannerInput::Map => ("the map", "mapping", map_ms),
        PlannerInput::Path => ("the path", "the global planner", path_ms),
        PlannerInput::Description => {
            return "The local planner brakes because the robot has not been described yet."
                .to_owned();
        }
        PlannerInput::None => {
            return "The local planner brakes because an input is too old or missing.".to_owned();
        }
    };
    format!(
        "The local planner brakes because {name} is {}: {topic} must send it again.",
        age(age_ms)
    )
}

fn age(age_ms: u16) -> String {
    match age_ms {
        AGE_MS_MAX => "missing, or older than a minute".to_owned(),
        age_ms => format!("{age_ms} ms old"),
    }
}

/// Why the robot drives as it does, or does not although it has a path.
fn driving(request: &Request, moment: &Moment) -> String {
    let limit = format!("{:.2} m/s", request.limit_mps);
    let obstacle = request.obstacle.map_or_else(String::new, |obstacle| {
        let [x_m, y_m] = obstacle.at_m;
        format!(
            " Tracked obstacle {} is near, at ({x_m:.2}, {y_m:.2}), with {:.2} m/s.",
            obstacle.track, obstacle.speed_mps
        )
    });
    let ahead = if request.blocked_arc_m > 0.0 {
        format!(
            " An obstacle is on the path, {:.2} m ahead.",
            request.blocked_arc_m
        )
    } else {
        String::new()
    };
    let cause = match request.cause {
        RequestCause::None if request.validity == Validity::Blocked => {
            "The local planner finds no admissible motion.".to_owned()
        }
        RequestCause::None => "The local planner follows the path; it tells no more.".to_owned(),
        RequestCause::Free => free(request, moment.command.as_ref()),
        RequestCause::Goal => {
            format!("The local planner slows down for the end of the path, to {limit}.")
        }
        RequestCause::Corner => {
            format!("The local planner slows down for a corner of the path, to {limit}.")
        }
        RequestCause::Critics => format!(
            "The critics of the local planner decided: at {limit} it keeps more clearance, or \
             nearer to the path.{ahead}{obstacle}"
        ),
        RequestCause::Ageing => format!(
            "The local planner slows down to {limit} because {} is getting old.",
            input(request.input)
        ),
        RequestCause::Heading => format!(
            "The robot faces away from the path: the local planner slows down to {limit} until it \
             faces it."
        ),
        RequestCause::Turn => "The local planner turns on the spot towards the path: it drives \
                               when it faces it."
            .to_owned(),
        RequestCause::TurnWait => format!(
            "The local planner waits for a moving obstacle to pass before it turns on the \
             spot.{obstacle}"
        ),
        RequestCause::Arrive => {
            "It is within the goal's tolerance and slows down to a stop.".to_owned()
        }
        RequestCause::GoalYaw => {
            "It is at the goal and turns on the spot to the goal's yaw.".to_owned()
        }
        RequestCause::Blocked => format!(
            "The local planner finds no admissible motion: from none of them the robot could stop \
             in time.{ahead}{obstacle} Its recovery begins when that lasts."
        ),
        RequestCause::Stale => stale(request),
        RequestCause::AskForPath
        | RequestCause::BackUp
        | RequestCause::Rotate
        | RequestCause::Wait
        | RequestCause::GiveUp => format!("{}{ahead}{obstacle}", recovery(request)),
    };
    let way = moment.path.as_ref().map_or_else(String::new, way);
    format!("{cause}{way}")
}

/// What a robot does that nothing holds back.
fn free(request: &Request, command: Option<&Command>) -> String {
    let now_mps = command.map_or(0.0, |command| command.v_mps);
    if now_mps + SPEEDING_UP_MPS < request.limit_mps {
        format!(
            "It speeds up to {:.2} m/s: nothing else limits it.",
            request.limit_mps
        )
    } else {
        "Nothing limits it but its own limits.".to_owned()
    }
}

/// What the recovery does, and why.
fn recovery(request: &Request) -> String {
    let why = match request.recovery {
        RecoveryReason::None => "",
        RecoveryReason::Blocked => " because no motion was admissible",
        RecoveryReason::NoProgress => " because the robot came no closer to its goal",
        RecoveryReason::DynamicObstacle => " because a moving obstacle is in the way",
        RecoveryReason::TimedOut => " because what it tried before took too long",
        RecoveryReason::Stuck => " because the time without coming closer is over",
        RecoveryReason::OutOfAttempts => " because no attempt is left",
    };
    let what = match request.cause {
        RequestCause::AskForPath => "has asked for another path and waits for it",
        RequestCause::BackUp => "drives back along the track that the robot came by",
        RequestCause::Rotate => "turns on the spot to look around",
        RequestCause::Wait => "waits for the way to become free",
        _ => "has nothing left to try",
    };
    format!("The recovery of the local planner {what}{why}.")
}

fn input(input: PlannerInput) -> &'static str {
    match input {
        PlannerInput::None => "an input",
        PlannerInput::Odometry => "odometry",
        PlannerInput::Scan => "the scan",
        PlannerInput::Map => "the map",
        PlannerInput::Path => "the path",
        PlannerInput::Description => "the robot's description",
    }
}

/// Why it takes this way.
fn way(path: &Path) -> String {
    if path.status != PathStatus::Found {
        return format!(" The global planner has no newer path: {}.", no_way(path));
    }
    let why = match (path.cause, path.block) {
        (PathCause::Obstacle, PathBlock::PathBefore) => {
            let [x_m, y_m] = path.block_m;
            format!("an obstacle at ({x_m:.2}, {y_m:.2}) cut the one before")
        }
        (PathCause::Obstacle, _) => "an obstacle cut the one before".to_owned(),
        (PathCause::Request, _) => "the local planner asked for another one".to_owned(),
        (PathCause::Shortcut, _) => "a shorter way opened".to_owned(),
        (PathCause::NextGoal, _) => "the next goal came up".to_owned(),
        (PathCause::Goal | PathCause::None, _) => "the goal was given".to_owned(),
    };
    let beside = if path.beside_goal_m > 0.005 {
        format!(
            "; it ends {:.2} m beside the goal, whose own cell is not free",
            path.beside_goal_m
        )
    } else {
        String::new()
    };
    let at = (path.time_s).map_or_else(String::new, |time_s| format!(" at {time_s:.2} s"));
    format!(
        " It follows a path of {:.1} m by {}, made{at} because {why}{beside}.",
        path.length_m, path.planner
    )
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
mod tests;
