//! The map as bits: which cells block, 64 to a word, with a blocked border of one cell.
//!
//! Source of the layout: Harabor, Grastien, "Improving Jump Point Search", ICAPS 2014 (block
//! scans). Positions are padded: cell (x, y) is at (x + 1, y + 1), so that every neighbour of
//! a cell exists and every scan ends inside its line.

use crate::planner::Unknown;
use zeronav_msgs::{CellRect, GridGeometry, MapCell, MapView};

/// Rows of a strip, the border of the map included.
pub(crate) const STRIP: usize = 64;

/// Lines of bits, 1 = blocked; along the rows of the map or, transposed, along its columns.
#[derive(Debug, Default, Clone)]
pub(crate) struct Lines {
    words: Vec<u64>,
    /// Words of a line.
    stride: usize,
    /// Cells of a line and number of lines, without the border.
    length: usize,
    count: usize,
}

impl Lines {
    /// All blocked, memory kept.
    pub(crate) fn reset(&mut self, length: usize, count: usize) {
        self.length = length;
        self.count = count;
        self.stride = (length + 2).div_ceil(64);
        self.words.clear();
        self.words.resize(self.stride * (count + 2), u64::MAX);
    }

    #[inline]
    pub(crate) fn set(&mut self, line: usize, position: usize, blocked: bool) {
        let word = &mut self.words[line * self.stride + (position >> 6)];
        let bit = 1 << (position & 63);
        if blocked {
            *word |= bit;
        } else {
            *word &= !bit;
        }
    }

    #[inline]
    pub(crate) fn is_blocked(&self, line: usize, position: usize) -> bool {
        self.words[line * self.stride + (position >> 6)] >> (position & 63) & 1 != 0
    }

    /// The words of a line.
    #[inline]
    pub(crate) fn line(&self, line: usize) -> &[u64] {
        &self.words[line * self.stride..(line + 1) * self.stride]
    }

    /// The bits of `position - 1`, `position` and `position + 1` in the three lowest bits.
    #[inline]
    pub(crate) fn three(&self, line: usize, position: usize) -> u32 {
        let first = position - 1;
        let at = line * self.stride + (first >> 6);
        let shift = first & 63;
        let mut bits = self.words[at] >> shift;
        if shift > 61 {
            bits |= self.words[at + 1] << (64 - shift);
        }
        (bits & 7) as u32
    }

    /// `n` <= 64 bits of a line from `position` on, the first lowest.
    #[inline]
    fn get(&self, line: usize, position: usize, n: usize) -> u64 {
        let at = line * self.stride + (position >> 6);
        let shift = position & 63;
        let mut bits = self.words[at] >> shift;
        if shift + n > 64 {
            bits |= self.words[at + 1] << (64 - shift);
        }
        bits & u64::MAX >> (64 - n)
    }

    pub(crate) const fn stride(&self) -> usize {
        self.stride
    }

    pub(crate) const fn count(&self) -> usize {
        self.count
    }

    /// Number of lines with the border.
    pub(crate) const fn count_padded(&self) -> usize {
        self.count + 2
    }

    pub(crate) const fn length(&self) -> usize {
        self.length
    }

    pub(crate) const fn words(&self) -> &Vec<u64> {
        &self.words
    }

    /// Bytes held.
    pub(crate) fn bytes(&self) -> usize {
        self.words.capacity() * size_of::<u64>()
    }
}

/// Rows of bits that follow a map.
#[derive(Debug, Default)]
pub(crate) struct BitMap {
    geometry: GridGeometry,
    unknown: Unknown,
    rows: Lines,
    /// Somebody tells of every change, so that the bits may be believed.
    told: bool,
    built: bool,
    version: u64,
    /// [`Self::version`] when a bit of each strip may have changed last.
    strips: Vec<u64>,
}

impl BitMap {
    pub(crate) const fn rows(&self) -> &Lines {
        &self.rows
    }

    /// Another number whenever a bit may have changed.
    pub(crate) const fn version(&self) -> u64 {
        self.version
    }

    /// Another number for a strip of [`STRIP`] rows whenever a bit of it may have changed, never 0.
    pub(crate) fn strips(&self) -> &[u64] {
        &self.strips
    }

    /// Makes the bits those of `map`; true when all of them were read again.
    pub(crate) fn follow(&mut self, map: &MapView<'_>, unknown: Unknown) -> bool {
        let fits = self.built && *map.geometry == self.geometry && unknown == self.unknown;
        if fits && self.told {
            return false;
        }
        self.geometry = *map.geometry;
        self.unknown = unknown;
        let (width, height) = (map.geometry.width as usize, map.geometry.height as usize);
        self.rows.reset(width, height);
        for (y, row) in (1..).zip(map.cells.chunks_exact(width.max(1))) {
            for (block, cells) in row.chunks(64).enumerate() {
                let bits = self.bits_of(cells);
                self.put(y, block * 64 + 1, cells.len(), bits);
            }
        }
        self.built = true;
        self.version += 1;
        self.strips.clear();
        let n_strips = self.rows.count_padded().div_ceil(STRIP);
        self.strips.resize(n_strips, self.version);
        true
    }

    /// Takes in the cells of `changed` and calls `flipped` for each padded position whose bit
    /// changed. From now on every change has to be told. False when the map is another one: then
    /// the next [`Self::follow`] reads all of it.
    pub(crate) fn change(
        &mut self,
        map: &MapView<'_>,
        changed: &[CellRect],
        mut flipped: impl FnMut(usize, usize, bool),
    ) -> bool {
        self.told = true;
        if !self.built || *map.geometry != self.geometry {
            self.built = false;
            return false;
        }
        let width = map.geometry.width as usize;
        let mut any = false;
        for rect in changed {
            let rect = rect.grown(0, map.geometry);
            if rect.min.x >= rect.max.x || rect.min.y >= rect.max.y {
                continue;
            }
            let [left, right, low, high] = [rect.min.x, rect.max.x, rect.min.y, rect.max.y]
                .map(|side| side.cast_unsigned() as usize);
            for y in low..high {
                let row = &map.cells[y * width..];
                for x in (left..right).step_by(64) {
                    let cells = &row[x..right.min(x + 64)];
                    let bits = self.bits_of(cells);
                    let mut differ = bits ^ self.rows.get(y + 1, x + 1, cells.len());
                    if differ == 0 {
                        continue;
                    }
                    any = true;
                    self.strips[(y + 1) / STRIP] = self.version + 1;
                    self.put(y + 1, x + 1, cells.len(), bits);
                    while differ != 0 {
                        let n = differ.trailing_zeros() as usize;
                        differ &= differ - 1;
                        flipped(x + n + 1, y + 1, bits >> n & 1 != 0);
                    }
                }
            }
        }
        self.version += u64::from(any);
        true
    }

    /// Which of at most 64 cells block, the first lowest.
    fn bits_of(&self, cells: &[MapCell]) -> u64 {
        cells.iter().zip(0..).fold(0, |bits, (cell, n)| {
            bits | u64::from(self.unknown.blocks(*cell)) << n
        })
    }

    /// Writes `n` <= 64 bits of a line from `position` on.
    fn put(&mut self, line: usize, position: usize, n: usize, bits: u64) {
        let mask = if n == 64 { u64::MAX } else { (1 << n) - 1 };
        let at = line * self.rows.stride + (position >> 6);
        let shift = position & 63;
        let word = &mut self.rows.words[at];
        *word = *word & !(mask << shift) | bits << shift;
        if shift > 0 && mask >> (64 - shift) != 0 {
            let word = &mut self.rows.words[at + 1];
            *word = *word & !(mask >> (64 - shift)) | bits >> (64 - shift);
        }
    }

    pub(crate) fn bytes(&self) -> usize {
        self.rows.bytes() + self.strips.capacity() * size_of::<u64>()
    }
}

/// Turns 64 x 64 bits over: bit `j` of word `i` becomes bit `i` of word `j`.
///
/// Warren, "Hacker's Delight", 2nd edition, section 7-3.
pub(crate) fn transpose(block: &mut [u64; 64]) {
    let mut width = 32;
    let mut mask = 0x0000_0000_ffff_ffff_u64;
    while width > 0 {
        let mut k = 0;
        while k < 64 {
            let swap = (block[k] >> width ^ block[k + width]) & mask;
            block[k] ^= swap << width;
            block[k + width] ^= swap;
            k = (k + width + 1) & !width;
        }
        width >>= 1;
        mask ^= mask << width;
    }
}

impl Lines {
    /// Becomes the columns of `rows`.
    pub(crate) fn become_columns_of(&mut self, rows: &Self) {
        self.reset(rows.count, rows.length);
        let mut block = [0; 64];
        for x_block in 0..rows.stride {
            for y_block in 0..self.stride {
                for (n, word) in block.iter_mut().enumerate() {
                    let line = y_block * 64 + n;
                    *word = rows
                        .words
                        .get(line * rows.stride + x_block)
                        .copied()
                        .unwrap_or(u64::MAX);
                }
                transpose(&mut block);
                for (n, word) in block.iter().enumerate() {
                    let line = x_block * 64 + n;
                    if line < self.count + 2 {
                        self.words[line * self.stride + y_block] = *word;
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_rows_turned_over() {
        for (width, height) in [(1, 1), (63, 62), (130, 70), (62, 129)] {
            let mut rows = Lines::default();
            rows.reset(width, height);
            for y in 1..=height {
                for x in 1..=width {
                    rows.set(y, x, (x * 7 + y * 13) % 5 < 2);
                }
            }
            let mut columns = Lines::default();
            columns.become_columns_of(&rows);
            for y in 0..height + 2 {
                for x in 0..width + 2 {
                    assert_eq!(rows.is_blocked(y, x), columns.is_blocked(x, y), "{x}, {y}");
                }
            }
        }
    }

    #[test]
    fn three_bits_across_words() {
        let mut lines = Lines::default();
        lines.reset(200, 1);
        for position in 1..=200 {
            lines.set(1, position, position % 3 == 0);
        }
        for position in 1..=200 {
            let expected = (0..3).fold(0, |bits, n| {
                bits | u32::from(lines.is_blocked(1, position + n - 1)) << n
            });
            assert_eq!(lines.three(1, position), expected, "{position}");
        }
    }
}
