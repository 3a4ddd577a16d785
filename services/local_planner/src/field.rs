//! Clearance around the robot: the shared map lowered by the points of the current scan.
//!
//! A window of the map's own cells, so nothing is resampled. Positions are metres relative to the
//! robot's centre along the axes of the map, in `f32`, so far coordinates cost no precision. A
//! point that lies in an obstacle's square adds nothing (the square is at least as near from
//! anywhere) and is skipped; the others lower the cells around them to their exact distance. In
//! steady state nearly every point is skipped, so the cost follows what the map does not know yet.
//!
//! The window is a little larger than needed and stays where it is while the robot drives inside it
//! and neither the map nor the points (as they lie in the map) change.

use crate::lanes::data::Sheet;
use crate::lanes::{clearances, lower_block, settle_row};
use nalgebra::Point2;
use zeronav_casts::Cast;
use zeronav_msgs::{GridGeometry, MapView, Pose};

/// Clearance without any map. [m] Far more than any footprint needs.
const FAR_M: f32 = 1.0e3;

/// [m] side of a cell where there is no map.
const RESOLUTION_M: f64 = 0.05;

/// Most cells on a side of the window.
const SIDE_MAX: i32 = 1024;

/// [m] by which the window is larger than asked for, on every side.
const SPARE_M: f64 = 0.4;

/// [m] within which a point of the scan lies where it lay; far more than rounding, far less than
/// any clearance that is told apart.
const SAME_M: f64 = 1.0e-6;

/// What a window was filled from, besides the points.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Source {
    /// The map's geometry and the number of its cells' state.
    map: Option<(GridGeometry, u64)>,
    /// Rows and columns around the cell it was made at.
    half: i32,
    stamp_m: f64,
}

/// Clearance in a square window around the robot.
#[derive(Debug, Clone, Default)]
pub(crate) struct ClearanceField {
    source: Option<Source>,
    /// Lowest cell of the window.
    min: (i32, i32),
    /// The points that were stamped, in the map. [m]
    stamped: Vec<Point2<f64>>,
    /// [m] at cell centres, row-major.
    cells: Vec<f32>,
    /// Squared distance to the stamped points, infinite elsewhere. [m^2]
    squared: Vec<f32>,
    side: i32,
    /// Index of the robot's centre, in cells, where integers are cell centres.
    centre: (f32, f32),
    resolution_m: f32,
    inverse: f32,
}

impl ClearanceField {
    /// Has a window that reaches `half_m` from the robot on every side; `map_cells` grows when
    /// cells of the map change. Points (in `base`) lower the clearance within `stamp_m` of them.
    /// Cells beside the map are obstacles. True when the window had to be filled.
    pub(crate) fn fill(
        &mut self,
        map: Option<(MapView<'_>, u64)>,
        map_from_base: &Pose,
        points_in_base: &[Point2<f64>],
        half_m: f64,
        stamp_m: f64,
    ) -> bool {
        let (origin_x, origin_y, resolution) = map.map_or((0.0, 0.0, RESOLUTION_M), |(map, _)| {
            let geometry = map.geometry;
            (
                geometry.origin_x_m,
                geometry.origin_y_m,
                geometry.resolution_m,
            )
        });
        let at_x = (map_from_base.x_m - origin_x) / resolution;
        let at_y = (map_from_base.y_m - origin_y) / resolution;
        let inner = (half_m / resolution).ceil().to_i32() + 2;
        let half = (inner + (SPARE_M / resolution).ceil().to_i32()).min(SIDE_MAX / 2);
        let source = Source {
            map: map.map(|(map, cells)| (*map.geometry, cells)),
            half,
            stamp_m,
        };
        let base = (at_x.floor().to_i32(), at_y.floor().to_i32());
        let within = |min: i32, at: i32| {
            let middle = min.saturating_add(half);
            at.abs_diff(middle) <= half.saturating_sub(inner).unsigned_abs()
        };
        let stays = self.source == Some(source)
            && within(self.min.0, base.0)
            && within(self.min.1, base.1)
            && self.same_points(map_from_base, points_in_base);
        if !stays {
            self.source = Some(source);
            self.min = (base.0.saturating_sub(half), base.1.saturating_sub(half));
        }
        self.side = 2 * half + 1;
        self.centre = (
            (at_x - f64::from(self.min.0) - 0.5).to_f32(),
            (at_y - f64::from(self.min.1) - 0.5).to_f32(),
        );
        self.resolution_m = resolution.to_f32();
        self.inverse = (1.0 / resolution).to_f32();
        if stays {
            return false;
        }
        self.copy_map(map.map(|(map, _)| map), self.min.0, self.min.1);
        self.stamp(points_in_base, map_from_base.yaw_rad, stamp_m.to_f32());
        self.stamped.clear();
        let in_map = map_from_base.isometry();
        self.stamped
            .extend(points_in_base.iter().map(|point| in_map * point));
        true
    }

    /// True when the points lie in the map where the stamped ones lie.
    fn same_points(&self, map_from_base: &Pose, points_in_base: &[Point2<f64>]) -> bool {
        let in_map = map_from_base.isometry();
        self.stamped.len() == points_in_base.len()
            && self.stamped.iter().zip(points_in_base).all(|(was, point)| {
                let off = in_map * point - was;
                off.x.abs() <= SAME_M && off.y.abs() <= SAME_M
            })
    }

    fn copy_map(&mut self, map: Option<MapView<'_>>, min_x: i32, min_y: i32) {
        let side = self.side.to_usize();
        self.cells.clear();
        let Some(map) = map else {
            self.cells.resize(side * side, FAR_M);
            return;
        };
        self.cells.resize(side * side, 0.0);
        let (width, height) = map.geometry.size();
        let (from_x, to_x) = (min_x.max(0), min_x.saturating_add(self.side).min(width));
        let (from_y, to_y) = (min_y.max(0), min_y.saturating_add(self.side).min(height));
        if from_x >= to_x {
            return;
        }
        let n = (to_x - from_x).to_usize();
        for y in from_y..to_y {
            let source = y.to_usize() * width.to_usize() + from_x.to_usize();
            let target = (y - min_y).to_usize() * side + (from_x - min_x).to_usize();
            let Some(source) = map.cells.get(source..source + n) else {
                continue;
            };
            clearances(source, &mut self.cells[target..target + n]);
        }
    }

    fn stamp(&mut self, points_in_base: &[Point2<f64>], yaw_rad: f64, stamp_m: f32) {
        let side = self.side.to_usize();
        if self.squared.len() != side * side {
            self.squared.clear();
            self.squared.resize(side * side, f32::INFINITY);
        }
        let (sin, cos) = yaw_rad.sin_cos();
        let reach = (stamp_m * self.inverse).ceil().to_i32();
        let last = self.side - 1;
        let (mut low, mut high) = ((last, last), (0, 0));
        for point in points_in_base {
            let x = (cos * point.x - sin * point.y).to_f32() * self.inverse + self.centre.0;
            let y = (sin * point.x + cos * point.y).to_f32() * self.inverse + self.centre.1;
            // Far enough that not even its surroundings lie in the window; also what is no number.
            let bound = (reach + 1).to_f32();
            let limit = self.side.to_f32() + bound;
            if !(x > -bound && y > -bound && x < limit && y < limit) {
                continue;
            }
            // Shifted to be positive, truncation rounds to the nearest centre.
            let shift = reach + 2;
            let cell_x = (x + 0.5 + shift.to_f32()).to_i32() - shift;
            let cell_y = (y + 0.5 + shift.to_f32()).to_i32() - shift;
            let inside = cell_x >= 0 && cell_y >= 0 && cell_x <= last && cell_y <= last;
            if inside && self.cells[(cell_y * self.side + cell_x).to_usize()] <= 0.0 {
                continue;
            }
            let (from_x, to_x) = ((cell_x - reach).max(0), (cell_x + reach).min(last));
            let (from_y, to_y) = ((cell_y - reach).max(0), (cell_y + reach).min(last));
            if from_x > to_x || from_y > to_y {
                continue;
            }
            low = (low.0.min(from_x), low.1.min(from_y));
            high = (high.0.max(to_x), high.1.max(to_y));
            let scale = self.resolution_m;
            let rows = &mut self.squared[from_y.to_usize() * side..(to_y.to_usize() + 1) * side];
            lower_block(
                rows,
                (from_x.to_usize(), to_x.to_usize(), side),
                (x, y - from_y.to_f32()),
                scale,
            );
        }
        for row in low.1..=high.1 {
            let start = (row * self.side).to_usize();
            let range =
                start + low.0.to_usize()..start + (high.0.to_usize() + 1).max(low.0.to_usize());
            settle_row(&mut self.cells[range.clone()], &mut self.squared[range]);
        }
    }

    /// The window as the lane-wise kernels see it.
    pub(crate) fn sheet(&self) -> Sheet<'_> {
        Sheet {
            cells: &self.cells,
            side: self.side,
            centre: self.centre,
            resolution_m: self.resolution_m,
            inverse: self.inverse,
        }
    }

    /// Largest difference between [`Self::nearest_m`] and the clearance anywhere in the cell. [m]
    pub(crate) fn slack_m(&self) -> f32 {
        core::f32::consts::FRAC_1_SQRT_2 * self.resolution_m
    }

    /// Clearance at the centre of the cell that holds a point. [m]
    pub(crate) fn nearest_m(&self, x: f32, y: f32) -> f32 {
        let last = self.side - 1;
        // The window begins below the robot, so truncation is rounding.
        let column = (x * self.inverse + self.centre.0 + 0.5)
            .to_i32()
            .clamp(0, last);
        let row = (y * self.inverse + self.centre.1 + 0.5)
            .to_i32()
            .clamp(0, last);
        self.cells[(row * self.side + column).to_usize()]
    }

    /// A bound below the clearance at a point, exact up to a few millimetres. [m]
    ///
    /// Bilinear between four cell centres. The distance to one convex obstacle is convex with a
    /// second derivative of at most 1/d across the line of sight, so the interpolation is too
    /// large by at most `h^2 / (8 d)`; several obstacles only make it smaller. Closer than 1.5
    /// cells that bound is worth nothing and the cell's own value less the way to its centre is
    /// taken.
    pub(crate) fn bound_m(&self, x: f32, y: f32) -> f32 {
        let last = (self.side - 2).to_f32();
        let u = (x * self.inverse + self.centre.0).clamp(0.0, last);
        let v = (y * self.inverse + self.centre.1).clamp(0.0, last);
        let (column, row) = (u.to_i32(), v.to_i32());
        let (fu, fv) = (u - column.to_f32(), v - row.to_f32());
        let start = (row * self.side + column).to_usize();
        let below = &self.cells[start..start + 2];
        let above = &self.cells[start + self.side.to_usize()..start + self.side.to_usize() + 2];
        let low = below[0] + (below[1] - below[0]) * fu;
        let high = above[0] + (above[1] - above[0]) * fu;
        let value = low + (high - low) * fv;
        let h = self.resolution_m;
        if value > 1.5 * h {
            value - h * h / (8.0 * (value - core::f32::consts::FRAC_1_SQRT_2 * h))
        } else {
            let (du, dv) = (fu.min(1.0 - fu), fv.min(1.0 - fv));
            let nearest = match (fu < 0.5, fv < 0.5) {
                (true, true) => below[0],
                (false, true) => below[1],
                (true, false) => above[0],
                (false, false) => above[1],
            };
            nearest - (du * du + dv * dv).sqrt() * h
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::print_stdout, reason = "the seed of a failed run")]

    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg32;
    use zeronav_msgs::{Cell, GridGeometry, MapCell};

    /// Distance from a point to the nearest obstacle square or scan point. [m]
    fn truth(
        geometry: &GridGeometry,
        lethal: &[Cell],
        points: &[Point2<f64>],
        at: Point2<f64>,
    ) -> f64 {
        let half = 0.5 * geometry.resolution_m;
        let squares = lethal.iter().map(|cell| {
            let offset = (geometry.centre_of(*cell) - at).abs();
            (offset.x - half).max(0.0).hypot((offset.y - half).max(0.0))
        });
        let points = points.iter().map(|point| (point - at).norm());
        squares.chain(points).fold(f64::INFINITY, f64::min)
    }

    #[test]
    fn the_bound_is_below_the_truth_and_near_it() {
        let geometry = GridGeometry {
            origin_x_m: -3.0,
            origin_y_m: 1.0,
            resolution_m: 0.05,
            width: 120,
            height: 100,
        };
        for seed in 0..20 {
            println!("seed {seed}");
            let mut random = Pcg32::seed_from_u64(seed);
            let lethal: Vec<Cell> = (0..12)
                .map(|_| Cell::new(random.random_range(0..120), random.random_range(0..100)))
                .collect();
            let mut cells = vec![MapCell::default(); geometry.len()];
            for y in 0..100 {
                for x in 0..120 {
                    let cell = Cell::new(x, y);
                    let clearance = truth(&geometry, &lethal, &[], geometry.centre_of(cell));
                    let index = geometry.index_of(cell).expect("inside");
                    cells[index].clearance_mm = (clearance * 1000.0).floor().min(1500.0).to_u16();
                }
            }
            let map = MapView {
                geometry: &geometry,
                cells: &cells,
            };
            let pose = Pose::new(0.03, 3.51, random.random_range(-3.0..3.0));
            let points_in_base: Vec<Point2<f64>> = (0..30)
                .map(|_| {
                    Point2::new(
                        random.random_range(-2.0..2.0),
                        random.random_range(-2.0..2.0),
                    )
                })
                .collect();
            let points: Vec<Point2<f64>> =
                points_in_base.iter().map(|p| pose.transform(*p)).collect();
            let mut field = ClearanceField::default();
            field.fill(Some((map, 1)), &pose, &points_in_base, 1.5, 0.5);
            for _ in 0..2000 {
                let x: f32 = random.random_range(-1.4..1.4);
                let y: f32 = random.random_range(-1.4..1.4);
                let at = Point2::new(pose.x_m + f64::from(x), pose.y_m + f64::from(y));
                let true_m = truth(&geometry, &lethal, &points, at);
                let bound_m = f64::from(field.bound_m(x, y));
                if true_m >= 0.4 {
                    // Points of the scan tell within 0.5 m only.
                    continue;
                }
                assert!(bound_m <= true_m + 1e-4, "{bound_m} > {true_m} at {at}");
                let nearest_m = f64::from(field.nearest_m(x, y));
                assert!(nearest_m <= true_m + f64::from(field.slack_m()) + 1e-4);
                assert!(nearest_m >= true_m - f64::from(field.slack_m()) - 2e-3);
                // Kinks between two obstacles are cut by up to half a cell's diagonal; where the
                // bilinear bound is worth nothing, the way to a centre and back is lost.
                let loss_m = if true_m < 0.12 { 0.075 } else { 0.04 };
                assert!(bound_m >= true_m - loss_m, "{bound_m} << {true_m} at {at}");
            }
        }
    }

    #[test]
    fn a_window_that_stays_tells_what_a_new_one_would() {
        let geometry = GridGeometry {
            resolution_m: 0.05,
            width: 200,
            height: 200,
            ..GridGeometry::default()
        };
        let mut random = Pcg32::seed_from_u64(9);
        let cells: Vec<MapCell> = (0..geometry.len())
            .map(|_| MapCell {
                clearance_mm: random.random_range(100..1500),
                ..MapCell::default()
            })
            .collect();
        let map = MapView {
            geometry: &geometry,
            cells: &cells,
        };
        let in_map: Vec<Point2<f64>> = (0..40)
            .map(|_| Point2::new(random.random_range(3.0..7.0), random.random_range(3.0..7.0)))
            .collect();
        let mut field = ClearanceField::default();
        let mut filled = 0;
        for step in 0..40 {
            let share = f64::from(step);
            let pose = Pose::new(4.0 + 0.03 * share, 5.0 - 0.01 * share, 0.02 * share);
            let from_map = pose.isometry().inverse();
            let points: Vec<Point2<f64>> = in_map.iter().map(|point| from_map * point).collect();
            filled += u32::from(field.fill(Some((map, 1)), &pose, &points, 1.5, 0.5));
            let mut fresh = ClearanceField::default();
            assert!(fresh.fill(Some((map, 1)), &pose, &points, 1.5, 0.5));
            for _ in 0..200 {
                let x: f32 = random.random_range(-1.5..1.5);
                let y: f32 = random.random_range(-1.5..1.5);
                let (kept_m, fresh_m) = (field.bound_m(x, y), fresh.bound_m(x, y));
                assert!((kept_m - fresh_m).abs() < 2e-3, "{kept_m} {fresh_m} {step}");
            }
        }
        // 1.17 m in windows with 0.4 m to spare.
        assert!((2..=4).contains(&filled), "{filled}");
        let pose = Pose::new(5.0, 5.0, 0.0);
        let full = Some((map, 1));
        assert!(field.fill(full, &pose, &in_map, 1.5, 0.5), "other points");
        assert!(!field.fill(full, &pose, &in_map, 1.5, 0.5), "nothing new");
        assert!(field.fill(full, &pose, &in_map[1..], 1.5, 0.5), "one less");
        let changed = Some((map, 2));
        assert!(field.fill(changed, &pose, &in_map[1..], 1.5, 0.5), "cells");
    }

    #[test]
    fn beside_the_map_is_an_obstacle_and_without_a_map_is_not() {
        let geometry = GridGeometry {
            resolution_m: 0.05,
            width: 20,
            height: 20,
            ..GridGeometry::default()
        };
        let cells = vec![
            MapCell {
                clearance_mm: 900,
                ..MapCell::default()
            };
            400
        ];
        let map = MapView {
            geometry: &geometry,
            cells: &cells,
        };
        let mut field = ClearanceField::default();
        field.fill(Some((map, 1)), &Pose::new(0.5, 0.5, 0.0), &[], 1.0, 0.4);
        assert!(field.nearest_m(0.0, 0.0) > 0.8);
        assert!(field.nearest_m(-0.6, 0.0) < 1e-6);
        field.fill(None, &Pose::new(0.5, 0.5, 0.0), &[], 1.0, 0.4);
        assert!(field.nearest_m(-0.6, 0.0) > 100.0);
    }
}
