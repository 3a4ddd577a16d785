//! Going to see whether a way is closed.
//!
//! From afar a lidar closes doors: beams that graze an edge return from somewhere in the opening, and they lie
//! so far apart that a few of them are as wide as the door. So what the lidar saw from afar proves nothing, where a
//! path led over what had been seen to be free. A path over what nobody has seen was a guess: a wall there is news,
//! and looking at it leads away from the door in which somebody stands.

use crate::config::GlobalPlannerConfig;
use crate::corridor::Legality;
use crate::plan::{Blocked, Cut, Plan};
use crate::planner::{Control, Expansions, GlobalPlanner, PlanQuery};
use zeronav_msgs::map::ObstacleSource;
use zeronav_msgs::path::{PathCause, PathStatus};
use zeronav_msgs::{MapView, Pose};

/// How far beside the last path the place may be from which the robot looks, at most [m] and as a part of the
/// distance that is near.
const BESIDE_M: f64 = 0.5;
const BESIDE_SHARE: f64 = 0.5;

/// True when the robot is near enough to `blocked` to see whether it is; at the end of a look it is.
pub(crate) fn is_near(
    config: &GlobalPlannerConfig,
    map: &MapView<'_>,
    blocked: &Blocked,
    robot: &Pose,
) -> bool {
    let least_m = beside_m(config) + 2.0 * map.geometry.resolution_m;
    (blocked.point() - robot.point()).norm() <= config.look_from_m.max(least_m)
}

fn beside_m(config: &GlobalPlannerConfig) -> f64 {
    (BESIDE_SHARE * config.look_from_m).min(BESIDE_M)
}

/// Instead of the failed search `plan`, leads to the cell before the cut of the path before, when the lidar alone
/// saw it, from afar.
pub(crate) fn lead(
    planner: &mut dyn GlobalPlanner,
    (query, config, legality): (&PlanQuery<'_>, &GlobalPlannerConfig, Legality),
    cut: Cut,
    budget: &mut dyn FnMut(Expansions) -> Control,
    plan: &mut Plan,
) {
    let is_closed = matches!(
        plan.status,
        PathStatus::Unreachable | PathStatus::UnreachableCorner | PathStatus::GoalBlocked
    );
    // A search for something better that fails changes nothing.
    let counts = !matches!(plan.cause, PathCause::Shortcut | PathCause::Improved);
    let Some(target) = plan.target.filter(|_| is_closed && counts) else {
        return;
    };
    let blocked = cut.blocked;
    let is_doubtful = blocked.source == ObstacleSource::Lidar && !cut.was_guess;
    if !is_doubtful || is_near(config, &query.map, &blocked, &query.start) {
        return;
    }
    let ahead = blocked.point() - cut.before;
    let there = PlanQuery {
        goal: Pose::new(cut.before.x, cut.before.y, ahead.y.atan2(ahead.x)),
        tolerance_m: beside_m(config),
        ..*query
    };
    let (status, end_source, effort) = (plan.status, plan.end_source, plan.cells.stats);
    plan.cells.clear();
    let result = planner.plan(&there, budget, &mut plan.cells);
    plan.cells.stats.add_effort(&effort);
    plan.set(&there, legality, target, result.err());
    if plan.status == PathStatus::Found {
        plan.is_look = true;
        (plan.cut, plan.closed) = (None, Some(blocked));
    } else {
        (plan.status, plan.end_source) = (status, end_source);
    }
}
