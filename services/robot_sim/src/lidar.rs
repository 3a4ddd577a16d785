//! The planar lidar: exact ranges to everything solid, then noise ([`crate::returns`]).
//!
//! Shapes are not searched per beam. Each shape says which beams can meet it, from the angle it
//! covers, and only those are computed; the cost follows what is in view, needs no tree that has to
//! be rebuilt for things that move, and is f64 throughout. Cells of a map are walked per beam and
//! only as far as the nearest shape.
//!
//! A lidar whose mirror turns while the robot moves ([`Exposure`] from [`Lidar::sweep`]) casts every
//! beam from where it was at that beam's moment, to where an obstacle was then. Which beams can
//! meet a shape is then asked from the middle of the sweep, with as much slack as anything moved.

use crate::ray::{self, Caster};
use crate::returns::{Return, Returns};
use crate::solid_grid::SolidGrid;
use core::f64::consts::TAU;
use nalgebra::{Point2, Vector2};
use parry2d::math::Vec2;
use parry2d::query::PointQuery;
use zeronav_casts::Cast;
use zeronav_msgs::Pose;
use zeronav_msgs::pose::wrap_angle;
use zeronav_msgs::scan::Scan;
use zeronav_msgs::time::nanoseconds;
use zeronav_robot_description::LidarSpec;
use zeronav_world::Convex;

/// Nothing, as the thing that a beam ended on.
const NOTHING: u32 = u32::MAX;

/// Rounding moves a direction by far less than a hundredth of a beam.
const SLACK_BEAMS: f64 = 0.01;

/// A lidar on a robot.
#[derive(Debug, Clone)]
pub struct Lidar {
    base_from_laser: Pose,
    /// By how much it is turned in its mount. [rad]
    turned_rad: f64,
    scan: Scan,
    range_m_max: f64,
    /// The last beam is the neighbour of the first.
    all_around: bool,
    returns: Returns,
    /// How long before the capture each beam is taken. [ns]
    ages_ns: Vec<u64>,
    /// In `laser`, one per beam.
    directions: Vec<Vector2<f64>>,
    /// Scratch: where each beam begins in `map`.
    origins: Vec<Point2<f64>>,
    /// Scratch: its direction in `map` for the present scan.
    directions_in_map: Vec<Vector2<f64>>,
    /// Scratch: the same as an angle that goes on beyond pi. [rad]
    angles_rad: Vec<f64>,
    /// Scratch: range of each beam before the noise. [m]
    nearest_m: Vec<f64>,
    /// Scratch: tag of what each beam ended on.
    ended_on: Vec<u32>,
    /// Scratch: the same after the noise.
    found: Vec<Return>,
}

/// One scan in the making: add what is solid, then [`Exposure::finish`].
#[derive(Debug)]
pub struct Exposure<'a> {
    lidar: &'a mut Lidar,
    /// Where it is asked from which beams can meet something.
    origin: Point2<f64>,
    /// Direction of `laser` there. [rad]
    yaw_rad: f64,
    order: Order,
}

/// How directions follow from the number of a beam.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Order {
    /// All from one pose: in even steps.
    Still,
    /// From poses within `slack_m` of the origin, still growing.
    Growing { slack_m: f64 },
    /// The robot turns faster than the mirror.
    Any,
}

impl Lidar {
    /// The lidar of `spec`, which [`LidarSpec::check`] accepts; `seed` draws its noise.
    ///
    /// Directions are those that the contract can carry: [`Scan`] has f32 angles, and a beam is
    /// cast exactly where a reader of the scan will see it. The same for the moments of the beams.
    #[must_use]
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        clippy::cast_precision_loss,
        reason = "the contract carries f32; the numbers are read back from it, and a sweep lasts \
                  at most a turn of 10 s"
    )]
    pub fn new(spec: &LidarSpec, seed: u64) -> Self {
        let n_beams = spec.n_beams as usize;
        let (angle_min_rad, angle_increment_rad) = spec.directions_rad();
        let scan = Scan {
            sensor: 0,
            n_beams: spec.n_beams,
            angle_min_rad: angle_min_rad as f32,
            angle_increment_rad: angle_increment_rad as f32,
            time_increment_s: spec.beam_period_s() as f32,
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
        let age_ns = |beam: usize| {
            let beams_later = (n_beams - 1 - beam) as f64;
            nanoseconds(beams_later * f64::from(scan.time_increment_s))
        };
        Self {
            base_from_laser: Pose::new(spec.pose[0], spec.pose[1], spec.pose[2]),
            turned_rad: 0.0,
            scan,
            range_m_max: spec.range_m_max,
            all_around: spec.fov_rad >= TAU - 1.0e-6,
            returns: Returns::new(spec, seed),
            ages_ns: (0..n_beams).map(age_ns).collect(),
            origins: vec![Point2::origin(); n_beams],
            directions_in_map: directions.clone(),
            directions,
            angles_rad: vec![0.0; n_beams],
            nearest_m: vec![f64::INFINITY; n_beams],
            ended_on: vec![NOTHING; n_beams],
            found: vec![Return::NONE; n_beams],
        }
    }

    /// Turns the lidar in its mount, from its own place, by `turned_rad`; nothing that it says of
    /// itself shows it.
    pub const fn turn(&mut self, turned_rad: f64) {
        self.turned_rad = turned_rad;
    }

    /// Where it really looks from.
    fn mounted(&self) -> Pose {
        let mut base_from_laser = self.base_from_laser;
        base_from_laser.yaw_rad += self.turned_rad;
        base_from_laser
    }

    /// `base_from_laser` as it is described.
    #[must_use]
    pub const fn base_from_laser(&self) -> Pose {
        self.base_from_laser
    }

    /// The fixed fields of every scan of this lidar.
    #[must_use]
    pub const fn header(&self) -> Scan {
        self.scan
    }

    /// How long before its capture a scan begins. [ns]
    #[must_use]
    pub fn sweep_ns(&self) -> u64 {
        self.ages_ns.first().copied().unwrap_or(0)
    }

    /// Begins a scan of all beams at once with the robot at `map_from_base`.
    pub fn expose(&mut self, map_from_base: &Pose) -> Exposure<'_> {
        let map_from_laser = map_from_base.then(&self.mounted());
        let (sin, cos) = map_from_laser.yaw_rad.sin_cos();
        self.origins.fill(map_from_laser.point());
        for (in_map, in_laser) in self.directions_in_map.iter_mut().zip(&self.directions) {
            *in_map = Vector2::new(
                cos * in_laser.x - sin * in_laser.y,
                sin * in_laser.x + cos * in_laser.y,
            );
        }
        self.begin(map_from_laser, Order::Still)
    }

    /// Begins a scan with the robot at `map_from_base_at(age)` so many nanoseconds before the
    /// capture.
    pub fn sweep(&mut self, mut map_from_base_at: impl FnMut(u64) -> Pose) -> Exposure<'_> {
        let base_from_laser = self.mounted();
        let mut last_yaw_rad: Option<f64> = None;
        let mut growing = true;
        for beam in 0..self.directions.len() {
            let map_from_laser = map_from_base_at(self.ages_ns[beam]).then(&base_from_laser);
            let (sin, cos) = map_from_laser.yaw_rad.sin_cos();
            let in_laser = self.directions[beam];
            self.origins[beam] = map_from_laser.point();
            self.directions_in_map[beam] = Vector2::new(
                cos * in_laser.x - sin * in_laser.y,
                sin * in_laser.x + cos * in_laser.y,
            );
            // The robot turns by less than half a turn from beam to beam.
            let yaw_rad = match last_yaw_rad {
                Some(last) => last + wrap_angle(map_from_laser.yaw_rad - last),
                None => map_from_laser.yaw_rad,
            };
            last_yaw_rad = Some(yaw_rad);
            self.angles_rad[beam] = yaw_rad + self.scan.angle_of(beam);
            growing &= beam == 0 || self.angles_rad[beam] >= self.angles_rad[beam - 1];
        }
        let middle = map_from_base_at(self.sweep_ns() / 2).then(&base_from_laser);
        let away_m = |at: &Point2<f64>| (at - middle.point()).norm();
        let slack_m = self.origins.iter().map(away_m).fold(0.0, f64::max);
        let order = if growing {
            Order::Growing { slack_m }
        } else {
            Order::Any
        };
        self.begin(middle, order)
    }

    fn begin(&mut self, map_from_laser: Pose, order: Order) -> Exposure<'_> {
        self.nearest_m.fill(f64::INFINITY);
        self.ended_on.fill(NOTHING);
        Exposure {
            origin: map_from_laser.point(),
            yaw_rad: map_from_laser.yaw_rad,
            lidar: self,
            order,
        }
    }
}

impl Exposure<'_> {
    /// Adds a solid shape of the map frame. Beams that end on it are counted under `tag`.
    pub fn add_shape(&mut self, form: &Convex, tag: Option<u32>) {
        let tag = tag.unwrap_or(NOTHING);
        self.each_range(form, 0.0, |exposure, first, end| {
            exposure.add_to_beams(form, tag, first, end);
        });
    }

    /// Adds a solid shape that moves: at the middle of the sweep it is `form`, at no moment more
    /// than `reach_m` away from there (infinite: anywhere), and so many nanoseconds before the
    /// capture it is `at(age)`, `None` while it does not exist.
    pub fn add_moving(
        &mut self,
        form: &Convex,
        reach_m: f64,
        tag: u32,
        at: impl Fn(u64) -> Option<Convex>,
    ) {
        self.each_range(form, reach_m, |exposure, first, end| {
            let lidar = &mut *exposure.lidar;
            for beam in first..end {
                if let Some(form) = at(lidar.ages_ns[beam]) {
                    let caster = Caster::new(&form, lidar.origins[beam]);
                    lidar.note(beam, &caster, tag);
                }
            }
        });
    }

    /// Adds the occupied cells of a map. Cheapest after the shapes, which end many beams early.
    pub fn add_grid(&mut self, grid: &SolidGrid) {
        let lidar = &mut *self.lidar;
        let beams = lidar.nearest_m.iter_mut().zip(&mut lidar.ended_on);
        let rays = lidar.origins.iter().zip(&lidar.directions_in_map);
        for ((nearest_m, ended_on), (origin, direction)) in beams.zip(rays) {
            let limit_m = nearest_m.min(lidar.range_m_max);
            if let Some(range_m) = grid.cast(*origin, *direction, limit_m)
                && range_m < *nearest_m
            {
                *nearest_m = range_m;
                *ended_on = NOTHING;
            }
        }
    }

    /// Writes the ranges of scan `scan_index` and counts at `beams_on[tag]` the beams that ended
    /// on each tagged shape and gave a range of it; tags beyond `beams_on` are not counted.
    ///
    /// # Panics
    /// When `ranges` has not one place per beam.
    pub fn finish(self, scan_index: u64, ranges: &mut [f32], beams_on: &mut [u32]) -> Scan {
        let lidar = self.lidar;
        assert!(
            ranges.len() == lidar.directions.len(),
            "one range per beam: {} for {} beams",
            ranges.len(),
            lidar.directions.len()
        );
        let (true_m, found) = (&lidar.nearest_m, &mut lidar.found);
        let all_around = lidar.all_around;
        lidar.returns.of_scan(scan_index, true_m, all_around, found);
        for ((range, found), ended_on) in ranges.iter_mut().zip(found).zip(&lidar.ended_on) {
            *range = found.range_m.to_f32();
            if found.genuine
                && let Some(count) = beams_on.get_mut(*ended_on as usize)
            {
                *count += 1;
            }
        }
        lidar.scan
    }

    /// Calls `add` with first and end of the beams that can meet something within `reach_m` of
    /// `form`.
    fn each_range(&mut self, form: &Convex, reach_m: f64, add: impl Fn(&mut Self, usize, usize)) {
        let n_beams = self.lidar.directions.len();
        let slack_m = match self.order {
            Order::Still => reach_m,
            Order::Growing { slack_m } => slack_m + reach_m,
            Order::Any => f64::INFINITY,
        };
        if slack_m.is_infinite() {
            return add(self, 0, n_beams);
        }
        let origin = Vec2::from(self.origin.coords);
        let away_m = form.bounds().distance_to_local_point(origin, true);
        if away_m > self.lidar.range_m_max + slack_m {
            return;
        }
        let Some((low_rad, high_rad)) = ray::covered_angle(form, self.origin, slack_m) else {
            return add(self, 0, n_beams);
        };
        let width_rad = high_rad - low_rad;
        if self.order == Order::Still {
            let low_rad = wrap_angle(low_rad - self.yaw_rad);
            for turn in [-TAU, 0.0, TAU] {
                let (first, end) = self.beams_between(low_rad + turn, low_rad + turn + width_rad);
                add(self, first, end);
            }
            return;
        }
        let angles_rad = &self.lidar.angles_rad;
        let (Some(begin_rad), Some(end_rad)) = (angles_rad.first(), angles_rad.last()) else {
            return;
        };
        let (begin_rad, end_rad) = (*begin_rad, *end_rad);
        // The first turn in which it is not yet over when the sweep begins.
        let slack_rad = SLACK_BEAMS * f64::from(self.lidar.scan.angle_increment_rad);
        let turns = ((begin_rad - slack_rad - high_rad) / TAU).ceil();
        let mut low_rad = low_rad + turns * TAU - slack_rad;
        while low_rad <= end_rad {
            let angles_rad = &self.lidar.angles_rad;
            let first = angles_rad.partition_point(|angle_rad| *angle_rad < low_rad);
            let until_rad = low_rad + width_rad + 2.0 * slack_rad;
            let end = angles_rad.partition_point(|angle_rad| *angle_rad <= until_rad);
            add(self, first, end);
            low_rad += TAU;
        }
    }

    /// The beams that point between two directions of the `laser` frame, as first and end.
    fn beams_between(&self, low_rad: f64, high_rad: f64) -> (usize, usize) {
        let scan = &self.lidar.scan;
        let beam_at = |angle_rad: f64| {
            (angle_rad - f64::from(scan.angle_min_rad)) / f64::from(scan.angle_increment_rad)
        };
        let first = (beam_at(low_rad) - SLACK_BEAMS).ceil().max(0.0).to_usize();
        let end = (beam_at(high_rad) + SLACK_BEAMS + 1.0)
            .floor()
            .max(0.0)
            .to_usize();
        (first, end.min(self.lidar.directions.len()))
    }

    fn add_to_beams(&mut self, form: &Convex, tag: u32, first: usize, end: usize) {
        if first >= end {
            return;
        }
        let lidar = &mut *self.lidar;
        if self.order == Order::Still {
            let caster = Caster::new(form, self.origin);
            for beam in first..end {
                lidar.note(beam, &caster, tag);
            }
            return;
        }
        for beam in first..end {
            let caster = Caster::new(form, lidar.origins[beam]);
            lidar.note(beam, &caster, tag);
        }
    }
}

impl Lidar {
    /// Ends `beam` on the shape of `caster`, if that is nearer than what it ended on.
    fn note(&mut self, beam: usize, caster: &Caster, tag: u32) {
        if let Some(range_m) = caster.cast(self.directions_in_map[beam], self.nearest_m[beam])
            && range_m < self.nearest_m[beam]
        {
            self.nearest_m[beam] = range_m;
            self.ended_on[beam] = tag;
        }
    }
}

#[cfg(test)]
mod tests;
