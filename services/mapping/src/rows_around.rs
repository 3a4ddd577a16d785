//! A cell and its eight neighbours, row by row.

use zeronav_msgs::{Cell, GridGeometry};

/// The rows of the 3 x 3 cells around a cell, each with its columns, cut to the map.
pub(crate) fn rows_around(
    geometry: &GridGeometry,
    index: usize,
) -> impl Iterator<Item = (usize, core::ops::Range<usize>)> + use<> {
    let (width, height) = (geometry.width as usize, geometry.height as usize);
    let (x, y) = (index % width, index / width);
    let columns = x.saturating_sub(1)..(x + 2).min(width);
    (y.saturating_sub(1)..(y + 2).min(height)).map(move |row| (row, columns.clone()))
}

/// A cell and the eight around it.
pub(crate) fn around(cell: Cell) -> impl Iterator<Item = Cell> {
    (-1..=1).flat_map(move |dy| {
        (-1..=1).map(move |dx| Cell::new(cell.x.saturating_add(dx), cell.y.saturating_add(dy)))
    })
}

/// The cell at a row-major index.
pub(crate) fn cell_at(geometry: &GridGeometry, index: usize) -> Cell {
    let width = geometry.width as usize;
    let number = |cells: usize| i32::try_from(cells).unwrap_or(i32::MAX);
    Cell::new(number(index % width), number(index / width))
}
