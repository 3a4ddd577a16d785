//! The cells whose bound may be too low, in the order in which they are looked at.

use super::node::Spot;
use core::cmp::Reverse;
use std::collections::BinaryHeap;

/// A bit for every cell.
#[derive(Debug, Default)]
pub(super) struct Marks(Vec<u64>);

impl Marks {
    /// Fits `n` cells, none of which is marked.
    fn new(n: usize) -> Self {
        Self(vec![0; n.div_ceil(64)])
    }

    pub(super) fn has(&self, spot: Spot) -> bool {
        self.0
            .get(spot as usize >> 6)
            .is_some_and(|word| word >> (spot & 63) & 1 != 0)
    }

    /// True when it was not there before.
    pub(super) fn add(&mut self, spot: Spot) -> bool {
        let had = self.has(spot);
        if let Some(word) = self.0.get_mut(spot as usize >> 6) {
            *word |= 1 << (spot & 63);
        }
        !had
    }

    pub(super) fn remove(&mut self, spot: Spot) {
        if let Some(word) = self.0.get_mut(spot as usize >> 6) {
            *word &= !(1 << (spot & 63));
        }
    }
}

/// What is known about the cells whose bound may be too low.
#[derive(Debug, Default)]
pub(super) struct Raise {
    /// Cells whose price or bound rose, and those that became cheaper, until looked at.
    pub(super) to_check: Vec<Spot>,
    /// A cell became cheaper.
    pub(super) cost_decreased: bool,
    /// Cells that may have lost every cheapest way, by what is left from them.
    pub(super) suspects: BinaryHeap<Reverse<u64>>,
    pub(super) suspected: Marks,
    /// Cells that have.
    pub(super) lost: Vec<Spot>,
    pub(super) is_lost: Marks,
    /// How many of `lost` have been offered what their neighbours allow, once that has begun.
    pub(super) offered: Option<usize>,
    pub(super) front: BinaryHeap<Reverse<u64>>,
    /// Lost cells with their new bounds, until these are written.
    pub(super) found: Vec<(Spot, u32)>,
}

impl Raise {
    /// Of a map of `n_cells`.
    pub(super) fn new(n_cells: usize) -> Self {
        Self {
            suspected: Marks::new(n_cells),
            is_lost: Marks::new(n_cells),
            ..Self::default()
        }
    }

    /// Forgets all cells.
    pub(super) fn clear(&mut self) {
        self.to_check.clear();
        self.cost_decreased = false;
        self.found.clear();
        for suspect in self.suspects.drain() {
            self.suspected.remove(parts(suspect).1);
        }
        for spot in self.lost.drain(..) {
            self.is_lost.remove(spot);
        }
        self.offered = None;
        self.front.clear();
    }

    #[inline]
    pub(super) fn note(&mut self, spot: Spot) {
        self.to_check.push(spot);
    }

    pub(super) fn is_idle(&self) -> bool {
        self.to_check.is_empty() && self.suspects.is_empty() && self.lost.is_empty()
    }

    pub(super) fn bytes(&self) -> usize {
        (self.to_check.capacity() + self.lost.capacity()) * size_of::<Spot>()
            + self.found.capacity() * size_of::<(Spot, u32)>()
            + (self.suspects.capacity() + self.front.capacity()) * size_of::<Reverse<u64>>()
            + (self.suspected.0.capacity() + self.is_lost.0.capacity()) * size_of::<u64>()
    }
}

pub(super) const fn item(left: u32, spot: Spot) -> Reverse<u64> {
    Reverse((left as u64) << 32 | spot as u64)
}

#[allow(clippy::cast_possible_truncation, reason = "the two halves, as pushed")]
pub(super) const fn parts(item: Reverse<u64>) -> (u32, Spot) {
    ((item.0 >> 32) as u32, item.0 as u32)
}
