//! Where the robot is, judged by how well its scan lies on the map.
//!
//! The pose is the most likely one given where odometry says the robot went and how far the ends of
//! the beams lie from the map's surfaces: Gauss and Newton on the sum of squared distances, as in
//! Kohlbrecher et al., "A Flexible and Scalable SLAM System with Full 3D Motion Estimation", 2011
//! (eq. 7 to 13, with distances instead of occupancies, which pull from farther away), with the
//! odometry's prediction as a prior, so that along a bare corridor nothing is made up, and with
//! weights that let go of what is not on the map (Geman, `McClure`, 1987).

use crate::clearance::ClearanceField;
use crate::hit_means::{BeamEnd, HitMeans, HitsMean, Surface};
use crate::rows_around::{around, cell_at};
use nalgebra::{Matrix3, Point2, Vector2, Vector3};
use zeronav_casts::Cast;
use zeronav_msgs::pose::wrap_angle;
use zeronav_msgs::{Cell, CellRect, GridGeometry, Pose};

/// How far from a surface a point still says something. [m]
const REACH_M: f64 = 0.5;

/// Most points that are used; of more, every n-th.
const POINTS_MAX: usize = 180;

/// How far from a surface a point is used as long as most lie nearer at the predicted pose, in cells:
/// what has just come into view beyond the end of a known wall would be pulled towards that end.
const HELD_CELLS: f64 = 2.0;

/// What the points are worth, in independent ones: neighbours share their errors.
const POINTS_WORTH: f64 = 40.0;

/// Standard deviation of a point's distance to its surface, in cells, for cell and sensor
/// together.
const SIGMA_CELLS: f64 = 1.0;

/// Distance at which a point's weight is a quarter. [m]
const LETS_GO_M: f64 = 0.15;

/// Share of the points that must lie near a surface for the scan to say anything.
const NEAR_SHARE_MIN: f64 = 0.3;

/// Fewest points near a surface: of fewer, what is wrong with one decides.
const NEAR_MIN: f64 = 20.0;

/// What a point laid on earlier hits is worth beside one on the static map: they were seen from poses that
/// had drifted about as far, and tell the same at every scan.
const HITS_WORTH: f64 = 0.25;

/// Steps of Gauss and Newton after which surfaces are looked up again.
const LOOKS_EVERY: usize = 4;

/// Steps of Gauss and Newton.
const STEPS_MAX: usize = 10;

/// Distances to the surfaces that scans are laid on: the visible cells of the static map, and what
/// scans found.
#[derive(Debug)]
pub struct Surfaces {
    geometry: GridGeometry,
    field: ClearanceField,
    /// Distance to the nearest surface by its square in half cells. [m]
    distance_m: Vec<f64>,
    /// Where scans ended on what the static map does not hold.
    means: HitMeans,
}

/// Sums of the normal equations in x, y and yaw.
#[derive(Debug, Default)]
struct Pulls {
    normal: Matrix3<f64>,
    right: Vector3<f64>,
    /// What of `normal` the static map tells.
    told: Matrix3<f64>,
}

impl Pulls {
    /// A point, `turned` from `base` into the axes of the map, lies `off_m` off along `axis`.
    fn add(&mut self, turned: &Vector2<f64>, axis: &Vector2<f64>, off_m: f64, worth: f64) {
        let row = Vector3::new(axis.x, axis.y, axis.y * turned.x - axis.x * turned.y);
        let weight = worth * (1.0 + (off_m / LETS_GO_M).powi(2)).powi(-2);
        self.normal += row * row.transpose() * weight;
        self.right += row * (weight * off_m);
    }

    /// Such a point lies so far off a cell, which may be one of the static map.
    fn add_cell(
        &mut self,
        turned: &Vector2<f64>,
        axis: &Vector2<f64>,
        off_m: f64,
        is_static: bool,
    ) {
        let before = self.normal;
        self.add(turned, axis, off_m, 1.0);
        if is_static {
            self.told += self.normal - before;
        }
    }

    /// Such a point lies at `at`, on a surface of earlier hits; one on a cell has `sigma_m`.
    fn add_surface(
        &mut self,
        turned: &Vector2<f64>,
        at: Point2<f64>,
        surface: &Surface,
        sigma_m: f64,
    ) {
        for (axis, variance) in surface.axes() {
            let worth = HITS_WORTH * sigma_m * sigma_m / variance;
            self.add(turned, &axis, (at - surface.mean).dot(&axis), worth);
        }
    }
}

/// What a match came to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Match {
    /// `map_from_base`.
    pub pose: Pose,
    /// Of (x, y, yaw). [m^2, m rad, rad^2]
    pub covariance: Matrix3<f64>,
    /// What the static map told, as the inverse of a covariance; 0 where it told nothing.
    pub told: Matrix3<f64>,
}

impl Surfaces {
    /// The surfaces of what `is_obstacle` says about every cell.
    #[must_use]
    pub fn new(geometry: &GridGeometry, is_obstacle: impl Fn(usize) -> bool) -> Self {
        let mut field = ClearanceField::new(geometry, REACH_M / geometry.resolution_m);
        let (width, height) = geometry.size();
        let blocked = |x: i32, y: i32| geometry.index_of(Cell::new(x, y)).map(&is_obstacle);
        for y in 0..height {
            for x in 0..width {
                let beside = [(1, 0), (-1, 0), (0, 1), (0, -1)];
                let is_surface = blocked(x, y) == Some(true)
                    && beside
                        .iter()
                        .any(|(dx, dy)| blocked(x + dx, y + dy) == Some(false));
                if let (true, Some(index)) = (is_surface, geometry.index_of(Cell::new(x, y))) {
                    field.set(index, true);
                }
            }
        }
        field.recompute_all();
        let half_cell_m = 0.5 * geometry.resolution_m;
        let half_cells = 2 * field.reach() + 1;
        let distance_m = (0..=2 * half_cells * half_cells)
            .map(|square| (f64::from(square).sqrt() * half_cell_m).min(REACH_M))
            .collect();
        Self {
            geometry: *geometry,
            field,
            distance_m,
            means: HitMeans::new(geometry),
        }
    }

    /// True when the cell at `index` is a surface.
    #[must_use]
    pub fn is_surface(&self, index: usize) -> bool {
        self.field.is_obstacle(index)
    }

    /// Takes in where beams ended on what the static map does not hold. [cells]
    pub(crate) fn take_in(&mut self, ends: &[BeamEnd]) {
        for end in ends {
            self.means.add(end);
        }
    }

    /// Takes over where beams ended on the map that this one is `shift` cells off.
    pub(crate) fn take_over(&mut self, other: &Self, shift: Cell) {
        other.means.copy_to(&mut self.means, shift);
    }

    /// Takes in the surfaces of which it is not known where beams ended, those whose index `which` holds.
    pub(crate) fn add_cells(&mut self, which: impl Fn(usize) -> bool) {
        for index in (0..self.geometry.len()).filter(|index| which(*index)) {
            if self.field.is_obstacle(index) {
                self.means.add_cell(cell_at(&self.geometry, index));
            }
        }
    }

    /// Forgets where beams ended in the cell at `index`, unless there is a surface beside it.
    pub(crate) fn forget(&mut self, index: usize) {
        let cell = cell_at(&self.geometry, index);
        let mut beside = around(cell).filter_map(|cell| self.geometry.index_of(cell));
        if !beside.any(|index| self.field.is_obstacle(index)) {
            self.means.forget(cell);
        }
    }

    /// Forgets where beams have ended.
    pub(crate) fn forget_hits(&mut self) {
        self.means.clear();
    }

    /// Says whether the cell at `index` is a surface.
    pub fn set(&mut self, index: usize, surface: bool) {
        if self.field.is_obstacle(index) == surface {
            return;
        }
        self.field.set(index, surface);
        let cell = cell_at(&self.geometry, index);
        if surface {
            self.field.add(cell);
        } else {
            let here = CellRect {
                min: cell,
                max: Cell::new(cell.x + 1, cell.y + 1),
            };
            let around = here.grown(self.field.reach(), &self.geometry);
            self.field.recompute(&around);
        }
    }

    /// The pose near `predicted`, known to `covariance`, at which the ends of the beams, in `base`
    /// [m], lie best; `None` when too few of them lie anywhere near. `is_static` says whether what is seen
    /// at a point of the map belongs to the static map.
    ///
    /// As long as most points lie near surfaces, points on the static map are drawn to its cells, and the
    /// others to where scans have really ended there ([`HitMeans`]).
    #[must_use]
    pub fn lay(
        &self,
        ends: &[Point2<f64>],
        predicted: &Pose,
        covariance: &Matrix3<f64>,
        is_static: impl Fn(Point2<f64>) -> bool,
    ) -> Option<Match> {
        let every = ends.len().div_ceil(POINTS_MAX).max(1);
        let points = || ends.iter().step_by(every);
        let prior = covariance.try_inverse()?;
        let at_start = Vector3::new(predicted.x_m, predicted.y_m, predicted.yaw_rad);
        let mut at = at_start;
        let mut information = prior;
        let mut told = Matrix3::zeros();
        let sigma_m = SIGMA_CELLS * self.geometry.resolution_m;
        let held_m = HELD_CELLS * self.geometry.resolution_m;
        let is_held = self.is_held(points(), predicted, held_m);
        let reach_m = if is_held { held_m } else { REACH_M };
        let mut seen = [HitsMean::Nothing; POINTS_MAX];
        for step in 0..STEPS_MAX {
            let (sin, cos) = at.z.sin_cos();
            let mut pulls = Pulls::default();
            let (mut n, mut near) = (0.0, 0.0);
            for (point, seen) in points().zip(&mut seen) {
                n += 1.0;
                let turned =
                    Vector2::new(cos * point.x - sin * point.y, sin * point.x + cos * point.y);
                let there = Point2::new(at.x + turned.x, at.y + turned.y);
                let Some((distance_m, slope)) = self.distance(there) else {
                    continue;
                };
                near += 1.0;
                if distance_m > reach_m {
                    continue;
                }
                if is_held && step % LOOKS_EVERY == 0 {
                    let look = || self.means.near(there, -turned);
                    *seen = if is_static(there) {
                        HitsMean::Nothing
                    } else {
                        look()
                    };
                }
                match seen {
                    HitsMean::Surface(surface) => {
                        pulls.add_surface(&turned, there, surface, sigma_m);
                    }
                    HitsMean::Nothing if !is_held || is_static(there) => {
                        pulls.add_cell(&turned, &slope, distance_m, is_static(there));
                    }
                    HitsMean::Nothing | HitsMean::Unclear => {}
                }
            }
            if near < (NEAR_SHARE_MIN * n).max(NEAR_MIN) {
                return None;
            }
            let worth = (POINTS_WORTH / n).min(1.0) / (sigma_m * sigma_m);
            information = prior + pulls.normal * worth;
            told = pulls.told * worth;
            let off = prior * (at - at_start) + pulls.right * worth;
            let change = information.try_inverse()? * off;
            at -= change;
            if change.norm() < 1.0e-5 {
                break;
            }
        }
        let pose = Pose::new(at.x, at.y, wrap_angle(at.z));
        // What has come into view beside known surfaces is no reason to move for a robot that knows where it is.
        let is_known = covariance[(0, 0)].max(covariance[(1, 1)]) < held_m * held_m;
        if is_known && !is_held && !self.is_held(points(), &pose, held_m) {
            return None;
        }
        Some(Match {
            pose,
            covariance: information.try_inverse()?,
            told,
        })
    }

    /// Where they lie.
    pub(crate) fn geometry(&self) -> &GridGeometry {
        &self.geometry
    }

    /// Distance of a point of the map to the nearest surface, at most [`REACH_M`], which counts beside
    /// the map, too. [m]
    pub(crate) fn distance_m(&self, at: Point2<f64>) -> f64 {
        let index = self.geometry.index_of(self.geometry.unbounded_cell_at(at));
        index.map_or(REACH_M, |index| {
            let square = usize::from(self.field.squares()[index].unsigned_abs());
            self.distance_m.get(square).copied().unwrap_or(REACH_M)
        })
    }

    /// True when most of the points that lie near a surface at `pose` lie within `held_m` of it.
    fn is_held<'a>(
        &self,
        points: impl Iterator<Item = &'a Point2<f64>>,
        pose: &Pose,
        held_m: f64,
    ) -> bool {
        let (sin, cos) = pose.yaw_rad.sin_cos();
        let (mut near, mut held) = (0_u32, 0_u32);
        for point in points {
            let at = Point2::new(
                pose.x_m + cos * point.x - sin * point.y,
                pose.y_m + sin * point.x + cos * point.y,
            );
            if let Some((distance_m, _)) = self.distance(at) {
                near += 1;
                held += u32::from(distance_m <= held_m);
            }
        }
        2 * held >= near
    }

    /// Distance to the nearest surface and its slope, between four cells' centres; `None` beside
    /// the map and where there is no surface within reach.
    fn distance(&self, at: Point2<f64>) -> Option<(f64, Vector2<f64>)> {
        let geometry = &self.geometry;
        let per_m = 1.0 / geometry.resolution_m;
        let x = (at.x - geometry.origin_x_m) * per_m - 0.5;
        let y = (at.y - geometry.origin_y_m) * per_m - 0.5;
        let (column, row) = (x.floor(), y.floor());
        let low = Cell::new(column.to_i32(), row.to_i32());
        let lower = geometry.index_of(low)?;
        geometry.index_of(Cell::new(low.x + 1, low.y + 1))?;
        let upper = lower + geometry.width as usize;
        let d = |index: usize| {
            let square = usize::from(self.field.squares()[index].unsigned_abs());
            self.distance_m.get(square).copied().unwrap_or(REACH_M)
        };
        let (a, b, c, e) = (d(lower), d(lower + 1), d(upper), d(upper + 1));
        if a.min(b).min(c).min(e) >= REACH_M {
            return None;
        }
        let (fx, fy) = (x - column, y - row);
        let (below, above) = (a + fx * (b - a), c + fx * (e - c));
        let slope = Vector2::new((b - a) + fy * ((e - c) - (b - a)), above - below) * per_m;
        Some((below + fy * (above - below), slope))
    }
}
