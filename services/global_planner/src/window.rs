//! A square of cells around one of them.

use zeronav_msgs::Cell;

/// A square of cells.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Window {
    min: Cell,
    side: i32,
}

impl Window {
    pub(crate) fn around(centre: Cell, radius: i32) -> Self {
        Self {
            min: Cell::new(centre.x - radius, centre.y - radius),
            side: 2 * radius + 1,
        }
    }

    pub(crate) fn len(self) -> usize {
        let side = self.side.cast_unsigned() as usize;
        side * side
    }

    pub(crate) fn index_of(self, cell: Cell) -> Option<usize> {
        let (x, y) = (cell.x - self.min.x, cell.y - self.min.y);
        let inside = (0..self.side).contains(&x) && (0..self.side).contains(&y);
        inside.then(|| (y * self.side + x).cast_unsigned() as usize)
    }
}

/// Whole cells in a distance; bounded, 0 for what is not a distance.
#[allow(
    clippy::cast_possible_truncation,
    reason = "clamped to the side of the largest map"
)]
pub(crate) fn cells_in(distance_m: f64, resolution_m: f64) -> i32 {
    let side = f64::from(zeronav_msgs::grid::SIDE_CELLS_MAX);
    // Rounding must not lose the cell at the very end of the distance.
    ((distance_m / resolution_m + 1.0e-6).floor().max(0.0)).min(side) as i32
}
