//! One search under the guidance of the field.

use super::eased_box::EasedBox;
use super::{
    BLOCKED, BUDGET_EVERY, CLOSED, FIELD, FIELD_AND_BOX, GENERATION_SHIFT, NO_STEP, NO_WAY, Node,
    PRICE_MASK, PRICE_SHIFT, STEP_MASK, STEP_SHIFT, Spot, WEIGHTED,
};
use crate::bucket_queue::BucketQueue;
use crate::moves::{STEPS, octile};
use crate::planner::{Control, CornerRule, Expansions, PlanStats};
use crate::search::{COST_SO_FAR_MAX, Found};

/// A search under way: slices and numbers in one place, so that the inner loop sees no `Vec`.
pub(super) struct Run<'a> {
    pub(super) nodes: &'a mut [Node],
    pub(super) open: &'a mut BucketQueue,
    pub(super) closed: &'a mut Vec<Spot>,
    pub(super) steps: &'a [[u32; 256]; 2],
    pub(super) offsets: [u32; 8],
    pub(super) rule: CornerRule,
    pub(super) width: u32,
    pub(super) generation: u32,
    pub(super) goal: Spot,
    pub(super) goal_xy: (u32, u32),
    pub(super) eased_box: EasedBox,
    pub(super) quarters: u32,
    pub(super) below: u32,
    pub(super) generated: u64,
    pub(super) overflow: bool,
}

impl Run<'_> {
    pub(super) fn search<const GUIDE: u8>(
        &mut self,
        start: Spot,
        span: u32,
        budget: &mut dyn FnMut(Expansions) -> Control,
        stats: &mut PlanStats,
    ) -> Found {
        self.closed.clear();
        let node = &mut self.nodes[start as usize];
        let xy = (start % self.width, start / self.width);
        let left = bound::<GUIDE>(node.left, xy, self.goal_xy, &self.eased_box);
        if left == NO_WAY {
            return Found::Nothing;
        }
        let key = weighted::<GUIDE>(left, self.quarters);
        node.so_far = 0;
        node.meta =
            self.generation << GENERATION_SHIFT | node.meta & PRICE_MASK | NO_STEP << STEP_SHIFT;
        self.open.reset(key, span);
        self.open.push(key, start);
        self.generated += 1;
        while let Some(spot) = self.open.pop() {
            let node = &mut self.nodes[spot as usize];
            if node.meta & CLOSED != 0 {
                // A dearer way to a cell that has been closed since.
                continue;
            }
            node.meta |= CLOSED;
            let (so_far, step) = (node.so_far, (node.meta & STEP_MASK) >> STEP_SHIFT);
            stats.expanded += 1;
            if spot == self.goal {
                return Found::Path;
            }
            self.closed.push(spot);
            if stats.expanded.is_multiple_of(BUDGET_EVERY)
                && budget(Expansions(stats.expanded)) == Control::Stop
            {
                return Found::Stopped;
            }
            stats.evaluated += if step == NO_STEP { 8 } else { 5 };
            let xy = if GUIDE == FIELD {
                (0, 0)
            } else {
                (spot % self.width, spot / self.width)
            };
            self.expand::<GUIDE>(spot, xy, so_far, step);
        }
        if self.overflow {
            Found::Stopped
        } else {
            Found::Nothing
        }
    }

    /// The neighbours that the cell before does not reach at least as well without this one:
    /// valid for costs of cells entered, since both ways enter the same cell last.
    #[inline]
    fn expand<const GUIDE: u8>(&mut self, spot: Spot, xy: (u32, u32), so_far: u32, step: u32) {
        let rule = self.rule;
        if step == NO_STEP {
            let straight = [0, 2, 4, 6].map(|step| self.offer::<GUIDE>(spot, xy, so_far, step));
            for n in 0..4 {
                let (one, other) = (straight[n as usize], straight[(n as usize + 1) % 4]);
                if rule.permits(!one, !other) {
                    self.offer::<GUIDE>(spot, xy, so_far, 2 * n + 1);
                }
            }
        } else if step.is_multiple_of(2) {
            let ahead = self.offer::<GUIDE>(spot, xy, so_far, step);
            let left = self.offer::<GUIDE>(spot, xy, so_far, step + 2);
            let right = self.offer::<GUIDE>(spot, xy, so_far, step + 6);
            if rule.permits(!ahead, !left) {
                self.offer::<GUIDE>(spot, xy, so_far, step + 1);
            }
            if rule.permits(!ahead, !right) {
                self.offer::<GUIDE>(spot, xy, so_far, step + 7);
            }
        } else {
            let left = self.offer::<GUIDE>(spot, xy, so_far, step + 1);
            let right = self.offer::<GUIDE>(spot, xy, so_far, step + 7);
            if rule.permits(!left, !right) {
                self.offer::<GUIDE>(spot, xy, so_far, step);
            }
            if rule.permits(!left, self.is_blocked_behind(spot, step + 3)) {
                self.offer::<GUIDE>(spot, xy, so_far, step + 2);
            }
            if rule.permits(!right, self.is_blocked_behind(spot, step + 5)) {
                self.offer::<GUIDE>(spot, xy, so_far, step + 6);
            }
        }
    }

    /// Whether a cell beside a diagonal step that was taken is blocked.
    #[inline]
    fn is_blocked_behind(&self, spot: Spot, step: u32) -> bool {
        match self.rule {
            // Not asked for, and not blocked, else the step would not have been legal.
            CornerRule::Allow | CornerRule::ForbidAny => false,
            CornerRule::ForbidBoth => {
                let spot = spot.wrapping_add(self.offsets[(step & 7) as usize]);
                self.nodes[spot as usize].price() == BLOCKED
            }
        }
    }

    /// Offers a way of cost `so_far` to `spot` and one more step. False when it is blocked.
    #[inline(always)]
    #[allow(clippy::inline_always, reason = "called five times per expansion")]
    fn offer<const GUIDE: u8>(
        &mut self,
        spot: Spot,
        xy: (u32, u32),
        so_far: u32,
        step: u32,
    ) -> bool {
        let step = step & 7;
        let spot = spot.wrapping_add(self.offsets[step as usize]);
        let node = &mut self.nodes[spot as usize];
        let price = node.price();
        if price == BLOCKED {
            return false;
        }
        let so_far = so_far + self.steps[step as usize & 1][price as usize];
        // Also refuses closed nodes: with a consistent heuristic theirs is the best way already,
        // and with a weighted one it is good enough for the weight.
        let closed = GUIDE == WEIGHTED && node.meta & CLOSED != 0;
        if node.meta >> GENERATION_SHIFT == self.generation && (closed || so_far >= node.so_far) {
            return true;
        }
        if so_far > COST_SO_FAR_MAX {
            self.overflow = true;
            return true;
        }
        let (dx, dy) = STEPS[step as usize];
        let xy = (xy.0.wrapping_add_signed(dx), xy.1.wrapping_add_signed(dy));
        let left = bound::<GUIDE>(node.left, xy, self.goal_xy, &self.eased_box);
        if left == NO_WAY || GUIDE == WEIGHTED && so_far + left >= self.below {
            return true;
        }
        node.so_far = so_far;
        node.meta = self.generation << GENERATION_SHIFT | price << PRICE_SHIFT | step << STEP_SHIFT;
        self.generated += 1;
        // A weighted heuristic may fall by more than the step costs; the key must not.
        let least = if GUIDE == WEIGHTED {
            self.open.key()
        } else {
            0
        };
        let key = (so_far + weighted::<GUIDE>(left, self.quarters)).max(least);
        self.open.push(key, spot);
        true
    }
}

/// What is left as the keys count it.
#[inline]
const fn weighted<const GUIDE: u8>(left: u32, quarters: u32) -> u32 {
    if GUIDE == WEIGHTED {
        left + left / 4 * (quarters - 4)
    } else {
        left
    }
}

/// Lower bound of what is left from the cell at `xy`, of which the field says `left`.
#[inline]
fn bound<const GUIDE: u8>(left: u32, xy: (u32, u32), goal: (u32, u32), eased: &EasedBox) -> u32 {
    let straight = || octile(xy.0.abs_diff(goal.0), xy.1.abs_diff(goal.1));
    match GUIDE {
        FIELD => left,
        FIELD_AND_BOX => eased.bound(left, xy.0, xy.1).max(straight()),
        _ => straight(),
    }
}
