//! One search under the guidance of the field.

use super::bounds::Bounds;
use super::eased_box::EasedBox;
use super::node::{CLOSED, GENERATION_SHIFT, NO_STEP, NO_WAY, Node, STEP_MASK, STEP_SHIFT, Spot};
use super::open_list::OpenList;
use super::prices::{BLOCKED, Prices};
use crate::moves::{STEPS, octile};
use crate::planner::{Control, CornerRule, Expansions, PlanStats};
use crate::search::{COST_SO_FAR_MAX, Found};
use zeronav_casts::low_u8;

/// Expansions between two looks at the budget: some 50 us, after which it may be known that there is no
/// way.
const BUDGET_EVERY: u64 = 512;

/// The kinds of heuristic, as parameters of the search.
pub(super) const OCTILE: u8 = 0;
pub(super) const FIELD: u8 = 1;
pub(super) const FIELD_AND_BOX: u8 = 2;
pub(super) const WEIGHTED: u8 = 3;
/// The field up to its reach, weighted.
pub(super) const FIELD_WEIGHTED: u8 = 4;

const fn is_weighted(guide: u8) -> bool {
    guide == WEIGHTED || guide == FIELD_WEIGHTED
}

/// What a field says is left, up to its reach.
#[derive(Debug, Clone, Copy)]
pub(super) struct Within<'a> {
    pub(super) bounds: &'a Bounds,
    /// Larger bounds count as `beyond`, or as the octile distance where that is more.
    pub(super) reach: u32,
    pub(super) beyond: u32,
    pub(super) width: u32,
    pub(super) goal_xy: (u32, u32),
}

impl Within<'_> {
    #[inline]
    fn from(&self, spot: Spot) -> u32 {
        let left = self.bounds.at(spot);
        if left <= self.reach {
            left
        } else if self.beyond == NO_WAY {
            NO_WAY
        } else {
            let xy = (spot % self.width, spot / self.width);
            self.beyond.max(octile(
                xy.0.abs_diff(self.goal_xy.0),
                xy.1.abs_diff(self.goal_xy.1),
            ))
        }
    }
}

/// A search under way: slices and numbers in one place, so that the inner loop sees no `Vec`.
pub(super) struct Run<'a, Q> {
    pub(super) left: Within<'a>,
    pub(super) nodes: &'a mut [Node],
    pub(super) prices: &'a Prices,
    pub(super) open: &'a mut Q,
    pub(super) closed: &'a mut Vec<Spot>,
    pub(super) steps: &'a [[u32; 256]; 2],
    pub(super) offsets: [u32; 8],
    pub(super) rule: CornerRule,
    pub(super) width: u32,
    pub(super) generation: u32,
    pub(super) goal: Spot,
    pub(super) goal_xy: (u32, u32),
    pub(super) eased_box: EasedBox,
    /// Largest difference of two keys in the open list.
    pub(super) span: u32,
    pub(super) quarters: u32,
    pub(super) below: u32,
    /// Counter of expansions at which the search gives up.
    pub(super) last: u64,
    pub(super) generated: u64,
    pub(super) overflow: bool,
}

impl<Q: OpenList> Run<'_, Q> {
    pub(super) fn search<const GUIDE: u8>(
        &mut self,
        start: Spot,
        span: u32,
        budget: &mut dyn FnMut(Expansions) -> Control,
        stats: &mut PlanStats,
    ) -> Found {
        if self.begin::<GUIDE>(start, span) {
            self.go_on::<GUIDE>(budget, stats)
        } else {
            Found::Nothing
        }
    }

    /// Opens the start; false when no way leads from it.
    pub(super) fn begin<const GUIDE: u8>(&mut self, start: Spot, span: u32) -> bool {
        self.closed.clear();
        self.span = span;
        let node = &mut self.nodes[start as usize];
        let xy = (start % self.width, start / self.width);
        let left = bound::<GUIDE>(self.left.from(start), xy, self.goal_xy, &self.eased_box);
        if left == NO_WAY {
            return false;
        }
        let key = weighted::<GUIDE>(left, self.quarters);
        node.so_far = 0;
        node.meta = self.generation << GENERATION_SHIFT | NO_STEP << STEP_SHIFT;
        self.open.reset(key, span);
        self.open.push(key, start);
        self.generated += 1;
        true
    }

    /// Searches on from where the open list stands.
    pub(super) fn go_on<const GUIDE: u8>(
        &mut self,
        budget: &mut dyn FnMut(Expansions) -> Control,
        stats: &mut PlanStats,
    ) -> Found {
        while let Some(spot) = self.open.pop() {
            let node = &mut self.nodes[spot as usize];
            if node.meta & CLOSED != 0 {
                // A dearer way to a cell that has been closed since.
                continue;
            }
            if matches!(GUIDE, FIELD | FIELD_AND_BOX) {
                let xy = if GUIDE == FIELD {
                    (0, 0)
                } else {
                    (spot % self.width, spot / self.width)
                };
                let left = bound::<GUIDE>(self.left.from(spot), xy, self.goal_xy, &self.eased_box);
                if left == NO_WAY {
                    continue;
                }
                let key = node.so_far.saturating_add(left);
                if key > self.open.least() {
                    // Its key was beyond the span, or its bound has risen since.
                    let most = self.open.least().saturating_add(self.span);
                    self.open.push(key.min(most), spot);
                    continue;
                }
            }
            node.meta |= CLOSED;
            let (so_far, step) = (node.so_far, (node.meta & STEP_MASK) >> STEP_SHIFT);
            stats.expanded += 1;
            if spot == self.goal {
                return Found::Path;
            }
            self.closed.push(spot);
            let asks = stats.expanded.is_multiple_of(BUDGET_EVERY);
            if stats.expanded >= self.last
                || asks && budget(Expansions(stats.expanded)) == Control::Stop
            {
                return Found::Stopped;
            }
            stats.evaluated += if step == NO_STEP { 8 } else { 5 };
            let xy = if matches!(GUIDE, FIELD | FIELD_WEIGHTED) {
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

    /// Offers the ways over `spot` to the neighbours that it may improve.
    ///
    /// A neighbour is left out when the cell before reaches it without `spot` for less, by the
    /// prices of the very cells: the three behind always, those beside where the direct diagonal
    /// step is cheaper. Of two equally dear ways, straight then diagonal and diagonal then
    /// straight, only the second is followed (Sturtevant, Rabin, "Canonical Orderings on Grids",
    /// IJCAI 2016, on equal prices). The last step of that one is straight and as dear as any
    /// other way there, so it is never left out itself.
    ///
    /// With a weighted heuristic closed cells need not have their least cost: then nothing but
    /// what lies behind is left out.
    #[inline]
    fn expand<const GUIDE: u8>(&mut self, spot: Spot, xy: (u32, u32), so_far: u32, step: u32) {
        let rule = self.rule;
        let (own, around) = self.prices.around(spot);
        // Prices by the number of eighth turns from the direction of arrival.
        let turned = around.rotate_right(8 * (step & 7));
        let at = |turn: u32| low_u8(turned >> (8 * turn));
        let [straight, diagonal] = self.steps;
        let dear = |table: &[u32; 256], price: u8| table[usize::from(price)];
        let mut offer = |turn: u32| {
            self.offer::<GUIDE>(spot, xy, so_far, (step + turn) & 7, at(turn));
        };
        if step == NO_STEP {
            for turn in 0..8 {
                let corner = |turn: u32| at(turn & 7) == BLOCKED;
                if at(turn) != BLOCKED
                    && (turn.is_multiple_of(2) || rule.permits(corner(turn + 7), corner(turn + 1)))
                {
                    offer(turn);
                }
            }
        } else if step.is_multiple_of(2) {
            let ahead_blocked = at(0) == BLOCKED;
            if !ahead_blocked {
                offer(0);
            }
            let mut fronts = [None; 2];
            for ((side, front, behind), ahead) in
                [(2, 1, 3), (6, 7, 5)].into_iter().zip(&mut fronts)
            {
                let (beside, before) = (at(side), at(front));
                let short = !is_weighted(GUIDE)
                    && beside != BLOCKED
                    && rule.permits(at(behind) == BLOCKED, false);
                let to_side = dear(diagonal, beside);
                if beside != BLOCKED
                    && !(short && to_side < dear(straight, own) + dear(straight, beside))
                {
                    offer(side);
                }
                if before != BLOCKED
                    && rule.permits(ahead_blocked, beside == BLOCKED)
                    && !(short
                        && to_side + dear(straight, before)
                            < dear(straight, own) + dear(diagonal, before))
                {
                    *ahead = Some(front);
                }
            }
            for front in fronts.into_iter().flatten() {
                offer(front);
            }
        } else {
            let [left_blocked, right_blocked] = [at(1) == BLOCKED, at(7) == BLOCKED];
            if !left_blocked {
                offer(1);
            }
            if !right_blocked {
                offer(7);
            }
            if at(0) != BLOCKED && rule.permits(left_blocked, right_blocked) {
                offer(0);
            }
            for (side, back, behind) in [(left_blocked, 2, 3), (right_blocked, 6, 5)] {
                let (passed, target) = (at(behind), at(back));
                if target == BLOCKED || !rule.permits(side, passed == BLOCKED) {
                    continue;
                }
                let short = !is_weighted(GUIDE)
                    && passed != BLOCKED
                    && dear(straight, passed) + dear(straight, target)
                        < dear(diagonal, own) + dear(diagonal, target);
                if !short {
                    offer(back);
                }
            }
        }
    }

    /// Offers a way of cost `so_far` to `spot` and one more step to a free cell of this price.
    #[inline(always)]
    #[allow(clippy::inline_always, reason = "called several times per expansion")]
    fn offer<const GUIDE: u8>(
        &mut self,
        spot: Spot,
        xy: (u32, u32),
        so_far: u32,
        step: u32,
        price: u8,
    ) {
        let spot = spot.wrapping_add(self.offsets[step as usize & 7]);
        let node = &mut self.nodes[spot as usize];
        let so_far = so_far + self.steps[step as usize & 1][usize::from(price)];
        // Also refuses closed nodes: with a consistent heuristic theirs is the best way already,
        // and with a weighted one it is good enough for the weight.
        let closed = is_weighted(GUIDE) && node.meta & CLOSED != 0;
        if node.meta >> GENERATION_SHIFT == self.generation && (closed || so_far >= node.so_far) {
            return;
        }
        if so_far > COST_SO_FAR_MAX {
            self.overflow = true;
            return;
        }
        let (dx, dy) = STEPS[step as usize & 7];
        let xy = (xy.0.wrapping_add_signed(dx), xy.1.wrapping_add_signed(dy));
        let left = bound::<GUIDE>(self.left.from(spot), xy, self.goal_xy, &self.eased_box);
        if left == NO_WAY || is_weighted(GUIDE) && so_far.saturating_add(left) >= self.below {
            return;
        }
        node.so_far = so_far;
        node.meta = self.generation << GENERATION_SHIFT | step << STEP_SHIFT;
        self.generated += 1;
        // A weighted heuristic, and a field under repair, may fall by more than the step costs, and
        // such a field may rise by more than the span; the key must not. A field is a lower bound
        // all the same: the way found is the cheapest, for a closed cell is opened again when a
        // cheaper way leads to it, and none is closed before its time.
        let least = self.open.least();
        let key = so_far
            .saturating_add(weighted::<GUIDE>(left, self.quarters))
            .clamp(least, least.saturating_add(self.span));
        self.open.push(key, spot);
    }
}

/// What is left as the keys count it.
#[inline]
const fn weighted<const GUIDE: u8>(left: u32, quarters: u32) -> u32 {
    if is_weighted(GUIDE) {
        let more = quarters - 4;
        left.saturating_add((left / 4).saturating_mul(more) + left % 4 * more / 4)
    } else {
        left
    }
}

/// Lower bound of what is left from the cell at `xy`, of which the field says `left`.
#[inline]
fn bound<const GUIDE: u8>(
    left: u32,
    xy: (u32, u32),
    goal: (u32, u32),
    cost_decreased: &EasedBox,
) -> u32 {
    let straight = || octile(xy.0.abs_diff(goal.0), xy.1.abs_diff(goal.1));
    match GUIDE {
        FIELD | FIELD_WEIGHTED => left,
        FIELD_AND_BOX => cost_decreased.bound(left, xy.0, xy.1).max(straight()),
        _ => straight(),
    }
}
