//! C-ASTAR: the reference A* with every switch that the papers' variants differ in.
//!
//! PAPERS 0.4 and Appendix D. [`crate::astar`] is the fast one for the default switches; this one
//! is plain: floating point, a binary heap keyed (f, h, insertion number), lazy deletion, nodes
//! stamped with a generation in place of clearing.

use crate::moves::STEPS;
use crate::papers::field::{Field, LENGTHS, Look, Meter, distance};
use crate::papers::heuristic::Heuristic;
use crate::papers::weight::Weight;
use crate::planner::PlanError;
use core::cmp::Ordering;
use std::collections::BinaryHeap;
use zeronav_msgs::Cell;
use zeronav_params::choices;

/// In what a best-first search differs from the next.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Recipe {
    /// Estimate of the way left.
    pub heuristic: Heuristic,
    /// Factor of the estimate.
    pub weight: Weight,
    /// What g is.
    pub so_far: SoFar,
    /// Whether closed nodes are opened again when a cheaper way to them turns up. Without, and
    /// with an inconsistent heuristic, the bound of weighted A* does not hold.
    pub reopen: bool,
    /// What a cell past a corner is.
    pub past_corner: PastCorner,
}

impl Recipe {
    /// A* with this estimate.
    #[must_use]
    pub(crate) const fn plain(heuristic: Heuristic) -> Self {
        Self {
            heuristic,
            weight: Weight::One,
            so_far: SoFar::Path,
            reopen: true,
            past_corner: PastCorner::Edge,
        }
    }
}

/// What g is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum SoFar {
    /// Cost of the path to the node.
    Path,
    /// Straight distance from the start: \[LWX\] eq. (2) as printed, which is wrong.
    StraightLine,
}

choices! {
    /// What a cell is that a diagonal step must not enter past a corner.
    pub enum PastCorner {
        /// That step is forbidden, nothing else.
        #[default]
        Edge = "edge",
        /// The cell is closed for every step, the literal reading of [BAO].
        Persistent = "persistent",
    }
}

/// Memory of a search, reused from call to call.
#[derive(Debug, Default)]
pub(crate) struct BestFirst {
    nodes: Vec<Node>,
    generation: u32,
    open: BinaryHeap<Entry>,
    entries: u64,
}

/// What the search knows about a cell.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Node {
    /// Cost of the best way found so far. [cells]
    pub(crate) so_far: f64,
    generation: u32,
    /// Step that led here; [`NO_STEP`] at the start.
    step: u8,
    pub(crate) closed: bool,
    past_corner: bool,
}

const NO_STEP: u8 = 8;

impl Default for Node {
    fn default() -> Self {
        Self {
            so_far: f64::INFINITY,
            generation: 0,
            step: NO_STEP,
            closed: false,
            past_corner: false,
        }
    }
}

/// A node in the open list.
#[derive(Debug, Clone, Copy)]
struct Entry {
    f: f64,
    h: f64,
    number: u64,
    so_far: f64,
    index: u32,
}

impl Ord for Entry {
    /// The smallest f is the greatest entry; of equal ones the nearer to the goal, then the
    /// earlier.
    fn cmp(&self, other: &Self) -> Ordering {
        other
            .f
            .total_cmp(&self.f)
            .then_with(|| other.h.total_cmp(&self.h))
            .then_with(|| other.number.cmp(&self.number))
    }
}

impl PartialOrd for Entry {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Entry {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Entry {}

impl BestFirst {
    /// Searches; true when a path was found, false when there is none for this recipe.
    ///
    /// # Errors
    /// [`PlanError::OutOfBudget`].
    pub(crate) fn search(
        &mut self,
        field: &Field<'_>,
        recipe: &Recipe,
        start: Cell,
        goal: Cell,
        meter: &mut Meter<'_>,
    ) -> Result<bool, PlanError> {
        self.begin(field.n_cells());
        let estimate = |cell| {
            let h = recipe.heuristic.between(cell, goal);
            (recipe.weight.at(field, cell) * h, h)
        };
        self.put(field, start, 0.0, NO_STEP, estimate(start), meter);
        while let Some(cell) = self.take(field) {
            let so_far = self.node(field.index(cell)).so_far;
            meter.expand()?;
            if cell == goal {
                return Ok(true);
            }
            meter.stats.evaluated += STEPS.len() as u64;
            for (n, length) in LENGTHS.iter().enumerate() {
                let to = match field.look(cell, n) {
                    Look::Free(to) => to,
                    Look::PastCorner(to) => {
                        self.note_past_corner(field, to, [start, goal], meter);
                        continue;
                    }
                    Look::Blocked => continue,
                };
                let through = match recipe.so_far {
                    SoFar::Path => so_far + length * field.price(to),
                    SoFar::StraightLine => distance(start, to),
                };
                let node = self.node(field.index(to));
                if through >= node.so_far - 1e-12
                    || (node.closed && !recipe.reopen)
                    || (node.past_corner && recipe.past_corner == PastCorner::Persistent)
                {
                    continue;
                }
                self.put(field, to, through, step_number(n), estimate(to), meter);
            }
        }
        Ok(false)
    }

    /// Empties the memory.
    pub(crate) fn begin(&mut self, n_cells: usize) {
        if self.nodes.len() != n_cells || self.generation == u32::MAX {
            self.nodes.clear();
            self.nodes.resize(n_cells, Node::default());
            self.generation = 0;
        }
        self.generation += 1;
        self.open.clear();
        self.entries = 0;
    }

    /// What is known about the cell at `index`.
    #[inline]
    pub(crate) fn node(&mut self, index: usize) -> &mut Node {
        let node = &mut self.nodes[index];
        if node.generation != self.generation {
            *node = Node {
                generation: self.generation,
                ..Node::default()
            };
        }
        node
    }

    /// Offers a way to `cell`; the caller has seen that it is better. `estimate` is the summand of
    /// the key and what decides between equal keys.
    pub(crate) fn put(
        &mut self,
        field: &Field<'_>,
        cell: Cell,
        so_far: f64,
        step: u8,
        estimate: (f64, f64),
        meter: &mut Meter<'_>,
    ) {
        let index = field.index(cell);
        let node = self.node(index);
        node.so_far = so_far;
        node.step = step;
        node.closed = false;
        self.open.push(Entry {
            f: so_far + estimate.0,
            h: estimate.1,
            number: self.entries,
            so_far,
            // Maps have at most 2^26 cells.
            index: u32::try_from(index).unwrap_or(u32::MAX),
        });
        self.entries += 1;
        meter.stats.generated += 1;
        meter.stats.peak_open = meter.stats.peak_open.max(self.open.len() as u64);
    }

    /// Closes the best open node.
    pub(crate) fn take(&mut self, field: &Field<'_>) -> Option<Cell> {
        while let Some(entry) = self.open.pop() {
            let node = self.node(entry.index as usize);
            // Entries of ways that were improved since are stale.
            if !node.closed && node.so_far.total_cmp(&entry.so_far).is_eq() {
                node.closed = true;
                return Some(field.cell(entry.index));
            }
        }
        None
    }

    /// Key of the best open node, infinite when there is none.
    pub(crate) fn least_key(&mut self) -> f64 {
        while let Some(entry) = self.open.peek().copied() {
            let node = self.node(entry.index as usize);
            if !node.closed && node.so_far.total_cmp(&entry.so_far).is_eq() {
                return entry.f;
            }
            self.open.pop();
        }
        f64::INFINITY
    }

    /// Start and goal are never virtual.
    fn note_past_corner(
        &mut self,
        field: &Field<'_>,
        cell: Cell,
        ends: [Cell; 2],
        meter: &mut Meter<'_>,
    ) {
        if !ends.contains(&cell) {
            let node = self.node(field.index(cell));
            meter.stats.remarks.virtual_total += u64::from(!node.past_corner);
            node.past_corner = true;
        }
    }

    /// True when the last search closed the cell at `index`.
    #[must_use]
    pub(crate) fn has_closed(&self, index: usize) -> bool {
        self.nodes
            .get(index)
            .is_some_and(|node| node.generation == self.generation && node.closed)
    }

    /// Appends the way from the start to `goal`, both included, that the last search found.
    pub(crate) fn trace(&self, field: &Field<'_>, goal: Cell, cells: &mut Vec<Cell>) {
        let first = cells.len();
        self.trace_back(field, goal, cells);
        cells[first..].reverse();
    }

    /// Appends the way back from `goal` to the start, both included.
    pub(crate) fn trace_back(&self, field: &Field<'_>, goal: Cell, cells: &mut Vec<Cell>) {
        let mut cell = goal;
        // Without a circle a way is no longer than the map is large.
        for _ in 0..self.nodes.len() {
            cells.push(cell);
            let step = self
                .nodes
                .get(field.index(cell))
                .map_or(NO_STEP, |n| n.step);
            let Some((dx, dy)) = STEPS.get(usize::from(step)) else {
                break;
            };
            cell = Cell::new(cell.x - dx, cell.y - dy);
        }
    }
}

/// A step's number as a node keeps it.
pub(crate) fn step_number(n: usize) -> u8 {
    u8::try_from(n).unwrap_or(NO_STEP)
}
