//! Ways round, ready before the path is cut.
//!
//! While no answer is due, a search from the robot's cell under the guidance of the exact field
//! closes cells in the order of what a way over them costs: the region. Two trees span it, the
//! cheapest ways from the robot and those to the goal. When cells close, what they cut off in a tree
//! is an interval of its preorder. A way over a cell that is cut off in neither is legal at once, and
//! the cheapest of them is the detour: one look at each cell of the region, in blocks, in place of a
//! search over the cells that lead into what closed.
//!
//! Malik, Mittal, Gupta, "The k most vital arcs in the shortest path problem", Operations Research
//! Letters 8, 1989: for one closed edge of an undirected graph the detour is the cheapest way. For
//! a block of cells it may be dearer. With it comes a lower bound: what the way before cost.

mod cuts;
mod forest;
mod grow;
mod pages;
mod positions;
#[cfg(test)]
mod tests;

use super::node::Spot;
use super::prices::{BLOCKED, is_blocked};
use super::{Changed, GoalField};
use crate::moves::STEPS;
use cuts::{Cuts, Cutting};
use forest::Forest;
use grow::{Growth, Progress};
use zeronav_msgs::Cell;

/// A region is made anew when the robot is farther from where it began. [cells]
const ROBOT_MOVED: u32 = 8;

/// Farther from there than this, ways that begin there are of no use to the robot. [cells]
const ROBOT_FAR: u32 = 3 * ROBOT_MOVED;

/// And when a cell of the map changed, after so many updates of the map.
const UPDATES_MIN: u32 = 5;

/// More changes than this are not worth a look at each.
const CHANGES_MAX: usize = 1 << 14;

/// Steps of a way that are read ahead.
const AHEAD: u32 = 12;

/// A way round.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Detour {
    /// In the integer costs of the search.
    pub(crate) cost: u32,
    /// No way costs less; 0 where that is not known.
    pub(crate) least: u32,
}

/// See the module's description.
#[derive(Debug, Default)]
pub(crate) struct Detours {
    ready: Forest,
    growth: Growth,
    /// Cells that became dearer since `ready` began.
    cost_increased: Vec<Spot>,
    /// How many of them came before `growth` began.
    before_growth: usize,
    /// Something became cheaper since `ready` began, and since `growth` did.
    cost_decreased: [bool; 2],
    changed: bool,
    updates: u32,
    cuts: Cuts,
    /// See [`Forest::detours_from`].
    from_start: Vec<(u32, u32)>,
    /// Steps to a cell, the last one first.
    chain: Vec<u32>,
}

impl Detours {
    /// A cell became dearer.
    pub(crate) fn note(&mut self, spot: Spot) {
        if !self.is_beyond_counting() {
            self.cost_increased.push(spot);
        }
    }

    const fn is_beyond_counting(&self) -> bool {
        self.cost_increased.len() >= CHANGES_MAX
    }

    /// An update of the map was taken in.
    pub(crate) fn note_update(&mut self, changed: Changed) {
        self.changed |= changed.any;
        self.cost_decreased = self
            .cost_decreased
            .map(|cost_decreased| cost_decreased | changed.cost_decreased);
        self.updates = self.updates.saturating_add(1);
    }

    pub(crate) fn bytes(&self) -> usize {
        self.ready.bytes()
            + self.growth.bytes()
            + self.cost_increased.capacity() * size_of::<Spot>()
            + self.cuts.bytes()
            + self.from_start.capacity() * size_of::<(u32, u32)>()
            + self.chain.capacity() * size_of::<u32>()
    }

    /// Work of about `expansions` expansions on the region around a robot in `start`; true when more
    /// is left.
    pub(crate) fn prepare(&mut self, field: &mut GoalField, start: Cell, expansions: u64) -> bool {
        if self.growth.is_under_way(field) {
            match self.growth.go_on(field, expansions) {
                Progress::More => return true,
                Progress::Abandoned => {
                    self.changed = true;
                    return false;
                }
                Progress::Ready => {}
            }
            core::mem::swap(&mut self.ready, self.growth.forest());
            self.cost_increased
                .drain(..self.before_growth.min(self.cost_increased.len()));
            self.cost_decreased[0] = self.cost_decreased[1];
            return false;
        }
        let start = field.spot(start);
        if !field.is_exact() || !self.is_due(field, start) || !self.growth.begin(field, start) {
            return false;
        }
        if self.is_beyond_counting() {
            // Not all that changed is known: what is ready is of no use.
            self.ready = Forest::default();
            self.cost_increased.clear();
        }
        self.before_growth = self.cost_increased.len();
        self.changed = false;
        self.cost_decreased[1] = false;
        self.updates = 0;
        true
    }

    fn is_due(&self, field: &GoalField, start: Spot) -> bool {
        let is_free = field.prices.at(start) != BLOCKED && start != field.goal;
        is_free
            && (!self.ready.is_for(field)
                || self.is_beyond_counting()
                || field.apart(self.ready.root(), start) > ROBOT_MOVED
                || self.changed && self.updates >= UPDATES_MIN)
    }

    /// Appends a way from `start` to `goal`, both included, that is legal now; none when no region
    /// knows one. Bounded by the size of a region, not by that of the map.
    pub(crate) fn answer(
        &mut self,
        field: &GoalField,
        (start, goal): (Cell, Cell),
        cells: &mut Vec<Cell>,
    ) -> Option<Detour> {
        let forest = &self.ready;
        if start == goal
            || !forest.is_for(field)
            || field.goal != field.spot(goal)
            || self.is_beyond_counting()
        {
            return None;
        }
        let spot = field.spot(start);
        if field.apart(forest.root(), spot) > ROBOT_FAR {
            return None;
        }
        let position = forest.known(spot)?.position;
        let first = cells.len();
        self.cuts
            .set(forest, field, &self.cost_increased, Cutting::Blocked);
        forest.detours_from(field, spot, &mut self.from_start);
        let so_far = forest.place(position).so_far;
        let (total, over) =
            forest.cheapest(self.cuts.forward(), self.cuts.to_goal(), &self.from_start)?;
        // Bounds are those of ways from the root.
        let least = forest.least().saturating_sub(so_far);
        let least = if self.cost_decreased[0] { 0 } else { least };
        let mut cost = self.lead(field, start, over, cells);
        let is_dearer = |cost: u32, total: u32| cost > total.saturating_sub(so_far);
        if cost.is_none_or(|cost| is_dearer(cost, total)) {
            // It leads over cells that became dearer: perhaps one that avoids those costs less.
            self.cuts
                .set(&self.ready, field, &self.cost_increased, Cutting::Dearer);
            let forest = &self.ready;
            let cuts = (self.cuts.forward(), self.cuts.to_goal());
            if let Some((total, over)) = forest.cheapest(cuts.0, cuts.1, &self.from_start)
                && cost.is_none_or(|cost| is_dearer(cost, total))
            {
                let second = cells.len();
                let other = self.lead(field, start, over, cells);
                if other.is_some_and(|other| cost.is_none_or(|cost| other < cost)) {
                    cells.drain(first..second);
                    cost = other;
                } else {
                    cells.truncate(second);
                }
            }
        }
        if cost.is_none() {
            cells.truncate(first);
        }
        cost.map(|cost| Detour {
            cost,
            least: least.min(cost),
        })
    }

    /// Appends the way from `start` over the cell at position `over` to the goal, and gives what it
    /// costs; none, and nothing appended, where it is not legal.
    fn lead(
        &mut self,
        field: &GoalField,
        start: Cell,
        over: u32,
        cells: &mut Vec<Cell>,
    ) -> Option<u32> {
        let first = cells.len();
        let cost = self.walk(field, start, over, cells);
        if cost.is_none() {
            cells.truncate(first);
        }
        cost
    }

    fn walk(
        &mut self,
        field: &GoalField,
        start: Cell,
        over: u32,
        cells: &mut Vec<Cell>,
    ) -> Option<u32> {
        let forest = &self.ready;
        let mut walk = Walk::new(field, start, cells);
        // Back to where the ways part, then on.
        let mut known = forest.known(walk.spot)?;
        while !forest.is_below(over, known.position) {
            walk.step(known.step? + 4)?;
            known = forest.known(walk.spot)?;
        }
        self.chain.clear();
        let mut at = forest.place(over).spot;
        while at != walk.spot {
            let known = forest.known(at)?;
            let step = known.step?;
            self.chain.push(step);
            read_ahead(field, forest, at, step + 4);
            at = known.parent(field, at)?;
        }
        for step in self.chain.iter().rev() {
            walk.step(*step)?;
        }
        while let Some(step) = forest.known(walk.spot)?.step_to_goal {
            read_ahead(field, forest, walk.spot, step);
            walk.step(step)?;
        }
        (walk.spot == field.goal).then_some(walk.cost)
    }
}

/// Reads what is known about the cell [`AHEAD`] steps on in the same direction, so that it is in the
/// cache when the way comes there. Ways turn seldom, and nothing waits for a value on which nothing
/// depends, while each step of a way hangs on what the cell before says.
#[inline]
fn read_ahead(field: &GoalField, forest: &Forest, spot: Spot, step: u32) {
    let ahead = field.offsets[step as usize & 7].wrapping_mul(AHEAD);
    let ahead = spot.wrapping_add(ahead);
    let _ = core::hint::black_box((forest.known(ahead), field.prices.get(ahead)));
}

/// A way under construction.
struct Walk<'a> {
    field: &'a GoalField,
    cell: Cell,
    spot: Spot,
    cost: u32,
    cells: &'a mut Vec<Cell>,
}

impl<'a> Walk<'a> {
    fn new(field: &'a GoalField, start: Cell, cells: &'a mut Vec<Cell>) -> Self {
        cells.push(start);
        Self {
            field,
            cell: start,
            spot: field.spot(start),
            cost: 0,
            cells,
        }
    }

    /// One step; none when it is not legal.
    fn step(&mut self, step: u32) -> Option<()> {
        let (field, step) = (self.field, step & 7);
        let (_, around) = field.prices.around(self.spot);
        if is_blocked(around, step) || !field.corner_permits(around, step) {
            return None;
        }
        self.spot = self.spot.wrapping_add(field.offsets[step as usize]);
        let (dx, dy) = STEPS[step as usize];
        self.cell = Cell::new(self.cell.x + dx, self.cell.y + dy);
        self.cells.push(self.cell);
        let price = usize::from(field.prices.at(self.spot));
        let cost = field.steps[step as usize & 1][price];
        self.cost = self.cost.saturating_add(cost);
        Some(())
    }
}

impl GoalField {
    /// Rows or columns between two cells, the larger number.
    fn apart(&self, a: Spot, b: Spot) -> u32 {
        let (ax, ay) = (a % self.width, a / self.width);
        let (bx, by) = (b % self.width, b / self.width);
        ax.abs_diff(bx).max(ay.abs_diff(by))
    }
}
