//! When a search asks whether there is a way at all.

use crate::bits::BitMap;
use crate::ends::{Ends, WayOut};
use crate::padded::padded;
use crate::planner::{CornerRule, PlanError};
use crate::regions::Regions;
use zeronav_msgs::Cell;

/// The connected regions of a map for each kind of corner, found when they are worth it.
#[derive(Debug, Default)]
pub(crate) struct Reach {
    edges: Regions,
    corners: Regions,
    asked: bool,
    /// Of the last question.
    rule: CornerRule,
    /// Expansions after which finding the regions costs about as much as the search did.
    worth_after: u64,
}

impl Reach {
    /// False when it is proved that no way leads from `start` to `goal` under `rule`.
    ///
    /// Known regions are asked at once; unknown ones are found only after so many expansions
    /// that finding them costs about as much as the search did so far.
    #[inline]
    pub(crate) fn may(
        &mut self,
        bits: &BitMap,
        rule: CornerRule,
        (start, goal): (Cell, Cell),
        expanded: u64,
    ) -> bool {
        if expanded == 0 {
            let n_unread = self.regions(rule).n_unread(bits, rule) as u64;
            (self.asked, self.rule) = (false, rule);
            self.worth_after = 256 + n_unread / 64;
        }
        if self.asked {
            return true;
        }
        let worth = expanded >= self.worth_after;
        if !worth && (expanded > 0 || !self.regions(rule).is_current(bits, rule)) {
            return true;
        }
        self.asked = true;
        self.known(bits, rule, start, goal)
    }

    /// Work for when no answer is due: reads one strip of the map for the regions; true when more is
    /// left.
    pub(crate) fn prepare(&mut self, bits: &BitMap) -> bool {
        let rule = self.rule;
        self.regions(rule).follow_next(bits, rule)
    }

    /// True when the two cells are connected; finds the regions if need be.
    pub(crate) fn known(&mut self, bits: &BitMap, rule: CornerRule, a: Cell, b: Cell) -> bool {
        self.rule = rule;
        let regions = self.regions(rule);
        regions.follow(bits, rule);
        regions.connected(padded(a), padded(b))
    }

    /// Where the search begins: at the start, or at the exit from the inflation around it that is
    /// not in a pocket cut off from the goal.
    pub(crate) fn exit(
        &mut self,
        bits: &BitMap,
        rule: CornerRule,
        ends: &Ends,
        way_out: &mut WayOut,
    ) -> Cell {
        if way_out.cells().len() <= 1 {
            return ends.start;
        }
        way_out
            .turn_to_next(|exit| !self.known(bits, rule, exit, ends.goal))
            .unwrap_or(ends.start)
    }

    /// The answer where there is no way.
    pub(crate) fn no_way(&mut self, bits: &BitMap, rule: CornerRule, ends: &Ends) -> PlanError {
        let blocked_by_corner =
            rule != CornerRule::Allow && self.known(bits, CornerRule::Allow, ends.start, ends.goal);
        PlanError::Unreachable { blocked_by_corner }
    }

    fn regions(&mut self, rule: CornerRule) -> &mut Regions {
        if rule == CornerRule::Allow {
            &mut self.corners
        } else {
            &mut self.edges
        }
    }

    pub(crate) fn bytes(&self) -> usize {
        self.edges.bytes() + self.corners.bytes()
    }
}
