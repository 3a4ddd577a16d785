//! The occupied cells of a static map as solid squares, for rays.
//!
//! Every cell stores its Chebyshev distance to the nearest occupied cell, up to 255 cells. A ray
//! crosses that many cells in one stride instead of cell by cell: the walk is that of Amanatides and Woo, "A Fast Voxel Traversal Algorithm for Ray Tracing" (1987),
//! over the blocks of Cohen and Sheffer, "Proximity clouds" (1994). Unlike sphere tracing it has no
//! sampling error: the range is the distance to the face of the occupied square, in f64.
//!
//! Cells are half-open as everywhere in the contract: a ray that only touches the upper edge or a
//! single corner of a square passes; two squares that meet at a corner let nothing through.

use nalgebra::{Point2, Vector2};
use zeronav_casts::Cast;
use zeronav_msgs::GridGeometry;
use zeronav_world::{Occupancy, StaticMap};

/// The occupied cells of a map. Everything outside the map is free.
#[derive(Debug, Clone)]
pub struct SolidGrid {
    geometry: GridGeometry,
    /// Row-major: 0 = occupied, k = all cells nearer than k cells (Chebyshev) are free.
    free_steps: Vec<u8>,
}

impl SolidGrid {
    /// The occupied cells of `map`; unknown ones are not solid. O(cells), a byte for each.
    #[must_use]
    pub fn new(map: &StaticMap) -> Self {
        let geometry = map.geometry;
        let mut free_steps: Vec<u8> = map
            .cells
            .iter()
            .map(|cell| match cell {
                Occupancy::Occupied => 0,
                Occupancy::Free | Occupancy::Unknown => u8::MAX,
            })
            .collect();
        free_steps.resize(geometry.len(), u8::MAX);
        chebyshev(
            &mut free_steps,
            geometry.width as usize,
            geometry.height as usize,
        );
        Self {
            geometry,
            free_steps,
        }
    }

    /// Distance from `origin` along the unit vector `direction`, both in the map frame, to the
    /// first occupied square; 0 inside one, `None` when there is none within `limit_m`. [m]
    #[must_use]
    pub fn cast(&self, origin: Point2<f64>, direction: Vector2<f64>, limit_m: f64) -> Option<f64> {
        let (width, height) = self.geometry.size();
        let per_m = 1.0 / self.geometry.resolution_m;
        let x = Axis::new((origin.x - self.geometry.origin_x_m) * per_m, direction.x);
        let y = Axis::new((origin.y - self.geometry.origin_y_m) * per_m, direction.y);
        let limit = limit_m * per_m;
        let (x_in, x_out) = x.crossing(f64::from(width))?;
        let (y_in, y_out) = y.crossing(f64::from(height))?;
        let mut t = x_in.max(y_in).max(0.0);
        if t > x_out.min(y_out).min(limit) {
            return None;
        }
        let mut cx = floor(x.at(t)).clamp(0, width - 1);
        let mut cy = floor(y.at(t)).clamp(0, height - 1);
        loop {
            let free = i32::from(self.free_steps[(cy * width + cx).cast_unsigned() as usize]);
            if free == 0 {
                return Some(t * self.geometry.resolution_m);
            }
            // Leave the block of free cells around this one through its nearer face. The other
            // coordinate follows from the ray, but never beyond the block.
            let (tx, ty) = (x.time_of_exit(cx, free), y.time_of_exit(cy, free));
            if tx <= ty {
                t = tx;
                cx += x.step * free;
                cy = floor(y.at(t)).clamp(cy - free + 1, cy + free - 1);
            } else {
                t = ty;
                cy += y.step * free;
                cx = floor(x.at(t)).clamp(cx - free + 1, cx + free - 1);
            }
            if t > limit || cx < 0 || cy < 0 || cx >= width || cy >= height {
                return None;
            }
        }
    }
}

/// One coordinate of a ray, in cells.
struct Axis {
    origin: f64,
    slope: f64,
    inverse: f64,
    step: i32,
}

impl Axis {
    fn new(origin: f64, slope: f64) -> Self {
        Self {
            origin,
            slope,
            inverse: 1.0 / slope,
            step: if slope < 0.0 { -1 } else { 1 },
        }
    }

    fn at(&self, t: f64) -> f64 {
        self.origin + t * self.slope
    }

    /// When the ray enters and leaves `0..size`; `None` when it never does.
    fn crossing(&self, size: f64) -> Option<(f64, f64)> {
        if self.slope == 0.0 {
            let inside = self.origin >= 0.0 && self.origin < size;
            return inside.then_some((f64::NEG_INFINITY, f64::INFINITY));
        }
        let (a, b) = (
            -self.origin * self.inverse,
            (size - self.origin) * self.inverse,
        );
        Some((a.min(b), a.max(b)))
    }

    /// When the ray leaves the `2 * free - 1` cells around `cell`.
    fn time_of_exit(&self, cell: i32, free: i32) -> f64 {
        if self.slope == 0.0 {
            return f64::INFINITY;
        }
        let face = if self.step > 0 {
            cell + free
        } else {
            cell - free + 1
        };
        (f64::from(face) - self.origin) * self.inverse
    }
}

/// Largest whole number not above `value`, without the call into the maths library that
/// `f64::floor` is on processors before SSE4.1. Saturates.
fn floor(value: f64) -> i32 {
    let whole = value.to_i32();
    whole.saturating_sub(i32::from(f64::from(whole) > value))
}

/// Turns 0 and 255 into the Chebyshev distance to the nearest 0, saturating at 255. Two passes
/// over the eight neighbours are exact for this metric (Rosenfeld and Pfaltz, "Distance functions
/// on digital pictures", 1968).
fn chebyshev(cells: &mut [u8], width: usize, height: usize) {
    for y in 0..height {
        for x in 0..width {
            let at = y * width + x;
            let mut nearest = u8::MAX;
            if x > 0 {
                nearest = nearest.min(cells[at - 1]);
            }
            if y > 0 {
                let below = at - width;
                nearest = nearest.min(cells[below]);
                if x > 0 {
                    nearest = nearest.min(cells[below - 1]);
                }
                if x + 1 < width {
                    nearest = nearest.min(cells[below + 1]);
                }
            }
            cells[at] = cells[at].min(nearest.saturating_add(1));
        }
    }
    for y in (0..height).rev() {
        for x in (0..width).rev() {
            let at = y * width + x;
            let mut nearest = u8::MAX;
            if x + 1 < width {
                nearest = nearest.min(cells[at + 1]);
            }
            if y + 1 < height {
                let above = at + width;
                nearest = nearest.min(cells[above]);
                if x > 0 {
                    nearest = nearest.min(cells[above - 1]);
                }
                if x + 1 < width {
                    nearest = nearest.min(cells[above + 1]);
                }
            }
            cells[at] = cells[at].min(nearest.saturating_add(1));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f64::consts::{FRAC_PI_4, SQRT_2, TAU};
    use parry2d::bounding_volume::Aabb;
    use parry2d::math::Vec2;
    use parry2d::query::{Ray, RayCast as _};
    use rand::RngExt as _;
    use rand::SeedableRng as _;
    use rand_pcg::Pcg64Mcg;
    use zeronav_msgs::Cell;

    fn geometry(width: u32, height: u32) -> GridGeometry {
        GridGeometry {
            origin_x_m: -1.0,
            origin_y_m: 2.0,
            resolution_m: 0.25,
            width,
            height,
        }
    }

    fn solid(geometry: GridGeometry, is_occupied: impl Fn(usize) -> bool) -> SolidGrid {
        let cells = (0..geometry.len())
            .map(|index| match (is_occupied(index), index % 3) {
                (true, _) => Occupancy::Occupied,
                (false, 0) => Occupancy::Unknown,
                (false, _) => Occupancy::Free,
            })
            .collect();
        SolidGrid::new(&StaticMap { geometry, cells })
    }

    fn grid(width: u32, height: u32, occupied: &[(i32, i32)]) -> SolidGrid {
        let geometry = geometry(width, height);
        let occupied: Vec<usize> = occupied
            .iter()
            .filter_map(|(x, y)| geometry.index_of(Cell::new(*x, *y)))
            .collect();
        solid(geometry, |index| occupied.contains(&index))
    }

    fn square_of(geometry: &GridGeometry, index: usize) -> Aabb {
        let x = f64::from(u32::try_from(index).unwrap() % geometry.width);
        let y = f64::from(u32::try_from(index).unwrap() / geometry.width);
        let min = Vec2::new(
            geometry.origin_x_m + x * geometry.resolution_m,
            geometry.origin_y_m + y * geometry.resolution_m,
        );
        Aabb::new(min, min + Vec2::splat(geometry.resolution_m))
    }

    fn direction(angle_rad: f64) -> Vector2<f64> {
        Vector2::new(angle_rad.cos(), angle_rad.sin())
    }

    #[track_caller]
    fn close(found: Option<f64>, expected: f64) {
        let found = found.expect("a hit");
        assert!((found - expected).abs() < 1e-12, "{found}, not {expected}");
    }

    #[test]
    fn ranges_end_on_the_face_of_the_square() {
        // Cell (6, 2) covers x 0.5..0.75, y 2.5..2.75.
        let grid = grid(12, 8, &[(6, 2)]);
        let from = Point2::new(-0.9, 2.6);
        close(grid.cast(from, Vector2::x(), 9.0), 1.4);
        close(grid.cast(Point2::new(1.9, 2.6), -Vector2::x(), 9.0), 1.15);
        close(grid.cast(Point2::new(0.6, 2.0), Vector2::y(), 9.0), 0.5);
        close(grid.cast(Point2::new(0.6, 3.9), -Vector2::y(), 9.0), 1.15);
        // From outside the map, diagonally onto the lower left corner.
        let far = Point2::new(0.5 - 5.0, 2.5 - 5.0);
        let slightly = far + Vector2::new(0.0, 1e-6);
        close(
            grid.cast(slightly, direction(FRAC_PI_4), 99.0),
            5.0 * SQRT_2,
        );
        // Beyond the limit, beside it, away from it.
        assert_eq!(grid.cast(from, Vector2::x(), 1.3), None);
        assert_eq!(grid.cast(Point2::new(-0.9, 2.4), Vector2::x(), 9.0), None);
        assert_eq!(grid.cast(from, -Vector2::x(), 9.0), None);
        assert_eq!(grid.cast(Point2::new(-9.0, 1.0), Vector2::x(), 99.0), None);
        assert_eq!(grid.cast(Point2::new(9.0, 2.6), Vector2::x(), 99.0), None);
        // Inside.
        close(grid.cast(Point2::new(0.6, 2.6), direction(2.0), 9.0), 0.0);
    }

    #[test]
    fn squares_that_meet_at_a_corner_let_nothing_through() {
        let grid = grid(8, 8, &[(3, 4), (4, 3)]);
        // From the middle of cell (1, 1) along the diagonal, through the corner (4, 4).
        let from = grid.geometry.centre_of(Cell::new(1, 1));
        close(
            grid.cast(from, direction(FRAC_PI_4), 9.0),
            2.5 * 0.25 * SQRT_2,
        );
    }

    #[test]
    fn grazing_a_corner_by_a_hair_hits_or_passes() {
        let grid = grid(12, 12, &[(6, 6)]);
        // Lines of slope one past the upper left corner (6, 7) of the cell, in cells.
        let along = |offset: f64| {
            let origin = Point2::new(-1.0 + 0.25 * 2.0, 2.0 + 0.25 * (3.0 + offset));
            grid.cast(origin, direction(FRAC_PI_4), 9.0)
        };
        close(along(-1e-9), 4.0 * 0.25 * SQRT_2);
        assert_eq!(along(1e-9), None);
    }

    #[test]
    fn rays_agree_with_every_square_on_random_maps() {
        let seed = 11;
        eprintln!("seed {seed}");
        let mut rng = Pcg64Mcg::seed_from_u64(seed);
        let mut hits = 0;
        for map in 0..60 {
            let (width, height) = (rng.random_range(1..60), rng.random_range(1..60));
            let density = [0.0, 0.002, 0.02, 0.2, 0.6][map % 5];
            let geometry = geometry(width, height);
            let occupied: Vec<bool> = (0..geometry.len())
                .map(|_| rng.random::<f64>() < density)
                .collect();
            let grid = solid(geometry, |index| occupied[index]);
            for ray in 0..400 {
                let origin =
                    Point2::new(rng.random_range(-5.0..18.0), rng.random_range(-2.0..20.0));
                let along = direction(rng.random_range(0.0..TAU));
                let limit_m = rng.random_range(0.0..30.0);
                let found = grid.cast(origin, along, limit_m);
                let mut expected = None;
                for (index, _) in occupied.iter().enumerate().filter(|(_, solid)| **solid) {
                    let ray = Ray::new(origin.coords.into(), along.into());
                    if let Some(t) = square_of(&geometry, index).cast_local_ray(&ray, limit_m, true)
                        && expected.is_none_or(|best| t < best)
                    {
                        expected = Some(t);
                    }
                }
                match (found, expected) {
                    (Some(a), Some(b)) => {
                        hits += 1;
                        assert!((a - b).abs() < 1e-9, "map {map} ray {ray}: {a}, not {b}");
                    }
                    (None, None) => {}
                    _ => panic!("map {map} ray {ray}: {found:?}, not {expected:?}"),
                }
            }
        }
        assert!(hits > 2000, "{hits} hits");
    }

    #[test]
    fn a_large_map_is_one_byte_a_cell_and_strides_are_exact() {
        // Free but for a far wall: strides of 255 cells.
        let geometry = geometry(2000, 3);
        let grid = solid(geometry, |index| index % 2000 == 1990);
        assert_eq!(grid.free_steps.len(), 6000);
        let from = geometry.centre_of(Cell::new(10, 1));
        close(grid.cast(from, Vector2::x(), 1.0e3), 1979.5 * 0.25);
    }
}
