//! Numbers of a few cells of a large map.

use super::super::node::Spot;
use zeronav_casts::Cast;

/// Side of a page, a square of cells: a way in any direction passes few of them.
const SIDE: u32 = 8;

const PAGE: usize = (SIDE * SIDE) as usize;

const NONE: u32 = u32::MAX;

/// See the module's description. Memory: four bytes for every 64 cells of the map, and for every
/// cell of a page in which one is known.
#[derive(Debug, Default)]
pub(super) struct Pages {
    /// Columns of the map, and of its pages.
    width: u32,
    columns: u32,
    directory: Vec<u32>,
    used: Vec<u32>,
    numbers: Vec<[u32; PAGE]>,
}

impl Pages {
    /// Forgets all, for a map of so many cells in rows of `width`.
    pub(super) fn reset(&mut self, width: u32, n_cells: usize) {
        let width = width.max(1);
        self.columns = width.div_ceil(SIDE);
        let rows = n_cells.div_ceil(width as usize).div_ceil(SIDE as usize);
        let n_pages = self.columns as usize * rows;
        if self.width == width && self.directory.len() == n_pages {
            for page in self.used.drain(..) {
                self.directory[page as usize] = NONE;
            }
        } else {
            self.width = width;
            self.used.clear();
            self.directory.clear();
            self.directory.resize(n_pages, NONE);
        }
        self.numbers.clear();
    }

    /// The page of a cell, and its place there. `width` is not 0.
    #[inline]
    fn place(&self, spot: Spot) -> (usize, usize) {
        let (x, y) = (spot % self.width, spot / self.width);
        let page = (y / SIDE) as usize * self.columns as usize + (x / SIDE) as usize;
        (page, (y % SIDE * SIDE + x % SIDE) as usize)
    }

    #[inline]
    pub(super) fn get(&self, spot: Spot) -> Option<u32> {
        if self.used.is_empty() {
            return None;
        }
        let (page, place) = self.place(spot);
        let page = *self.directory.get(page)?;
        let number = self.numbers.get(page as usize)?[place];
        (number != NONE).then_some(number)
    }

    #[inline]
    pub(super) fn set(&mut self, spot: Spot, number: u32) {
        let (at, place) = self.place(spot);
        let Some(page) = self.directory.get_mut(at) else {
            return;
        };
        if *page == NONE {
            *page = self.numbers.len().to_u32();
            self.numbers.push([NONE; PAGE]);
            self.used.push(at.to_u32());
        }
        self.numbers[*page as usize][place] = number;
    }

    pub(super) fn bytes(&self) -> usize {
        (self.directory.capacity() + self.used.capacity()) * size_of::<u32>()
            + self.numbers.capacity() * size_of::<[u32; PAGE]>()
    }
}
