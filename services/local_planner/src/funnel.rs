//! Cost-to-go over the map around the robot, seeded from the path.
//!
//! Every cell of a window knows how far it is to the path's end by the shortest free way to the
//! path and along it (Dijkstra from all of the path's points in the window at once), so a motion
//! into a dead end is worth nothing however near it brings the robot to the path. Recomputed only
//! when the path or the map's cells changed, or when the robot has come near the window's edge.

#![allow(
    clippy::cast_possible_truncation,
    clippy::cast_possible_wrap,
    clippy::cast_precision_loss,
    clippy::cast_sign_loss,
    reason = "indices of a window of at most 160 x 160 cells, clamped before use"
)]

use crate::progress::{PathTracker, Place};
use core::cmp::Reverse;
use nalgebra::Point2;
use std::collections::BinaryHeap;
use zeronav_msgs::path::Waypoint;
use zeronav_msgs::{Cell, MapView};

/// [m] smallest side of a cell; finer maps are taken in blocks.
const CELL_M: f64 = 0.1;

/// Most cells on a side.
const SIDE_MAX: i32 = 160;

/// Steps to neighbours and their lengths in thousandths of a cell.
const STEPS: [(i32, i32, u32); 8] = [
    (1, 0, 1000),
    (0, 1, 1000),
    (-1, 0, 1000),
    (0, -1, 1000),
    (1, 1, 1414),
    (-1, 1, 1414),
    (-1, -1, 1414),
    (1, -1, 1414),
];

/// [m] between seeds along the path.
const SEED_M: f64 = 0.05;

/// Cost of a cell that leads nowhere.
const UNREACHED: u32 = u32::MAX;

/// What the window was made from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
struct Key {
    geometry: u64,
    cells: u64,
    /// Rows and columns of cells around the robot.
    half: i32,
}

/// The window.
#[derive(Debug, Clone, Default)]
pub(crate) struct Funnel {
    key: Option<Key>,
    cell_m: f64,
    /// Map frame, centre of cell (0, 0). [m]
    origin: Point2<f64>,
    side: i32,
    /// Where the robot was, in cells.
    made_at: (i32, i32),
    /// [m] to the path's end, infinite where no way leads there.
    to_go: Vec<f32>,
    costs: Vec<u32>,
    /// Cost factor in 256ths, 0 = not free.
    factors: Vec<u32>,
    open: BinaryHeap<Reverse<(u32, u32)>>,
}

/// What the window is made from.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FunnelInputs<'a> {
    pub(crate) map: MapView<'a>,
    /// Grows when cells of the map change.
    pub(crate) map_cells: u64,
    pub(crate) path: &'a [Waypoint],
    pub(crate) geometry: u64,
    pub(crate) place: Place,
    pub(crate) position: Point2<f64>,
    /// [m] around the robot that must be known.
    pub(crate) reach_m: f64,
    /// [m] nearer than which obstacles block the robot's centre.
    pub(crate) inscribed_m: f64,
    /// [m] from obstacles below which a way costs more.
    pub(crate) soft_m: f64,
}

impl Funnel {
    /// Makes the window anew when it has to be; true when it was.
    pub(crate) fn update(&mut self, tracker: &PathTracker, inputs: &FunnelInputs<'_>) -> bool {
        let geometry = inputs.map.geometry;
        let stride = (CELL_M / geometry.resolution_m).ceil().max(1.0);
        let cell_m = stride * geometry.resolution_m;
        let half = ((1.35 * inputs.reach_m / cell_m).ceil() as i32 + 2).min(SIDE_MAX / 2 - 1);
        let key = Key {
            geometry: inputs.geometry,
            cells: inputs.map_cells,
            half,
        };
        let at = inputs.position;
        let stride = stride as i32;
        let cell = geometry.unbounded_cell_at(at);
        let block = (cell.x.div_euclid(stride), cell.y.div_euclid(stride));
        let drifted = (block.0 - self.made_at.0)
            .abs()
            .max((block.1 - self.made_at.1).abs());
        let inner = (inputs.reach_m / cell_m).ceil() as i32;
        if self.key == Some(key) && drifted <= (half - inner).max(2) {
            return false;
        }
        self.key = Some(key);
        self.made_at = block;
        self.cell_m = cell_m;
        self.side = 2 * half + 1;
        let first = (block.0 - half, block.1 - half);
        self.origin = Point2::new(
            geometry.origin_x_m + (f64::from(first.0) + 0.5) * cell_m,
            geometry.origin_y_m + (f64::from(first.1) + 0.5) * cell_m,
        );
        self.weigh(inputs, first, stride);
        self.seed(tracker, inputs);
        self.spread();
        true
    }

    /// Cost factors of all cells: a block is as free as its freest cell.
    fn weigh(&mut self, inputs: &FunnelInputs<'_>, first: (i32, i32), stride: i32) {
        let n = (self.side * self.side) as usize;
        self.factors.clear();
        self.factors.reserve(n);
        let soft_m = inputs.inscribed_m + inputs.soft_m;
        for row in 0..self.side {
            for column in 0..self.side {
                let (x, y) = ((first.0 + column) * stride, (first.1 + row) * stride);
                let mut clearance_mm = 0;
                for dy in 0..stride {
                    for dx in 0..stride {
                        if let Some(cell) = inputs.map.get(Cell::new(x + dx, y + dy)) {
                            clearance_mm = clearance_mm.max(cell.clearance_mm);
                        }
                    }
                }
                let clearance_m = f64::from(clearance_mm) * 1.0e-3;
                let near = ((soft_m - clearance_m) / inputs.soft_m).clamp(0.0, 1.0);
                self.factors.push(if clearance_m < inputs.inscribed_m {
                    0
                } else {
                    256 + (512.0 * near * near) as u32
                });
            }
        }
    }

    /// Index of the cell that holds a point of the map frame.
    fn index_of(&self, at: Point2<f64>) -> Option<usize> {
        let column = ((at.x - self.origin.x) / self.cell_m).round() as i32;
        let row = ((at.y - self.origin.y) / self.cell_m).round() as i32;
        let inside = column >= 0 && row >= 0 && column < self.side && row < self.side;
        inside.then_some((row * self.side + column) as usize)
    }

    /// Puts the path's points in the window into the queue.
    fn seed(&mut self, tracker: &PathTracker, inputs: &FunnelInputs<'_>) {
        let n = self.factors.len();
        self.costs.clear();
        self.costs.resize(n, UNREACHED);
        self.open.clear();
        self.open.reserve(4 * n);
        let length_m = tracker.length_m();
        let around_m = f64::from(self.side) * self.cell_m;
        let mut arc_m = (inputs.place.arc_m - 1.0).max(0.0);
        let until_m = (inputs.place.arc_m + 2.0 * around_m).min(length_m);
        loop {
            let at = tracker.point_at(inputs.path, arc_m);
            if let Some(index) = self.index_of(at)
                && self.factors[index] > 0
            {
                let cost = ((length_m - arc_m) / self.cell_m * 1000.0).min(4.0e9) as u32;
                if cost < self.costs[index] {
                    self.costs[index] = cost;
                    self.open.push(Reverse((cost, index as u32)));
                }
            }
            if arc_m >= until_m {
                break;
            }
            arc_m = (arc_m + SEED_M).min(until_m);
        }
    }

    /// Dijkstra from all seeds.
    fn spread(&mut self) {
        while let Some(Reverse((cost, index))) = self.open.pop() {
            let index = index as usize;
            if cost > self.costs[index] {
                continue;
            }
            let (column, row) = (index as i32 % self.side, index as i32 / self.side);
            for (dx, dy, length) in STEPS {
                let (x, y) = (column + dx, row + dy);
                if x < 0 || y < 0 || x >= self.side || y >= self.side {
                    continue;
                }
                let next = (y * self.side + x) as usize;
                let factor = self.factors[next];
                if factor == 0 {
                    continue;
                }
                let through = cost.saturating_add(length * factor / 256);
                if through < self.costs[next] {
                    self.costs[next] = through;
                    self.open.push(Reverse((through, next as u32)));
                }
            }
        }
        self.to_go.clear();
        let thousandth_m = (self.cell_m * 1.0e-3) as f32;
        self.to_go.extend(self.costs.iter().map(|cost| match *cost {
            UNREACHED => f32::INFINITY,
            cost => cost as f32 * thousandth_m,
        }));
    }

    /// The way to go from a point of the map frame, bilinear where all four neighbours know it;
    /// `None` where no free way is known. [m]
    pub(crate) fn at(&self, point: Point2<f64>) -> Option<f32> {
        let u = ((point.x - self.origin.x) / self.cell_m) as f32;
        let v = ((point.y - self.origin.y) / self.cell_m) as f32;
        let last = (self.side - 1) as f32;
        if !(u >= 0.0 && v >= 0.0 && u < last && v < last) {
            return None;
        }
        let (column, row) = (u as usize, v as usize);
        let (fu, fv) = (u - column as f32, v - row as f32);
        let side = self.side as usize;
        let start = row * side + column;
        let quad = [start, start + 1, start + side, start + side + 1].map(|i| self.to_go[i]);
        let low = quad[0] + (quad[1] - quad[0]) * fu;
        let high = quad[2] + (quad[3] - quad[2]) * fu;
        let mean = low + (high - low) * fv;
        if mean.is_finite() {
            return Some(mean);
        }
        // Beside an obstacle: the nearest neighbour that knows a way.
        let least = quad.into_iter().fold(f32::INFINITY, f32::min);
        least.is_finite().then_some(least)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use zeronav_msgs::{GridGeometry, MapCell};

    const GEOMETRY: GridGeometry = GridGeometry {
        origin_x_m: 0.0,
        origin_y_m: 0.0,
        resolution_m: 0.1,
        width: 80,
        height: 60,
    };

    /// A wall along x = 4 m from y = 0 to `top_m`; the path goes round its upper end.
    fn world(top_m: f64) -> Vec<MapCell> {
        let mut cells = vec![MapCell::default(); GEOMETRY.len()];
        for (index, cell) in cells.iter_mut().enumerate() {
            let at = GEOMETRY.centre_of(Cell::new(index as i32 % 80, index as i32 / 80));
            let (dx, dy) = ((at.x - 4.0).abs() - 0.1, (at.y - top_m).max(0.0));
            cell.clearance_mm = (dx.max(0.0).hypot(dy).min(1.5) * 1000.0) as u16;
        }
        cells
    }

    fn funnel(cells: &[MapCell]) -> Funnel {
        let corners = [(1.0, 1.0), (1.0, 5.5), (7.0, 5.5), (7.0, 1.0)];
        let path = corners.map(|(x_m, y_m)| Waypoint {
            x_m,
            y_m,
            ..Waypoint::default()
        });
        let mut tracker = PathTracker::new();
        let position = Point2::new(1.0, 1.0);
        let place = tracker.advance(1, &path, position).expect("a path");
        let mut funnel = Funnel::default();
        let inputs = FunnelInputs {
            map: MapView {
                geometry: &GEOMETRY,
                cells,
            },
            map_cells: 1,
            path: &path,
            geometry: 1,
            place,
            position,
            reach_m: 5.0,
            inscribed_m: 0.25,
            soft_m: 0.2,
        };
        assert!(funnel.update(&tracker, &inputs));
        assert!(!funnel.update(&tracker, &inputs), "nothing changed");
        let moved = FunnelInputs {
            map_cells: 2,
            ..inputs
        };
        assert!(funnel.update(&tracker, &moved), "the map changed");
        funnel
    }

    #[test]
    fn on_the_path_the_way_is_what_is_left_of_it() {
        let funnel = funnel(&world(4.0));
        for (x, y, left_m) in [(7.0, 3.0, 2.0), (7.0, 4.5, 3.5)] {
            let to_go_m = f64::from(funnel.at(Point2::new(x, y)).expect("on the path"));
            assert!((to_go_m - left_m).abs() < 0.1, "{to_go_m}");
        }
        // Corners may be cut, but never is the way longer than along the path.
        for (x, y, left_m) in [(1.0, 1.0, 15.0), (1.0, 3.0, 13.0), (2.5, 5.5, 9.0)] {
            let to_go_m = f64::from(funnel.at(Point2::new(x, y)).expect("on the path"));
            assert!(
                to_go_m < left_m + 0.1 && to_go_m > 0.6 * left_m,
                "{to_go_m}"
            );
        }
    }

    #[test]
    fn before_a_wall_the_way_leads_back_round_it() {
        let funnel = funnel(&world(4.0));
        // 1 m before the wall, 2 m from the path's last leg behind it.
        let far = funnel.at(Point2::new(3.0, 1.5)).expect("free");
        let near = funnel.at(Point2::new(3.5, 1.5)).expect("free");
        assert!(far > 6.0, "{far}");
        assert!(near > far - 0.3, "{near} {far}");
        assert_eq!(funnel.at(Point2::new(4.0, 1.5)), None);
    }
}
