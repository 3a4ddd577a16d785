//! A region of cells and its two trees.

use super::super::GoalField;
use super::super::node::{NO_WAY, Spot};
use super::pages::Pages;

/// In place of a position in the tree to the goal: no way from the cell is known.
pub(super) const NEVER: u32 = u32::MAX;

/// In place of a parent.
pub(super) const NOWHERE: u32 = u32::MAX;

/// In place of a step.
pub(super) const NO_STEP: u8 = 8;

/// Cells that are looked at together.
const BLOCK: usize = 128;

/// Positions from the first to before the last.
pub(super) type Interval = (u32, u32);

/// What is known about the cell at a position.
#[derive(Debug, Clone, Copy)]
pub(super) struct Place {
    pub(super) spot: Spot,
    /// What the way to it costs.
    pub(super) so_far: u32,
    /// Its parent's position; the root's is its own.
    pub(super) parent: u32,
    /// Where the positions below it end.
    pub(super) end: u32,
    /// Parent and end in the tree to the goal; [`NOWHERE`] where it leads out of the region.
    pub(super) goal_parent: u32,
    pub(super) goal_end: u32,
    /// Step from its parent; none at the root.
    pub(super) step: u8,
    /// First step to the goal.
    pub(super) step_to_goal: u8,
    /// Price when the region was found, below [`super::super::prices::BLOCKED`].
    pub(super) price: u8,
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
    positions: Pages,
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
            parent: 0,
            end: 0,
            goal_parent: NOWHERE,
            goal_end: NEVER,
            step: NO_STEP,
            step_to_goal: NO_STEP,
            price: 0,
        };
        self.places.clear();
        self.places.resize(n, nothing);
        self.blocks.clear();
        self.positions.reset(field.nodes.len());
    }

    pub(super) fn put(&mut self, position: u32, total: u32, to_goal: u32, place: Place) {
        let at = position as usize;
        self.totals[at] = total;
        self.to_goal[at] = to_goal;
        self.places[at] = place;
        self.positions.set(place.spot, position);
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

    pub(super) fn root(&self) -> Spot {
        self.places.first().map_or(0, |place| place.spot)
    }

    #[inline]
    pub(super) fn position(&self, spot: Spot) -> Option<u32> {
        self.positions.get(spot)
    }

    #[inline]
    pub(super) fn place(&self, position: u32) -> &Place {
        &self.places[position as usize]
    }

    /// True when the cheapest way from the root to `position` leads over `above`.
    pub(super) fn is_below(&self, position: u32, above: u32) -> bool {
        (above..self.places[above as usize].end).contains(&position)
    }

    /// The positions below `position` in the tree to the goal.
    pub(super) fn below_to_goal(&self, position: u32) -> Option<Interval> {
        let first = self.to_goal[position as usize];
        (first != NEVER).then(|| (first, self.places[position as usize].goal_end))
    }

    /// What ways from the cell at `start` cost more than those from the root, by the position that
    /// they lead to: from each position of `detours` on so much, plus what the way to `start` costs.
    /// They lead back to where the ways from the root part.
    pub(super) fn detours_from(&self, start: u32, detours: &mut Vec<(u32, u32)>) {
        detours.clear();
        let so_far = |position: u32| self.place(position).so_far;
        let extra = |fork: u32| 2 * so_far(start).saturating_sub(so_far(fork));
        let (mut fork, mut n_forks) = (start, 0);
        loop {
            detours.push((fork, extra(fork)));
            n_forks += 1;
            let parent = self.place(fork).parent;
            if parent == fork {
                break;
            }
            fork = parent;
        }
        detours.reverse();
        for n in (1..n_forks).rev() {
            let end = self.place(detours[n].0).end;
            detours.push((end, detours[n - 1].1));
        }
    }

    /// The cheapest cell that lies in no interval of either kind: what a way over it costs, `detours`
    /// included, and its position. Intervals are sorted and do not touch.
    pub(super) fn cheapest(
        &self,
        forward: &[Interval],
        to_goal: &[Interval],
        detours: &[(u32, u32)],
    ) -> Option<(u32, u32)> {
        let mut best = (NO_WAY, NOWHERE);
        let mut cuts = forward.iter().copied().peekable();
        let mut detours = detours.iter().copied().peekable();
        let mut extra = 0;
        for (block, first) in self.blocks.iter().zip((0_usize..).step_by(BLOCK)) {
            if block.least >= best.0 || is_covered(to_goal, block.to_goal) {
                continue;
            }
            let last = self.totals.len().min(first + BLOCK);
            let mut at = first;
            while at < last {
                #[allow(clippy::cast_possible_truncation, reason = "positions fit 32 bits")]
                let position = at as u32;
                while cuts.next_if(|cut| cut.1 <= position).is_some() {}
                if let Some(cut) = cuts.peek()
                    && cut.0 <= position
                {
                    at = cut.1 as usize;
                    continue;
                }
                while let Some((_, next)) = detours.next_if(|detour| detour.0 <= position) {
                    extra = next;
                }
                let total = self.totals[at].saturating_add(extra);
                let other = self.to_goal[at];
                if total < best.0 && other != NEVER && !is_covered(to_goal, (other, other + 1)) {
                    best = (total, position);
                }
                at += 1;
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
            + self.positions.bytes()
    }
}

/// True when one of the intervals holds all of `part`, or nothing is in it.
fn is_covered(intervals: &[Interval], part: Interval) -> bool {
    let behind = intervals.partition_point(|interval| interval.0 <= part.0);
    part.0 >= part.1
        || behind
            .checked_sub(1)
            .is_some_and(|n| intervals[n].1 >= part.1)
}
