//! `lwx_rrt`: the random tree that \[LWX\] compares with. Every parameter but the region is ours.
//!
//! `LaValle`, "Rapidly-exploring random trees: a new tool for path planning", 1998: nodes anywhere
//! in the map's plane, branches of one length. The tree has arrived when its newest node lies in
//! the region around the goal and sees it; the way is the branches to that node and the line to the
//! goal, not smoothed. Samples that end first are a budget that ended.

use crate::papers::field::{Field, Meter};
use crate::papers::on_map::Solver;
use crate::planner::PlanError;
use nalgebra::{Point2, Vector2};
use rand::{RngExt as _, SeedableRng as _};
use rand_pcg::Pcg64Mcg;
use zeronav_casts::Cast;
use zeronav_msgs::Cell;
use zeronav_params::parameters;

/// Draws for one free cell before a sample is given up.
const DRAWS: u32 = 64;

/// Buckets along the longer side of the map.
const BUCKETS: i32 = 64;

/// The planner's method.
#[must_use]
pub(crate) fn lwx_rrt(options: TreeOptions, seed: u64) -> LwxRrt {
    LwxRrt {
        options,
        seed,
        tree: Tree::default(),
        way: Vec::new(),
    }
}

/// Part of the samples that is the goal. The paper gives none.
const GOAL_BIAS: f64 = 0.05;

parameters! {
    /// `lwx_rrt`: the random tree.
    #[derive(Copy)]
    pub struct TreeOptions {
        /// Length of a branch. One cell is for maps like those of the paper; on one of hundreds of
        /// cells a tree of such branches rarely gets anywhere before its samples end.
        step_cells: f64 = 1.0, [0.1, 100.0] "cells";
        /// Most samples.
        samples: u32 = 20_000, [1, 10_000_000];
        /// Distance to the goal that the tree must reach.
        region_cells: f64 = 1.0, [0.0, 1.0e4] "cells";
    }
}

/// See the module's description.
#[derive(Debug)]
pub(crate) struct LwxRrt {
    options: TreeOptions,
    seed: u64,
    tree: Tree,
    /// The last way found. [cells]
    way: Vec<Point2<f64>>,
}

/// Nodes with their parents, in buckets by place.
#[derive(Debug, Default)]
struct Tree {
    nodes: Vec<(Point2<f64>, u32)>,
    buckets: Vec<Vec<u32>>,
    columns: i32,
    rows: i32,
    side: i32,
}

impl Tree {
    fn begin(&mut self, width: i32, height: i32) {
        self.side = (width.max(height) + BUCKETS - 1) / BUCKETS;
        self.columns = (width + self.side - 1) / self.side;
        self.rows = (height + self.side - 1) / self.side;
        let n = self.columns.unsigned_abs() as usize * self.rows.unsigned_abs() as usize;
        for bucket in &mut self.buckets {
            bucket.clear();
        }
        self.buckets.resize_with(n, Vec::new);
        self.nodes.clear();
    }

    fn add(&mut self, at: Point2<f64>, parent: u32) {
        let number = u32::try_from(self.nodes.len()).unwrap_or(u32::MAX);
        self.nodes.push((at, parent));
        let cell = cell_of(at);
        if let Some(bucket) = self.bucket(cell.x / self.side, cell.y / self.side) {
            self.buckets[bucket].push(number);
        }
    }

    fn bucket(&self, column: i32, row: i32) -> Option<usize> {
        let inside = (0..self.columns).contains(&column) && (0..self.rows).contains(&row);
        inside.then(|| (row * self.columns + column).unsigned_abs() as usize)
    }

    /// Number of the node nearest to a point, the earliest of equally near ones.
    fn nearest(&self, to: Point2<f64>) -> u32 {
        let cell = cell_of(to);
        let (column, row) = (cell.x / self.side, cell.y / self.side);
        let mut best = (f64::INFINITY, 0);
        for ring in 0..self.columns.max(self.rows) {
            // Every point of this ring and all later ones is at least this far.
            if best.0 < f64::from((ring - 1) * self.side) {
                break;
            }
            for dy in -ring..=ring {
                let stride = if dy.abs() == ring {
                    1
                } else {
                    (2 * ring).max(1)
                };
                let mut dx = -ring;
                while dx <= ring {
                    if let Some(bucket) = self.bucket(column + dx, row + dy) {
                        for number in &self.buckets[bucket] {
                            let away = (self.nodes[*number as usize].0 - to).norm();
                            if (away, *number) < best {
                                best = (away, *number);
                            }
                        }
                    }
                    dx += stride;
                }
            }
        }
        best.1
    }

    /// Writes the way from the root to a node.
    fn trace(&self, mut number: u32, way: &mut Vec<Point2<f64>>) {
        way.clear();
        // Parents come before their children, so the numbers fall.
        while let Some((at, parent)) = self.nodes.get(number as usize) {
            way.push(*at);
            if number == 0 {
                break;
            }
            number = *parent;
        }
        way.reverse();
    }
}

/// The cell that a point lies in; coordinates are in cells from the map's lower left corner.
fn cell_of(at: Point2<f64>) -> Cell {
    Cell::new(at.x.floor().to_i32(), at.y.floor().to_i32())
}

/// Centre of a cell, in cells from the map's lower left corner.
fn centre_of(cell: Cell) -> Point2<f64> {
    Point2::new(f64::from(cell.x) + 0.5, f64::from(cell.y) + 0.5)
}

/// True when a segment touches no obstacle's square, not even at its edge, and does not leave the
/// map.
fn sees(
    field: &Field<'_>,
    from: Point2<f64>,
    to: Point2<f64>,
    meter: &mut Meter<'_>,
) -> Result<bool, PlanError> {
    let low = cell_of(from.coords.inf(&to.coords).into());
    let high = cell_of(from.coords.sup(&to.coords).into());
    meter.aux(u64::from(
        (high.x - low.x + 1).unsigned_abs() * (high.y - low.y + 1).unsigned_abs(),
    ))?;
    // One more on the lower sides, whose squares a segment along a grid line touches.
    let touched = |x: i32, y: i32| touches_square(from, to, f64::from(x), f64::from(y));
    let free = (low.y - 1..=high.y).all(|y| {
        (low.x - 1..=high.x).all(|x| {
            let cell = Cell::new(x, y);
            field.is_free(cell) || !touched(x, y)
        })
    });
    let inside = |at| field.map.geometry.contains(cell_of(at));
    Ok(free && inside(from) && inside(to))
}

/// By how much a segment may miss a square and still touch it: a way that passes a corner within rounding
/// would cross it by its cells. [cells]
const ROUNDING: f64 = 1.0e-9;

/// True when a segment touches the closed square of side 1 with this lower left corner, by clipping
/// (Liang, Barsky 1984).
fn touches_square(from: Point2<f64>, to: Point2<f64>, left: f64, low: f64) -> bool {
    let (mut enters, mut leaves) = (0.0_f64, 1.0_f64);
    for (start, way, low) in [(from.x, to.x - from.x, left), (from.y, to.y - from.y, low)] {
        let (low, high) = (low - ROUNDING, low + 1.0 + ROUNDING);
        if way == 0.0 {
            if start < low || start > high {
                return false;
            }
            continue;
        }
        let (one, other) = ((low - start) / way, (high - start) / way);
        enters = enters.max(one.min(other));
        leaves = leaves.min(one.max(other));
    }
    enters <= leaves
}

/// Appends the cells that a way passes through, one after the other.
fn push_cells(way: &[Point2<f64>], cells: &mut Vec<Cell>) {
    let mut crossings: Vec<f64> = Vec::new();
    for ends in way.windows(2) {
        let (from, along) = (ends[0], ends[1] - ends[0]);
        crossings.clear();
        crossings.extend([0.0, 1.0]);
        for (start, way) in [(from.x, along.x), (from.y, along.y)] {
            let end = start + way;
            let mut line = start.min(end).floor() + 1.0;
            while line < start.max(end) {
                crossings.push((line - start) / way);
                line += 1.0;
            }
        }
        crossings.sort_by(f64::total_cmp);
        for pair in crossings.windows(2) {
            let cell = cell_of(from + along * (0.5 * (pair[0] + pair[1])));
            if cells.last() != Some(&cell) {
                cells.push(cell);
            }
        }
    }
}

impl Solver for LwxRrt {
    fn solve(
        &mut self,
        field: &Field<'_>,
        start: Cell,
        goal: Cell,
        meter: &mut Meter<'_>,
        cells: &mut Vec<Cell>,
    ) -> Result<(), PlanError> {
        let (width, height) = field.map.geometry.size();
        let options = self.options;
        let mut rng = Pcg64Mcg::seed_from_u64(self.seed);
        let target = centre_of(goal);
        self.tree.begin(width, height);
        self.tree.add(centre_of(start), 0);
        let mut newest = (centre_of(start), 0);
        for _ in 0..options.samples {
            let in_region = (newest.0 - target).norm() <= options.region_cells;
            if newest.0 == target || (in_region && sees(field, newest.0, target, meter)?) {
                self.tree.trace(newest.1, &mut self.way);
                if newest.0 != target || self.way.len() == 1 {
                    self.way.push(target);
                }
                push_cells(&self.way, cells);
                return Ok(());
            }
            meter.expand()?;
            let sample = if rng.random_range(0.0..1.0) < GOAL_BIAS {
                Some(target)
            } else {
                (0..DRAWS)
                    .map(|_| {
                        let x = rng.random_range(0.0..f64::from(width));
                        Point2::new(x, rng.random_range(0.0..f64::from(height)))
                    })
                    .find(|at| field.is_free(cell_of(*at)))
            };
            let Some(sample) = sample else {
                continue;
            };
            let nearest = self.tree.nearest(sample);
            let from = self.tree.nodes[nearest as usize].0;
            let to = steer(from, sample, options.step_cells);
            meter.stats.evaluated += 1;
            if to != from && sees(field, from, to, meter)? {
                newest = (to, u32::try_from(self.tree.nodes.len()).unwrap_or(u32::MAX));
                self.tree.add(to, nearest);
                meter.stats.generated += 1;
            }
        }
        Err(PlanError::OutOfBudget)
    }

    fn polyline(&self) -> Option<&[Point2<f64>]> {
        Some(&self.way)
    }
}

/// The point `step` from `from` towards `to`, at most `to`.
fn steer(from: Point2<f64>, to: Point2<f64>, step: f64) -> Point2<f64> {
    let way: Vector2<f64> = to - from;
    if way.norm() <= step {
        to
    } else {
        from + way * (step / way.norm())
    }
}
