//! Cells and metres: the only place where one becomes the other.

use crate::message;
use crate::message::{COORDINATE_M_MAX, Refusal, ZeroCopySend, ensure, number};
use nalgebra::Point2;
use zeronav_casts::Cast;

/// Smallest and largest side of a cell. [m]
pub const RESOLUTION_M: [f64; 2] = [1.0e-3, 10.0];

/// Largest side of a map. [cells]
pub const SIDE_CELLS_MAX: u32 = 8192;

/// Column `x` and row `y` of a cell; negative or large values lie outside the map.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct Cell {
    /// Column, along map +x.
    pub x: i32,
    /// Row, along map +y.
    pub y: i32,
}

impl Cell {
    /// The cell in column `x` and row `y`.
    #[must_use]
    pub const fn new(x: i32, y: i32) -> Self {
        Self { x, y }
    }
}

/// Half-open rectangle of cells: `min.x <= x < max.x`, `min.y <= y < max.y`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct CellRect {
    /// First column and row inside.
    pub min: Cell,
    /// First column and row outside.
    pub max: Cell,
}

impl CellRect {
    /// True when `cell` lies inside.
    #[must_use]
    pub const fn contains(&self, cell: Cell) -> bool {
        cell.x >= self.min.x && cell.x < self.max.x && cell.y >= self.min.y && cell.y < self.max.y
    }

    /// The rectangle grown by `margin` cells on every side and cut to the map.
    #[must_use]
    pub fn grown(&self, margin: i32, geometry: &GridGeometry) -> Self {
        let (width, height) = geometry.size();
        Self {
            min: Cell::new((self.min.x - margin).max(0), (self.min.y - margin).max(0)),
            max: Cell::new(
                (self.max.x + margin).min(width),
                (self.max.y + margin).min(height),
            ),
        }
    }
}

message! {
    /// Where a grid lies in the map frame. Row-major, `width x height`, half-open cells, origin
    /// at the outer corner of cell (0, 0), columns along +x, rows along +y.
    pub struct GridGeometry = "zeronav.GridGeometry.v1" {
        /// [m] map frame, outer corner of cell (0, 0).
        pub origin_x_m: f64,
        /// [m] map frame, outer corner of cell (0, 0).
        pub origin_y_m: f64,
        /// [m] side of a cell, > 0.
        pub resolution_m: f64,
        /// [count] Columns, 1 to [`SIDE_CELLS_MAX`].
        pub width: u32,
        /// [count] Rows, 1 to [`SIDE_CELLS_MAX`].
        pub height: u32,
    }
}

impl GridGeometry {
    /// Columns and rows as signed numbers, for arithmetic with [`Cell`].
    #[must_use]
    pub fn size(&self) -> (i32, i32) {
        (self.width.cast_signed(), self.height.cast_signed())
    }

    /// Number of cells.
    #[must_use]
    pub fn len(&self) -> usize {
        self.width as usize * self.height as usize
    }

    /// True for the geometry of no map at all.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// True when `cell` is inside.
    #[must_use]
    pub fn contains(&self, cell: Cell) -> bool {
        let (width, height) = self.size();
        cell.x >= 0 && cell.y >= 0 && cell.x < width && cell.y < height
    }

    /// Row-major index of `cell`; `None` outside.
    #[must_use]
    pub fn index_of(&self, cell: Cell) -> Option<usize> {
        self.contains(cell).then(|| {
            cell.y.cast_unsigned() as usize * self.width as usize + cell.x.cast_unsigned() as usize
        })
    }

    /// The cell that holds a point of the map frame; `None` outside or when not finite.
    #[must_use]
    pub fn cell_at(&self, point_in_map: Point2<f64>) -> Option<Cell> {
        let cell = self.unbounded_cell_at(point_in_map);
        self.contains(cell).then_some(cell)
    }

    /// Like [`Self::cell_at`], also for points beside the map; saturates far away.
    #[must_use]
    pub fn unbounded_cell_at(&self, point_in_map: Point2<f64>) -> Cell {
        let x = ((point_in_map.x - self.origin_x_m) / self.resolution_m).floor();
        let y = ((point_in_map.y - self.origin_y_m) / self.resolution_m).floor();
        if x.is_nan() || y.is_nan() {
            return Cell::new(i32::MIN, i32::MIN);
        }
        Cell::new(x.to_i32(), y.to_i32())
    }

    /// Centre of `cell` in the map frame. [m]
    #[must_use]
    pub fn centre_of(&self, cell: Cell) -> Point2<f64> {
        Point2::new(
            self.origin_x_m + (f64::from(cell.x) + 0.5) * self.resolution_m,
            self.origin_y_m + (f64::from(cell.y) + 0.5) * self.resolution_m,
        )
    }

    /// Accepts geometries that [`Self::cell_at`] and the tiles can live with.
    ///
    /// # Errors
    /// The first field that is wrong.
    pub fn check(&self) -> Result<(), Refusal> {
        let (limit, [least_m, most_m]) = (COORDINATE_M_MAX, RESOLUTION_M);
        number(self.origin_x_m, -limit, limit, "origin_x_m")?;
        number(self.origin_y_m, -limit, limit, "origin_y_m")?;
        number(self.resolution_m, least_m, most_m, "resolution_m")?;
        let side = 1..=SIDE_CELLS_MAX;
        ensure(side.contains(&self.width), Refusal::OutOfRange("width"))?;
        ensure(side.contains(&self.height), Refusal::OutOfRange("height"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GRID: GridGeometry = GridGeometry {
        origin_x_m: -1.0,
        origin_y_m: 2.0,
        resolution_m: 0.05,
        width: 40,
        height: 30,
    };

    #[test]
    fn every_cell_is_found_again_at_its_centre() {
        for y in 0..30 {
            for x in 0..40 {
                let cell = Cell::new(x, y);
                assert_eq!(GRID.cell_at(GRID.centre_of(cell)), Some(cell));
            }
        }
    }

    #[test]
    fn outside_is_none_also_just_below_the_origin() {
        assert_eq!(GRID.cell_at(Point2::new(-1.001, 2.1)), None);
        assert_eq!(GRID.cell_at(Point2::new(-1.0, 1.999)), None);
        assert_eq!(GRID.cell_at(Point2::new(f64::NAN, 2.1)), None);
        assert_eq!(GRID.cell_at(Point2::new(1.0e300, 2.1)), None);
        assert_eq!(GRID.cell_at(Point2::new(-1.0, 2.0)), Some(Cell::new(0, 0)));
    }

    #[test]
    fn rectangles_are_half_open_and_grow_up_to_the_map() {
        let rect = CellRect {
            min: Cell::new(2, 5),
            max: Cell::new(4, 9),
        };
        for x in 0..6 {
            for y in 3..11 {
                let inside = (x == 2 || x == 3) && (5..=8).contains(&y);
                assert_eq!(rect.contains(Cell::new(x, y)), inside, "({x}, {y})");
            }
        }
        let grown = rect.grown(1, &GRID);
        assert_eq!((grown.min, grown.max), (Cell::new(1, 4), Cell::new(5, 10)));
        let all = rect.grown(100, &GRID);
        assert_eq!((all.min, all.max), (Cell::new(0, 0), Cell::new(40, 30)));
    }

    #[test]
    fn cells_have_an_index_row_by_row() {
        assert_eq!((GRID.size(), GRID.len()), ((40, 30), 1200));
        let nothing = GridGeometry { height: 0, ..GRID };
        assert!(nothing.is_empty() && !GRID.is_empty());
        for (x, y, index) in [
            (0, 0, Some(0)),
            (1, 2, Some(81)),
            (39, 29, Some(1199)),
            (40, 0, None),
            (0, 30, None),
            (-1, 3, None),
            (3, -1, None),
        ] {
            assert_eq!(GRID.index_of(Cell::new(x, y)), index, "({x}, {y})");
        }
        let centre = GRID.centre_of(Cell::new(3, 4));
        assert!((centre.x + 0.825).abs() < 1e-12 && (centre.y - 2.225).abs() < 1e-12);
        // Beside the map, too: the half-open cell that would be there.
        let beside = GRID.unbounded_cell_at(Point2::new(-1.26, 3.51));
        assert_eq!(beside, Cell::new(-6, 30));
        for nan in [Point2::new(f64::NAN, 0.0), Point2::new(0.0, f64::NAN)] {
            assert_eq!(GRID.unbounded_cell_at(nan), Cell::new(i32::MIN, i32::MIN));
        }
    }
}
