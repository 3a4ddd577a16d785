//! What is said of inputs and paths, whoever says it.

use zeronav_measure::result::moment::{Blocked, Path, Request, Task};
use zeronav_msgs::command::{AGE_MS_MAX, PlannerInput};
use zeronav_msgs::map::ObstacleSource;
use zeronav_msgs::path::{PathBlock, PathCause, PathStatus};
use zeronav_msgs::task::{EndReason, StuckCause};

/// Why the global planner has no path, and what would have to change.
pub(super) fn no_way(path: &Path) -> String {
    let (planner, blocked) = (&path.planner, path.blocked());
    let what = match path.status {
        PathStatus::Unreachable => unreachable(blocked),
        PathStatus::UnreachableCorner => format!(
            "the global planner has proved that only a way that cuts an obstacle's corner leads \
             to the goal{}",
            opening(blocked)
        ),
        PathStatus::StartBlocked => start_blocked(blocked),
        PathStatus::StartOutsideMap => {
            "the robot is not on the map: `zeronav pose` says where it is".to_owned()
        }
        PathStatus::GoalBlocked => goal_blocked(blocked),
        PathStatus::GoalOutsideMap => goal_outside(blocked),
        PathStatus::DeadEnd => {
            let opening = opening(blocked);
            format!("the planner {planner} gave up in a dead end{opening}")
        }
        PathStatus::OutOfBudget => {
            let opening = opening(blocked);
            format!("the planner {planner} spent its budget before it found a way{opening}")
        }
        PathStatus::TooLong => "the path has more corners than a message holds".to_owned(),
        PathStatus::NoGoal | PathStatus::Found => "there is none".to_owned(),
    };
    format!("{what} ({})", path.status)
}

/// Why a task has failed, and what was in the way.
pub(in crate::why) fn failure(task: &Task) -> String {
    let blocked = task.blocked;
    match (task.reason, task.stuck) {
        (EndReason::Stuck, cause) => {
            let why = match cause {
                StuckCause::Blocked => ", because no motion was admissible",
                StuckCause::NoProgress => ": it moved, but came no closer to its goal",
                StuckCause::TooManyAttempts => ": every attempt of its recovery was made",
                StuckCause::None => "",
            };
            format!("the robot got stuck{why}{}", opening(blocked))
        }
        (EndReason::Replaced, _) => "a later task took its place".to_owned(),
        (EndReason::Unreachable, _) => unreachable(blocked),
        (EndReason::GoalBlocked, _) => goal_blocked(blocked),
        (EndReason::GoalOutsideMap, _) => goal_outside(blocked),
        (EndReason::NoPath, _) => match blocked.map(|blocked| blocked.block) {
            Some(PathBlock::Robot) => start_blocked(blocked),
            _ => format!(
                "the global planner had no path for too long{}",
                opening(blocked)
            ),
        },
        (EndReason::PoseUnknown, _) => {
            "the robot did not know where it is for too long, or nothing that it sees has confirmed where it was \
             told to be; `zeronav pose` says where it is"
                .to_owned()
        }
        (EndReason::None, _) => "no reason was told".to_owned(),
    }
}

/// What a task waits for, and for how long at most.
pub(in crate::why) fn waiting(task: &Task) -> String {
    if task.reason == EndReason::PoseUnknown {
        return format!(
            "The robot would be at its goal, or give it up, but nothing that it sees has confirmed where it was told to \
             be; {} s more, then the goal fails ({})",
            task.waits_s, task.reason
        );
    }
    format!(
        "The robot waits for what is in its way to go, and takes any way that opens; {} s more, then the \
         goal fails: {} ({})",
        task.waits_s,
        failure(task),
        task.reason
    )
}

fn unreachable(blocked: Option<Blocked>) -> String {
    let opening = opening(blocked);
    format!("the global planner has proved that no way leads to the goal{opening}")
}

fn start_blocked(blocked: Option<Blocked>) -> String {
    format!(
        "the robot's own cell{} is in an obstacle{} and no free cell is near",
        place(blocked),
        origin(blocked)
    )
}

fn goal_blocked(blocked: Option<Blocked>) -> String {
    format!(
        "the goal's cell{} is in an obstacle{}, or too close to one, and no cell within its \
         tolerance is free",
        place(blocked),
        origin(blocked)
    )
}

fn goal_outside(blocked: Option<Blocked>) -> String {
    format!("the goal{} is not on the map", place(blocked))
}

/// What would have to open, or go.
fn opening(blocked: Option<Blocked>) -> String {
    let (place, origin) = (place(blocked), origin(blocked));
    match blocked.map(|blocked| blocked.block) {
        Some(PathBlock::PathBefore) => {
            format!("; the last path was cut{place} by an obstacle{origin}, which would have to go")
        }
        Some(PathBlock::Closed) => {
            format!("; the nearest way that could open is closed{place} by an obstacle{origin}")
        }
        Some(PathBlock::Obstacle) => format!("; in its way is an obstacle{place}{origin}"),
        Some(PathBlock::None | PathBlock::Robot | PathBlock::Goal) | None => String::new(),
    }
}

/// Where a cell is, `map` frame.
fn place(blocked: Option<Blocked>) -> String {
    blocked.map_or_else(
        String::new,
        |Blocked {
             at_m: [x_m, y_m], ..
         }| { format!(" at ({x_m:.2}, {y_m:.2})") },
    )
}

/// Where the obstacle comes from that blocks a cell.
fn origin(blocked: Option<Blocked>) -> &'static str {
    match blocked.map(|blocked| blocked.source) {
        Some(ObstacleSource::StaticMap) => " of the static map",
        Some(ObstacleSource::Lidar) => " that the lidar saw and the static map does not have",
        Some(ObstacleSource::Tracked) => " that is tracked",
        Some(ObstacleSource::Unknown) => " of cells of which nothing is known",
        Some(ObstacleSource::Keepout) => " that is a keepout zone",
        Some(ObstacleSource::None) | None => "",
    }
}

/// Why the local planner brakes for an input.
pub(super) fn stale(request: &Request) -> String {
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
        PlannerInput::Pose => {
            return "The local planner brakes because the robot does not know where it is: the scans \
                    contradict odometry or the map. It goes on when they lie on the map near by; on a fixed static \
                    map it is also looked for everywhere, and the log of mapping says how that goes. \
                    `zeronav pose` says where it is."
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

/// An age in words.
pub(super) fn age(age_ms: u16) -> String {
    match age_ms {
        AGE_MS_MAX => "missing, or older than a minute".to_owned(),
        age_ms => format!("{age_ms} ms old"),
    }
}

/// The name of an input.
pub(super) fn input(input: PlannerInput) -> &'static str {
    match input {
        PlannerInput::None => "an input",
        PlannerInput::Odometry => "odometry",
        PlannerInput::Scan => "the scan",
        PlannerInput::Map => "the map",
        PlannerInput::Path => "the path",
        PlannerInput::Description => "the robot's description",
        PlannerInput::Pose => "the pose",
    }
}

/// Why it takes this way.
pub(super) fn way(path: &Path) -> String {
    if path.status != PathStatus::Found {
        return format!(" The global planner has no newer path: {}.", no_way(path));
    }
    let why = match (path.cause, path.block) {
        (PathCause::Obstacle, PathBlock::PathBefore) => {
            let (place, origin) = (place(path.blocked()), origin(path.blocked()));
            format!("an obstacle{place}{origin} cut the one before")
        }
        (PathCause::Obstacle, _) => "an obstacle cut the one before".to_owned(),
        (PathCause::Request, _) => "the local planner asked for another one".to_owned(),
        (PathCause::Shortcut, _) => "a shorter way opened".to_owned(),
        (PathCause::Improved, _) => {
            "a search found a better one than the detour that was ready".to_owned()
        }
        (PathCause::NextGoal, _) => "the next goal came up".to_owned(),
        (PathCause::Goal | PathCause::None, _) => "the goal was given".to_owned(),
    };
    let beside = if path.block == PathBlock::Closed {
        format!(
            "; it leads to where the robot sees from near whether an obstacle{}{} closes the only way",
            place(path.blocked()),
            origin(path.blocked())
        )
    } else if path.beside_goal_m > 0.005 {
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
