//! A cell and its eight neighbours, row by row.

use zeronav_msgs::GridGeometry;

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
