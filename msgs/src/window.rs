//! A square of cells around one of them.

use crate::grid::{Cell, SIDE_CELLS_MAX};
use zeronav_casts::Cast;

/// A square of cells.
#[derive(Debug, Clone, Copy, Default)]
pub struct Window {
    min: Cell,
    side: i32,
}

impl Window {
    /// All cells that are at most `radius` away from `centre` along either axis.
    #[must_use]
    pub fn around(centre: Cell, radius: i32) -> Self {
        Self {
            min: Cell::new(centre.x - radius, centre.y - radius),
            side: 2 * radius + 1,
        }
    }

    /// How many they are.
    #[must_use]
    #[allow(clippy::len_without_is_empty, reason = "its centre is always in it")]
    pub fn len(self) -> usize {
        let side = self.side.cast_unsigned() as usize;
        side * side
    }

    /// Number of a cell, row by row; `None` outside.
    #[must_use]
    pub fn index_of(self, cell: Cell) -> Option<usize> {
        let (x, y) = (cell.x - self.min.x, cell.y - self.min.y);
        let inside = (0..self.side).contains(&x) && (0..self.side).contains(&y);
        inside.then(|| (y * self.side + x).cast_unsigned() as usize)
    }
}

/// Whole cells in a distance; bounded, 0 for what is not a distance.
#[must_use]
pub fn cells_in(distance_m: f64, resolution_m: f64) -> i32 {
    let side = f64::from(SIDE_CELLS_MAX);
    // Rounding must not lose the cell at the very end of the distance.
    ((distance_m / resolution_m + 1.0e-6).floor().max(0.0))
        .min(side)
        .to_i32()
}
