//! The field's upkeep: what is done while no answer is due.

use super::eased_box::EasedBox;
use super::node::{NO_WAY, Spot};
use super::prices::{BLOCKED, is_blocked};
use super::{GoalField, State};
use crate::bucket_queue::BucketQueue;
use crate::search::COST_SO_FAR_MAX;
use core::cmp::Reverse;
use std::collections::BinaryHeap;
use zeronav_casts::low_u32;
use zeronav_msgs::Cell;

/// Bounds that are forgotten in the time of an expansion.
const CLEARED_PER_EXPANSION: usize = 256;

impl GoalField {
    /// Work for when no answer is due: learns from the last search, then grows the field of `goal` to
    /// beyond `robot`, or beyond where the last search began when that is off the map or blocked, or
    /// repairs it where costs fell and where they rose, by `expansions` at most. A field that has lost
    /// the robot is not grown anew while the two are not `connected`. True when work is left.
    pub(crate) fn improve(
        &mut self,
        robot: Option<Cell>,
        goal: Cell,
        expansions: u64,
        mut connected: impl FnMut(Cell, Cell) -> bool,
    ) -> bool {
        // The goal may be that of another map.
        if !self.built || self.geometry.index_of(goal).is_none() {
            return false;
        }
        let goal_cell = goal;
        let goal = self.spot(goal);
        let robot = robot
            .map(|cell| self.spot(cell))
            .filter(|spot| self.prices.at(*spot) != BLOCKED)
            .unwrap_or(self.from);
        let mut falls_short =
            |field: &Self| field.falls_short_of(robot) && connected(field.cell(robot), goal_cell);
        if goal != self.goal || self.state == State::Missing || falls_short(self) {
            self.begin(goal);
            return true;
        }
        self.learn();
        match self.state {
            State::Clearing => {
                self.clear(expansions);
                true
            }
            State::Growing => self.grow(robot, expansions),
            State::Whole => !self.repair(expansions) || self.raise(expansions) || falls_short(self),
            State::Missing | State::Beyond => false,
        }
    }

    /// True when so little of the field lies beyond the robot that ways round may leave it.
    fn falls_short_of(&self, robot: Spot) -> bool {
        let left = self.left.at(robot);
        self.reach != NO_WAY
            && self.is_exact()
            && self.prices.at(robot) != BLOCKED
            && self.prices.at(self.goal) != BLOCKED
            && left.saturating_add((left / 8).max(self.margin / 4)) > self.reach
    }

    /// What the last search proved: from a cell that it closed, the rest costs what its way cost
    /// less the way to the cell.
    pub(super) fn learn(&mut self) {
        if let Some(EasedBox { min, max, least }) = self.closed_box.take()
            && !self.lists.closed.is_empty()
        {
            // What was proved beside the box rests on this bound inside it.
            for y in min.1..=max.1 {
                for x in min.0..=max.0 {
                    self.learn_of(y * self.width + x, least);
                }
            }
        }
        let mut closed = core::mem::take(&mut self.lists.closed);
        for spot in closed.drain(..) {
            let left = if self.proved == NO_WAY {
                NO_WAY
            } else {
                self.proved.saturating_sub(self.nodes[spot as usize].so_far)
            };
            self.learn_of(spot, left);
        }
        self.lists.closed = closed;
    }

    /// At least `left` is left from `spot`.
    fn learn_of(&mut self, spot: Spot, left: u32) {
        if left > self.left.at(spot) {
            self.left.set(spot, left);
            self.raise.note(spot);
            if left != NO_WAY && !self.eased_box.is_empty() {
                // Those before it are not lowered to it yet.
                self.lowered
                    .push(Reverse(u64::from(left) << 32 | u64::from(spot)));
            }
        }
    }

    /// Makes the field consistent where costs fell, by `limit` expansions at most; true when it is.
    /// Until then the box stays, which bounds what is not lowered yet.
    fn repair(&mut self, limit: u64) -> bool {
        let mut cost_decreased = core::mem::take(&mut self.cost_decreased);
        for spot in cost_decreased.drain(..) {
            self.lower(spot);
            for offset in self.offsets {
                self.lower(spot.wrapping_add(offset));
            }
        }
        self.cost_decreased = cost_decreased;
        for _ in 0..limit {
            let Some(Reverse(item)) = self.lowered.pop() else {
                self.eased_box = EasedBox::EMPTY;
                return true;
            };
            let (left, spot) = (low_u32(item >> 32), low_u32(item));
            if self.left.at(spot) == left && left <= self.reach {
                self.relax(spot, |heap, left, spot| {
                    heap.1
                        .push(Reverse(u64::from(left) << 32 | u64::from(spot)));
                });
            }
        }
        false
    }

    fn begin(&mut self, goal: Spot) {
        self.goal = goal;
        self.forget_eased();
        self.lists.closed.clear();
        self.raise.clear();
        self.reach = NO_WAY;
        self.state = State::Clearing;
    }

    fn clear(&mut self, expansions: u64) {
        let most = usize::try_from(expansions).unwrap_or(usize::MAX);
        if self.left.clear(most.saturating_mul(CLEARED_PER_EXPANSION)) {
            return;
        }
        self.left.set(self.goal, 0);
        self.front.reset(0, self.span);
        self.front.push(0, self.goal);
        self.state = State::Growing;
    }

    fn grow(&mut self, robot: Spot, expansions: u64) -> bool {
        let from_robot = self.left.at(robot);
        if self.reach == NO_WAY && from_robot < self.front.key() {
            self.reach = from_robot.saturating_add((from_robot / 2).max(self.margin));
        }
        let mut used = 0;
        while used < expansions {
            let Some((left, spot)) = self.front.pop_with_key() else {
                self.reach = NO_WAY;
                self.state = State::Whole;
                return !self.is_exact();
            };
            if self.left.at(spot) != left {
                continue;
            }
            if left > self.reach {
                self.state = State::Whole;
                return !self.is_exact();
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
        let left = self.left.at(spot);
        let costs = self.steps.each_ref().map(|steps| steps[usize::from(own)]);
        for (step, offset) in (0_u32..).zip(self.offsets) {
            if is_blocked(around, step) || !self.corner_permits(around, step) {
                continue;
            }
            let from = spot.wrapping_add(offset);
            let left = left + costs[step as usize & 1];
            if left < self.left.at(from) {
                self.left.set(from, left);
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
            let left = self.left.at(to);
            if left != NO_WAY {
                let price = usize::from(self.prices.at(to));
                least = least.min(left + self.steps[step as usize & 1][price]);
            }
        }
        if least < self.left.at(spot) {
            self.left.set(spot, least);
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
