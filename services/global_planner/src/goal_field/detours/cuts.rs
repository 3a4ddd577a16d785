//! What changes of the map cut off in the trees of a region.

use super::super::GoalField;
use super::super::node::Spot;
use super::super::prices::{BLOCKED, is_blocked};
use super::forest::{Forest, Known};
use super::positions::{Interval, PositionSet, merge};
use crate::planner::CornerRule;

/// [`super::super::prices::Prices::around`] of a cell that has no free neighbour.
const ALL_BLOCKED: u64 = u64::from_ne_bytes([BLOCKED; 8]);

/// Positions in the two trees, as intervals that are sorted and do not touch.
#[derive(Debug, Default)]
pub(super) struct Cuts {
    forward: Vec<Interval>,
    to_goal: PositionSet,
}

/// Which cells cut.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Cutting {
    /// Those that blocked since the region was found.
    Blocked,
    /// Those that became dearer, too.
    Dearer,
}

impl Cutting {
    /// True when a cell of the region with this price then and now cuts.
    fn cuts(self, then: u8, now: u8) -> bool {
        now > then && (self == Self::Dearer || now == BLOCKED)
    }
}

impl Cuts {
    /// Becomes what the cells of `cost_increased` cut off, which may be named more than once.
    pub(super) fn set(
        &mut self,
        forest: &Forest,
        field: &GoalField,
        cost_increased: &[Spot],
        cutting: Cutting,
    ) {
        self.forward.clear();
        self.to_goal.clear();
        for spot in cost_increased {
            let (own, around) = field.prices.around(*spot);
            // Its neighbours on both ways are blocked, too, and cut it off themselves.
            let is_inside = around == ALL_BLOCKED && *spot != forest.root() && *spot != field.goal;
            if cutting == Cutting::Blocked && (own != BLOCKED || is_inside) {
                continue;
            }
            if let Some(known) = forest.known(*spot)
                && cutting.cuts(known.price, own)
            {
                self.add(forest, field, *spot, known, cutting);
            }
            if own == BLOCKED && !is_inside && field.rule != CornerRule::Allow {
                self.add_corners(forest, field, *spot, around);
            }
        }
        merge(&mut self.forward);
        self.to_goal.close(forest.len());
    }

    /// Cuts at a cell, unless the next one on a way cuts: then it is cut off with that.
    fn add(
        &mut self,
        forest: &Forest,
        field: &GoalField,
        spot: Spot,
        known: Known,
        cutting: Cutting,
    ) {
        let next_cuts = |step: Option<u32>, opposite: u32| {
            step.is_some_and(|step| {
                let next = spot.wrapping_add(field.offsets[(step + opposite) as usize & 7]);
                let then = forest.known(next).map_or(BLOCKED, |next| next.price);
                cutting.cuts(then, field.prices.at(next))
            })
        };
        if !next_cuts(known.step, 4) {
            self.forward.push(forest.below(known.position));
        }
        if !next_cuts(known.step_to_goal, 0) {
            self.cut_to_goal(forest, known.position);
        }
    }

    /// Cuts the diagonal steps past `spot`, given the prices around it.
    fn add_corners(&mut self, forest: &Forest, field: &GoalField, spot: Spot, around: u64) {
        for n in [0, 2, 4, 6] {
            let is_blocked = |step: u32| is_blocked(around, step);
            if is_blocked(n) || is_blocked(n + 2) || field.rule.permits(true, is_blocked(n + 1)) {
                continue;
            }
            let beside =
                |step: u32| forest.known(spot.wrapping_add(field.offsets[step as usize & 7]));
            let (Some(one), Some(other)) = (beside(n), beside(n + 2)) else {
                continue;
            };
            // From the cell in direction n to that in direction n + 2, and back.
            for (from, to, step) in [(one, other, n + 3), (other, one, n + 7)] {
                let step = Some(step & 7);
                if to.step == step {
                    self.forward.push(forest.below(to.position));
                }
                if from.step_to_goal == step {
                    self.cut_to_goal(forest, from.position);
                }
            }
        }
    }

    fn cut_to_goal(&mut self, forest: &Forest, position: u32) {
        if let Some(below) = forest.below_to_goal(position) {
            self.to_goal.add(below);
        }
    }

    pub(super) fn forward(&self) -> &[Interval] {
        &self.forward
    }

    pub(super) fn to_goal(&self) -> &PositionSet {
        &self.to_goal
    }

    pub(super) fn bytes(&self) -> usize {
        self.forward.capacity() * size_of::<Interval>() + self.to_goal.bytes()
    }
}
