//! When a search asks whether there is a way at all.

use crate::bits::BitMap;
use crate::jps::padded;
use crate::planner::CornerRule;
use crate::regions::Regions;
use zeronav_msgs::Cell;

/// The connected regions of a map for each kind of corner, found when they are worth it.
#[derive(Debug, Default)]
pub(crate) struct Reach {
    edges: Regions,
    corners: Regions,
    asked: bool,
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
            self.asked = false;
        }
        if self.asked {
            return true;
        }
        let rows = bits.rows();
        let worth = expanded >= 256 + rows.words().len() as u64 / 64;
        if !worth && (expanded > 0 || !self.regions(rule).is_current(bits, rule)) {
            return true;
        }
        self.asked = true;
        self.known(bits, rule, start, goal)
    }

    /// True when the two cells are connected; finds the regions if need be.
    pub(crate) fn known(&mut self, bits: &BitMap, rule: CornerRule, a: Cell, b: Cell) -> bool {
        let regions = self.regions(rule);
        regions.follow(bits, rule);
        regions.connected(padded(a), padded(b))
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
