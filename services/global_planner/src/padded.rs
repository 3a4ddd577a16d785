//! Positions on a map with a border of one blocked cell: `(x + 1, y + 1)` of the cell `(x, y)`, so
//! that every neighbour of a cell exists.

use zeronav_msgs::Cell;

/// The padded position of `cell`.
pub(crate) const fn padded(cell: Cell) -> (u32, u32) {
    (cell.x.cast_unsigned() + 1, cell.y.cast_unsigned() + 1)
}

/// The cell at a padded position.
#[allow(
    clippy::cast_possible_wrap,
    reason = "positions lie within a side of the map"
)]
pub(crate) const fn cell_of((x, y): (u32, u32)) -> Cell {
    Cell::new(x as i32 - 1, y as i32 - 1)
}

/// Appends the cell at a padded position, unless the path ends there already.
pub(crate) fn push_cell(cells: &mut Vec<Cell>, at: (u32, u32)) {
    let cell = cell_of(at);
    if cells.last() != Some(&cell) {
        cells.push(cell);
    }
}
