//! The cells that a beam passes.
//!
//! Amanatides, Woo, "A Fast Voxel Traversal Algorithm for Ray Tracing", 1987: from border to
//! border, so that no cell is missed and none is visited twice. It runs on blocks of cells first,
//! and on the cells of a block only where there is something to do.

use crate::free_blocks::BLOCK_CELLS;
use nalgebra::{Point2, Vector2};
use zeronav_casts::Cast;
use zeronav_msgs::Cell;

/// A ray over a grid, in cells: cell (x, y) covers `x <= . < x + 1`.
#[derive(Debug, Clone, Copy)]
pub struct Ray {
    /// Where it begins; may lie beside the grid.
    pub origin: Point2<f64>,
    /// Its direction, of length 1.
    pub direction: Vector2<f64>,
}

/// What is done along a ray.
pub trait Passing {
    /// True when nothing is to be done in the block in column `x` and row `y` of blocks.
    fn leaps(&self, x: i32, y: i32) -> bool;
    /// Called for every cell that was left in time, by its row-major index.
    fn passed(&mut self, index: usize);
}

impl Ray {
    /// The cell at a distance from the origin, on the grid or beyond. [cells]
    pub(crate) fn cell_at(&self, cells: f64) -> Cell {
        let at = self.origin + self.direction * cells;
        Cell::new(at.x.floor().to_i32(), at.y.floor().to_i32())
    }

    /// The point `cells` after its origin. [cells]
    pub(crate) fn at(&self, cells: f64) -> Point2<f64> {
        self.origin + self.direction * cells
    }

    /// Shows `passing` every cell of a `width x height` grid that the ray has left again `until`
    /// cells after its origin, in order, except those of blocks that it leaps over. A cell that
    /// the ray only touches at a corner is not shown.
    #[inline]
    pub fn left_cells(&self, width: i32, height: i32, until: f64, passing: &mut impl Passing) {
        let Some((begin, end)) = self.crosses(f64::from(width), f64::from(height)) else {
            return;
        };
        let side = f64::from(BLOCK_CELLS);
        let columns = (width - 1) / BLOCK_CELLS;
        let rows = (height - 1) / BLOCK_CELLS;
        let at = self.origin + self.direction * begin;
        // At the upper borders the ray enters the last cell, which floor would miss.
        let mut x = cell(at.x, 0, width - 1) / BLOCK_CELLS;
        let mut y = cell(at.y, 0, height - 1) / BLOCK_CELLS;
        let (mut leaves_x, step_x) = borders(self.origin.x, self.direction.x, x, side);
        let (mut leaves_y, step_y) = borders(self.origin.y, self.direction.y, y, side);
        let (sign_x, sign_y) = (sign(self.direction.x), sign(self.direction.y));
        let mut entered = begin;
        // The blocks at the upper borders reach beyond the grid, the ray does not.
        while entered <= until && entered < end {
            if !passing.leaps(x, y) {
                let low = (x * BLOCK_CELLS, y * BLOCK_CELLS);
                let high = (
                    (low.0 + BLOCK_CELLS).min(width) - 1,
                    (low.1 + BLOCK_CELLS).min(height) - 1,
                );
                self.left_of_block(low, high, width, (entered, until), passing);
            }
            entered = leaves_x.min(leaves_y);
            let (over_x, over_y) = (leaves_x <= leaves_y, leaves_y <= leaves_x);
            if over_x {
                x += sign_x;
                leaves_x += step_x;
            }
            if over_y {
                y += sign_y;
                leaves_y += step_y;
            }
            if x < 0 || y < 0 || x > columns || y > rows {
                return;
            }
        }
    }

    /// [`Self::left_cells`] in one block, given by its first and last column and row.
    #[inline]
    fn left_of_block(
        &self,
        low: (i32, i32),
        high: (i32, i32),
        width: i32,
        (entered, until): (f64, f64),
        passing: &mut impl Passing,
    ) {
        let at = self.origin + self.direction * entered;
        let (mut x, mut y) = (cell(at.x, low.0, high.0), cell(at.y, low.1, high.1));
        let (mut leaves_x, step_x) = borders(self.origin.x, self.direction.x, x, 1.0);
        let (mut leaves_y, step_y) = borders(self.origin.y, self.direction.y, y, 1.0);
        let (sign_x, sign_y) = (sign(self.direction.x), sign(self.direction.y));
        // Branches, because the processor guesses most of them: a quarter faster than selecting.
        while leaves_x.min(leaves_y) <= until {
            passing.passed(y.to_usize() * width.to_usize() + x.to_usize());
            let (over_x, over_y) = (leaves_x <= leaves_y, leaves_y <= leaves_x);
            if over_x {
                x += sign_x;
                leaves_x += step_x;
            }
            if over_y {
                y += sign_y;
                leaves_y += step_y;
            }
            if x < low.0 || y < low.1 || x > high.0 || y > high.1 {
                return;
            }
        }
    }

    /// How far from its origin the ray enters and leaves the grid; `None` when it misses it.
    fn crosses(&self, width: f64, height: f64) -> Option<(f64, f64)> {
        let (mut enter, mut leave) = (0.0_f64, f64::INFINITY);
        for (origin, direction, side) in [
            (self.origin.x, self.direction.x, width),
            (self.origin.y, self.direction.y, height),
        ] {
            if direction == 0.0 {
                if !(0.0..side).contains(&origin) {
                    return None;
                }
            } else {
                let (one, other) = (-origin / direction, (side - origin) / direction);
                enter = enter.max(one.min(other));
                leave = leave.min(one.max(other));
            }
        }
        (enter < leave).then_some((enter, leave))
    }
}

/// The column or row of a coordinate, at least `low` and at most `high`.
fn cell(at: f64, low: i32, high: i32) -> i32 {
    at.floor().to_i32().clamp(low, high)
}

/// Distance from the origin at which the ray leaves column or row `number` of those `side` cells
/// wide, and from border to border.
fn borders(origin: f64, direction: f64, number: i32, side: f64) -> (f64, f64) {
    let low = f64::from(number) * side;
    if direction > 0.0 {
        ((low + side - origin) / direction, side / direction)
    } else if direction < 0.0 {
        ((low - origin) / direction, -side / direction)
    } else {
        (f64::INFINITY, f64::INFINITY)
    }
}

fn sign(direction: f64) -> i32 {
    i32::from(direction > 0.0) - i32::from(direction < 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const WIDTH: usize = 21;

    /// Remembers what it is shown; leaps over the blocks that are listed.
    #[derive(Default)]
    struct Shown {
        cells: Vec<(usize, usize)>,
        leaps: Vec<(i32, i32)>,
    }

    impl Passing for Shown {
        fn leaps(&self, x: i32, y: i32) -> bool {
            self.leaps.contains(&(x, y))
        }

        fn passed(&mut self, index: usize) {
            self.cells.push((index % WIDTH, index / WIDTH));
        }
    }

    fn shown(ray: &Ray, until: f64, leaps: &[(i32, i32)]) -> Vec<(usize, usize)> {
        let mut shown = Shown {
            leaps: leaps.to_vec(),
            ..Shown::default()
        };
        ray.left_cells(21, 10, until, &mut shown);
        shown.cells
    }

    fn cells(origin: (f64, f64), angle_rad: f64, until: f64) -> Vec<(usize, usize)> {
        let ray = Ray {
            origin: Point2::new(origin.0, origin.1),
            direction: Vector2::new(angle_rad.cos(), angle_rad.sin()),
        };
        shown(&ray, until, &[])
    }

    #[test]
    fn rays_by_hand() {
        assert_eq!(cells((0.5, 0.5), 0.0, 2.6), [(0, 0), (1, 0), (2, 0)]);
        assert_eq!(cells((0.5, 0.5), 0.0, 2.4), [(0, 0), (1, 0)]);
        assert_eq!(cells((0.5, 0.5), 0.0, 0.4), []);
        // From beside the grid, over it and out again.
        assert_eq!(cells((-3.0, 7.5), 0.0, 100.0).len(), WIDTH);
        assert_eq!(cells((-3.0, 7.5), 0.0, 5.0), [(0, 7), (1, 7)]);
        assert_eq!(cells((-3.0, 10.5), 0.0, 100.0), []);
        assert_eq!(cells((22.0, 3.0), 0.0, 100.0), []);
    }

    #[test]
    fn a_corner_is_not_a_cell() {
        let root = 0.5_f64.sqrt();
        let ray = Ray {
            origin: Point2::new(0.5, 0.5),
            direction: Vector2::new(root, root),
        };
        assert_eq!(shown(&ray, 4.0, &[]), [(0, 0), (1, 1), (2, 2)]);
        // Also where blocks meet at a corner.
        assert_eq!(shown(&ray, 12.5, &[])[7..], [(7, 7), (8, 8)]);
    }

    proptest! {
        /// Against each cell's own geometry: shown exactly when the ray crosses its inside and has
        /// left it in time, once, and not in a block that is leapt over.
        #[test]
        fn every_ray_shows_what_it_crosses(
            x in -5.0..26.0, y in -5.0..15.0, angle in -4.0..4.0, until in 0.0..35.0,
            leap in proptest::option::of((0_i32..3, 0_i32..2)),
        ) {
            let (dx, dy) = (f64::cos(angle), f64::sin(angle));
            let ray = Ray { origin: Point2::new(x, y), direction: Vector2::new(dx, dy) };
            let leaps: Vec<(i32, i32)> = leap.into_iter().collect();
            let cells = shown(&ray, until, &leaps);
            let mut once = cells.clone();
            once.sort_unstable();
            once.dedup();
            prop_assert_eq!(once.len(), cells.len());
            for row in 0_u32..10 {
                for column in 0_u32..21 {
                    let slab = |origin: f64, direction: f64, low: f64| {
                        let (a, b) = ((low - origin) / direction, (low + 1.0 - origin) / direction);
                        (a.min(b), a.max(b))
                    };
                    let (x0, x1) = slab(x, dx, f64::from(column));
                    let (y0, y1) = slab(y, dy, f64::from(row));
                    let (enter, leave) = (x0.max(y0).max(0.0), x1.min(y1));
                    let is_shown = cells.contains(&(column as usize, row as usize));
                    let block = ((column / 8).cast_signed(), (row / 8).cast_signed());
                    let leapt = leaps.contains(&block);
                    if leave - enter > 1e-9 && leave < until - 1e-9 && !leapt {
                        prop_assert!(is_shown, "missed {column}, {row}");
                    }
                    if leave - enter < -1e-9 || leave > until + 1e-9 || leapt {
                        prop_assert!(!is_shown, "showed {column}, {row}");
                    }
                }
            }
        }
    }
}
