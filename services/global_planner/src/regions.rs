//! Which cells are connected at all: a proof that there is no way without a search for one.
//!
//! Rows are cut into runs of free cells, runs that touch are joined (Rosenfeld, Pfaltz,
//! "Sequential Operations in Digital Picture Processing", 1966; union by path halving). Strips of
//! rows have regions of their own, which are joined where the strips meet: after a change only the
//! strips are read again in which a cell changed.

use crate::bits::{BitMap, Lines, STRIP};
use crate::planner::CornerRule;
use zeronav_casts::Cast;

/// Free cells `from..to` of a row, padded.
#[derive(Debug, Clone, Copy)]
struct Run {
    from: u32,
    to: u32,
    /// Number of its region within the strip.
    region: u32,
}

/// [`STRIP`] rows.
#[derive(Debug, Default)]
struct Strip {
    /// Of the bits that were read; 0 before the first time.
    version: u64,
    runs: Vec<Run>,
    /// First run of each row, and the end of the last.
    rows: Vec<u32>,
    n_regions: u32,
    /// Number of its first region among those of all strips.
    first: u32,
}

/// See the module's description.
#[derive(Debug, Default)]
pub(crate) struct Regions {
    strips: Vec<Strip>,
    /// The region that each was joined to, by its number among those of all strips.
    joined: Vec<u32>,
    /// The run that each was joined to, while a strip is read.
    parents: Vec<u32>,
    /// Of the bits that were read.
    version: u64,
    corners: bool,
}

impl Regions {
    /// True when the regions are those of the bits as they are.
    pub(crate) fn is_current(&self, bits: &BitMap, rule: CornerRule) -> bool {
        self.version == bits.version() && self.corners == joins_corners(rule)
    }

    /// Words of bits that [`Self::follow`] has to read.
    pub(crate) fn n_unread(&self, bits: &BitMap, rule: CornerRule) -> usize {
        let kept = self.corners == joins_corners(rule);
        let read = |n: usize| self.strips.get(n).map_or(0, |strip| strip.version);
        let versions = bits.strips().iter().enumerate();
        let unread = versions.filter(|(n, version)| !kept || read(*n) != **version);
        unread.count() * STRIP * bits.rows().stride()
    }

    /// Finds the regions, unless they are known.
    ///
    /// With [`CornerRule::ForbidAny`] and [`CornerRule::ForbidBoth`] a diagonal step past a free
    /// cell can be replaced by two straight ones, so that cells are connected over edges alone.
    pub(crate) fn follow(&mut self, bits: &BitMap, rule: CornerRule) {
        while self.follow_next(bits, rule) {}
    }

    /// Reads one more strip for [`Self::follow`]; false when the regions are known.
    pub(crate) fn follow_next(&mut self, bits: &BitMap, rule: CornerRule) -> bool {
        if self.is_current(bits, rule) {
            return false;
        }
        let corners = joins_corners(rule);
        if corners != self.corners {
            self.corners = corners;
            self.strips.clear();
            self.version = 0;
        }
        self.strips.resize_with(bits.strips().len(), Strip::default);
        for (n, (strip, version)) in self.strips.iter_mut().zip(bits.strips()).enumerate() {
            if strip.version != *version {
                strip.read(bits.rows(), n, corners, &mut self.parents);
                strip.version = *version;
                return true;
            }
        }
        self.join();
        self.version = bits.version();
        false
    }

    /// True when a way may lead from one padded position (x, y) to the other; [`Self::follow`]
    /// comes before it.
    pub(crate) fn connected(&mut self, one: (u32, u32), other: (u32, u32)) -> bool {
        match (self.region_at(one), self.region_at(other)) {
            (Some(one), Some(other)) => {
                root(&mut self.joined, one) == root(&mut self.joined, other)
            }
            _ => false,
        }
    }

    pub(crate) fn bytes(&self) -> usize {
        let strips = self.strips.iter().map(|strip| {
            strip.runs.capacity() * size_of::<Run>() + strip.rows.capacity() * size_of::<u32>()
        });
        strips.sum::<usize>()
            + self.strips.capacity() * size_of::<Strip>()
            + (self.joined.capacity() + self.parents.capacity()) * size_of::<u32>()
    }

    /// Joins the regions of strips that meet.
    fn join(&mut self) {
        let mut n_regions = 0;
        for strip in &mut self.strips {
            strip.first = n_regions;
            n_regions += strip.n_regions;
        }
        self.joined.clear();
        self.joined.extend(0..n_regions);
        for pair in self.strips.windows(2) {
            let [above, here] = pair else { continue };
            let joined = &mut self.joined;
            touching(above.last_row(), here.row(0), self.corners, |one, other| {
                let one = above.first + above.last_row()[one].region;
                join(joined, one, here.first + here.row(0)[other].region);
            });
        }
    }

    fn region_at(&self, (x, y): (u32, u32)) -> Option<u32> {
        let y = y as usize;
        let strip = self.strips.get(y / STRIP)?;
        let row = strip.row(y % STRIP);
        let n = row.partition_point(|run| run.to <= x);
        let run = row.get(n).filter(|run| run.from <= x)?;
        Some(strip.first + run.region)
    }
}

impl Strip {
    /// Reads strip `n` of the rows.
    fn read(&mut self, lines: &Lines, n: usize, corners: bool, parents: &mut Vec<u32>) {
        self.runs.clear();
        self.rows.clear();
        parents.clear();
        let mut above = 0..0;
        for line in n * STRIP..lines.count_padded().min((n + 1) * STRIP) {
            let first = self.runs.len();
            self.rows.push(first.to_u32());
            cut(lines.line(line), &mut self.runs);
            let here = first..self.runs.len();
            parents.extend(here.start.to_u32()..here.end.to_u32());
            let (one, other) = (&self.runs[above.clone()], &self.runs[here.clone()]);
            touching(one, other, corners, |one, other| {
                join(
                    parents,
                    (above.start + one).to_u32(),
                    (here.start + other).to_u32(),
                );
            });
            above = here;
        }
        self.rows.push(self.runs.len().to_u32());
        self.n_regions = 0;
        for n in 0..self.runs.len() {
            // A root comes before those that were joined to it.
            let root = root(parents, n.to_u32()) as usize;
            if root == n {
                self.runs[n].region = self.n_regions;
                self.n_regions += 1;
            } else {
                self.runs[n].region = self.runs[root].region;
            }
        }
    }

    /// The runs of a row of the strip.
    fn row(&self, n: usize) -> &[Run] {
        match (self.rows.get(n), self.rows.get(n + 1)) {
            (Some(first), Some(end)) => &self.runs[*first as usize..*end as usize],
            _ => &[],
        }
    }

    fn last_row(&self) -> &[Run] {
        self.row(self.rows.len().saturating_sub(2))
    }
}

/// Cuts a row into runs of free cells, and appends these.
fn cut(row: &[u64], runs: &mut Vec<Run>) {
    let mut from = None;
    for (n, word) in row.iter().enumerate() {
        // Bits that differ from the one before: the ends of runs.
        let carry = u64::from(from.is_none());
        let mut edges = word ^ (word << 1 | carry);
        while edges != 0 {
            let position = n.to_u32() * 64 + edges.trailing_zeros();
            edges &= edges - 1;
            from = match from {
                None => Some(position),
                Some(from) => {
                    runs.push(Run {
                        from,
                        to: position,
                        region: 0,
                    });
                    None
                }
            };
        }
    }
}

/// Calls `touch` with each pair of runs of two rows that touch, by their places in the rows.
fn touching(above: &[Run], here: &[Run], corners: bool, mut touch: impl FnMut(usize, usize)) {
    let reach = u32::from(corners);
    let (mut a, mut b) = (0, 0);
    while let (Some(one), Some(other)) = (above.get(a), here.get(b)) {
        if one.from < other.to + reach && other.from < one.to + reach {
            touch(a, b);
        }
        if one.to < other.to {
            a += 1;
        } else {
            b += 1;
        }
    }
}

/// Joins two in a forest of parents, of which roots have the lowest number.
fn join(parents: &mut [u32], one: u32, other: u32) {
    let (one, other) = (root(parents, one), root(parents, other));
    parents[one.max(other) as usize] = one.min(other);
}

fn root(parents: &mut [u32], mut n: u32) -> u32 {
    while parents[n as usize] != n {
        let parent = parents[n as usize];
        parents[n as usize] = parents[parent as usize];
        n = parent;
    }
    n
}

const fn joins_corners(rule: CornerRule) -> bool {
    matches!(rule, CornerRule::Allow)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::moves::STEPS;
    use crate::padded::padded;
    use crate::planner::Unknown;
    use crate::test_map::Draw;
    use proptest::prelude::*;
    use zeronav_msgs::map::{COST_FREE, COST_LETHAL};
    use zeronav_msgs::{Cell, CellRect, GridGeometry, MapCell, MapView};

    proptest! {
        /// Against a flood.
        #[test]
        fn regions_are_what_a_flood_reaches(
            width in 1_u32..150,
            height in 1_u32..12,
            seed: u64,
            corners: bool,
        ) {
            check((width, height), seed, corners, 0)?;
        }

        /// Also over several strips, after changes that are told.
        #[test]
        fn regions_follow_changes(
            width in 1_u32..150,
            height in 1_u32..150,
            seed: u64,
            corners: bool,
        ) {
            check((width, height), seed, corners, 4)?;
        }
    }

    /// One cell of so many is blocked.
    const SHARE_BLOCKED: u64 = 3;

    fn cell(draw: &mut Draw) -> MapCell {
        let is_blocked = draw.below(SHARE_BLOCKED) == 0;
        MapCell {
            cost: if is_blocked { COST_LETHAL } else { COST_FREE },
            flags: 0,
            clearance_mm: 0,
        }
    }

    /// The same number for free cells that hang together, 0 for the others.
    fn flooded(map: &MapView<'_>, corners: bool) -> Vec<u32> {
        let mut label = vec![0; map.cells.len()];
        let stride = if corners { 1 } else { 2 };
        for (seed, number) in (0..map.cells.len()).zip(1..) {
            if map.cells[seed].blocks_centre() || label[seed] != 0 {
                continue;
            }
            label[seed] = number;
            let mut front = vec![cell_at(map.geometry, seed)];
            while let Some(from) = front.pop() {
                for (dx, dy) in STEPS.iter().step_by(stride) {
                    let to = Cell::new(from.x + dx, from.y + dy);
                    if let Some(n) = map.geometry.index_of(to)
                        && label[n] == 0
                        && !map.cells[n].blocks_centre()
                    {
                        label[n] = number;
                        front.push(to);
                    }
                }
            }
        }
        label
    }

    fn cell_at(geometry: &GridGeometry, n: usize) -> Cell {
        let (width, n) = (geometry.size().0, i32::try_from(n).unwrap());
        Cell::new(n % width, n / width)
    }

    fn check(
        (width, height): (u32, u32),
        seed: u64,
        corners: bool,
        n_changes: u32,
    ) -> Result<(), TestCaseError> {
        let geometry = GridGeometry {
            origin_x_m: 0.0,
            origin_y_m: 0.0,
            resolution_m: 1.0,
            width,
            height,
        };
        let mut draw = Draw(seed);
        let mut cells: Vec<MapCell> = (0..geometry.len()).map(|_| cell(&mut draw)).collect();
        let rule = if corners {
            CornerRule::Allow
        } else {
            CornerRule::ForbidAny
        };
        let (mut bits, mut regions) = (BitMap::default(), Regions::default());
        for n in 0..=n_changes {
            let below = |draw: &mut Draw, n: u32| i32::try_from(draw.below(u64::from(n))).unwrap();
            if n > 0 {
                let min = Cell::new(below(&mut draw, width), below(&mut draw, height));
                let max = Cell::new(min.x + 1 + below(&mut draw, 90), min.y + 3);
                let rect = CellRect { min, max }.grown(0, &geometry);
                for y in rect.min.y..rect.max.y {
                    for x in rect.min.x..rect.max.x {
                        cells[geometry.index_of(Cell::new(x, y)).unwrap()] = cell(&mut draw);
                    }
                }
                let map = MapView {
                    geometry: &geometry,
                    cells: &cells,
                };
                bits.change(&map, &[rect], |_, _, _| {});
            }
            let map = MapView {
                geometry: &geometry,
                cells: &cells,
            };
            bits.follow(&map, Unknown::Free);
            if n > 0 {
                prop_assert!(regions.n_unread(&bits, rule) <= 2 * STRIP * bits.rows().stride());
            }
            regions.follow(&bits, rule);
            prop_assert!(regions.is_current(&bits, rule));
            prop_assert_eq!(regions.n_unread(&bits, rule), 0);
            let label = flooded(&map, corners);
            for _ in 0..400 {
                let [one, other] =
                    [(); 2].map(|()| usize::try_from(draw.below(cells.len() as u64)).unwrap());
                let expected = label[one] != 0 && label[one] == label[other];
                let ends = [one, other].map(|n| padded(cell_at(&geometry, n)));
                prop_assert_eq!(regions.connected(ends[0], ends[1]), expected);
            }
        }
        Ok(())
    }
}
