//! The potential-field methods rolled out on a map, as the papers do it: squares for blocked cells, a
//! path of A* in cells, and no robot.

use crate::maps::Maze;
use crate::solve::Way;
use nalgebra::Point2;
use zeronav_local_planner::papers::walk::{End, Trace, Walk, walk};
use zeronav_local_planner::papers::{Body, Extent, Law};
use zeronav_msgs::path::Waypoint;
use zeronav_msgs::{Cell, Pose};

/// Blocked cells of a map as bodies. [cells]
#[must_use]
pub fn bodies(maze: &Maze) -> Vec<Body> {
    let (columns, rows) = maze.size();
    let cells = (0..rows).flat_map(|y| (0..columns).map(move |x| Cell::new(x, y)));
    cells
        .filter(|cell| !maze.is_free(*cell))
        .map(|cell| Body::standing(centre(maze, cell), Extent::Square(0.5)))
        .collect()
}

fn centre(maze: &Maze, cell: Cell) -> Point2<f64> {
    let Pose { x_m, y_m, .. } = maze.pose(cell);
    Point2::new(x_m, y_m)
}

/// The corners of a way as waypoints, the first and the last cell among them.
#[must_use]
pub fn waypoints(maze: &Maze, way: &Way) -> Vec<Waypoint> {
    let cells = &way.cells;
    let corner = |n: usize| {
        n == 0 || n + 1 == cells.len() || {
            let (one, here, other) = (cells[n - 1], cells[n], cells[n + 1]);
            let (before, after) = (
                (here.x - one.x, here.y - one.y),
                (other.x - here.x, other.y - here.y),
            );
            before != after
        }
    };
    (0..cells.len())
        .filter(|n| corner(*n))
        .map(|n| {
            let at = centre(maze, cells[n]);
            Waypoint {
                x_m: at.x,
                y_m: at.y,
                ..Waypoint::default()
            }
        })
        .collect()
}

/// A roll-out along a way of A*, and how near it came to obstacles.
#[derive(Debug, Clone)]
pub struct Rollout {
    /// The walk.
    pub trace: Trace,
    /// Least distance from an obstacle's square, 0 when the walk touches or crosses one. [cells]
    pub clearance: f64,
}

impl Rollout {
    /// True when it arrived.
    #[must_use]
    pub fn arrived(&self) -> bool {
        self.trace.end == End::Reached
    }

    /// True when it arrived and crossed nothing.
    #[must_use]
    pub fn is_clean(&self) -> bool {
        self.arrived() && self.clearance > 0.0
    }

    /// Length of the walk and what is left to the goal. [cells]
    #[must_use]
    pub fn length(&self, goal: Point2<f64>) -> f64 {
        let last = self.trace.points.last().copied().unwrap_or(goal);
        self.trace.length() + (goal - last).norm()
    }
}

/// Rolls a law out from start to goal of a map; how near it comes to obstacles is not measured, so that
/// this is what can be timed.
pub fn walked(
    law: &mut dyn Law,
    maze: &Maze,
    bodies: &[Body],
    path: &[Waypoint],
    how: &Walk,
) -> Trace {
    let (start, goal) = (centre(maze, maze.start), centre(maze, maze.goal));
    walk(law, start, goal, bodies, path, how)
}

/// The same with its distance from obstacles.
pub fn roll(
    law: &mut dyn Law,
    maze: &Maze,
    bodies: &[Body],
    path: &[Waypoint],
    how: &Walk,
) -> Rollout {
    measured(maze, walked(law, maze, bodies, path, how))
}

/// A walk with its distance from the map's obstacles, by their true outlines.
#[must_use]
pub fn measured(maze: &Maze, trace: Trace) -> Rollout {
    let clearance = maze.world.polyline_clearance_m(&trace.points);
    Rollout { trace, clearance }
}

/// The goal of a map. [cells]
#[must_use]
pub fn goal_of(maze: &Maze) -> Point2<f64> {
    centre(maze, maze.goal)
}
