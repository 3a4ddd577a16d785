//! What stands: how far the goal is, and whether the robot touches something.

use super::oracle::robot::Abilities;
use nalgebra::Point2;
use std::cmp::Ordering;
use std::collections::BinaryHeap;
use zeronav_casts::Cast;
use zeronav_msgs::grid::Cell;
use zeronav_msgs::{GridGeometry, Pose};
use zeronav_world::World;

/// Side of a cell. [m] More when there would be more than [`CELLS_MAX`].
const CELL_M: f64 = 0.1;
const CELLS_MAX: f64 = 1.0e6;

/// Room that a robot keeps to what stands, at least. [m] It forgives what is between two moments.
const ROOM_M: f64 = 0.01;

/// Farther away nothing is told apart. [m]
const FAR_M: f64 = 1.0;

/// The area of the world in cells.
pub(super) struct Ground<'a> {
    world: &'a World,
    abilities: &'a Abilities,
    geometry: GridGeometry,
    /// Distance of each cell's centre from everything static. [m]
    room_m: Vec<f64>,
    /// Way from each cell's centre to the goal, infinite where there is none. [m]
    to_go_m: Vec<f64>,
    /// No point of a cell is farther from its centre. [m]
    slack_m: f64,
}

impl<'a> Ground<'a> {
    /// The ground of a world with a goal.
    pub(super) fn new(
        world: &'a World,
        abilities: &'a Abilities,
        goal_m: [f64; 2],
        tolerance_m: f64,
    ) -> Self {
        let geometry = geometry(world);
        let (width, height) = geometry.size();
        let cells = (0..height).flat_map(|y| (0..width).map(move |x| Cell::new(x, y)));
        let centres = cells.map(|cell| geometry.centre_of(cell));
        let room_m: Vec<f64> = centres.map(|at| world.point_distance_m(at)).collect();
        let slack_m = geometry.resolution_m * core::f64::consts::FRAC_1_SQRT_2;
        let mut ground = Self {
            world,
            abilities,
            geometry,
            to_go_m: vec![f64::INFINITY; room_m.len()],
            room_m,
            slack_m,
        };
        ground.spread(goal_m.into(), tolerance_m);
        ground
    }

    /// Way from a place to the goal for the centre of the robot, between the centres of cells;
    /// infinite where it cannot be, and outside of the world's area. [m]
    pub(super) fn to_go_m(&self, at_m: [f64; 2]) -> f64 {
        let at = Point2::from(at_m);
        let Some(own) = self.geometry.cell_at(at) else {
            return f64::INFINITY;
        };
        let side_m = self.geometry.resolution_m;
        let lower = self
            .geometry
            .unbounded_cell_at(Point2::new(at.x - 0.5 * side_m, at.y - 0.5 * side_m));
        let corner = |dx: i32, dy: i32| self.of(Cell::new(lower.x + dx, lower.y + dy));
        let share = (at - self.geometry.centre_of(lower)) / side_m;
        let row = |dy: i32| (1.0 - share.x) * corner(0, dy) + share.x * corner(1, dy);
        let between = (1.0 - share.y) * row(0) + share.y * row(1);
        if between.is_finite() {
            between
        } else {
            self.of(own)
        }
    }

    /// Room that the outline certainly has at a place, whatever its yaw, without asking the world.
    /// [m]
    pub(super) fn certain_room_m(&self, at_m: [f64; 2]) -> f64 {
        let cell = self.geometry.cell_at(at_m.into());
        let index = cell.and_then(|cell| self.geometry.index_of(cell));
        let room_m = index.map_or(0.0, |index| self.room_m[index]);
        room_m - self.slack_m - self.abilities.reach_m - ROOM_M
    }

    /// Room that the outline has at a pose beyond what it must keep, at most [`FAR_M`]; below 0
    /// when it has too little. [m]
    pub(super) fn room_m(&self, pose: &Pose) -> f64 {
        let outline = self.abilities.outline.placed(pose);
        self.world.convex_distance_m(&outline, FAR_M) - ROOM_M
    }

    fn of(&self, cell: Cell) -> f64 {
        let index = self.geometry.index_of(cell);
        index.map_or(f64::INFINITY, |index| self.to_go_m[index])
    }

    /// Finds the ways to the goal: the arrival times of a front that leaves its tolerance at 1 m/s
    /// (the fast marching method, Sethian, "A fast marching level set method for monotonically
    /// advancing fronts", 1996). A cell is open when the centre of the robot may be in it.
    fn spread(&mut self, goal: Point2<f64>, tolerance_m: f64) {
        let mut open = BinaryHeap::new();
        let (width, height) = self.geometry.size();
        for (index, way_m) in self.to_go_m.iter_mut().enumerate() {
            let cell = cell_of(index, &self.geometry);
            let apart_m = (self.geometry.centre_of(cell) - goal).norm();
            if apart_m <= tolerance_m.max(self.slack_m) {
                *way_m = 0.0;
                open.push(Open { way_m: 0.0, index });
            }
        }
        while let Some(Open { way_m, index }) = open.pop() {
            if way_m > self.to_go_m[index] {
                continue;
            }
            let Cell { x, y } = cell_of(index, &self.geometry);
            for next in [(x - 1, y), (x + 1, y), (x, y - 1), (x, y + 1)] {
                let inside = (0..width).contains(&next.0) && (0..height).contains(&next.1);
                let next = Cell::new(next.0, next.1);
                let Some(next_index) = self.geometry.index_of(next).filter(|_| inside) else {
                    continue;
                };
                if self.room_m[next_index] <= self.abilities.radius_m - self.slack_m {
                    continue;
                }
                let way_m = self.arrival_m(next);
                if way_m < self.to_go_m[next_index] {
                    self.to_go_m[next_index] = way_m;
                    open.push(Open {
                        way_m,
                        index: next_index,
                    });
                }
            }
        }
    }

    /// When the front reaches a cell by what is known of its neighbours. [m]
    fn arrival_m(&self, Cell { x, y }: Cell) -> f64 {
        let side_m = self.geometry.resolution_m;
        let along = |a: Cell, b: Cell| self.of(a).min(self.of(b));
        let across_m = along(Cell::new(x - 1, y), Cell::new(x + 1, y));
        let up_m = along(Cell::new(x, y - 1), Cell::new(x, y + 1));
        let (first_m, second_m) = (across_m.min(up_m), across_m.max(up_m));
        let apart_m = second_m - first_m;
        if apart_m >= side_m {
            return first_m + side_m;
        }
        0.5 * (first_m + second_m + (2.0 * side_m * side_m - apart_m * apart_m).sqrt())
    }
}

/// An entry of the front, the nearest first.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Open {
    way_m: f64,
    index: usize,
}

impl Eq for Open {}

impl Ord for Open {
    fn cmp(&self, other: &Self) -> Ordering {
        let by_way = other.way_m.total_cmp(&self.way_m);
        by_way.then(other.index.cmp(&self.index))
    }
}

impl PartialOrd for Open {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

/// Cells over the area of a world.
fn geometry(world: &World) -> GridGeometry {
    let own = world.geometry();
    let length_m = |cells: u32| f64::from(cells) * own.resolution_m;
    let (width_m, height_m) = (length_m(own.width), length_m(own.height));
    let side_m = (width_m * height_m / CELLS_MAX).sqrt().max(CELL_M);
    let cells = |length_m: f64| (length_m / side_m - 1.0e-6).ceil().max(1.0).to_u32();
    GridGeometry {
        resolution_m: side_m,
        width: cells(width_m),
        height: cells(height_m),
        ..*own
    }
}

/// The cell with this row-major index.
fn cell_of(index: usize, geometry: &GridGeometry) -> Cell {
    let width = geometry.width as usize;
    Cell::new((index % width).to_i32(), (index / width).to_i32())
}
