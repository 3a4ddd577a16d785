//! What the planners of the papers see of a map: free cells, legal steps, prices; and the meter
//! that their work runs on.

use crate::line::supercover;
use crate::moves::{STEPS, price};
use crate::planner::{Control, CornerRule, Expansions, PlanError, PlanStats, Unknown};
use core::f64::consts::SQRT_2;
use std::sync::Arc;
use zeronav_msgs::{Cell, MapView};

/// Lengths of the steps [`STEPS`]. [cells]
pub(crate) const LENGTHS: [f64; 8] = [1.0, SQRT_2, 1.0, SQRT_2, 1.0, SQRT_2, 1.0, SQRT_2];

/// Factor by which entering a cell of each cost is dearer than entering a free one, >= 1.
#[derive(Debug, Clone)]
pub(crate) struct Prices(Arc<[f64; 256]>);

impl Prices {
    /// See [`price`].
    #[must_use]
    pub(crate) fn new(cost_weight: f64) -> Self {
        let mut prices = [1.0; 256];
        for (entry, cost) in prices.iter_mut().zip(0..=u8::MAX) {
            *entry = price(cost, cost_weight);
        }
        Self(Arc::new(prices))
    }
}

/// A map under one policy for unknown cells and one corner rule, with virtual obstacles of the
/// planner's own.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Field<'a> {
    /// The map.
    pub map: MapView<'a>,
    /// Whether unknown cells may be crossed.
    pub unknown: Unknown,
    /// Which diagonal steps are legal.
    pub corner_rule: CornerRule,
    /// What entering a cell costs.
    pub prices: &'a Prices,
    /// Row-major: true = an obstacle that is not on the map. Empty = none.
    pub walls: &'a [bool],
    /// Flags of the map's cells that make an obstacle of a cell, too.
    pub layers: u8,
    /// Start and goal, which no flag makes an obstacle.
    pub spared: [Cell; 2],
}

/// What one of the eight steps from a cell leads to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Look {
    /// A free cell, by a legal step.
    Free(Cell),
    /// A free cell past a corner that must not be cut: "virtual" in the words of \[BAO\].
    PastCorner(Cell),
    /// An obstacle, or no cell of the map.
    Blocked,
}

impl<'a> Field<'a> {
    /// The same with these virtual obstacles in place of its own.
    #[must_use]
    pub(crate) const fn with_walls(self, walls: &'a [bool]) -> Self {
        Self { walls, ..self }
    }

    /// The same without virtual obstacles from the map.
    #[must_use]
    pub(crate) const fn without_layers(self) -> Self {
        Self { layers: 0, ..self }
    }

    /// The same under another corner rule.
    #[must_use]
    pub(crate) const fn with_rule(self, corner_rule: CornerRule) -> Self {
        Self {
            corner_rule,
            ..self
        }
    }

    /// Number of cells of the map.
    #[must_use]
    pub(crate) fn n_cells(&self) -> usize {
        self.map.cells.len()
    }

    /// Row-major index of a cell of the map; 0 for any other.
    #[must_use]
    #[inline]
    pub(crate) fn index(&self, cell: Cell) -> usize {
        self.map.geometry.index_of(cell).unwrap_or(0)
    }

    /// Cell of a row-major index.
    #[must_use]
    #[inline]
    pub(crate) fn cell(&self, index: u32) -> Cell {
        let width = self.map.geometry.width.max(1);
        Cell::new((index % width).cast_signed(), (index / width).cast_signed())
    }

    /// True when the robot's centre may be in `cell`.
    #[must_use]
    #[inline]
    pub(crate) fn is_free(&self, cell: Cell) -> bool {
        self.map.geometry.index_of(cell).is_some_and(|index| {
            let on_map = self.map.cells[index];
            !self.unknown.blocks(on_map)
                && (on_map.flags & self.layers == 0 || self.spared.contains(&cell))
                && !self.walls.get(index).is_some_and(|wall| *wall)
        })
    }

    /// Where step `n` of [`STEPS`] (modulo 8) leads.
    #[must_use]
    #[inline]
    pub(crate) fn look(&self, from: Cell, n: usize) -> Look {
        let n = n % 8;
        let (dx, dy) = STEPS[n];
        let to = Cell::new(from.x + dx, from.y + dy);
        if !self.is_free(to) {
            Look::Blocked
        } else if n.is_multiple_of(2) || self.corner_permits(from, to) {
            Look::Free(to)
        } else {
            Look::PastCorner(to)
        }
    }

    fn corner_permits(&self, from: Cell, to: Cell) -> bool {
        self.corner_rule == CornerRule::Allow
            || self.corner_rule.permits(
                !self.is_free(Cell::new(to.x, from.y)),
                !self.is_free(Cell::new(from.x, to.y)),
            )
    }

    /// True when a legal step leads from `from` to `to`, or both are the same.
    #[must_use]
    pub(crate) fn is_step(&self, from: Cell, to: Cell) -> bool {
        let (dx, dy) = (to.x - from.x, to.y - from.y);
        from == to
            || STEPS
                .iter()
                .position(|step| *step == (dx, dy))
                .is_some_and(|n| self.look(from, n) == Look::Free(to))
    }

    /// Factor of entering `cell`, >= 1.
    #[must_use]
    #[inline]
    pub(crate) fn price(&self, cell: Cell) -> f64 {
        let cost = self.map.get(cell).map_or(0, |cell| cell.cost);
        self.prices.0[usize::from(cost)]
    }

    /// Cost of the straight line between the centres of two cells: a step costs its length times
    /// the price of the cell it enters, a longer line its length in every cell times that cell's
    /// price. [cells]
    #[must_use]
    pub(crate) fn line_cost(&self, from: Cell, to: Cell) -> f64 {
        let length = distance(from, to);
        if (to.x - from.x).abs() <= 1 && (to.y - from.y).abs() <= 1 {
            return length * self.price(to);
        }
        let mut cost = 0.0;
        supercover(from, to, |crossing| {
            cost += (crossing.leaves - crossing.enters) * self.price(crossing.cell);
        });
        length * cost
    }
}

/// Straight distance. [cells]
#[must_use]
#[inline]
pub(crate) fn distance(from: Cell, to: Cell) -> f64 {
    f64::from(to.x - from.x).hypot(f64::from(to.y - from.y))
}

/// Units of work between two looks at the budget.
const ASK_EVERY: u64 = 1024;

/// Cells looked at beside the search that are as much work as one expansion.
const AUX_PER_EXPANSION: u64 = 16;

/// Counts what a search does and asks the budget now and then.
pub(crate) struct Meter<'a> {
    budget: &'a mut dyn FnMut(Expansions) -> Control,
    /// The counters.
    pub stats: &'a mut PlanStats,
    work: u64,
    ask_at: u64,
    stopped: bool,
}

impl<'a> Meter<'a> {
    /// Counts into `stats`.
    pub(crate) fn new(
        budget: &'a mut dyn FnMut(Expansions) -> Control,
        stats: &'a mut PlanStats,
    ) -> Self {
        Self {
            budget,
            stats,
            work: 0,
            ask_at: ASK_EVERY * AUX_PER_EXPANSION,
            stopped: false,
        }
    }

    /// One node more was expanded.
    ///
    /// # Errors
    /// [`PlanError::OutOfBudget`] when the budget says so.
    #[inline]
    pub(crate) fn expand(&mut self) -> Result<(), PlanError> {
        self.stats.expanded += 1;
        self.add(AUX_PER_EXPANSION)
    }

    /// So many cells were looked at beside the search: by sight lines, floods, evaporation.
    ///
    /// # Errors
    /// [`PlanError::OutOfBudget`] when the budget says so.
    pub(crate) fn aux(&mut self, cells: u64) -> Result<(), PlanError> {
        self.stats.remarks.aux_cells += cells;
        self.add(cells)
    }

    /// One entry of a walk was taken back.
    ///
    /// # Errors
    /// [`PlanError::OutOfBudget`] when the budget says so.
    pub(crate) fn turn_back(&mut self) -> Result<(), PlanError> {
        self.stats.remarks.turned_back += 1;
        self.add(AUX_PER_EXPANSION)
    }

    #[inline]
    fn add(&mut self, work: u64) -> Result<(), PlanError> {
        self.work += work;
        if self.work < self.ask_at {
            return Ok(());
        }
        self.ask_at = self.work + ASK_EVERY * AUX_PER_EXPANSION;
        match (self.budget)(Expansions(self.stats.expanded)) {
            Control::Go => Ok(()),
            Control::Stop => {
                self.stopped = true;
                Err(PlanError::OutOfBudget)
            }
        }
    }

    /// True when the budget ended, and not a limit of the method's own.
    #[must_use]
    pub(crate) const fn is_stopped(&self) -> bool {
        self.stopped
    }
}

/// A set of cells that is emptied without touching them.
#[derive(Debug, Default)]
pub(crate) struct Marks {
    marks: Vec<u32>,
    generation: u32,
}

impl Marks {
    /// Becomes the empty set over `n_cells` cells.
    pub(crate) fn begin(&mut self, n_cells: usize) {
        if self.marks.len() != n_cells || self.generation == u32::MAX {
            self.marks.clear();
            self.marks.resize(n_cells, 0);
            self.generation = 0;
        }
        self.generation += 1;
    }

    /// Puts a cell in; true when it is new.
    pub(crate) fn insert(&mut self, index: usize) -> bool {
        let generation = self.generation;
        self.marks
            .get_mut(index)
            .is_some_and(|mark| core::mem::replace(mark, generation) != generation)
    }

    /// True for cells that were put in.
    #[must_use]
    pub(crate) fn has(&self, index: usize) -> bool {
        self.marks.get(index) == Some(&self.generation)
    }
}
