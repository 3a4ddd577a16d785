//! What changes of the map cut off in the trees of a region.

use super::super::GoalField;
use super::super::node::Spot;
use super::super::prices::BLOCKED;
use super::forest::{Forest, Interval, NOWHERE, Place};
use crate::planner::CornerRule;

/// Intervals of positions, sorted, none touching another.
#[derive(Debug, Default)]
pub(super) struct Cuts {
    forward: Vec<Interval>,
    to_goal: Vec<Interval>,
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
    /// True when the cell of `place` cuts.
    fn cuts(self, field: &GoalField, place: &Place) -> bool {
        let price = field.prices.at(place.spot);
        price > place.price && (self == Self::Dearer || price == BLOCKED)
    }
}

impl Cuts {
    /// Becomes what the cells of `risen` cut off, which may be named more than once.
    pub(super) fn set(
        &mut self,
        forest: &Forest,
        field: &GoalField,
        risen: &[Spot],
        cutting: Cutting,
    ) {
        self.forward.clear();
        self.to_goal.clear();
        for spot in risen {
            let is_blocked = field.prices.at(*spot) == BLOCKED;
            if !is_blocked && cutting == Cutting::Blocked {
                continue;
            }
            if let Some(position) = forest.position(*spot) {
                self.add(forest, field, position, cutting);
            }
            if is_blocked && field.rule != CornerRule::Allow {
                self.add_corners(forest, field, *spot);
            }
        }
        merge(&mut self.forward);
        merge(&mut self.to_goal);
    }

    /// Cuts at a cell, unless its parent cuts: then it is cut off with that.
    fn add(&mut self, forest: &Forest, field: &GoalField, position: u32, cutting: Cutting) {
        let place = forest.place(position);
        if !cutting.cuts(field, place) {
            return;
        }
        let parent = forest.place(place.parent);
        if place.parent == position || !cutting.cuts(field, parent) {
            self.forward.push((position, place.end));
        }
        let next = place.goal_parent;
        if next == NOWHERE || !cutting.cuts(field, forest.place(next)) {
            self.to_goal.extend(forest.below_to_goal(position));
        }
    }

    /// Cuts the diagonal steps past `spot`.
    fn add_corners(&mut self, forest: &Forest, field: &GoalField, spot: Spot) {
        for n in [0, 2, 4, 6] {
            let beside = |step: usize| {
                let beside = spot.wrapping_add(field.offsets[step & 7]);
                let free = field.prices.at(beside) != BLOCKED;
                free.then(|| forest.position(beside)).flatten()
            };
            let opposite = spot.wrapping_add(field.offsets[n + 1]);
            if field
                .rule
                .permits(true, field.prices.at(opposite) == BLOCKED)
            {
                continue;
            }
            let (Some(one), Some(other)) = (beside(n), beside(n + 2)) else {
                continue;
            };
            for (above, below) in [(one, other), (other, one)] {
                let (from, to) = (forest.place(above), forest.place(below));
                if to.parent == above {
                    self.forward.push((below, to.end));
                }
                if from.goal_parent == below {
                    self.to_goal.extend(forest.below_to_goal(above));
                }
            }
        }
    }

    pub(super) fn forward(&self) -> &[Interval] {
        &self.forward
    }

    pub(super) fn to_goal(&self) -> &[Interval] {
        &self.to_goal
    }

    pub(super) fn bytes(&self) -> usize {
        (self.forward.capacity() + self.to_goal.capacity()) * size_of::<Interval>()
    }
}

/// Sorts intervals and joins those that touch.
fn merge(intervals: &mut Vec<Interval>) {
    intervals.sort_unstable();
    intervals.dedup_by(|next, last| {
        let touches = next.0 <= last.1;
        if touches {
            last.1 = last.1.max(next.1);
        }
        touches
    });
}
