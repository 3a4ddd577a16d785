//! A region of cells and its two trees.

use super::super::GoalField;
use super::super::node::{NO_STEP, NO_WAY, Spot};
use super::pages::Pages;
use super::positions::{Interval, PositionSet};
use zeronav_casts::Cast;

/// In place of a position in the tree to the goal: no way from the cell is known.
pub(super) const NEVER: u32 = u32::MAX;

/// In place of a number.
pub(super) const NOWHERE: u32 = u32::MAX;

/// Cells that are looked at together.
const BLOCK: usize = 128;

/// Positions of a region, at most.
pub(super) const POSITIONS_MAX: u32 = 1 << STEP_AT;

const STEP_AT: u32 = 16;
const STEP_TO_GOAL_AT: u32 = 20;
const PRICE_AT: u32 = 24;

/// What is known about the cell at a position.
#[derive(Debug, Clone, Copy)]
pub(super) struct Place {
    pub(super) spot: Spot,
    /// What the way to it costs.
    pub(super) so_far: u32,
    /// Where the positions below it end.
    pub(super) end: u32,
    /// The same in the tree to the goal.
    pub(super) goal_end: u32,
}

/// What is known about a cell by where it lies. What a change cuts off is decided by this and by
/// prices alone, and ways are followed by it: it lies beside that of the cell's neighbours, while
/// places are anywhere in memory.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Known {
    pub(super) position: u32,
    /// Step from its parent; none at the root.
    pub(super) step: Option<u32>,
    /// First step to the goal; none at the goal, and where it leads out of the region.
    pub(super) step_to_goal: Option<u32>,
    /// Price when the region was found, below [`super::super::prices::BLOCKED`].
    pub(super) price: u8,
}

impl Known {
    /// In one number, which is never [`u32::MAX`]: steps are at most [`NO_STEP`].
    #[inline]
    fn packed(self) -> u32 {
        debug_assert!(self.position < POSITIONS_MAX);
        self.position
            | self.step.unwrap_or(NO_STEP) << STEP_AT
            | self.step_to_goal.unwrap_or(NO_STEP) << STEP_TO_GOAL_AT
            | u32::from(self.price) << PRICE_AT
    }

    #[inline]
    fn unpacked(number: u32) -> Self {
        let step = |at: u32| Some(number >> at & 0xf).filter(|step| *step != NO_STEP);
        Self {
            position: number & (POSITIONS_MAX - 1),
            step: step(STEP_AT),
            step_to_goal: step(STEP_TO_GOAL_AT),
            price: (number >> PRICE_AT) as u8,
        }
    }

    /// Where it was reached from; none for the root.
    #[inline]
    pub(super) fn parent(self, field: &GoalField, spot: Spot) -> Option<Spot> {
        let back = (self.step? + 4) as usize & 7;
        Some(spot.wrapping_add(field.offsets[back]))
    }
}

/// Summary of [`BLOCK`] positions.
#[derive(Debug, Clone, Copy)]
struct Block {
    /// Cheapest way over one of its cells.
    least: u32,
    /// Positions of its cells in the tree to the goal: lowest, and behind the highest.
    to_goal: Interval,
}

/// Cells by their position in the preorder of the cheapest ways from the root.
#[derive(Debug, Default)]
pub(super) struct Forest {
    life: u64,
    goal: Spot,
    /// What a way over the cell costs.
    totals: Vec<u32>,
    /// Position in the preorder of the cheapest ways to the goal.
    to_goal: Vec<u32>,
    places: Vec<Place>,
    blocks: Vec<Block>,
    /// [`Known`] by spot.
    known: Pages,
}

impl Forest {
    pub(super) fn begin(&mut self, field: &GoalField, goal: Spot, n: usize) {
        self.life = field.life;
        self.goal = goal;
        self.totals.clear();
        self.totals.resize(n, NO_WAY);
        self.to_goal.clear();
        self.to_goal.resize(n, NEVER);
        let nothing = Place {
            spot: 0,
            so_far: 0,
            end: 0,
            goal_end: NEVER,
        };
        self.places.clear();
        self.places.resize(n, nothing);
        self.blocks.clear();
        self.known.reset(field.width, field.nodes.len());
    }

    /// What a way over the cell costs, its position in the tree to the goal, and the rest.
    pub(super) fn put(&mut self, known: Known, (total, to_goal): (u32, u32), place: Place) {
        let at = known.position as usize;
        self.totals[at] = total;
        self.to_goal[at] = to_goal;
        self.places[at] = place;
        self.known.set(place.spot, known.packed());
    }

    /// Sums up the next block; false when there is none.
    pub(super) fn sum_up_next(&mut self) -> bool {
        let first = self.blocks.len() * BLOCK;
        let last = self.totals.len().min(first + BLOCK);
        if first >= last {
            return false;
        }
        let known = self.to_goal[first..last]
            .iter()
            .filter(|position| **position != NEVER);
        self.blocks.push(Block {
            least: self.totals[first..last]
                .iter()
                .copied()
                .min()
                .unwrap_or(NO_WAY),
            to_goal: (
                known.clone().copied().min().unwrap_or(NEVER),
                known.copied().max().map_or(0, |last| last + 1),
            ),
        });
        true
    }

    /// True when its cells and its goal are those of the field.
    pub(super) fn is_for(&self, field: &GoalField) -> bool {
        !self.places.is_empty() && self.goal == field.goal && self.life == field.life
    }

    /// Number of its cells.
    pub(super) fn len(&self) -> usize {
        self.totals.len()
    }

    pub(super) fn root(&self) -> Spot {
        self.places.first().map_or(0, |place| place.spot)
    }

    #[inline]
    pub(super) fn known(&self, spot: Spot) -> Option<Known> {
        self.known.get(spot).map(Known::unpacked)
    }

    #[inline]
    pub(super) fn place(&self, position: u32) -> &Place {
        &self.places[position as usize]
    }

    /// The positions below `position`, itself included.
    pub(super) fn below(&self, position: u32) -> Interval {
        (position, self.places[position as usize].end)
    }

    /// True when the cheapest way from the root to `position` leads over `above`.
    pub(super) fn is_below(&self, position: u32, above: u32) -> bool {
        let (first, end) = self.below(above);
        (first..end).contains(&position)
    }

    /// The positions below `position` in the tree to the goal.
    pub(super) fn below_to_goal(&self, position: u32) -> Option<Interval> {
        let first = self.to_goal[position as usize];
        (first != NEVER).then(|| (first, self.places[position as usize].goal_end))
    }

    /// What ways from the cell at `start` cost more than those from the root, by the position that
    /// they lead to: from each position of `detours` on so much, plus what the way to `start` costs.
    /// They lead back to where the ways from the root part.
    pub(super) fn detours_from(
        &self,
        field: &GoalField,
        start: Spot,
        detours: &mut Vec<(u32, u32)>,
    ) {
        detours.clear();
        let (mut next, mut n_forks, mut so_far) = (Some(start), 0, None);
        while let Some(spot) = next
            && let Some(known) = self.known(spot)
        {
            let cost = self.place(known.position).so_far;
            let extra = 2 * so_far.get_or_insert(cost).saturating_sub(cost);
            detours.push((known.position, extra));
            n_forks += 1;
            next = known.parent(field, spot);
        }
        detours.reverse();
        for n in (1..n_forks).rev() {
            let end = self.place(detours[n].0).end;
            detours.push((end, detours[n - 1].1));
        }
    }

    /// The cheapest cell that is cut off in neither tree: what a way over it costs, `detours` included,
    /// and its position. The intervals of `forward` are sorted and do not touch.
    pub(super) fn cheapest(
        &self,
        forward: &[Interval],
        to_goal: &PositionSet,
        detours: &[(u32, u32)],
    ) -> Option<(u32, u32)> {
        let mut best = (NO_WAY, NOWHERE);
        let mut forward = forward.iter().copied().peekable();
        let mut detours = detours.iter().copied().peekable();
        let mut extra = 0;
        for (block, first) in self.blocks.iter().zip((0_usize..).step_by(BLOCK)) {
            let last = self.totals.len().min(first + BLOCK);
            let mut at = first;
            while at < last {
                let position = at.to_u32();
                while forward.next_if(|cut| cut.1 <= position).is_some() {}
                let until = match forward.peek() {
                    Some(cut) if cut.0 <= position => {
                        at = cut.1 as usize;
                        continue;
                    }
                    Some(cut) => last.min(cut.0 as usize),
                    None => last,
                };
                while let Some((_, next)) = detours.next_if(|detour| detour.0 <= position) {
                    extra = next;
                }
                let until = detours
                    .peek()
                    .map_or(until, |detour| until.min(detour.0 as usize));
                if block.least.saturating_add(extra) < best.0 && !to_goal.holds_all(block.to_goal) {
                    let costs = self.totals[at..until].iter();
                    let others = self.to_goal[at..until].iter();
                    for ((total, other), position) in costs.zip(others).zip(position..) {
                        let total = total.saturating_add(extra);
                        if total < best.0 && !to_goal.holds(*other) {
                            best = (total, position);
                        }
                    }
                }
                at = until;
            }
        }
        (best.1 != NOWHERE).then_some(best)
    }

    /// What the cheapest way from the root cost: no way costs less while nothing becomes cheaper.
    pub(super) fn least(&self) -> u32 {
        self.totals.first().copied().unwrap_or(0)
    }

    pub(super) fn bytes(&self) -> usize {
        (self.totals.capacity() + self.to_goal.capacity()) * size_of::<u32>()
            + self.places.capacity() * size_of::<Place>()
            + self.blocks.capacity() * size_of::<Block>()
            + self.known.bytes()
    }
}
