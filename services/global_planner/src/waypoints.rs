//! A path of cells as the waypoints of `plan/path`.

use nalgebra::Point2;
use zeronav_casts::Cast;
use zeronav_msgs::path::{WAYPOINTS_MAX, Waypoint};
use zeronav_msgs::pose::wrap_angle;
use zeronav_msgs::{Cell, MapView, Pose};

/// The path has more corners than a message holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, thiserror::Error)]
#[error("the path has more than {WAYPOINTS_MAX} corners")]
pub(crate) struct TooLong;

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
pub(crate) fn waypoints_of(
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
pub(crate) struct NoCurve;

/// Writes the points of a curve in the `map` frame [m] as waypoints and gives its length [m]. The
/// yaw of the last is that of `goal`, wrapped to (-pi, pi].
///
/// # Errors
/// [`NoCurve`]; `waypoints` is then empty.
pub(crate) fn waypoints_along(
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
            clearance_m: cell.map_or(0.0, |cell| cell.clearance_m().to_f32()),
        });
        Ok(())
    }
}

/// Turns every waypoint to the next and sums up the length. [m]
fn turn(waypoints: &mut [Waypoint], goal: &Pose) -> f64 {
    let mut length_m = 0.0;
    for n in 1..waypoints.len() {
        let (dx, dy) = (
            waypoints[n].x_m - waypoints[n - 1].x_m,
            waypoints[n].y_m - waypoints[n - 1].y_m,
        );
        waypoints[n - 1].yaw_rad = dy.atan2(dx).to_f32();
        length_m += dx.hypot(dy);
    }
    if let Some(last) = waypoints.last_mut() {
        last.yaw_rad = wrap_angle(goal.yaw_rad).to_f32();
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::support::Map;

    fn waypoints(map: &Map, cells: &[(i32, i32)], goal: &Pose) -> (Vec<Waypoint>, f64) {
        let cells: Vec<Cell> = cells.iter().map(|(x, y)| Cell::new(*x, *y)).collect();
        let mut waypoints = Vec::new();
        let length_m = waypoints_of(&map.view(), &cells, goal, &mut waypoints).unwrap();
        (waypoints, length_m)
    }

    /// Waypoints in cells from the centre of cell (0, 0), rounded to hundredths.
    fn in_cells(map: &Map, waypoints: &[Waypoint]) -> Vec<(f64, f64)> {
        let centre = map.geometry.centre_of(Cell::new(0, 0));
        let cells = |m: f64| (m / 0.05 * 100.0).round() / 100.0 + 0.0;
        waypoints
            .iter()
            .map(|w| (cells(w.x_m - centre.x), cells(w.y_m - centre.y)))
            .collect()
    }

    #[test]
    fn straight_runs_become_their_corners() {
        let map = Map::free(9, 9);
        let goal = map.pose(Cell::new(5, 2));
        let cells = [(0, 0), (1, 0), (2, 0), (3, 1), (4, 2), (5, 2)];
        let (waypoints, length_m) = waypoints(&map, &cells, &goal);
        let corners = [(0.0, 0.0), (2.0, 0.0), (4.0, 2.0), (5.0, 2.0)];
        assert_eq!(in_cells(&map, &waypoints), corners);
        assert!((length_m - (3.0 + 8.0_f64.sqrt()) * 0.05).abs() < 1e-9);
        let yaws: Vec<f32> = waypoints.iter().map(|w| w.yaw_rad).collect();
        let expected = [0.0, std::f32::consts::FRAC_PI_4, 0.0, 0.25];
        assert!(
            yaws.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-5),
            "{yaws:?}"
        );
        assert!(waypoints.iter().all(|w| (w.clearance_m - 0.5).abs() < 1e-6));
    }

    #[test]
    fn the_last_waypoint_is_the_goal_when_it_lies_in_the_last_cell() {
        let map = Map::free(9, 9);
        let mut goal = map.pose(Cell::new(4, 0));
        goal.x_m += 0.01;
        goal.y_m -= 0.02;
        goal.yaw_rad = 4.0;
        let run: Vec<(i32, i32)> = (0..5).map(|x| (x, 0)).collect();
        let (way, length_m) = waypoints(&map, &run, &goal);
        assert_eq!(in_cells(&map, &way), [(0.0, 0.0), (3.0, 0.0), (4.2, -0.4)]);
        assert!((way[2].yaw_rad - (4.0 - std::f32::consts::TAU)).abs() < 1e-5);
        assert!((length_m - (3.0 + 1.2_f64.hypot(0.4)) * 0.05).abs() < 1e-9);
        // The same from a path of corners, and where the cell before is a corner anyway.
        let (way, _) = waypoints(&map, &[(0, 0), (4, 0)], &goal);
        assert_eq!(in_cells(&map, &way), [(0.0, 0.0), (3.0, 0.0), (4.2, -0.4)]);
        let (way, _) = waypoints(&map, &[(3, 1), (3, 0), (4, 0)], &goal);
        assert_eq!(in_cells(&map, &way), [(3.0, 1.0), (3.0, 0.0), (4.2, -0.4)]);
        // Another cell takes the goal's place.
        let (way, _) = waypoints(&map, &[(3, 1), (3, 0)], &goal);
        assert_eq!(in_cells(&map, &way), [(3.0, 1.0), (3.0, 0.0)]);
        // The robot is in the goal's cell.
        let (way, length_m) = waypoints(&map, &[(4, 0)], &goal);
        assert_eq!(in_cells(&map, &way), [(4.2, -0.4)]);
        assert!(length_m.abs() < 1e-12);
    }

    #[test]
    fn too_many_corners_are_refused() {
        let map = Map::free(8000, 2);
        let zigzag: Vec<Cell> = (0..8000).map(|x| Cell::new(x, (x / 2) % 2)).collect();
        let goal = map.pose(zigzag[7999]);
        let mut way = Vec::new();
        let result = waypoints_of(&map.view(), &zigzag, &goal, &mut way);
        assert_eq!(result, Err(TooLong));
        assert!(way.is_empty());
        let short = &zigzag[..2000];
        assert!(waypoints_of(&map.view(), short, &map.pose(short[1999]), &mut way).is_ok());
        assert!(way.len() <= WAYPOINTS_MAX);
    }
}
