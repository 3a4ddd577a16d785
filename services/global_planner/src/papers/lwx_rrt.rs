//! `lwx_rrt`: the random tree that \[LWX\] compares with. Every parameter but the region is ours.
//!
//! `LaValle`, "Rapidly-exploring random trees: a new tool for path planning", 1998, with nodes on
//! the centres of cells. The tree has arrived when a node lies in the region around the goal and
//! sees it.

use crate::papers::field::{Field, Marks, Meter, distance};
use crate::papers::on_map::Solver;
use crate::papers::sight::sees;
use crate::planner::PlanError;
use rand::{RngExt as _, SeedableRng as _};
use rand_pcg::Pcg64Mcg;
use zeronav_msgs::Cell;
use zeronav_params::parameters;

/// Draws for one free cell before a sample is given up.
const DRAWS: u32 = 64;

/// Buckets along the longer side of the map.
const BUCKETS: i32 = 64;

/// Branches on the longer side of the map, without [`TreeOptions::step_cells`].
const BRANCHES: f64 = 20.0;

/// The planner's method.
#[must_use]
pub(crate) fn lwx_rrt(options: TreeOptions, seed: u64) -> LwxRrt {
    LwxRrt {
        options,
        seed,
        tree: Tree::default(),
        taken: Marks::default(),
    }
}

/// Part of the samples that is the goal. The paper gives none.
const GOAL_BIAS: f64 = 0.05;

parameters! {
    /// `lwx_rrt`: the random tree.
    #[derive(Copy)]
    pub struct TreeOptions {
        /// Length of a branch. Without, a twentieth of the map's longer side: one cell on the maps
        /// of the paper.
        #[serde(skip_serializing_if = "Option::is_none")]
        step_cells: Option<f64> = None, [1.0, 1.0e4] "cells";
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
    /// Cells that are nodes.
    taken: Marks,
}

/// Nodes with their parents, in buckets by place.
#[derive(Debug, Default)]
struct Tree {
    nodes: Vec<(Cell, u32)>,
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

    fn add(&mut self, cell: Cell, parent: u32) {
        let number = u32::try_from(self.nodes.len()).unwrap_or(u32::MAX);
        self.nodes.push((cell, parent));
        if let Some(bucket) = self.bucket(cell.x / self.side, cell.y / self.side) {
            self.buckets[bucket].push(number);
        }
    }

    fn bucket(&self, column: i32, row: i32) -> Option<usize> {
        let inside = (0..self.columns).contains(&column) && (0..self.rows).contains(&row);
        inside.then(|| (row * self.columns + column).unsigned_abs() as usize)
    }

    /// Number of the node nearest to `cell`, the earliest of equally near ones.
    fn nearest(&self, cell: Cell) -> u32 {
        let (column, row) = (cell.x / self.side, cell.y / self.side);
        let mut best = (f64::INFINITY, 0);
        for ring in 0..self.columns.max(self.rows) {
            // Every cell of this ring and all later ones is at least this far.
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
                            let d = distance(self.nodes[*number as usize].0, cell);
                            if (d, *number) < best {
                                best = (d, *number);
                            }
                        }
                    }
                    dx += stride;
                }
            }
        }
        best.1
    }
}

/// The cell nearest to the point `step` cells from `from` towards `to`.
#[allow(
    clippy::cast_possible_truncation,
    reason = "a point between two cells of the map"
)]
fn steer(from: Cell, to: Cell, step: f64) -> Cell {
    let length = distance(from, to);
    if length <= step {
        return to;
    }
    let part = step / length;
    let along = |from: i32, to: i32| from + (f64::from(to - from) * part).round() as i32;
    Cell::new(along(from.x, to.x), along(from.y, to.y))
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
        let step = options
            .step_cells
            .unwrap_or_else(|| f64::from(width.max(height)) / BRANCHES)
            .max(1.0);
        let mut rng = Pcg64Mcg::seed_from_u64(self.seed);
        self.tree.begin(width, height);
        self.taken.begin(field.n_cells());
        self.taken.insert(field.index(start));
        self.tree.add(start, 0);
        let mut newest = (start, 0);
        for _ in 0..options.samples {
            let in_region = distance(newest.0, goal) <= options.region_cells.max(0.0);
            if newest.0 == goal || (in_region && sees(field, newest.0, goal, meter)?) {
                self.trace(newest.1, cells);
                if newest.0 != goal {
                    cells.push(goal);
                }
                return Ok(());
            }
            meter.expand()?;
            let sample = if rng.random_range(0.0..1.0) < GOAL_BIAS {
                Some(goal)
            } else {
                (0..DRAWS)
                    .map(|_| Cell::new(rng.random_range(0..width), rng.random_range(0..height)))
                    .find(|cell| field.is_free(*cell))
            };
            let Some(sample) = sample else {
                continue;
            };
            let nearest = self.tree.nearest(sample);
            let from = self.tree.nodes[nearest as usize].0;
            let to = steer(from, sample, step);
            meter.stats.evaluated += 1;
            if !self.taken.has(field.index(to)) && sees(field, from, to, meter)? {
                self.taken.insert(field.index(to));
                newest = (to, u32::try_from(self.tree.nodes.len()).unwrap_or(u32::MAX));
                self.tree.add(to, nearest);
                meter.stats.generated += 1;
            }
        }
        Err(PlanError::DeadEnd)
    }
}

impl LwxRrt {
    /// Appends the way from the root to a node.
    fn trace(&self, mut number: u32, cells: &mut Vec<Cell>) {
        let first = cells.len();
        // Parents come before their children, so the numbers fall.
        while let Some((cell, parent)) = self.tree.nodes.get(number as usize) {
            cells.push(*cell);
            if number == 0 {
                break;
            }
            number = *parent;
        }
        cells[first..].reverse();
    }
}
