//! What jump point search reads of a map: bits along rows and columns, and where a scan stops.
//!
//! A stop is a cell that is blocked or has a forced neighbour when it is entered along the line.
//! With both in one bit a scan reads one word for 64 cells, where the blocks of Harabor and
//! Grastien ("Improving Jump Point Search", ICAPS 2014) take three lines.

use crate::bits::{BitMap, Lines};
use crate::ground::FreeCells;
use crate::planner::Unknown;
use zeronav_casts::Cast;
use zeronav_msgs::{CellRect, MapView};

/// Lines with their stops in both directions.
#[derive(Debug, Default)]
struct Scans {
    /// Stops of a scan towards larger positions.
    up: Vec<u64>,
    /// Stops of a scan towards smaller ones.
    down: Vec<u64>,
}

impl Scans {
    fn reset(&mut self, lines: &Lines) {
        for stops in [&mut self.up, &mut self.down] {
            stops.clear();
            stops.resize(lines.words().len(), u64::MAX);
        }
        for line in 1..=lines.count() {
            self.refresh(lines, line, 0..lines.stride());
        }
    }

    fn refresh(&mut self, lines: &Lines, line: usize, words: core::ops::Range<usize>) {
        let stride = lines.stride();
        let (before, here, after) = (lines.line(line - 1), lines.line(line), lines.line(line + 1));
        for n in words {
            let mut up = here[n];
            let mut down = here[n];
            for side in [before, after] {
                let lower = if n > 0 { side[n - 1] >> 63 } else { 1 };
                let higher = if n + 1 < stride {
                    side[n + 1] << 63
                } else {
                    1 << 63
                };
                up |= (side[n] << 1 | lower) & !side[n];
                down |= (side[n] >> 1 | higher) & !side[n];
            }
            self.up[line * stride + n] = up;
            self.down[line * stride + n] = down;
        }
    }
}

/// See the module's description.
#[derive(Debug, Default)]
pub(crate) struct JumpMap {
    bits: BitMap,
    columns: Lines,
    along_rows: Scans,
    along_columns: Scans,
    /// Share of the cells with a forced neighbour when the whole map was last read.
    forced_share: f64,
}

impl FreeCells for JumpMap {
    fn bits(&self) -> &BitMap {
        &self.bits
    }

    /// Becomes that of `map`, see [`BitMap::follow`].
    fn follow(&mut self, map: &MapView<'_>, unknown: Unknown) {
        if self.bits.follow(map, unknown) {
            self.columns.become_columns_of(self.bits.rows());
            self.along_rows.reset(self.bits.rows());
            self.along_columns.reset(&self.columns);
            self.forced_share = self.count_forced();
        }
    }

    /// Takes in what changed, see [`BitMap::change`].
    fn change(&mut self, map: &MapView<'_>, changed: &[CellRect]) {
        for rect in changed {
            let mut flipped: Option<[usize; 4]> = None;
            let columns = &mut self.columns;
            let same = self
                .bits
                .change(map, core::slice::from_ref(rect), |x, y, blocked| {
                    columns.set(x, y, blocked);
                    let [x0, y0, x1, y1] = flipped.unwrap_or([x, y, x, y]);
                    flipped = Some([x0.min(x), y0.min(y), x1.max(x), y1.max(y)]);
                });
            if !same {
                return;
            }
            // A bit is seen from the lines beside it and from the positions beside it.
            if let Some([x0, y0, x1, y1]) = flipped {
                let rows = self.bits.rows();
                for line in (y0 - 1).max(1)..=(y1 + 1).min(rows.count()) {
                    let words = (x0 - 1) >> 6..((x1 + 1) >> 6) + 1;
                    self.along_rows.refresh(rows, line, words);
                }
                for line in (x0 - 1).max(1)..=(x1 + 1).min(self.columns.count()) {
                    let words = (y0 - 1) >> 6..((y1 + 1) >> 6) + 1;
                    self.along_columns.refresh(&self.columns, line, words);
                }
            }
        }
        if changed.is_empty() {
            self.bits.change(map, &[], |_, _, _| {});
        }
    }

    fn bytes(&self) -> usize {
        let scans = |scans: &Scans| (scans.up.capacity() + scans.down.capacity()) * 8;
        self.bits.bytes()
            + self.columns.bytes()
            + scans(&self.along_rows)
            + scans(&self.along_columns)
    }
}

impl JumpMap {
    #[inline]
    pub(crate) fn is_blocked(&self, x: u32, y: u32) -> bool {
        self.bits.rows().is_blocked(y as usize, x as usize)
    }

    /// The first jump point in direction `step` (even: east, north, west, south) from `(x, y)`:
    /// the goal, or the first cell with a forced neighbour; `None` before an obstacle. Padded.
    #[inline]
    pub(crate) fn jump(&self, x: u32, y: u32, step: u32, goal: (u32, u32)) -> Option<(u32, u32)> {
        match step {
            0 => {
                let goal = (y == goal.1).then_some(goal.0);
                up(self.bits.rows(), &self.along_rows.up, y, x, goal).map(|x| (x, y))
            }
            2 => {
                let goal = (x == goal.0).then_some(goal.1);
                up(&self.columns, &self.along_columns.up, x, y, goal).map(|y| (x, y))
            }
            4 => {
                let goal = (y == goal.1).then_some(goal.0);
                down(self.bits.rows(), &self.along_rows.down, y, x, goal).map(|x| (x, y))
            }
            _ => {
                let goal = (x == goal.0).then_some(goal.1);
                down(&self.columns, &self.along_columns.down, x, y, goal).map(|y| (x, y))
            }
        }
    }

    /// Share of the cells at which a scan along the rows is stopped by a forced neighbour, which
    /// makes jumps short; as of the last time the whole map was read: local changes do not turn
    /// halls into clutter.
    pub(crate) const fn forced_share(&self) -> f64 {
        self.forced_share
    }

    fn count_forced(&self) -> f64 {
        let blocked = self.bits.rows().words();
        let stops = &self.along_rows.up;
        let forced: u32 = blocked
            .iter()
            .zip(stops)
            .map(|(blocked, stop)| (stop & !blocked).count_ones())
            .sum();
        let rows = self.bits.rows();
        let cells = (rows.length() * rows.count()).max(1);
        let cells = cells.to_f64();
        f64::from(forced) / cells
    }
}

#[inline]
fn up(lines: &Lines, stops: &[u64], line: u32, from: u32, goal: Option<u32>) -> Option<u32> {
    let base = line as usize * lines.stride();
    let first = from + 1;
    let mut word = (first >> 6) as usize;
    let mut bits = stops[base + word] & u64::MAX << (first & 63);
    while bits == 0 {
        word += 1;
        bits = stops[base + word];
    }
    let stop = word.to_u32() << 6 | bits.trailing_zeros();
    if let Some(goal) = goal.filter(|goal| (first..=stop).contains(goal)) {
        return Some(goal);
    }
    (lines.words()[base + word] >> (stop & 63) & 1 == 0).then_some(stop)
}

#[inline]
fn down(lines: &Lines, stops: &[u64], line: u32, from: u32, goal: Option<u32>) -> Option<u32> {
    let base = line as usize * lines.stride();
    let first = from - 1;
    let mut word = (first >> 6) as usize;
    let mut bits = stops[base + word] & u64::MAX >> (63 - (first & 63));
    while bits == 0 {
        word -= 1;
        bits = stops[base + word];
    }
    let stop = word.to_u32() << 6 | bits.ilog2();
    if let Some(goal) = goal.filter(|goal| (stop..=first).contains(goal)) {
        return Some(goal);
    }
    (lines.words()[base + word] >> (stop & 63) & 1 == 0).then_some(stop)
}
