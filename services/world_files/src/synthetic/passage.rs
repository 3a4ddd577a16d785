//! Can a robot get through? The certificate of a synthetic world.
//!
//! The robot is the disc around its outline, which may turn wherever it fits. What is found here
//! is a drive that it can make; what is not found may exist all the same, because a disc is more
//! than the outline.

use nalgebra::{Point2, Vector2};
use std::cmp::Ordering;
use std::collections::{BinaryHeap, VecDeque};
use zeronav_casts::Cast;
use zeronav_world::World;

/// Side of a cell of the search among static obstacles. [m]
const CELL_M: f64 = 0.05;

/// Side of a cell of the search in time. [m]
const STEP_M: f64 = 0.25;

/// Time in which the robot goes from one of these cells to the next. [s] 1 m/s is half of what a
/// Jackal drives, which leaves it the time to reach and leave that speed.
const STEP_S: f64 = 0.25;

/// Steps that a quarter turn on the spot takes, with the stop before it.
const TURN_STEPS: u32 = 4;

/// Room that is left beside the robot among what moves. [m]
const ROOM_M: f64 = 0.05;

/// What of a robot counts here.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Robot {
    /// Radius of the disc that holds its outline. [m]
    pub radius_m: f64,
}

/// A disc at a moment: centre and radius. [m]
pub type Disc = (Point2<f64>, f64);

/// Cells in which the centre of the robot may be.
struct Grid {
    lower: Point2<f64>,
    side_m: f64,
    columns: usize,
    rows: usize,
    free: Vec<bool>,
}

impl Grid {
    /// Free is a cell from whose centre the robot can go straight to the centres of all free
    /// neighbours: no point of that way is more than half a diagonal from one of both centres.
    fn new(world: &World, robot: Robot, side_m: f64) -> Self {
        let geometry = world.geometry();
        let lower = Point2::new(geometry.origin_x_m, geometry.origin_y_m);
        let cells = |n: u32| (f64::from(n) * geometry.resolution_m / side_m).floor();
        let (columns, rows) = (
            cells(geometry.width).to_usize(),
            cells(geometry.height).to_usize(),
        );
        let mut grid = Self {
            lower,
            side_m,
            columns,
            rows,
            free: Vec::new(),
        };
        let apart_m = robot.radius_m + side_m * core::f64::consts::FRAC_1_SQRT_2;
        grid.free = (0..columns * rows)
            .map(|index| world.point_distance_m(grid.centre(index)) > apart_m)
            .collect();
        grid
    }

    fn centre(&self, index: usize) -> Point2<f64> {
        let (x, y) = (index % self.columns, index / self.columns);
        let along = |n: usize| (n.to_f64() + 0.5) * self.side_m;
        self.lower + Vector2::new(along(x), along(y))
    }

    /// The free cell nearest to a point, if one lies within `within_m`.
    fn near(&self, point: Point2<f64>, within_m: f64) -> Option<usize> {
        let far_m = |index: usize| (self.centre(index) - point).norm();
        (0..self.free.len())
            .filter(|index| self.free[*index] && far_m(*index) <= within_m)
            .min_by(|a, b| far_m(*a).total_cmp(&far_m(*b)))
    }

    /// The free neighbour in a direction.
    fn step(&self, index: usize, (dx, dy): (isize, isize)) -> Option<usize> {
        let x = (index % self.columns).checked_add_signed(dx)?;
        let y = (index / self.columns).checked_add_signed(dy)?;
        let next = y * self.columns + x;
        (x < self.columns && y < self.rows && self.free[next]).then_some(next)
    }
}

/// Length of the shortest drive in eight directions from `start` to within `tolerance_m` of
/// `goal` among the static obstacles of `world`; `None` when there is none. [m]
#[must_use]
pub fn shortest_m(
    world: &World,
    robot: Robot,
    [start, goal]: [Point2<f64>; 2],
    tolerance_m: f64,
) -> Option<f64> {
    let grid = Grid::new(world, robot, CELL_M);
    let from = grid.near(start, CELL_M)?;
    let mut reached = vec![f64::INFINITY; grid.free.len()];
    reached[from] = 0.0;
    let mut open = BinaryHeap::from([Open {
        length_m: 0.0,
        index: from,
    }]);
    while let Some(Open { length_m, index }) = open.pop() {
        if (grid.centre(index) - goal).norm() <= tolerance_m {
            return Some(length_m);
        }
        if length_m > reached[index] {
            continue;
        }
        for dy in -1..=1_i8 {
            for dx in -1..=1_i8 {
                let Some(next) = grid.step(index, (dx.into(), dy.into())) else {
                    continue;
                };
                let length_m = length_m + CELL_M * f64::from(dx).hypot(f64::from(dy));
                if length_m < reached[next] {
                    reached[next] = length_m;
                    open.push(Open {
                        length_m,
                        index: next,
                    });
                }
            }
        }
    }
    None
}

/// An entry of the search, the shortest first.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Open {
    length_m: f64,
    index: usize,
}

impl Eq for Open {}

impl Ord for Open {
    fn cmp(&self, other: &Self) -> Ordering {
        let by_length = other.length_m.total_cmp(&self.length_m);
        by_length.then(other.index.cmp(&self.index))
    }
}

impl PartialOrd for Open {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

/// The four headings, counter-clockwise from +x.
const HEADINGS: [(isize, isize); 4] = [(1, 0), (0, 1), (-1, 0), (0, -1)];

/// Time of a drive from `start`, heading along +x, to within `tolerance_m` of `goal` that touches
/// neither the static obstacles of `world` nor the discs, which are asked for at moments of the run; `None`
/// when none was found within `limit_s`. [s]
///
/// The robot drives straight from cell to cell at 1 m/s, turns by quarters on the spot in a
/// second, or waits.
#[must_use]
pub fn crossing_s(
    world: &World,
    robot: Robot,
    [start, goal]: [Point2<f64>; 2],
    tolerance_m: f64,
    limit_s: f64,
    discs_at: &dyn Fn(f64) -> Vec<Disc>,
) -> Option<f64> {
    let grid = Grid::new(world, robot, STEP_M);
    let n_steps = (limit_s / STEP_S).max(0.0).to_u32();
    let moment = |step: u32| discs_at(f64::from(step) * STEP_S);
    let mut moments: VecDeque<Vec<Disc>> = (0..=TURN_STEPS).map(moment).collect();
    // A state is a cell and a heading; layer n holds those that are reached n steps from now.
    let mut layers: VecDeque<Vec<bool>> = (0..=TURN_STEPS)
        .map(|_| vec![false; 4 * grid.free.len()])
        .collect();
    layers[0][4 * grid.near(start, STEP_M)?] = true;
    for step in 0..n_steps {
        let now = layers.pop_front()?;
        layers.push_back(vec![false; now.len()]);
        for state in (0..now.len()).filter(|state| now[*state]) {
            let (cell, heading) = (state / 4, state % 4);
            let at = grid.centre(cell);
            if (at - goal).norm() <= tolerance_m {
                return Some(f64::from(step) * STEP_S);
            }
            let clear =
                |n: usize, from, to| is_clear([&moments[n], &moments[n + 1]], robot, from, to);
            if clear(0, at, at) {
                layers[0][state] = true;
                if (1..moments.len() - 1).all(|n| clear(n, at, at)) {
                    for turned in [(heading + 1) % 4, (heading + 3) % 4] {
                        layers[moments.len() - 2][4 * cell + turned] = true;
                    }
                }
            }
            if let Some(next) = grid.step(cell, HEADINGS[heading])
                && clear(0, at, grid.centre(next))
            {
                layers[0][4 * next + heading] = true;
            }
        }
        moments.pop_front();
        moments.push_back(moment(step + TURN_STEPS + 1));
    }
    None
}

/// True when a robot that goes straight from `from` to `to` while the discs go straight from the
/// first to the second of two moments touches none of them.
fn is_clear(moments: [&[Disc]; 2], robot: Robot, from: Point2<f64>, to: Point2<f64>) -> bool {
    let mut discs = moments[0].iter().zip(moments[1]);
    discs.all(|((was, radius_m), (is, _))| {
        from_origin_m(from - was, to - is) > robot.radius_m + radius_m + ROOM_M
    })
}

/// Distance of the segment from `a` to `b` from the origin. [m]
fn from_origin_m(a: Vector2<f64>, b: Vector2<f64>) -> f64 {
    let along = b - a;
    let length2 = along.norm_squared();
    let share = if length2 > 0.0 {
        (-a.dot(&along) / length2).clamp(0.0, 1.0)
    } else {
        0.0
    };
    (a + along * share).norm()
}

#[cfg(test)]
mod tests {
    use super::*;
    use zeronav_world::WorldSpec;
    use zeronav_world::spec::ShapeSpec;

    const ROBOT: Robot = Robot { radius_m: 0.3 };

    /// A room of 8 m x 4 m, walled off in the middle but for a gap.
    fn room(gap_m: f64) -> World {
        let wall = |y: f64| ShapeSpec::Box {
            centre_m: [4.0, y],
            size_m: [0.2, 2.0],
            yaw_rad: 0.0,
        };
        let spec = WorldSpec {
            shapes: vec![wall(1.0 - gap_m / 2.0), wall(3.0 + gap_m / 2.0)],
            ..WorldSpec::area([0.0, 0.0], [8.0, 4.0])
        };
        World::new(&spec, None).unwrap()
    }

    fn ends() -> [Point2<f64>; 2] {
        [Point2::new(1.0, 2.0), Point2::new(7.0, 2.0)]
    }

    #[test]
    fn a_gap_is_passed_by_what_fits_through_it() {
        let length_m = shortest_m(&room(0.8), ROBOT, ends(), CELL_M).unwrap();
        assert!((5.9..6.2).contains(&length_m), "{length_m}");
        assert_eq!(shortest_m(&room(0.55), ROBOT, ends(), CELL_M), None);
        let nothing = |_| Vec::new();
        let cross = |gap_m| crossing_s(&room(gap_m), ROBOT, ends(), 0.25, 30.0, &nothing);
        let time_s = cross(1.4).unwrap();
        assert!((5.0..8.0).contains(&time_s), "{time_s}");
        assert_eq!(cross(0.55), None);
    }

    #[test]
    fn a_disc_in_the_gap_is_waited_for() {
        let cross = |leaves_s: f64| {
            let discs_at = |t_s: f64| {
                let y = if t_s < leaves_s {
                    2.0
                } else {
                    2.0 + (t_s - leaves_s).min(30.0)
                };
                vec![(Point2::new(4.0, y), 0.3)]
            };
            crossing_s(&room(1.4), ROBOT, ends(), 0.25, 30.0, &discs_at)
        };
        let (early_s, late_s) = (cross(0.0).unwrap(), cross(10.0).unwrap());
        assert!(
            early_s < 8.0 && (12.0..16.0).contains(&late_s),
            "{early_s} {late_s}"
        );
        assert_eq!(cross(60.0), None);
    }
}
