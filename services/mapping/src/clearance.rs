//! Exact distance from every cell's centre to the nearest obstacle square, kept up to date by
//! work that follows what changed.
//!
//! Distances are squares of half cells: `max(2|dx| - 1, 0)^2 + max(2|dy| - 1, 0)^2`, integers that
//! need no rounding. A new obstacle lowers the distances in its window; where one vanished, its
//! window is recomputed in two passes, first down the columns, then along the rows
//! (Felzenszwalb, Huttenlocher, "Distance Transforms of Sampled Functions", 2012; the lower
//! envelope is replaced by the minimum over the window, which the compiler turns into vector
//! instructions and is faster for windows of this size). Beyond the limit distances are not told
//! apart, which is what makes the windows small.

use zeronav_casts::Cast;
use zeronav_msgs::{Cell, CellRect, GridGeometry};

/// Squared distance of cells without an obstacle within the limit.
pub const FAR: i16 = i16::MAX;

/// Most cells that the limit may span, so that squared distances fit 16 bits.
pub const CLEARANCE_CELLS_MAX: f64 = 90.0;

/// Rows that are computed together when everything is.
const BAND_ROWS: usize = 128;

/// See the module's description.
#[derive(Debug)]
pub struct ClearanceField {
    geometry: GridGeometry,
    /// How far an obstacle reaches along a row or column. [cells]
    reach: i32,
    /// 1 = obstacle.
    obstacles: Vec<u8>,
    /// [half cells^2]
    squares: Vec<i16>,
    /// Rows below, at and above an obstacle, each the squared distances of the window's columns.
    stamp: Vec<i16>,
    /// Squared distance along the column to the nearest obstacle, for the current window.
    columns: Vec<i16>,
    /// Cells since the last obstacle, for each column of the current window.
    since: Vec<i16>,
}

/// Squared distance along one axis. [half cells^2]
fn square(cells: i32) -> i16 {
    let half_cells = (2 * cells.abs() - 1).clamp(0, 181);
    (half_cells * half_cells).min(i32::from(FAR)).to_i16()
}

impl ClearanceField {
    /// A field without obstacles whose distances are exact up to `limit_cells`, at most
    /// [`CLEARANCE_CELLS_MAX`].
    #[must_use]
    pub fn new(geometry: &GridGeometry, limit_cells: f64) -> Self {
        // Cells at reach + 1 are at least the limit away.
        let reach = (limit_cells - 0.5)
            .ceil()
            .clamp(0.0, CLEARANCE_CELLS_MAX)
            .to_i32();
        let mut stamp = Vec::new();
        for y in -reach..=reach {
            stamp.extend((-reach..=reach).map(|x| square(x).saturating_add(square(y))));
        }
        Self {
            geometry: *geometry,
            reach,
            obstacles: vec![0; geometry.len()],
            squares: vec![FAR; geometry.len()],
            stamp,
            columns: Vec::new(),
            since: Vec::new(),
        }
    }

    /// How far an obstacle reaches along a row or column. [cells]
    #[must_use]
    pub fn reach(&self) -> i32 {
        self.reach
    }

    /// Squared distances, row-major; 0 exactly in obstacles, [`FAR`] where there is none within
    /// reach. [half cells^2]
    #[must_use]
    pub fn squares(&self) -> &[i16] {
        &self.squares
    }

    /// Says that the cell at `index` is an obstacle or is none. The distances around it are right
    /// again after [`Self::add`] or [`Self::recompute`].
    pub fn set(&mut self, index: usize, obstacle: bool) {
        self.obstacles[index] = u8::from(obstacle);
    }

    /// True when the cell at `index` is an obstacle.
    #[must_use]
    #[inline]
    pub fn is_obstacle(&self, index: usize) -> bool {
        self.obstacles[index] != 0
    }

    /// Recomputes every distance, in bands, so that a large map needs no large memory for it.
    pub fn recompute_all(&mut self) {
        let (width, height) = self.geometry.size();
        for y in (0..height).step_by(BAND_ROWS) {
            let band = CellRect {
                min: Cell::new(0, y),
                max: Cell::new(width, height.min(y + offset(BAND_ROWS))),
            };
            self.recompute(&band);
        }
    }

    /// Lowers the distances around a new obstacle.
    pub fn add(&mut self, obstacle: Cell) {
        let here = CellRect {
            min: obstacle,
            max: Cell::new(obstacle.x + 1, obstacle.y + 1),
        };
        let window = here.grown(self.reach, &self.geometry);
        let side = at(2 * self.reach + 1);
        let first = at(window.min.x - obstacle.x + self.reach);
        let n = at(window.max.x - window.min.x);
        for y in window.min.y..window.max.y {
            let from = at(y - obstacle.y + self.reach) * side + first;
            let to = self.index(window.min.x, y);
            let stamp = &self.stamp[from..from + n];
            for (square, new) in self.squares[to..to + n].iter_mut().zip(stamp) {
                *square = (*square).min(*new);
            }
        }
    }

    /// Recomputes the distances of the cells of `rect`, which lies on the map.
    pub fn recompute(&mut self, rect: &CellRect) {
        let wide = rect.grown(self.reach, &self.geometry);
        let n = at(wide.max.x - wide.min.x);
        let rows = at(rect.max.y - rect.min.y);
        self.rows_to_obstacles(rect, &wide);
        // Along the rows: the nearest obstacle over all columns of the window.
        for row in 0..rows {
            let to = self.index(rect.min.x, rect.min.y + offset(row));
            let columns = &self.columns[row * n..(row + 1) * n];
            let width = at(rect.max.x - rect.min.x);
            let squares = &mut self.squares[to..to + width];
            squares.fill(FAR);
            for dx in -self.reach..=self.reach {
                // Cells of the row whose column at dx lies in the window.
                let first = (wide.min.x - dx - rect.min.x).max(0);
                let last = (wide.max.x - dx - rect.min.x).min(offset(width));
                if first >= last {
                    continue;
                }
                let along = square(dx);
                let from = at(rect.min.x + first + dx - wide.min.x);
                let columns = &columns[from..from + at(last - first)];
                for (square, column) in squares[at(first)..at(last)].iter_mut().zip(columns) {
                    *square = (*square).min(column.saturating_add(along));
                }
            }
        }
    }

    /// Fills `columns` with the squared distance along the column to the nearest obstacle of
    /// `wide`, for the rows of `rect` and the columns of `wide`.
    fn rows_to_obstacles(&mut self, rect: &CellRect, wide: &CellRect) {
        let n = at(wide.max.x - wide.min.x);
        let width = at(self.geometry.size().0);
        let reach = i16::try_from(self.reach).unwrap_or(0);
        self.columns.clear();
        self.columns.resize(at(rect.max.y - rect.min.y) * n, FAR);
        for upwards in [true, false] {
            self.since.clear();
            self.since.resize(n, FAR);
            for step in 0..wide.max.y - wide.min.y {
                let y = if upwards {
                    wide.min.y + step
                } else {
                    wide.max.y - 1 - step
                };
                let from = at(y) * width + at(wide.min.x);
                let obstacles = &self.obstacles[from..from + n];
                for (since, obstacle) in self.since.iter_mut().zip(obstacles) {
                    let one_more = since.saturating_add(1);
                    *since = if *obstacle == 0 { one_more } else { 0 };
                }
                if (rect.min.y..rect.max.y).contains(&y) {
                    let row = at(y - rect.min.y) * n;
                    let columns = &mut self.columns[row..row + n];
                    for (column, since) in columns.iter_mut().zip(&self.since) {
                        let near = (*since).min(reach);
                        let half_cells = (2 * near - 1).max(0);
                        let square = if *since > reach {
                            FAR
                        } else {
                            half_cells * half_cells
                        };
                        *column = (*column).min(square);
                    }
                }
            }
        }
    }

    fn index(&self, x: i32, y: i32) -> usize {
        at(y) * at(self.geometry.size().0) + at(x)
    }
}

fn at(cells: i32) -> usize {
    cells.cast_unsigned() as usize
}

fn offset(cells: usize) -> i32 {
    i32::try_from(cells).unwrap_or(i32::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn geometry(width: u32, height: u32) -> GridGeometry {
        GridGeometry {
            origin_x_m: 0.0,
            origin_y_m: 0.0,
            resolution_m: 0.05,
            width,
            height,
        }
    }

    /// Distance of a centre to the nearest obstacle square. [cells]
    fn brute_force(obstacles: &[Cell], cell: Cell) -> f64 {
        let gap = |a: i32, b: i32| (f64::from((a - b).abs()) - 0.5).max(0.0);
        obstacles
            .iter()
            .map(|o| gap(o.x, cell.x).hypot(gap(o.y, cell.y)))
            .fold(f64::INFINITY, f64::min)
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(300))]

        /// After every batch of random edits, every cell against brute force.
        #[test]
        fn edits_keep_every_distance_exact(
            width in 1_i32..50,
            height in 1_i32..50,
            limit in 1.0_f64..25.0,
            batches in proptest::collection::vec(
                proptest::collection::vec((0_i32..50, 0_i32..50, any::<bool>()), 0..30),
                1..6,
            ),
        ) {
            let grid = geometry(width.cast_unsigned(), height.cast_unsigned());
            let mut field = ClearanceField::new(&grid, limit);
            let mut obstacles: Vec<Cell> = Vec::new();
            for batch in batches {
                let before = obstacles.clone();
                for (x, y, obstacle) in batch {
                    let cell = Cell::new(x % width, y % height);
                    obstacles.retain(|o| *o != cell);
                    if obstacle {
                        obstacles.push(cell);
                    }
                    field.set(grid.index_of(cell).unwrap(), obstacle);
                }
                for gone in before.iter().filter(|o| !obstacles.contains(o)) {
                    let one = CellRect { min: *gone, max: Cell::new(gone.x + 1, gone.y + 1) };
                    field.recompute(&one.grown(field.reach(), &grid));
                }
                for new in obstacles.iter().filter(|o| !before.contains(o)) {
                    field.add(*new);
                }
                for y in 0..height {
                    for x in 0..width {
                        let cell = Cell::new(x, y);
                        let square = field.squares()[grid.index_of(cell).unwrap()];
                        let exact = brute_force(&obstacles, cell);
                        if exact < limit {
                            let distance = f64::from(square).sqrt() / 2.0;
                            prop_assert!((distance - exact).abs() < 1e-9, "{cell:?}: {exact}");
                        } else {
                            prop_assert!(f64::from(square).sqrt() / 2.0 >= limit - 1e-9);
                        }
                        prop_assert_eq!(square == 0, obstacles.contains(&cell));
                    }
                }
            }
        }
    }

    #[test]
    fn the_longest_limit_does_not_overflow() {
        let grid = geometry(200, 200);
        let mut field = ClearanceField::new(&grid, 90.0);
        field.set(grid.index_of(Cell::new(100, 100)).unwrap(), true);
        field.add(Cell::new(100, 100));
        let at = |field: &ClearanceField, x: usize, y: usize| field.squares()[y * 200 + x];
        assert_eq!(at(&field, 190, 100), 179 * 179);
        assert_eq!(at(&field, 191, 100), FAR);
        assert_eq!(at(&field, 30, 30), FAR);
        let whole = CellRect {
            min: Cell::new(0, 0),
            max: Cell::new(200, 200),
        };
        let before = field.squares().to_vec();
        field.recompute(&whole);
        assert_eq!(field.squares(), before);
    }
}
