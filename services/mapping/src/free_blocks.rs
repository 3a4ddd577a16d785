//! Blocks of cells that are all known to be free: rays skip them.
//!
//! Nearly every cell that a beam passes is known to be free and stays so. Where that holds for all
//! cells of a block, the beam changes nothing in it and continues behind it. The cost of a scan
//! depends on the number of uncertain cells, not on the length of the beams, and the counters of a
//! map of 4000 x 4000 cells are small enough to stay in a cache.

use zeronav_msgs::GridGeometry;

/// Side of a block. [cells]
pub(crate) const BLOCK_CELLS: i32 = 8;

const SHIFT: u32 = 3;

/// Number of uncertain cells in each block.
#[derive(Debug, Clone)]
pub(crate) struct FreeBlocks {
    width: usize,
    columns: usize,
    uncertain: Vec<u8>,
}

impl FreeBlocks {
    /// All cells are free.
    #[must_use]
    pub(crate) fn new(geometry: &GridGeometry) -> Self {
        let side = BLOCK_CELLS.unsigned_abs();
        let columns = geometry.width.div_ceil(side) as usize;
        let rows = geometry.height.div_ceil(side) as usize;
        Self {
            width: geometry.width as usize,
            columns,
            uncertain: vec![0; columns * rows],
        }
    }

    /// Counts the cell at `index`, free until now, as uncertain.
    #[inline]
    pub(crate) fn add_uncertain(&mut self, index: usize) {
        let block = self.block_of(index);
        self.uncertain[block] += 1;
    }

    /// Counts the cell at `index`, uncertain until now, as free.
    #[inline]
    pub(crate) fn remove_uncertain(&mut self, index: usize) {
        let block = self.block_of(index);
        self.uncertain[block] -= 1;
    }

    /// True when every cell of the block in column `x` and row `y` of blocks is free.
    #[must_use]
    #[inline]
    pub(crate) fn is_free(&self, x: i32, y: i32) -> bool {
        let (x, y) = (x.cast_unsigned() as usize, y.cast_unsigned() as usize);
        self.uncertain[y * self.columns + x] == 0
    }

    fn block_of(&self, index: usize) -> usize {
        let (x, y) = (index % self.width, index / self.width);
        (y >> SHIFT) * self.columns + (x >> SHIFT)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_at_the_edge_may_be_smaller() {
        let geometry = GridGeometry {
            origin_x_m: 0.0,
            origin_y_m: 0.0,
            resolution_m: 0.05,
            width: 17,
            height: 9,
        };
        let mut blocks = FreeBlocks::new(&geometry);
        let last = 17 * 9 - 1;
        blocks.add_uncertain(last);
        blocks.add_uncertain(last - 17);
        assert!(!blocks.is_free(2, 1) && !blocks.is_free(2, 0));
        assert!(blocks.is_free(1, 1) && blocks.is_free(0, 0));
        blocks.remove_uncertain(last);
        assert!(blocks.is_free(2, 1) && !blocks.is_free(2, 0));
    }
}
