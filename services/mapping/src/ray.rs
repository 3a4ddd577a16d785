//! The cells that a beam passes.
//!
//! Amanatides, Woo, "A Fast Voxel Traversal Algorithm for Ray Tracing", 1987: from border to
//! border, so that no cell is missed and none is visited twice.

use nalgebra::{Point2, Vector2};

/// A ray over a grid, in cells: cell (x, y) covers `x <= . < x + 1`.
#[derive(Debug, Clone, Copy)]
pub struct Ray {
    /// Where it begins; may lie beside the grid.
    pub origin: Point2<f64>,
    /// Its direction, of length 1.
    pub direction: Vector2<f64>,
}

impl Ray {
    /// Calls `visit` with the row-major index of every cell of a `width x height` grid that the
    /// ray has left again `until` cells after its origin, in order. A cell that the ray only
    /// touches at a corner is not visited.
    #[inline]
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_precision_loss,
        clippy::cast_sign_loss,
        reason = "sides are at most 8192, and the ray is cut to the grid before"
    )]
    pub fn left_cells(&self, width: i32, height: i32, until: f64, mut visit: impl FnMut(usize)) {
        let Some(begin) = self.enters(f64::from(width), f64::from(height)) else {
            return;
        };
        let at = self.origin + self.direction * begin;
        // At the upper borders the ray enters the last cell, which floor would miss.
        let cell = |at: f64, side: i32| (at.floor() as i32).clamp(0, side - 1);
        let (mut x, mut y) = (cell(at.x, width), cell(at.y, height));
        let (mut leaves_x, step_x) = borders(self.origin.x, self.direction.x, x);
        let (mut leaves_y, step_y) = borders(self.origin.y, self.direction.y, y);
        let (sign_x, sign_y) = (sign(self.direction.x), sign(self.direction.y));
        // Branches, because the processor guesses most of them: a quarter faster than selecting.
        while leaves_x.min(leaves_y) <= until {
            visit(y as usize * width as usize + x as usize);
            let (over_x, over_y) = (leaves_x <= leaves_y, leaves_y <= leaves_x);
            if over_x {
                x += sign_x;
                leaves_x += step_x;
            }
            if over_y {
                y += sign_y;
                leaves_y += step_y;
            }
            if x < 0 || y < 0 || x >= width || y >= height {
                return;
            }
        }
    }

    /// How far from its origin the ray enters the grid; `None` when it misses it.
    fn enters(&self, width: f64, height: f64) -> Option<f64> {
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
        (enter < leave).then_some(enter)
    }
}

/// Distance from the origin at which the ray leaves column or row `cell`, and from border to
/// border.
fn borders(origin: f64, direction: f64, cell: i32) -> (f64, f64) {
    if direction > 0.0 {
        (
            (f64::from(cell) + 1.0 - origin) / direction,
            1.0 / direction,
        )
    } else if direction < 0.0 {
        ((f64::from(cell) - origin) / direction, -1.0 / direction)
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

    fn cells(origin: (f64, f64), angle_rad: f64, until: f64) -> Vec<(usize, usize)> {
        let ray = Ray {
            origin: Point2::new(origin.0, origin.1),
            direction: Vector2::new(angle_rad.cos(), angle_rad.sin()),
        };
        let mut cells = Vec::new();
        ray.left_cells(10, 8, until, |index| cells.push((index % 10, index / 10)));
        cells
    }

    #[test]
    fn rays_by_hand() {
        assert_eq!(cells((0.5, 0.5), 0.0, 2.6), [(0, 0), (1, 0), (2, 0)]);
        assert_eq!(cells((0.5, 0.5), 0.0, 2.4), [(0, 0), (1, 0)]);
        assert_eq!(cells((0.5, 0.5), 0.0, 0.4), []);
        // From beside the grid, over it and out again.
        assert_eq!(cells((-3.0, 7.5), 0.0, 100.0).len(), 10);
        assert_eq!(cells((-3.0, 7.5), 0.0, 5.0), [(0, 7), (1, 7)]);
        assert_eq!(cells((-3.0, 9.5), 0.0, 100.0), []);
        assert_eq!(cells((12.0, 3.0), 0.0, 100.0), []);
    }

    #[test]
    fn a_corner_is_not_a_cell() {
        let root = 0.5_f64.sqrt();
        let ray = Ray {
            origin: Point2::new(0.5, 0.5),
            direction: Vector2::new(root, root),
        };
        let mut cells = Vec::new();
        ray.left_cells(10, 8, 4.0, |index| cells.push((index % 10, index / 10)));
        assert_eq!(cells, [(0, 0), (1, 1), (2, 2)]);
    }

    proptest! {
        /// Against each cell's own geometry: visited exactly when the ray crosses its inside and
        /// has left it in time.
        #[test]
        fn every_ray_visits_what_it_crosses(
            x in -5.0..15.0, y in -5.0..13.0, angle in -4.0..4.0, until in 0.0..25.0,
        ) {
            let (dx, dy) = (f64::cos(angle), f64::sin(angle));
            let visited = cells((x, y), angle, until);
            for row in 0_u32..8 {
                for column in 0_u32..10 {
                    let slab = |origin: f64, direction: f64, low: f64| {
                        let (a, b) = ((low - origin) / direction, (low + 1.0 - origin) / direction);
                        (a.min(b), a.max(b))
                    };
                    let (x0, x1) = slab(x, dx, f64::from(column));
                    let (y0, y1) = slab(y, dy, f64::from(row));
                    let (enter, leave) = (x0.max(y0).max(0.0), x1.min(y1));
                    let is_visited = visited.contains(&(column as usize, row as usize));
                    if leave - enter > 1e-9 && leave < until - 1e-9 {
                        prop_assert!(is_visited, "missed {column}, {row}");
                    }
                    if leave - enter < -1e-9 || leave > until + 1e-9 {
                        prop_assert!(!is_visited, "visited {column}, {row}");
                    }
                }
            }
        }
    }
}
