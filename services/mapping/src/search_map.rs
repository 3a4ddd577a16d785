//! What a scan is laid on when the robot may be anywhere: how likely a beam ends in a cell, and the most
//! likely cell of ever larger squares of them, so that a square of poses can be refused at one look.
//!
//! Hess, Kohler, Rapp, Andor, "Real-Time Loop Closure in 2D LIDAR SLAM", 2016, section V: precomputed grids.

use nalgebra::{Point2, Vector2};
use zeronav_casts::Cast;
use zeronav_msgs::{Cell, GridGeometry};

/// Grids: the cells themselves, and squares of 2, 4, 8, 16 and 32 cells a side.
const LEVELS: usize = 6;

/// Cells that the grids begin before the map: a square that begins there may reach into it.
const BEFORE: i32 = 1 << (LEVELS - 1);

/// Side of a cell that is aimed at, in whole cells of the map. [m]
const CELL_M: f64 = 0.1;

/// Most cells; of more, they are larger.
const CELLS_MAX: usize = 1 << 20;

/// Standard deviation of a beam's end around its surface, and how far one is looked for. [m] In larger cells the
/// same as a share of their side.
const SPREAD_M: f64 = 0.1;
const SPREAD_CELLS: f64 = 0.7;
const REACH: f64 = 2.5;

/// What it costs to make a surface of a cell, and how many plain cells of a grid cost as much as one of the map to look at.
const SURFACE: usize = 32;
const PLAIN: usize = 2;

/// Likelihoods of a map, for searching.
#[derive(Debug)]
pub(crate) struct SearchMap {
    /// Of the map, and how many rows of its cells were looked at.
    geometry: GridGeometry,
    n_rows: i32,
    /// [m]
    origin: Point2<f64>,
    cell_m: f64,
    width: i32,
    height: i32,
    stride: i32,
    /// 255 where a beam ends on a surface, less beside it. Level n: the most of the square of 2^n cells a side that
    /// begins there.
    levels: Vec<Vec<u8>>,
    /// Whether there is room for the robot in a cell, and in how many cells left of and below a corner.
    is_roomy: Vec<bool>,
    room: Vec<u32>,
}

impl SearchMap {
    /// Goes on making the map, for about as long as it takes to look at so many cells, by the row-major indices of the map's
    /// cells: whether one is a wall, and whether the robot may stand in it. True when the map is whole.
    pub(crate) fn make(
        &mut self,
        is_wall: impl Fn(usize) -> bool,
        has_room: impl Fn(usize) -> bool,
        n_cells: usize,
    ) -> bool {
        let (columns, rows) = self.geometry.size();
        let n_columns = usize::try_from(columns).unwrap_or(0);
        let mut spent = 0;
        while self.levels.len() < LEVELS {
            let is_looked_at = self.n_rows >= rows;
            let cost = if is_looked_at {
                self.levels[0].len() / PLAIN
            } else {
                n_columns
            };
            if spent > 0 && spent + cost > n_cells {
                return false;
            }
            spent += cost;
            if !is_looked_at {
                spent += SURFACE * self.add_row(&is_wall, &has_room);
            } else if self.room.is_empty() {
                self.sum_up();
            } else {
                self.add_level(1 << (self.levels.len() - 1));
            }
        }
        true
    }

    /// Looks at the next row of the map's cells; how many of them are surfaces.
    fn add_row(
        &mut self,
        is_wall: impl Fn(usize) -> bool,
        has_room: impl Fn(usize) -> bool,
    ) -> usize {
        let geometry = self.geometry;
        let at = |x: i32, y: i32| geometry.index_of(Cell::new(x, y));
        let (y, mut n_surfaces) = (self.n_rows, 0);
        self.n_rows += 1;
        for x in 0..geometry.size().0 {
            let Some(here) = at(x, y) else { continue };
            let centre = self.cells_of(geometry.centre_of(Cell::new(x, y)));
            if is_wall(here) {
                let beside = [(1, 0), (-1, 0), (0, 1), (0, -1)];
                let mut beside = beside.iter().filter_map(|(dx, dy)| at(x + dx, y + dy));
                if beside.any(|index| !is_wall(index)) {
                    self.add_surface(centre);
                    n_surfaces += 1;
                }
            } else if has_room(here) {
                let (x, y) = floor(centre);
                if let Some(cell) = (self.holds(x, y)).then(|| index(x, y, self.width)) {
                    self.is_roomy[cell] = true;
                }
            }
        }
        n_surfaces
    }

    /// An empty map, to be made of one of these cells.
    pub(crate) fn new(geometry: &GridGeometry) -> Self {
        let mut times = (CELL_M / geometry.resolution_m).round().max(1.0);
        let cells = |times: f64| {
            let along = |cells: u32| (f64::from(cells) / times).ceil();
            along(geometry.width) * along(geometry.height)
        };
        while cells(times) > CELLS_MAX.to_f64() {
            times += 1.0;
        }
        let along = |cells: u32| (f64::from(cells) / times).ceil().to_i32();
        let (width, height) = (along(geometry.width), along(geometry.height));
        let stride = width + BEFORE;
        Self {
            geometry: *geometry,
            n_rows: 0,
            origin: Point2::new(geometry.origin_x_m, geometry.origin_y_m),
            cell_m: times * geometry.resolution_m,
            width,
            height,
            stride,
            levels: vec![vec![0; index(0, height + BEFORE, stride)]],
            is_roomy: vec![false; index(width, height, width)],
            room: Vec::new(),
        }
    }

    /// A beam that ends around here is explained. [cells]
    fn add_surface(&mut self, at: Point2<f64>) {
        let spread = (SPREAD_M / self.cell_m).max(SPREAD_CELLS);
        let reach = REACH * spread;
        let (low, high) = (floor(at.map(|v| v - reach)), floor(at.map(|v| v + reach)));
        for y in low.1..=high.1 {
            for x in low.0..=high.0 {
                let centre = Point2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
                let square = (centre - at).norm_squared();
                if square > reach * reach || !self.holds(x, y) {
                    continue;
                }
                let value = (255.0 * (-0.5 * square / (spread * spread)).exp()).to_u8();
                let cell = index(x + BEFORE, y + BEFORE, self.stride);
                self.levels[0][cell] = self.levels[0][cell].max(value);
            }
        }
    }

    /// The next level, of squares of twice as many cells a side as the last one, which are `side`.
    fn add_level(&mut self, side: i32) {
        let last = &self.levels[self.levels.len() - 1];
        let rows = self.height + BEFORE;
        let mut next = vec![0; last.len()];
        for y in 0..rows {
            let above = (y + side).min(rows - 1);
            for x in 0..self.stride {
                let right = (x + side).min(self.stride - 1);
                let of = |x: i32, y: i32| last[index(x, y, self.stride)];
                next[index(x, y, self.stride)] = of(x, y)
                    .max(of(right, y))
                    .max(of(x, above))
                    .max(of(right, above));
            }
        }
        self.levels.push(next);
    }

    fn sum_up(&mut self) {
        let stride = self.width + 1;
        self.room = vec![0; index(0, self.height + 1, stride)];
        for y in 0..self.height {
            let mut row = 0;
            for x in 0..self.width {
                row += u32::from(self.is_roomy[index(x, y, self.width)]);
                self.room[index(x + 1, y + 1, stride)] = row + self.room[index(x + 1, y, stride)];
            }
        }
    }

    /// True when there is room for the robot in the square of `side` cells from (x, y) on.
    pub(crate) fn has_room(&self, x: i32, y: i32, side: i32) -> bool {
        let of = |x: i32, y: i32| {
            let (x, y) = (x.clamp(0, self.width), y.clamp(0, self.height));
            self.room[index(x, y, self.width + 1)]
        };
        let (right, above) = (x + side, y + side);
        of(right, above) + of(x, y) > of(x, above) + of(right, y)
    }

    /// How well ends are explained, 0 to 255 each, at best, in the squares of 2^`level` cells that begin at (x, y) and as
    /// far from there as these; 0 when that is not above `least`. How many ends that took.
    #[inline]
    pub(crate) fn sum(
        &self,
        level: usize,
        (x, y): (i32, i32),
        ends: &[(i32, i32)],
        least: u32,
    ) -> (u32, usize) {
        /// Ends between two looks at whether the others can still make it.
        const BATCH: usize = 24;
        let (x, y) = (x + BEFORE, y + BEFORE);
        let (columns, rows) = (self.stride, self.height + BEFORE);
        let grid = &self.levels[level][..];
        let (mut sum, mut left) = (0, ends.len());
        for batch in ends.chunks(BATCH) {
            for (end_x, end_y) in batch {
                let (x, y) = (x.saturating_add(*end_x), y.saturating_add(*end_y));
                if (0..columns).contains(&x) && (0..rows).contains(&y) {
                    sum += u32::from(grid[index(x, y, columns)]);
                }
            }
            left -= batch.len();
            if sum + 255 * left.to_u32() <= least {
                return (0, ends.len() - left);
            }
        }
        (sum, ends.len())
    }

    /// Columns and rows.
    pub(crate) fn size(&self) -> (i32, i32) {
        (self.width, self.height)
    }

    /// Side of a cell. [m]
    pub(crate) fn cell_m(&self) -> f64 {
        self.cell_m
    }

    /// The centre of a cell, in the map. [m]
    pub(crate) fn centre_of(&self, x: i32, y: i32) -> Point2<f64> {
        self.origin + Vector2::new(f64::from(x) + 0.5, f64::from(y) + 0.5) * self.cell_m
    }

    fn cells_of(&self, point_in_map: Point2<f64>) -> Point2<f64> {
        Point2::from((point_in_map - self.origin) / self.cell_m)
    }

    fn holds(&self, x: i32, y: i32) -> bool {
        (0..self.width).contains(&x) && (0..self.height).contains(&y)
    }
}

fn floor(at: Point2<f64>) -> (i32, i32) {
    (at.x.floor().to_i32(), at.y.floor().to_i32())
}

/// Of a cell that lies on the grid.
fn index(x: i32, y: i32, stride: i32) -> usize {
    y.to_usize() * stride.to_usize() + x.to_usize()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn best(map: &SearchMap, level: usize, x: i32, y: i32) -> u32 {
        map.sum(level, (x, y), &[(0, 0)], 0).0
    }

    /// A room of 6 m x 4 m with walls of two cells, of 5 cm, made by so many cells at a time.
    fn room_by(n_cells: usize) -> (SearchMap, usize) {
        let geometry = GridGeometry {
            origin_x_m: -1.0,
            origin_y_m: 2.0,
            resolution_m: 0.05,
            width: 120,
            height: 80,
        };
        let is_wall = |index: usize| {
            let (x, y) = (index % 120, index / 120);
            !(2..118).contains(&x) || !(2..78).contains(&y)
        };
        let mut map = SearchMap::new(&geometry);
        let n_times = (1..1000).find(|_| map.make(is_wall, |_| true, n_cells));
        (map, n_times.expect("whole"))
    }

    fn room() -> SearchMap {
        let (map, n_times) = room_by(1_000_000);
        assert_eq!(n_times, 1);
        map
    }

    /// A large map is made with many scans, each of which takes little.
    #[test]
    fn a_map_is_the_same_however_it_is_made() {
        let whole = room();
        let (sliced, n_times) = room_by(5000);
        assert!((10..20).contains(&n_times), "{n_times}");
        assert!(whole.levels == sliced.levels && whole.room == sliced.room);
    }

    #[test]
    fn no_square_is_better_than_its_bound() {
        let map = room();
        for level in 1..LEVELS {
            let side = 1 << level;
            for (x, y) in [(-31, -3), (-3, 5), (0, 0), (7, 30), (50, 33), (58, 38)] {
                let inside = |x: i32, y: i32| (map.holds(x, y)).then(|| best(&map, 0, x, y));
                let cells = (0..side).flat_map(|dy| (0..side).map(move |dx| (x + dx, y + dy)));
                let most = cells.filter_map(|(x, y)| inside(x, y)).max().unwrap_or(0);
                assert_eq!(best(&map, level, x, y), most, "{level}: {x}, {y}");
            }
        }
    }

    #[test]
    fn walls_are_likely_and_rooms_are_roomy() {
        let map = room();
        assert_eq!(map.size(), (60, 40));
        assert!(best(&map, 0, 0, 20) > 200, "on the wall's face");
        assert_eq!(best(&map, 0, 30, 20), 0, "in the middle of the room");
        assert_eq!(best(&map, 0, -1, 20), 0, "beside the map");
        let beside = map.sum(0, (0, 20), &[(i32::MAX, 0), (0, i32::MIN)], 0);
        assert_eq!(beside, (0, 2));
        assert!(map.has_room(30, 20, 1) && map.has_room(-8, -8, 16));
        assert!(
            !map.has_room(-8, -8, 8) && !map.has_room(0, 10, 1),
            "in the wall"
        );
        assert!((map.centre_of(0, 0) - Point2::new(-0.95, 2.05)).norm() < 1e-9);
    }
}
