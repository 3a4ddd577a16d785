//! A path of cells as the waypoints of `plan/path`.

use nalgebra::Point2;
use zeronav_msgs::path::{WAYPOINTS_MAX, Waypoint};
use zeronav_msgs::pose::wrap_angle;
use zeronav_msgs::{Cell, MapView, Pose};

/// The path has more corners than a message holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, thiserror::Error)]
#[error("the path has more than {WAYPOINTS_MAX} corners")]
pub struct TooLong;

/// Writes the corners of the path that is straight between the centres of `cells`, and gives its
/// length [m].
///
/// The first waypoint is the centre of the first cell. When the last cell is that of `goal`, the
/// last waypoint is `goal` itself, reached from one cell before, so that the path leaves the
/// cells that were checked by less than half a cell; else it is the centre of the last cell. Its
/// yaw is that of `goal`, wrapped to (-pi, pi]. One cell makes one waypoint, no cell none.
///
/// # Errors
/// [`TooLong`]; `waypoints` is then empty.
pub fn waypoints_of(
    map: &MapView<'_>,
    cells: &[Cell],
    goal: &Pose,
    waypoints: &mut Vec<Waypoint>,
) -> Result<f64, TooLong> {
    waypoints.clear();
    let Some(last) = cells.last() else {
        return Ok(0.0);
    };
    let mut line = Line { map, waypoints };
    for (n, cell) in cells.iter().enumerate() {
        let corner = match (n.checked_sub(1).map(|n| cells[n]), cells.get(n + 1)) {
            (Some(before), Some(after)) => !is_straight(before, *cell, *after),
            _ => n + 1 < cells.len(),
        };
        if corner {
            line.push(map.geometry.centre_of(*cell))?;
        }
    }
    let centre = map.geometry.centre_of(*last);
    if map.geometry.cell_at(goal.point()) == Some(*last) {
        let beside_centre = (goal.point() - centre).norm() > 1.0e-9;
        if let ([.., before, last], true) = (cells, beside_centre) {
            let (dx, dy) = (last.x - before.x, last.y - before.y);
            let steps = dx.abs().max(dy.abs()).max(1);
            let back = nalgebra::Vector2::new(f64::from(dx), f64::from(dy)) / f64::from(steps);
            // Otherwise the line to the cell before the last has been a corner already.
            if steps > 1
                || line
                    .waypoints
                    .last()
                    .is_some_and(|w| !is_at(w, *before, map))
            {
                line.push(centre - back * map.geometry.resolution_m)?;
            }
        }
        line.push(goal.point())?;
    } else {
        line.push(centre)?;
    }
    Ok(turn(waypoints, goal))
}

/// No curve, or one of more points than a message holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, thiserror::Error)]
#[error("the curve has no points, or more than {WAYPOINTS_MAX}")]
pub struct NoCurve;

/// Writes the points of a curve in the `map` frame [m] as waypoints and gives its length [m]. The
/// yaw of the last is that of `goal`, wrapped to (-pi, pi].
///
/// # Errors
/// [`NoCurve`]; `waypoints` is then empty.
pub fn waypoints_along(
    map: &MapView<'_>,
    curve: &[Point2<f64>],
    goal: &Pose,
    waypoints: &mut Vec<Waypoint>,
) -> Result<f64, NoCurve> {
    waypoints.clear();
    if curve.is_empty() {
        return Err(NoCurve);
    }
    let mut line = Line { map, waypoints };
    for (n, point) in curve.iter().enumerate() {
        let corner = match (n.checked_sub(1).map(|n| curve[n]), curve.get(n + 1)) {
            (Some(before), Some(after)) => {
                let (one, other) = (point - before, after - point);
                one.perp(&other).abs() > 1e-9 * one.norm() * other.norm()
            }
            _ => true,
        };
        if corner {
            line.push(*point).map_err(|TooLong| NoCurve)?;
        }
    }
    Ok(turn(waypoints, goal))
}

struct Line<'a> {
    map: &'a MapView<'a>,
    waypoints: &'a mut Vec<Waypoint>,
}

impl Line<'_> {
    #[allow(clippy::cast_possible_truncation, reason = "the wire is f32")]
    fn push(&mut self, at: Point2<f64>) -> Result<(), TooLong> {
        if self.waypoints.len() == WAYPOINTS_MAX {
            self.waypoints.clear();
            return Err(TooLong);
        }
        let cell = self
            .map
            .geometry
            .cell_at(at)
            .and_then(|at| self.map.get(at));
        self.waypoints.push(Waypoint {
            x_m: at.x,
            y_m: at.y,
            yaw_rad: 0.0,
            clearance_m: cell.map_or(0.0, |cell| cell.clearance_m() as f32),
        });
        Ok(())
    }
}

/// Turns every waypoint to the next and sums up the length. [m]
#[allow(clippy::cast_possible_truncation, reason = "the wire is f32")]
fn turn(waypoints: &mut [Waypoint], goal: &Pose) -> f64 {
    let mut length_m = 0.0;
    for n in 1..waypoints.len() {
        let (dx, dy) = (
            waypoints[n].x_m - waypoints[n - 1].x_m,
            waypoints[n].y_m - waypoints[n - 1].y_m,
        );
        waypoints[n - 1].yaw_rad = dy.atan2(dx) as f32;
        length_m += dx.hypot(dy);
    }
    if let Some(last) = waypoints.last_mut() {
        last.yaw_rad = wrap_angle(goal.yaw_rad) as f32;
    }
    length_m
}

fn is_at(waypoint: &Waypoint, cell: Cell, map: &MapView<'_>) -> bool {
    map.geometry
        .cell_at(Point2::new(waypoint.x_m, waypoint.y_m))
        == Some(cell)
}

/// True when `b` lies on the way straight on from `a` to `c`.
fn is_straight(a: Cell, b: Cell, c: Cell) -> bool {
    let step = |from: Cell, to: Cell| (i64::from(to.x - from.x), i64::from(to.y - from.y));
    let ((ax, ay), (bx, by)) = (step(a, b), step(b, c));
    ax * by == ay * bx && ax * bx + ay * by > 0
}
