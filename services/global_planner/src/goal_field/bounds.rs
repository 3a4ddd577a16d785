//! What is left to the goal from each cell.

use super::node::{NO_WAY, Spot};
use core::ops::Range;

/// A lower bound of the cost to the goal by spot. Stored so that zero means [`NO_WAY`]: the bounds of
/// a map are made without writing to them, and those of cells that the field does not reach take no
/// memory.
#[derive(Debug, Default)]
pub(super) struct Bounds {
    inverted: Vec<u32>,
    /// Holds every spot with another value than [`NO_WAY`].
    written: Range<usize>,
}

impl Bounds {
    /// No way leads from any of `n` cells.
    pub(super) fn new(n: usize) -> Self {
        Self {
            inverted: vec![0; n],
            written: 0..0,
        }
    }

    #[inline]
    pub(super) fn at(&self, spot: Spot) -> u32 {
        !self.inverted[spot as usize]
    }

    /// None outside the array.
    #[inline]
    pub(super) fn get(&self, spot: Spot) -> Option<u32> {
        self.inverted.get(spot as usize).map(|inverted| !*inverted)
    }

    #[inline]
    pub(super) fn set(&mut self, spot: Spot, left: u32) {
        let at = spot as usize;
        self.inverted[at] = !left;
        if self.written.is_empty() {
            self.written = at..at + 1;
        } else {
            self.written = self.written.start.min(at)..self.written.end.max(at + 1);
        }
    }

    /// Makes about `most` bounds [`NO_WAY`] again; true when more is left.
    pub(super) fn clear(&mut self, most: usize) -> bool {
        let end = self
            .written
            .end
            .min(self.written.start.saturating_add(most));
        self.inverted[self.written.start..end].fill(!NO_WAY);
        self.written.start = end;
        !self.written.is_empty()
    }

    pub(super) fn bytes(&self) -> usize {
        self.inverted.capacity() * size_of::<u32>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_map::Draw;

    #[test]
    fn every_bound_is_forgotten_in_slices_of_any_size() {
        for seed in 0..40 {
            let mut draw = Draw(seed);
            let mut bounds = Bounds::new(500);
            for _ in 0..3 {
                for _ in 0..draw.below(20) {
                    let spot = Spot::try_from(draw.below(500)).unwrap();
                    bounds.set(spot, 7);
                    assert_eq!(bounds.at(spot), 7);
                }
                let most = 1 + usize::try_from(draw.below(90)).unwrap();
                // One more while it is under way.
                if bounds.clear(most) {
                    bounds.set(Spot::try_from(draw.below(500)).unwrap(), 9);
                }
                while bounds.clear(most) {}
                assert!(
                    (0..500).all(|spot| bounds.at(spot) == NO_WAY),
                    "seed {seed}"
                );
            }
        }
    }
}
