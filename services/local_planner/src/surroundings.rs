//! What is near the robot, and whether a pose or a stop is free of it.

use crate::dynamic_obstacles::DynamicObstacles;
use crate::field::ClearanceField;
use crate::footprint::Footprint;
use crate::lanes::data::narrow;
use crate::past_hits::Hit;
use crate::squares::Squares;
use nalgebra::{Point2, Vector2};
use zeronav_motion::{Stop, Twist};
use zeronav_msgs::description::{Corner, Description};
use zeronav_msgs::{MapView, Pose};

/// [m] that must be left even where the full margin is not to be had.
const MARGIN_LEAST_M: f64 = 0.005;

/// [m] by which a robot inside the margin may come nearer in one check: noise, not motion.
const MARGIN_NOISE_M: f64 = 0.002;

/// [m] by which any point of the outline moves from one checked pose of a stop to the next.
const STOP_SPACING_M: f64 = 0.03;

/// [m/s] up to which and [rad/s] from which a robot turns rather than drives.
const TURNING_MPS: f64 = 0.15;
const TURNING_RADPS: f64 = 0.1;

/// [s] between two looks at a robot that stands.
const STANDING_STEP_S: f64 = 0.05;

/// For so many steps of [s] a turn keeps clear of what comes.
const COMING_STEPS: u32 = 6;
const COMING_STEP_S: f64 = 0.1;

/// Map and scan around the robot, and its outline.
#[derive(Debug, Clone)]
pub(crate) struct Surroundings {
    pub(crate) field: ClearanceField,
    pub(crate) footprint: Footprint,
    described: (Description, Vec<Corner>),
    /// Points of the scan that a stop can reach, in `base`. [m]
    near_x: Vec<f64>,
    near_y: Vec<f64>,
    /// Obstacle cells that a stop can reach; for an outline with corners.
    squares: Squares,
    yaw_rad: f64,
    /// Margin that motions of this period must keep. [m]
    need_m: f64,
}

/// A motion's position relative to the robot along the map's axes, with its heading there.
#[derive(Debug, Clone, Copy)]
pub(crate) struct LocalPose {
    /// [m]
    pub(crate) x: f32,
    /// [m]
    pub(crate) y: f32,
    /// Cosine of the yaw in the map.
    pub(crate) cos: f32,
    /// Sine of the yaw in the map.
    pub(crate) sin: f32,
}

impl Default for Surroundings {
    fn default() -> Self {
        let robot = Description::default();
        Self {
            field: ClearanceField::default(),
            footprint: Footprint::new(&robot, &[]),
            described: (robot, Vec::new()),
            near_x: Vec::new(),
            near_y: Vec::new(),
            squares: Squares::default(),
            yaw_rad: 0.0,
            need_m: 0.0,
        }
    }
}

/// Reach of the queries of one period.
#[derive(Debug, Clone, Copy)]
#[allow(clippy::struct_field_names, reason = "the postfix is the unit")]
pub(crate) struct Reach {
    /// [m] how far any queried position is from the robot.
    pub(crate) field_m: f64,
    /// [m] how far a stop takes the robot at most.
    pub(crate) stop_m: f64,
    /// [m] around the outline within which clearance matters.
    pub(crate) soft_m: f64,
    /// [m] that shall stay free around the outline.
    pub(crate) margin_m: f64,
}

impl Surroundings {
    /// Takes in the robot; the outline is prepared again only when it changed.
    pub(crate) fn describe(&mut self, robot: &Description, corners: &[Corner]) {
        if self.described.0 != *robot || self.described.1 != corners {
            self.described = (*robot, corners.to_vec());
            self.footprint = Footprint::new(robot, corners);
        }
    }

    /// Looks around: after this the queries are as of `map_from_base`. The number beside the map
    /// grows when its cells change. Stops are checked against
    /// all points and the hits of scans before them; the points of `stamped_in_base`, normally the same,
    /// lower the clearance field.
    pub(crate) fn look(
        &mut self,
        map: Option<(MapView<'_>, u64)>,
        map_from_base: &Pose,
        (points_in_base, past_in_base): (&[Point2<f64>], &[Hit]),
        stamped_in_base: &[Point2<f64>],
        reach: Reach,
    ) {
        let outer_m = self.footprint.circumscribed_m;
        self.field.fill(
            map,
            map_from_base,
            stamped_in_base,
            reach.field_m + outer_m + reach.soft_m,
            // A cell's diagonal more than is ever compared with.
            outer_m + reach.soft_m + 0.15,
        );
        self.yaw_rad = map_from_base.yaw_rad;
        self.near_x.clear();
        self.near_y.clear();
        let near_m = reach.stop_m + outer_m + reach.margin_m;
        let past = past_in_base.iter().map(|hit| &hit.at);
        for point in points_in_base.iter().chain(past) {
            if point.coords.norm_squared() <= near_m * near_m {
                self.near_x.push(point.x);
                self.near_y.push(point.y);
            }
        }
        if !self.footprint.is_disc() {
            self.squares((points_in_base, past_in_base), near_m);
        }
        let now_m = self.margin_m(&Pose::default());
        // Inside the margin already: no nearer; inside the outline: only away.
        self.need_m = if now_m >= reach.margin_m {
            reach.margin_m
        } else if now_m >= MARGIN_LEAST_M {
            (now_m - MARGIN_NOISE_M).max(MARGIN_LEAST_M)
        } else {
            now_m - 1.0e-4
        };
    }

    /// Finds the obstacle cells within `reach_m` of the robot that no scan measures.
    fn squares(&mut self, (points, past): (&[Point2<f64>], &[Hit]), reach_m: f64) {
        let along_axes = Pose::new(0.0, 0.0, self.yaw_rad);
        let lidar = self.described.0.base_from_laser.point();
        let hits = points.iter().map(|at| Hit::of(lidar, *at));
        let hits = hits.chain(past.iter().copied());
        let hits = hits.map(|hit| hit.in_parent(&along_axes));
        self.squares.fill(&self.field.sheet(), reach_m, hits);
    }

    /// Margin that motions of this period must keep. [m]
    pub(crate) const fn need_m(&self) -> f64 {
        self.need_m
    }

    /// Space around the outline at a pose in the `base` of now: exact for the points of the scan and,
    /// with corners, for the cells of the map; for a disc a bound from below for the map. [m]
    fn margin_m(&self, pose: &Pose) -> f64 {
        let map_m = if self.footprint.is_disc() {
            f64::from(self.field_margin_m(self.local(pose)))
        } else {
            self.squares_m(pose, f64::INFINITY)
        };
        map_m.min(self.scan_margin_m(pose))
    }

    /// True when the outline keeps the margin of this period at a pose in the `base` of now.
    pub(crate) fn keeps_margin(&self, pose: &Pose) -> bool {
        let is_free = self.space(self.local(pose), 0.0).is_some()
            || !self.footprint.is_disc() && self.squares_m(pose, self.need_m) >= self.need_m;
        is_free && self.scan_keeps(pose)
    }

    /// Space between the outline at a pose in the `base` of now and the obstacle cells, as far as it is
    /// less than `enough_m`. [m]
    fn squares_m(&self, pose: &Pose, enough_m: f64) -> f64 {
        let (half_m, at) = (self.squares.half_m, self.local(pose));
        let (x, y) = (f64::from(at.x), f64::from(at.y));
        let (cos, sin) = (f64::from(at.cos), f64::from(at.sin));
        // Half of a diagonal from a square's centre to its corners.
        let around_m = self.footprint.circumscribed_m + core::f64::consts::SQRT_2 * half_m;
        let mut least_m = enough_m;
        for centre in &self.squares.centres {
            let (dx, dy) = (centre.x - x, centre.y - y);
            if dx.hypot(dy) - around_m < least_m {
                let in_base = Point2::new(cos * dx + sin * dy, cos * dy - sin * dx);
                let side = Vector2::new(cos, -sin);
                let space_m = self.footprint.square_distance_m(in_base, side, half_m);
                least_m = least_m.min(space_m);
            }
        }
        least_m
    }

    /// A pose in the `base` of now as the clearance field takes it.
    fn local(&self, pose: &Pose) -> LocalPose {
        let (sin, cos) = (self.yaw_rad + pose.yaw_rad).sin_cos();
        let (base_sin, base_cos) = self.yaw_rad.sin_cos();
        LocalPose {
            x: narrow(base_cos * pose.x_m - base_sin * pose.y_m),
            y: narrow(base_sin * pose.x_m + base_cos * pose.y_m),
            cos: narrow(cos),
            sin: narrow(sin),
        }
    }

    /// Space around the outline by the clearance field alone; a bound from below. [m]
    fn field_margin_m(&self, at: LocalPose) -> f32 {
        let mut least = f32::INFINITY;
        for disc in &self.footprint.discs {
            let (dx, dy) = (narrow(disc.centre.x), narrow(disc.centre.y));
            let x = at.x + at.cos * dx - at.sin * dy;
            let y = at.y + at.sin * dx + at.cos * dy;
            least = least.min(self.field.bound_m(x, y) - narrow(disc.radius_m));
        }
        least
    }

    /// Space around the outline by the clearance field, at most `soft`; `None` when it is less
    /// than what must be kept. Most places are settled by one cell, most discs by another. [m]
    pub(crate) fn space(&self, at: LocalPose, soft: f32) -> Option<f32> {
        let need = narrow(self.need_m);
        let soft = soft.max(need);
        let slack = self.field.slack_m();
        let outer = narrow(self.footprint.circumscribed_m);
        if self.field.nearest_m(at.x, at.y) >= outer + soft + slack {
            return Some(soft);
        }
        let mut least = soft;
        for disc in &self.footprint.discs {
            let (dx, dy) = (narrow(disc.centre.x), narrow(disc.centre.y));
            let x = at.x + at.cos * dx - at.sin * dy;
            let y = at.y + at.sin * dx + at.cos * dy;
            let radius = narrow(disc.radius_m);
            if self.field.nearest_m(x, y) >= radius + least + slack {
                continue;
            }
            least = least.min(self.field.bound_m(x, y) - radius);
            if least < need {
                return None;
            }
        }
        Some(least)
    }

    /// Space between the outline and the nearest point of the scan, exact. [m]
    fn scan_margin_m(&self, pose: &Pose) -> f64 {
        let points = self.near_x.iter().zip(&self.near_y);
        if self.footprint.is_disc() {
            let squared = points.fold(f64::INFINITY, |least, (x, y)| {
                let (dx, dy) = (x - pose.x_m, y - pose.y_m);
                least.min(dx * dx + dy * dy)
            });
            return squared.sqrt() - self.footprint.circumscribed_m;
        }
        let (sin, cos) = pose.yaw_rad.sin_cos();
        let mut least = f64::INFINITY;
        for (x, y) in points {
            let (dx, dy) = (x - pose.x_m, y - pose.y_m);
            // The circumscribed circle settles most points.
            if dx.hypot(dy) - self.footprint.circumscribed_m < least {
                let point = Point2::new(cos * dx + sin * dy, cos * dy - sin * dx);
                least = least.min(self.footprint.distance_m(point));
            }
        }
        least
    }

    /// True when no point of the scan is nearer to the outline than the margin of this period.
    fn scan_keeps(&self, pose: &Pose) -> bool {
        let footprint = &self.footprint;
        let reach_m = footprint.circumscribed_m + self.need_m;
        if reach_m <= 0.0 {
            return self.scan_margin_m(pose) >= self.need_m;
        }
        let near = |x: f64, y: f64| {
            let (dx, dy) = (x - pose.x_m, y - pose.y_m);
            dx * dx + dy * dy < reach_m * reach_m
        };
        let mut points = self.near_x.iter().zip(&self.near_y);
        if footprint.is_disc() {
            return !points.fold(false, |any, (x, y)| any | near(*x, *y));
        }
        let (sin, cos) = pose.yaw_rad.sin_cos();
        points.all(|(x, y)| {
            let (dx, dy) = (x - pose.x_m, y - pose.y_m);
            let point = Point2::new(cos * dx + sin * dy, cos * dy - sin * dx);
            !near(*x, *y) || footprint.distance_m(point) >= self.need_m
        })
    }

    /// True when the outline can turn on the spot by `angle_rad`; always for a disc.
    pub(crate) fn turn_is_free(&self, angle_rad: f64) -> bool {
        const STEPS_MAX: u32 = 64;
        if self.footprint.is_disc() {
            return true;
        }
        // As far from pose to pose as in a stop, but never more than that many poses.
        let swept_m = angle_rad.abs() * self.footprint.circumscribed_m;
        (1..=STEPS_MAX)
            .map(|step| f64::from(step) * (swept_m / f64::from(STEPS_MAX)).max(STOP_SPACING_M))
            .take_while(|at_m| *at_m < swept_m)
            .all(|at_m| {
                let yaw_rad = (at_m / self.footprint.circumscribed_m).copysign(angle_rad);
                self.keeps_margin(&Pose::new(0.0, 0.0, yaw_rad))
            })
    }

    /// False for a turn on the spot while something that moves comes into reach of the corners:
    /// people walk around a robot that is stopped, but into a corner that swings.
    fn turns_clear(&self, twist: Twist, moving: &DynamicObstacles) -> bool {
        if self.footprint.is_disc()
            || twist.v_mps.abs() > TURNING_MPS
            || twist.w_radps.abs() < TURNING_RADPS
        {
            return true;
        }
        let at = |elapsed_s| moving.around_m(self.footprint.circumscribed_m, elapsed_s);
        let keep_m = self.need_m.max(0.0).min(at(0.0) - MARGIN_NOISE_M);
        (1..=COMING_STEPS).all(|step| at(COMING_STEP_S * f64::from(step)) >= keep_m)
    }

    /// False when the robot, braking from `twist` at once and then standing, is hit within `until_s`.
    pub(crate) fn rest_is_free(
        &self,
        robot: &Description,
        twist: Twist,
        moving: &DynamicObstacles,
        until_s: f64,
    ) -> bool {
        let outline_m = |point| self.footprint.distance_m(point);
        let mut stop = Stop::new(robot, twist, 0.0, 0.0, STOP_SPACING_M);
        let step_s = stop.step_s();
        let mut at = Pose::default();
        let mut elapsed_s = 0.0;
        while elapsed_s < until_s {
            elapsed_s += match stop.next() {
                Some((pose, _)) => {
                    at = pose;
                    step_s
                }
                None => STANDING_STEP_S,
            };
            if moving.margin_m(&at, elapsed_s, outline_m) < 0.0 {
                return false;
            }
        }
        true
    }

    /// The arc of a stop from `twist`, when it is free of what is static: what moves is left to a
    /// search. [m]
    pub(crate) fn static_stop_arc_m(
        &self,
        robot: &Description,
        twist: Twist,
        reaction_s: f64,
    ) -> Option<f64> {
        let mut stop = Stop::new(robot, twist, reaction_s, self.reach_m(), STOP_SPACING_M);
        let free = stop
            .by_ref()
            .all(|(pose, _)| self.space(self.local(&pose), 0.0).is_some());
        free.then(|| stop.arc_m())
    }

    /// How far the outline reaches when the robot turns; 0 for a disc. [m]
    fn reach_m(&self) -> f64 {
        if self.footprint.is_disc() {
            0.0
        } else {
            self.footprint.circumscribed_m
        }
    }

    /// The arc of a stop from `twist`, when it is free all along. [m]
    ///
    /// Holds the twist for `reaction_s`, then ramps to rest as [`zeronav_motion::towards_rest`]
    /// does; every pose keeps the margin of this period from the map and the scan, and from where
    /// the moving obstacles will be by then, or comes no nearer to them than it is now. The outline
    /// moves by at most 3 cm from pose to pose, so an obstacle between two of them comes at most
    /// 1 mm into a 0.1 m disc's margin.
    pub(crate) fn stop_arc_m(
        &self,
        robot: &Description,
        twist: Twist,
        reaction_s: f64,
        moving: &DynamicObstacles,
    ) -> Option<f64> {
        let reach_m = self.reach_m();
        let outline_m = |point| self.footprint.distance_m(point);
        let now_m = moving.margin_m(&Pose::default(), 0.0, outline_m);
        let keep_m = self.need_m.max(0.0).min(now_m - MARGIN_NOISE_M);
        if !self.turns_clear(twist, moving) {
            return None;
        }
        let mut stop = Stop::new(robot, twist, reaction_s, reach_m, STOP_SPACING_M);
        let mut elapsed_s = 0.0;
        let step_s = stop.step_s();
        let free = stop.by_ref().all(|(pose, _)| {
            elapsed_s += step_s;
            self.keeps_margin(&pose) && moving.margin_m(&pose, elapsed_s, outline_m) >= keep_m
        });
        free.then(|| stop.arc_m())
    }
}

#[cfg(test)]
mod tests;
