//! Numbers of a few cells of a large map.

use super::super::node::Spot;

/// Cells of a page, which follow each other in a row.
const PAGE: usize = 64;

const NONE: u32 = u32::MAX;

/// See the module's description. Memory: four bytes for every 64 cells of the map, and for every
/// cell of a page in which one is known.
#[derive(Debug, Default)]
pub(super) struct Pages {
    directory: Vec<u32>,
    used: Vec<u32>,
    numbers: Vec<[u32; PAGE]>,
}

impl Pages {
    /// Forgets all, for a map of so many cells.
    pub(super) fn reset(&mut self, n_cells: usize) {
        let n_pages = n_cells.div_ceil(PAGE);
        if self.directory.len() == n_pages {
            for page in self.used.drain(..) {
                self.directory[page as usize] = NONE;
            }
        } else {
            self.used.clear();
            self.directory.clear();
            self.directory.resize(n_pages, NONE);
        }
        self.numbers.clear();
    }

    #[inline]
    pub(super) fn get(&self, spot: Spot) -> Option<u32> {
        let page = *self.directory.get(spot as usize / PAGE)?;
        let number = self.numbers.get(page as usize)?[spot as usize % PAGE];
        (number != NONE).then_some(number)
    }

    #[inline]
    #[allow(
        clippy::cast_possible_truncation,
        reason = "pages are fewer than spots"
    )]
    pub(super) fn set(&mut self, spot: Spot, number: u32) {
        let Some(page) = self.directory.get_mut(spot as usize / PAGE) else {
            return;
        };
        if *page == NONE {
            *page = self.numbers.len() as u32;
            self.numbers.push([NONE; PAGE]);
            self.used.push(spot / PAGE as u32);
        }
        self.numbers[*page as usize][spot as usize % PAGE] = number;
    }

    pub(super) fn bytes(&self) -> usize {
        (self.directory.capacity() + self.used.capacity()) * size_of::<u32>()
            + self.numbers.capacity() * size_of::<[u32; PAGE]>()
    }
}
