//! The planar lidar: exact ranges to everything solid, then Gaussian noise.
//!
//! Shapes are not searched per beam. Each shape says which beams can meet it, from the angle it
//! covers, and only those are computed; the cost follows what is in view, needs no tree that has to
//! be rebuilt for things that move, and is f64 throughout. Cells of a map are walked per beam and
//! only as far as the nearest shape.

use crate::noise::RangeNoise;
use crate::ray::{self, Caster};
use crate::solid_grid::SolidGrid;
use core::f64::consts::TAU;
use nalgebra::{Point2, Vector2};
use parry2d::math::Vec2;
use parry2d::query::PointQuery;
use zeronav_msgs::Pose;
use zeronav_msgs::pose::wrap_angle;
use zeronav_msgs::scan::Scan;
use zeronav_world::{Convex, LidarSpec};

/// Nothing, as the thing that a beam ended on.
const NOTHING: u32 = u32::MAX;

/// A lidar on a robot.
#[derive(Debug, Clone)]
pub struct Lidar {
    base_from_laser: Pose,
    scan: Scan,
    range_m_min: f64,
    range_m_max: f64,
    noise: RangeNoise,
    /// In `laser`, one per beam.
    directions: Vec<Vector2<f64>>,
    /// Scratch: the same in `map` for the present scan.
    directions_in_map: Vec<Vector2<f64>>,
    /// Scratch: range of each beam before the noise. [m]
    nearest_m: Vec<f64>,
    /// Scratch: tag of what each beam ended on.
    ended_on: Vec<u32>,
}

/// One scan in the making: add what is solid, then [`Exposure::finish`].
#[derive(Debug)]
pub struct Exposure<'a> {
    lidar: &'a mut Lidar,
    origin: Point2<f64>,
    yaw_rad: f64,
}

impl Lidar {
    /// The lidar of `spec`, which [`LidarSpec::check`] accepts; `seed` draws its noise.
    ///
    /// Directions are those that the contract can carry: [`Scan`] has f32 angles, and a beam is
    /// cast exactly where a reader of the scan will see it.
    #[must_use]
    #[allow(
        clippy::cast_possible_truncation,
        reason = "the contract carries f32; the angles are read back from it"
    )]
    pub fn new(spec: &LidarSpec, seed: u64) -> Self {
        let n_beams = spec.n_beams as usize;
        let (angle_min_rad, angle_increment_rad) = spec.directions_rad();
        let scan = Scan {
            sensor: 0,
            n_beams: spec.n_beams,
            angle_min_rad: angle_min_rad as f32,
            angle_increment_rad: angle_increment_rad as f32,
            time_increment_s: 0.0,
            range_m_min: spec.range_m_min as f32,
            range_m_max: spec.range_m_max as f32,
            spare: 0,
        };
        let directions: Vec<Vector2<f64>> = (0..n_beams)
            .map(|beam| {
                let (sin, cos) = scan.angle_of(beam).sin_cos();
                Vector2::new(cos, sin)
            })
            .collect();
        Self {
            base_from_laser: Pose::new(spec.pose[0], spec.pose[1], spec.pose[2]),
            scan,
            range_m_min: spec.range_m_min,
            range_m_max: spec.range_m_max,
            noise: RangeNoise::new(seed, spec.sigma_m),
            directions_in_map: directions.clone(),
            directions,
            nearest_m: vec![f64::INFINITY; n_beams],
            ended_on: vec![NOTHING; n_beams],
        }
    }

    /// `base_from_laser`.
    #[must_use]
    pub const fn base_from_laser(&self) -> Pose {
        self.base_from_laser
    }

    /// The fixed fields of every scan of this lidar.
    #[must_use]
    pub const fn header(&self) -> Scan {
        self.scan
    }

    /// Begins a scan of a robot that stands at `map_from_base`. All beams are captured at once.
    pub fn expose(&mut self, map_from_base: &Pose) -> Exposure<'_> {
        let map_from_laser = map_from_base.then(&self.base_from_laser);
        let (sin, cos) = map_from_laser.yaw_rad.sin_cos();
        for (in_map, in_laser) in self.directions_in_map.iter_mut().zip(&self.directions) {
            *in_map = Vector2::new(
                cos * in_laser.x - sin * in_laser.y,
                sin * in_laser.x + cos * in_laser.y,
            );
        }
        self.nearest_m.fill(f64::INFINITY);
        self.ended_on.fill(NOTHING);
        Exposure {
            origin: map_from_laser.point(),
            yaw_rad: map_from_laser.yaw_rad,
            lidar: self,
        }
    }
}

impl Exposure<'_> {
    /// Adds a solid shape of the map frame. Beams that end on it are counted under `tag`.
    pub fn add_shape(&mut self, form: &Convex, tag: Option<u32>) {
        let tag = tag.unwrap_or(NOTHING);
        let origin = Vec2::from(self.origin.coords);
        if form.bounds().distance_to_local_point(origin, true) > self.lidar.range_m_max {
            return;
        }
        let Some((low_rad, high_rad)) = ray::covered_angle(form, self.origin) else {
            self.add_to_beams(form, tag, 0, self.lidar.directions.len());
            return;
        };
        let width_rad = high_rad - low_rad;
        let low_rad = wrap_angle(low_rad - self.yaw_rad);
        for turn in [-TAU, 0.0, TAU] {
            let (first, end) = self.beams_between(low_rad + turn, low_rad + turn + width_rad);
            self.add_to_beams(form, tag, first, end);
        }
    }

    /// Adds the occupied cells of a map. Cheapest after the shapes, which end many beams early.
    pub fn add_grid(&mut self, grid: &SolidGrid) {
        let lidar = &mut *self.lidar;
        let beams = lidar.nearest_m.iter_mut().zip(&mut lidar.ended_on);
        for ((nearest_m, ended_on), direction) in beams.zip(&lidar.directions_in_map) {
            let limit_m = nearest_m.min(lidar.range_m_max);
            if let Some(range_m) = grid.cast(self.origin, *direction, limit_m)
                && range_m < *nearest_m
            {
                *nearest_m = range_m;
                *ended_on = NOTHING;
            }
        }
    }

    /// Writes the ranges of scan `scan_index` and counts at `beams_on[tag]` the beams that ended
    /// on each tagged shape and gave a range; tags beyond `beams_on` are not counted.
    ///
    /// A range is the distance plus noise; NaN closer than the sensor's limit, +inf when nothing is
    /// within its reach. A lidar inside something solid sees nothing but NaN.
    ///
    /// # Panics
    /// When `ranges` has not one place per beam.
    #[allow(
        clippy::cast_possible_truncation,
        reason = "the contract carries f32 ranges"
    )]
    pub fn finish(self, scan_index: u64, ranges: &mut [f32], beams_on: &mut [u32]) -> Scan {
        let lidar = self.lidar;
        assert!(
            ranges.len() == lidar.directions.len(),
            "one range per beam: {} for {} beams",
            ranges.len(),
            lidar.directions.len()
        );
        let mut errors_m = lidar.noise.of_scan(scan_index);
        for (beam, range) in ranges.iter_mut().enumerate() {
            let true_m = lidar.nearest_m[beam];
            let seen_m = true_m + errors_m.next_m();
            *range = if true_m > lidar.range_m_max || seen_m > lidar.range_m_max {
                f32::INFINITY
            } else if true_m == 0.0 || seen_m < lidar.range_m_min {
                f32::NAN
            } else {
                if let Some(count) = beams_on.get_mut(lidar.ended_on[beam] as usize) {
                    *count += 1;
                }
                seen_m as f32
            };
        }
        lidar.scan
    }

    /// The beams that point between two directions of the `laser` frame, as first and end.
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "float to int saturates, and both are cut to the beams"
    )]
    fn beams_between(&self, low_rad: f64, high_rad: f64) -> (usize, usize) {
        // Rounding moves a direction by far less than a hundredth of a beam.
        const SLACK_BEAMS: f64 = 0.01;
        let scan = &self.lidar.scan;
        let beam_at = |angle_rad: f64| {
            (angle_rad - f64::from(scan.angle_min_rad)) / f64::from(scan.angle_increment_rad)
        };
        let first = (beam_at(low_rad) - SLACK_BEAMS).ceil().max(0.0) as usize;
        let end = (beam_at(high_rad) + SLACK_BEAMS + 1.0).floor().max(0.0) as usize;
        (first, end.min(self.lidar.directions.len()))
    }

    fn add_to_beams(&mut self, form: &Convex, tag: u32, first: usize, end: usize) {
        if first >= end {
            return;
        }
        let caster = Caster::new(form, self.origin);
        let lidar = &mut *self.lidar;
        let beams = lidar.nearest_m[first..end]
            .iter_mut()
            .zip(&mut lidar.ended_on[first..end])
            .zip(&lidar.directions_in_map[first..end]);
        for ((nearest_m, ended_on), direction) in beams {
            if let Some(range_m) = caster.cast(*direction, *nearest_m)
                && range_m < *nearest_m
            {
                *nearest_m = range_m;
                *ended_on = tag;
            }
        }
    }
}

#[cfg(test)]
mod tests;
