//! What an output may say: the contract of its topic, and what its seat may never ask for.

use super::others::TASK_GOAL;
use super::raw::Received;
use super::robot::description;
use super::room::{Room, geometry};
use nalgebra::Point2;
use zeronav_msgs::command::{Validity, VelocityCommand, VelocityRequest};
use zeronav_msgs::map::{COST_LETHAL, ObstacleSource};
use zeronav_msgs::path::{Path, PathBlock, PathStatus, Waypoint};
use zeronav_msgs::topics::{ControlRequest, PlanPath, RobotCommand};

/// What floating point may add to a limit.
const ROUNDING: f64 = 1.0e-9;

/// How far before a block a path may end that leads to where it can be seen. [m]
const LOOK_M: f64 = 1.5;

/// Length of the first part of a path that may lie where the robot stands already. [m]
const BEGINNING_M: f64 = 0.3;

/// Accepts a message that a reader accepts, and that means what its seat may say.
///
/// # Errors
/// What is wrong, with topic and tick.
pub(crate) fn check(message: &Received) -> Result<(), String> {
    let named = |why: String| {
        format!(
            "{} of tick {}: {why}",
            message.row.name, message.header.tick
        )
    };
    if let Some(refusal) = message.refusal {
        return Err(named(refusal.to_string()));
    }
    let problem = if let Some(path) = message.meta::<PlanPath>() {
        path_problem(&path, &message.items::<PlanPath>(), message.header.tick)
    } else if let Some(request) = message.meta::<ControlRequest>() {
        twist_problem(request.v_mps, request.w_radps)
    } else if let Some(command) = message.meta::<RobotCommand>() {
        twist_problem(command.v_mps, command.w_radps)
    } else {
        None
    };
    problem.map_or(Ok(()), |why| Err(named(why)))
}

/// Accepts an idle output: it moves nothing and promises nothing.
///
/// # Errors
/// What it says instead.
pub(crate) fn check_idle(message: &Received) -> Result<(), String> {
    let standing = |v_mps: f64, w_radps: f64| v_mps == 0.0 && w_radps == 0.0;
    let idle = if let Some(path) = message.meta::<PlanPath>() {
        path.n_waypoints == 0 && path.goal == 0
    } else if let Some(request) = message.meta::<ControlRequest>() {
        let VelocityRequest { v_mps, w_radps, .. } = request;
        standing(v_mps, w_radps) && request.validity() != Some(Validity::Drive)
    } else if let Some(command) = message.meta::<RobotCommand>() {
        let VelocityCommand { v_mps, w_radps, .. } = command;
        standing(v_mps, w_radps) && command.validity() == Some(Validity::NoRequest)
    } else {
        true
    };
    if idle {
        Ok(())
    } else {
        Err(format!("{} asks for something", message.row.name))
    }
}

fn twist_problem(v_mps: f64, w_radps: f64) -> Option<String> {
    let robot = description();
    let (low, high) = (robot.v_mps_min - ROUNDING, robot.v_mps_max + ROUNDING);
    if !(low..=high).contains(&v_mps) {
        return Some(format!(
            "{v_mps} m/s where the robot can {} to {}",
            robot.v_mps_min, robot.v_mps_max
        ));
    }
    let most = robot.w_radps_max;
    (w_radps.abs() > most + ROUNDING).then(|| format!("{w_radps} rad/s where the robot can {most}"))
}

fn path_problem(path: &Path, waypoints: &[Waypoint], tick: u64) -> Option<String> {
    if path.status() != Some(PathStatus::Found) {
        return None;
    }
    let room = Room::at(tick);
    let mut arc_m = 0.0;
    for (from, to) in waypoints.iter().zip(waypoints.iter().skip(1)) {
        let (from, to) = (Point2::new(from.x_m, from.y_m), Point2::new(to.x_m, to.y_m));
        let length_m = (to - from).norm();
        let step_m = 0.5 * geometry().resolution_m;
        let mut along_m = 0.0;
        while along_m < length_m {
            let at = from + (to - from) * (along_m / length_m);
            let cell = geometry().cell_at(at).map(|cell| room.cell(cell).cost);
            if cell == Some(COST_LETHAL) && arc_m + along_m > BEGINNING_M {
                return Some(format!(
                    "it leads through an obstacle at ({:.2}, {:.2})",
                    at.x, at.y
                ));
            }
            along_m += step_m;
        }
        arc_m += length_m;
    }
    let end = waypoints.last()?;
    let beside_m = (Point2::new(end.x_m, end.y_m) - TASK_GOAL.pose.point()).norm();
    // With a block that only the lidar saw it leads to where that is seen from near.
    let [x_m, y_m] = path.block_m;
    let is_look = path.block() == Some(PathBlock::Closed)
        && path.source() == Some(ObstacleSource::Lidar)
        && (Point2::new(end.x_m, end.y_m) - Point2::new(x_m, y_m)).norm() < LOOK_M;
    (!is_look && path.goal == TASK_GOAL.id && beside_m > TASK_GOAL.tolerance_m + ROUNDING)
        .then(|| format!("it ends {beside_m:.2} m from the goal"))
}
