//! [ZM]'s dynamic scenes without a robot: a disc moved by the force alone, a step at a time at constant
//! speed, as in the paper. Nobody brakes, so that a scene without a contact is the method's own doing.

use crate::maps::Maze;
use crate::rollout::{bodies, waypoints};
use crate::scenes::ZmScene;
use crate::solve::{Fault, Method};
use crate::table::TableError;
use nalgebra::{Point2, Vector2};
use zeronav_local_planner::papers::options::ZmFullConfig;
use zeronav_local_planner::papers::zm_full::ZmFull;
use zeronav_local_planner::papers::{Body, Extent, Law as _, LawInput, Push};
use zeronav_msgs::Cell;
use zeronav_msgs::path::Waypoint;

/// Length of a step, distance from the goal that counts as there, and radius of the robot. [cells]
const STEP: f64 = 0.1;
const TOLERANCE: f64 = 0.2;
const RADIUS: f64 = 0.25;

/// Distance at which the obstacle appears. [cells]
const NEAR: f64 = 4.0;

/// Most steps.
const STEPS_MAX: usize = 2000;

/// A walk.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Walked {
    /// It ended at its goal.
    pub(super) arrived: bool,
    /// Where it first touched an obstacle.
    pub(super) contact: Option<Point2<f64>>,
}

/// The walks on the maps on which the cell of the obstacle is free and a way passes within four cells of
/// it: to the others nothing happens.
pub(super) fn unbraked(
    method: &Method,
    mazes: &[Maze],
    scene: ZmScene,
) -> Result<Vec<Walked>, TableError> {
    walks(method, &ZmFullConfig::default(), mazes, scene)
}

/// The same with these gains.
fn walks(
    method: &Method,
    gains: &ZmFullConfig,
    mazes: &[Maze],
    scene: ZmScene,
) -> Result<Vec<Walked>, TableError> {
    let mut walks = Vec::new();
    for maze in mazes.iter().filter(|maze| maze.is_free(scene.cell())) {
        walks.extend(of_map(method, gains, maze, scene.cell())?);
    }
    Ok(walks)
}

/// The way of a method on a map, as waypoints.
fn route(method: &Method, maze: &Maze) -> Result<Option<Vec<Waypoint>>, Fault> {
    let way = method.ways(core::slice::from_ref(maze))?.remove(0);
    Ok(way.ok().map(|way| waypoints(maze, &way)))
}

/// The nearest blocked cells' squares with the robot around them.
fn grown(maze: &Maze) -> Vec<Body> {
    let grow = |body: Body| Body {
        extent: match body.extent {
            Extent::Square(half) => Extent::Square(half + RADIUS),
            Extent::Disc(radius) => Extent::Disc(radius + RADIUS),
        },
        ..body
    };
    bodies(maze).into_iter().map(grow).collect()
}

fn of_map(
    method: &Method,
    gains: &ZmFullConfig,
    maze: &Maze,
    obstacle: Cell,
) -> Result<Option<Walked>, TableError> {
    let Some(mut path) = route(method, maze)? else {
        return Ok(None);
    };
    let goal = maze.pose(maze.goal).point();
    let appears = maze.pose(obstacle).point();
    let mut around = grown(maze);
    let mut law = ZmFull::new(gains);
    let (mut at, mut velocity) = (maze.pose(maze.start).point(), Vector2::zeros());
    let mut geometry = 1;
    let mut contact = None;
    for _ in 0..STEPS_MAX {
        if geometry == 1 && (at - appears).norm() <= NEAR {
            geometry = 2;
            let here = maze.cell_at(at);
            if here == Some(obstacle) || obstacle == maze.goal {
                return Ok(None);
            }
            let changed = maze.with_block(obstacle, here.unwrap_or(maze.start))?;
            around = grown(&changed);
            // Without another way it goes on along the first one.
            path = route(method, &changed)?.unwrap_or(path);
        }
        let input = LawInput {
            at,
            velocity,
            goal,
            bodies: &around,
            path: &path,
            geometry,
            literal: false,
            steps: 1.0,
            ground: None,
        };
        let arrived = (at - goal).norm() < TOLERANCE;
        let step = match law.push(&input) {
            Push::Along(force) if !arrived => force.try_normalize(1.0e-9),
            _ => None,
        };
        let Some(direction) = step else {
            let walked = Walked { arrived, contact };
            return Ok((geometry == 2).then_some(walked));
        };
        let next = at + direction * STEP.min((at - goal).norm());
        let touches = around.iter().any(|body| body.touches(at, next));
        if touches && contact.is_none() {
            contact = Some(next);
        }
        (at, velocity) = (next, direction);
    }
    let walked = Walked {
        arrived: false,
        contact,
    };
    Ok((geometry == 2).then_some(walked))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::maps::MapFamily;
    use crate::table::corners;
    use zeronav_global_planner::CornerRule;

    /// Most walks arrive although nobody brakes (28 of 31).
    #[test]
    fn most_walks_arrive_without_a_brake() {
        let mazes = corners(MapFamily::Blocky, [20, 20], 0.15)
            .draw(1, 60)
            .unwrap();
        let method = Method::new("IM_APF_A*", "zm_im").under(CornerRule::Allow);
        let walks = unbraked(&method, &mazes.mazes, ZmScene::Table2).unwrap();
        let arrived = walks.iter().filter(|walk| walk.arrived).count();
        assert!(walks.len() >= 10, "{} walks", walks.len());
        assert!(2 * arrived > walks.len(), "{arrived} of {}", walks.len());
        // None of them touches anything.
        let touched = walks.iter().filter(|walk| walk.contact.is_some());
        assert_eq!(touched.count(), 0);
    }

    /// What the claim is judged by can fail: pulled a hundred thousand times as hard, the disc runs into
    /// what it is not led around.
    #[test]
    fn a_disc_that_minds_no_obstacle_touches_some() {
        let mazes = corners(MapFamily::Blocky, [20, 20], 0.15)
            .draw(1, 60)
            .unwrap();
        let method = Method::new("IM_APF_A*", "zm_im").under(CornerRule::Allow);
        let gains = ZmFullConfig {
            attract: 1.0e5,
            ..ZmFullConfig::default()
        };
        let walks = walks(&method, &gains, &mazes.mazes, ZmScene::Table2).unwrap();
        let touched = walks.iter().filter(|walk| walk.contact.is_some()).count();
        assert!(touched > 0, "0 of {}", walks.len());
    }
}
