//! Where steps became cheaper since the field was made consistent.

use crate::moves::octile;

/// A box in which steps became cheaper, in padded positions, and what a way through it costs at
/// least from there on.
#[derive(Debug, Clone, Copy)]
pub(super) struct EasedBox {
    pub(super) min: (u32, u32),
    pub(super) max: (u32, u32),
    pub(super) least: u32,
}

impl EasedBox {
    pub(super) const EMPTY: Self = Self {
        min: (u32::MAX, u32::MAX),
        max: (0, 0),
        least: 0,
    };

    pub(super) const fn is_empty(&self) -> bool {
        self.min.0 > self.max.0
    }

    pub(super) fn add(&mut self, x: u32, y: u32) {
        self.min = (self.min.0.min(x), self.min.1.min(y));
        self.max = (self.max.0.max(x), self.max.1.max(y));
    }

    /// Lower bound of all ways from a cell of which the field says `left`: those that enter the
    /// box and those that do not. Inside it the field, which may be lower there than `least`, does
    /// not count: with it the bound could fall by more than a step costs.
    #[inline]
    pub(super) fn bound(&self, left: u32, x: u32, y: u32) -> u32 {
        let apart = |at: u32, min: u32, max: u32| min.saturating_sub(at) + at.saturating_sub(max);
        let dx = apart(x, self.min.0, self.max.0);
        let dy = apart(y, self.min.1, self.max.1);
        if (dx, dy) == (0, 0) {
            self.least
        } else {
            left.min(octile(dx, dy).saturating_add(self.least))
        }
    }
}
