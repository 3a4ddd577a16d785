//! What is said of inputs and paths, whoever says it.

use crate::result::moment::{Path, Request};
use zeronav_msgs::command::{AGE_MS_MAX, PlannerInput};
use zeronav_msgs::path::{PathBlock, PathCause, PathStatus};

/// Why the global planner has no path, and what would have to change.
pub(super) fn no_way(path: &Path) -> String {
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
    }
}

/// Why it takes this way.
pub(super) fn way(path: &Path) -> String {
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
        (PathCause::Improved, _) => {
            "a search found a better one than the detour that was ready".to_owned()
        }
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
