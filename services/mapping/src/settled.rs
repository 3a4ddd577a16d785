//! Blocks of cells that no beam can change by passing: rays leap over them.
//!
//! Nearly every cell that a beam passes is known to be free and stays so. Where all cells of a
//! block are, there is nothing to do in it, and a ray goes on behind it. What is left to visit
//! follows what is uncertain, not the length of the beams; and the counters of a map of
//! 4000 x 4000 cells are small enough to stay in a cache.

use zeronav_msgs::GridGeometry;

/// Side of a block. [cells]
pub const BLOCK_CELLS: i32 = 8;

const SHIFT: u32 = 3;

/// How many cells of each block are not settled.
#[derive(Debug, Clone)]
pub struct Settled {
    width: usize,
    columns: usize,
    open: Vec<u8>,
}

impl Settled {
    /// All cells settled.
    #[must_use]
    pub fn new(geometry: &GridGeometry) -> Self {
        let side = BLOCK_CELLS.unsigned_abs();
        let columns = geometry.width.div_ceil(side) as usize;
        let rows = geometry.height.div_ceil(side) as usize;
        Self {
            width: geometry.width as usize,
            columns,
            open: vec![0; columns * rows],
        }
    }

    /// The cell at `index`, settled until now, is not any more.
    #[inline]
    pub fn open(&mut self, index: usize) {
        let block = self.block_of(index);
        self.open[block] += 1;
    }

    /// The cell at `index`, not settled until now, is.
    #[inline]
    pub fn settle(&mut self, index: usize) {
        let block = self.block_of(index);
        self.open[block] -= 1;
    }

    /// True when every cell of the block in column `x` and row `y` of blocks is settled.
    #[must_use]
    #[inline]
    pub fn is_settled(&self, x: i32, y: i32) -> bool {
        let (x, y) = (x.cast_unsigned() as usize, y.cast_unsigned() as usize);
        self.open[y * self.columns + x] == 0
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
    fn blocks_at_the_edge_are_blocks() {
        let geometry = GridGeometry {
            origin_x_m: 0.0,
            origin_y_m: 0.0,
            resolution_m: 0.05,
            width: 17,
            height: 9,
        };
        let mut settled = Settled::new(&geometry);
        let last = 17 * 9 - 1;
        settled.open(last);
        settled.open(last - 17);
        assert!(!settled.is_settled(2, 1) && !settled.is_settled(2, 0));
        assert!(settled.is_settled(1, 1) && settled.is_settled(0, 0));
        settled.settle(last);
        assert!(settled.is_settled(2, 1) && !settled.is_settled(2, 0));
    }
}
