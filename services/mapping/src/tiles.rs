//! Which tiles of the map changed, and where in them.

use zeronav_msgs::map::{MapTile, TILE_CELLS, tiles_of};
use zeronav_msgs::{Cell, CellRect, GridGeometry};

/// Column and row of a tile, as in [`MapTile`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct TileIndex {
    /// Row of tiles, from 0.
    pub y: u32,
    /// Column of tiles, from 0.
    pub x: u32,
}

/// Every tile of a map, row by row: the order of keyframes.
pub fn all_tiles(geometry: &GridGeometry) -> impl Iterator<Item = TileIndex> + use<> {
    let (columns, rows) = tiles_of(geometry);
    (0..rows).flat_map(move |y| (0..columns).map(move |x| TileIndex { y, x }))
}

impl TileIndex {
    /// Says in `tile` which one it is.
    pub fn name(self, tile: &mut MapTile) {
        tile.tile_x = self.x;
        tile.tile_y = self.y;
    }
}

/// A set of cells, kept as one box per tile. Memory is reused.
#[derive(Debug)]
pub(crate) struct TileBoxes {
    columns: usize,
    /// Position in `boxes` of each tile, row by row; [`NOWHERE`] without a cell in it.
    places: Vec<u32>,
    /// Tile and box, in the order in which tiles were first touched.
    boxes: Vec<(usize, CellRect)>,
}

const NOWHERE: u32 = u32::MAX;

impl TileBoxes {
    /// The empty set.
    #[must_use]
    pub(crate) fn new(geometry: &GridGeometry) -> Self {
        let (columns, rows) = tiles_of(geometry);
        let n_tiles = columns as usize * rows as usize;
        Self {
            columns: columns as usize,
            places: vec![NOWHERE; n_tiles],
            boxes: Vec::with_capacity(n_tiles),
        }
    }

    /// Adds a cell of the map.
    #[inline]
    pub(crate) fn add(&mut self, cell: Cell) {
        let (x, y) = (at(cell.x), at(cell.y));
        let tile = y / TILE_CELLS * self.columns + x / TILE_CELLS;
        let beyond = Cell::new(cell.x + 1, cell.y + 1);
        if let Some((_, rect)) = self.boxes.get_mut(self.places[tile] as usize) {
            rect.min = Cell::new(rect.min.x.min(cell.x), rect.min.y.min(cell.y));
            rect.max = Cell::new(rect.max.x.max(beyond.x), rect.max.y.max(beyond.y));
        } else {
            self.places[tile] = number(self.boxes.len());
            let rect = CellRect {
                min: cell,
                max: beyond,
            };
            self.boxes.push((tile, rect));
        }
    }

    /// Number of tiles with a cell in the set.
    #[must_use]
    pub(crate) fn len(&self) -> usize {
        self.boxes.len()
    }

    /// The box of the `n`-th tile that was touched.
    ///
    /// # Panics
    /// When `n` is not below [`Self::len`].
    #[must_use]
    pub(crate) fn get(&self, n: usize) -> CellRect {
        self.boxes[n].1
    }

    /// Adds the tiles to `tiles`, which is then in the order of [`all_tiles`] and names each tile
    /// once, and empties the set.
    pub(crate) fn take_tiles(&mut self, tiles: &mut Vec<TileIndex>) {
        tiles.extend(self.boxes.iter().map(|(tile, _)| TileIndex {
            y: number(tile / self.columns),
            x: number(tile % self.columns),
        }));
        tiles.sort_unstable();
        tiles.dedup();
        self.clear();
    }

    /// Empties the set.
    pub(crate) fn clear(&mut self) {
        for (tile, _) in self.boxes.drain(..) {
            self.places[tile] = NOWHERE;
        }
    }
}

fn at(cells: i32) -> usize {
    cells.cast_unsigned() as usize
}

fn number(tiles: usize) -> u32 {
    u32::try_from(tiles).unwrap_or(u32::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_of_a_tile_share_a_box() {
        let geometry = GridGeometry {
            origin_x_m: 0.0,
            origin_y_m: 0.0,
            resolution_m: 0.05,
            width: 70,
            height: 40,
        };
        assert_eq!(all_tiles(&geometry).count(), 6);
        let mut set = TileBoxes::new(&geometry);
        for (x, y) in [(69, 39), (33, 2), (40, 1), (69, 33)] {
            set.add(Cell::new(x, y));
        }
        let rect = |x0, y0, x1, y1| CellRect {
            min: Cell::new(x0, y0),
            max: Cell::new(x1, y1),
        };
        let boxes: Vec<CellRect> = (0..set.len()).map(|n| set.get(n)).collect();
        assert_eq!(boxes, [rect(69, 33, 70, 40), rect(33, 1, 41, 3)]);
        let mut tiles = Vec::new();
        set.take_tiles(&mut tiles);
        assert_eq!(tiles, [TileIndex { y: 0, x: 1 }, TileIndex { y: 1, x: 2 }]);
        // What was not sent is not lost.
        set.add(Cell::new(0, 0));
        set.add(Cell::new(69, 39));
        set.take_tiles(&mut tiles);
        let named: Vec<(u32, u32)> = tiles.iter().map(|tile| (tile.x, tile.y)).collect();
        assert_eq!(named, [(0, 0), (1, 0), (2, 1)]);
        assert_eq!(set.len(), 0);
    }
}
