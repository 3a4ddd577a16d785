//! The field's upkeep: what is done while no answer is due.

use super::eased_box::EasedBox;
use super::node::{NO_WAY, Spot};
use super::prices::{BLOCKED, is_blocked};
use super::{GoalField, State};
use crate::bucket_queue::BucketQueue;
use crate::search::COST_SO_FAR_MAX;
use core::cmp::Reverse;
use std::collections::BinaryHeap;
use zeronav_msgs::Cell;

impl GoalField {
    /// Work for when no answer is due: learns from the last search, then grows the field of `goal`,
    /// or repairs it where costs fell and where they rose, by `expansions` at most. True when work is left.
    pub(crate) fn improve(&mut self, goal: Cell, expansions: u64) -> bool {
        // The goal may be that of another map.
        if !self.built || self.geometry.index_of(goal).is_none() {
            return false;
        }
        let goal = self.spot(goal);
        if goal != self.goal || self.state == State::Missing {
            self.begin(goal);
            return true;
        }
        self.learn();
        match self.state {
            State::Growing => self.grow(expansions),
            State::Whole => !self.repair(expansions) || self.raise(expansions),
            State::Missing | State::Beyond => false,
        }
    }

    /// Makes the field consistent where costs fell, by `limit` expansions at most; true when it is.
    /// Until then the box stays, which bounds what is not lowered yet.
    fn repair(&mut self, limit: u64) -> bool {
        let mut eased = core::mem::take(&mut self.eased);
        for spot in eased.drain(..) {
            self.lower(spot);
            for offset in self.offsets {
                self.lower(spot.wrapping_add(offset));
            }
        }
        self.eased = eased;
        for _ in 0..limit {
            let Some(Reverse(item)) = self.lowered.pop() else {
                self.eased_box = EasedBox::EMPTY;
                return true;
            };
            #[allow(clippy::cast_possible_truncation, reason = "the two halves, as pushed")]
            let (left, spot) = ((item >> 32) as u32, item as u32);
            if self.nodes[spot as usize].left == left {
                self.relax(spot, |heap, left, spot| {
                    heap.1
                        .push(Reverse(u64::from(left) << 32 | u64::from(spot)));
                });
            }
        }
        false
    }

    fn begin(&mut self, goal: Spot) {
        for node in &mut self.nodes {
            node.left = NO_WAY;
        }
        self.goal = goal;
        self.forget_eased();
        self.lists.closed.clear();
        self.raise.reset(self.nodes.len());
        self.nodes[goal as usize].left = 0;
        self.front.reset(0, self.span);
        self.front.push(0, goal);
        self.state = State::Growing;
    }

    fn grow(&mut self, expansions: u64) -> bool {
        let mut used = 0;
        while used < expansions {
            let Some((left, spot)) = self.front.pop_with_key() else {
                self.state = State::Whole;
                return !self.is_exact();
            };
            if self.nodes[spot as usize].left != left {
                continue;
            }
            if left > COST_SO_FAR_MAX {
                self.state = State::Beyond;
                return false;
            }
            used += 1;
            self.relax(spot, |queue, left, spot| queue.0.push(left, spot));
        }
        true
    }

    /// Offers what is left from `spot` to the cells from which a step leads there.
    #[inline]
    fn relax(
        &mut self,
        spot: Spot,
        mut push: impl FnMut((&mut BucketQueue, &mut BinaryHeap<Reverse<u64>>), u32, Spot),
    ) {
        let (own, around) = self.prices.around(spot);
        if own == BLOCKED {
            return;
        }
        let left = self.nodes[spot as usize].left;
        let costs = self.steps.each_ref().map(|steps| steps[usize::from(own)]);
        for (step, offset) in (0_u32..).zip(self.offsets) {
            if is_blocked(around, step) || !self.corner_permits(around, step) {
                continue;
            }
            let from = spot.wrapping_add(offset);
            let left = left + costs[step as usize & 1];
            let other = &mut self.nodes[from as usize];
            if left < other.left {
                other.left = left;
                push((&mut self.front, &mut self.lowered), left, from);
            }
        }
    }

    /// Lowers what is left from `spot` to what its neighbours allow.
    fn lower(&mut self, spot: Spot) {
        // Beside the border there may be nothing at all.
        if self.prices.at(spot) == BLOCKED || spot == self.goal {
            return;
        }
        let (_, around) = self.prices.around(spot);
        let mut least = NO_WAY;
        for (step, offset) in (0_u32..).zip(self.offsets) {
            if is_blocked(around, step) || !self.corner_permits(around, step) {
                continue;
            }
            let to = spot.wrapping_add(offset);
            let left = self.nodes[to as usize].left;
            if left != NO_WAY {
                let price = usize::from(self.prices.at(to));
                least = least.min(left + self.steps[step as usize & 1][price]);
            }
        }
        let node = &mut self.nodes[spot as usize];
        if least < node.left {
            node.left = least;
            self.lowered
                .push(Reverse(u64::from(least) << 32 | u64::from(spot)));
        }
    }

    #[inline]
    pub(super) const fn corner_permits(&self, around: u64, step: u32) -> bool {
        step.is_multiple_of(2)
            || self
                .rule
                .permits(is_blocked(around, step - 1), is_blocked(around, step + 1))
    }
}
