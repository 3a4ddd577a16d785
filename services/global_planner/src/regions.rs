//! Which cells are connected at all: a proof that there is no way without a search for one.
//!
//! Rows are cut into runs of free cells, runs that touch are joined (Rosenfeld, Pfaltz,
//! "Sequential Operations in Digital Picture Processing", 1966; union by path halving). Time
//! follows the words and runs of the map, not its cells: some 30 us at 600 x 400.

use crate::bits::{BitMap, Lines};
use crate::planner::CornerRule;

/// Free cells `from..to` of a row, padded, and the run that it was joined to.
#[derive(Debug, Clone, Copy)]
struct Run {
    from: u32,
    to: u32,
    parent: u32,
}

/// See the module's description.
#[derive(Debug, Default)]
pub(crate) struct Regions {
    runs: Vec<Run>,
    /// First run of each padded row, and the end of the last.
    rows: Vec<u32>,
    /// Of the bits that were read.
    version: u64,
    corners: bool,
}

impl Regions {
    /// True when the regions are those of the bits as they are.
    pub(crate) fn is_current(&self, bits: &BitMap, rule: CornerRule) -> bool {
        self.version == bits.version() && self.corners == joins_corners(rule)
    }

    /// Finds the regions, unless they are known.
    ///
    /// With [`CornerRule::ForbidAny`] and [`CornerRule::ForbidBoth`] a diagonal step past a free
    /// cell can be replaced by two straight ones, so that cells are connected over edges alone.
    #[allow(
        clippy::cast_possible_truncation,
        reason = "positions lie within a side, runs are fewer than cells"
    )]
    pub(crate) fn follow(&mut self, bits: &BitMap, rule: CornerRule) {
        if self.is_current(bits, rule) {
            return;
        }
        self.version = bits.version();
        self.corners = joins_corners(rule);
        self.runs.clear();
        self.rows.clear();
        let lines = bits.rows();
        self.rows.push(0);
        let mut above = 0..0;
        for line in 1..=lines.count() {
            let first = self.runs.len();
            self.rows.push(first as u32);
            self.cut(lines, line);
            let here = first..self.runs.len();
            self.join(above, here.clone());
            above = here;
        }
        self.rows.push(self.runs.len() as u32);
    }

    /// True when a way may lead from one padded position (x, y) to the other; [`Self::follow`]
    /// comes before it.
    pub(crate) fn connected(&mut self, one: (u32, u32), other: (u32, u32)) -> bool {
        match (self.run_at(one), self.run_at(other)) {
            (Some(one), Some(other)) => self.root(one) == self.root(other),
            _ => false,
        }
    }

    pub(crate) fn bytes(&self) -> usize {
        self.runs.capacity() * size_of::<Run>() + self.rows.capacity() * size_of::<u32>()
    }

    #[allow(
        clippy::cast_possible_truncation,
        reason = "positions lie within a side, runs are fewer than cells"
    )]
    fn cut(&mut self, lines: &Lines, line: usize) {
        let mut from = None;
        for (n, word) in lines.line(line).iter().enumerate() {
            // Bits that differ from the one before: the ends of runs.
            let carry = u64::from(from.is_none());
            let mut edges = word ^ (word << 1 | carry);
            while edges != 0 {
                let position = n as u32 * 64 + edges.trailing_zeros();
                edges &= edges - 1;
                from = match from {
                    None => Some(position),
                    Some(from) => {
                        let parent = self.runs.len() as u32;
                        self.runs.push(Run {
                            from,
                            to: position,
                            parent,
                        });
                        None
                    }
                };
            }
        }
    }

    fn join(&mut self, above: core::ops::Range<usize>, here: core::ops::Range<usize>) {
        let reach = u32::from(self.corners);
        let (mut a, mut b) = (above.start, here.start);
        while a < above.end && b < here.end {
            let (one, other) = (self.runs[a], self.runs[b]);
            if one.from < other.to + reach && other.from < one.to + reach {
                let (one, other) = (self.root(a), self.root(b));
                let (low, high) = (one.min(other), one.max(other));
                self.runs[high].parent = self.runs[low].parent;
            }
            if one.to < other.to {
                a += 1;
            } else {
                b += 1;
            }
        }
    }

    #[allow(
        clippy::cast_possible_truncation,
        reason = "runs are fewer than cells, which fit 32 bits"
    )]
    fn root(&mut self, mut run: usize) -> usize {
        while self.runs[run].parent != run as u32 {
            let parent = self.runs[run].parent as usize;
            self.runs[run].parent = self.runs[parent].parent;
            run = parent;
        }
        run
    }

    fn run_at(&self, (x, y): (u32, u32)) -> Option<usize> {
        let first = *self.rows.get(y as usize)? as usize;
        let end = *self.rows.get(y as usize + 1)? as usize;
        let row = &self.runs[first..end];
        let n = row.partition_point(|run| run.to <= x);
        row.get(n).filter(|run| run.from <= x).map(|_| first + n)
    }
}

const fn joins_corners(rule: CornerRule) -> bool {
    matches!(rule, CornerRule::Allow)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::planner::Unknown;
    use proptest::prelude::*;
    use zeronav_msgs::map::{COST_FREE, COST_LETHAL};
    use zeronav_msgs::{GridGeometry, MapCell, MapView};

    proptest! {
        /// Against a flood.
        #[test]
        fn regions_are_what_a_flood_reaches(
            width in 1_u32..150,
            height in 1_u32..12,
            seed: u64,
            corners: bool,
        ) {
            let geometry = GridGeometry {
                origin_x_m: 0.0, origin_y_m: 0.0, resolution_m: 1.0, width, height,
            };
            let mut state = seed;
            let cells: Vec<MapCell> = (0..geometry.len()).map(|_| {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
                let cost = if state >> 33 & 1 == 0 { COST_LETHAL } else { COST_FREE };
                MapCell { cost, flags: 0, clearance_mm: 0 }
            }).collect();
            let map = MapView { geometry: &geometry, cells: &cells };
            let mut bits = BitMap::default();
            bits.follow(&map, Unknown::Free);
            let rule = if corners { CornerRule::Allow } else { CornerRule::ForbidAny };
            let mut regions = Regions::default();
            regions.follow(&bits, rule);
            let at = |n: usize| {
                let n = u32::try_from(n).unwrap();
                (n % width, n / width)
            };
            let mut label = vec![0; cells.len()];
            for seed in 0..cells.len() {
                if cells[seed].blocks_centre() || label[seed] != 0 {
                    continue;
                }
                let mut front = vec![seed];
                label[seed] = seed + 1;
                while let Some(from) = front.pop() {
                    for to in 0..cells.len() {
                        let ((ax, ay), (bx, by)) = (at(from), at(to));
                        let (dx, dy) = (ax.abs_diff(bx), ay.abs_diff(by));
                        let beside = if corners { dx.max(dy) == 1 } else { dx + dy == 1 };
                        if beside && label[to] == 0 && !cells[to].blocks_centre() {
                            label[to] = seed + 1;
                            front.push(to);
                        }
                    }
                }
            }
            let padded = |n: usize| (at(n).0 + 1, at(n).1 + 1);
            for one in 0..cells.len().min(40) {
                for other in 0..cells.len() {
                    let expected = label[one] != 0 && label[one] == label[other];
                    prop_assert_eq!(regions.connected(padded(one), padded(other)), expected);
                }
            }
        }
    }
}
