//! Is there room for the robot at a goal?

use crate::footprint::Footprint;
use crate::world::World;
use core::f64::consts::PI;
use nalgebra::{Point2, Vector2};
use std::collections::VecDeque;
use zeronav_msgs::Pose;
use zeronav_msgs::grid::Cell;
use zeronav_msgs::pose::wrap_angle;

/// How near to a goal counts as there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tolerance {
    /// Straight distance. [m] >= 0
    pub distance_m: f64,
    /// Difference of yaw, pi or more = any yaw. [rad]
    pub yaw_rad: f64,
}

/// Step between the yaws that are tried. [rad]
const YAW_STEP_RAD: f64 = 5.0 * PI / 180.0;

/// Half the side of the smallest squares that are looked into for a disc. [m]
const HALF_M_MIN: f64 = 1.0e-3;

/// Between the rings on which the nearest free pose is looked for, and between points of a ring. [m]
const RING_STEP_M: f64 = 0.1;

/// The largest of these rings. [m]
const RING_M_MAX: f64 = 10.0;

/// A polygon has more poses to try: its squares are not smaller than this part of the tolerance.
const POLYGON_HALF_RATIO_MIN: f64 = 1.0 / 32.0;

impl World {
    /// A pose on the map within `tolerance` of `goal` at which the robot touches nothing static,
    /// near to the goal if possible; `None` when there is none.
    ///
    /// Squares of positions are cut into four until they are certainly blocked (the world is
    /// nearer to all of the square than the inscribed radius) or their middle is free. For a disc
    /// this finds every gap of 2 mm; for a polygon poses are tried on a lattice of 1/32 of the
    /// tolerance and 5 degrees.
    #[must_use]
    pub fn free_pose_near(
        &self,
        footprint: &Footprint,
        goal: &Pose,
        tolerance: Tolerance,
    ) -> Option<Pose> {
        let reach_m = tolerance.distance_m.max(0.0);
        let half_m_min = if footprint.form().is_disc() {
            HALF_M_MIN
        } else {
            HALF_M_MIN.max(reach_m * POLYGON_HALF_RATIO_MIN)
        };
        let mut squares = VecDeque::from([(goal.point(), reach_m)]);
        while let Some((centre, half_m)) = squares.pop_front() {
            let from_goal = centre - goal.point();
            let nearest = from_goal.map(|along| (along.abs() - half_m).max(0.0));
            if nearest.norm() > reach_m {
                continue;
            }
            let distance_m = self.point_distance_m(centre);
            if distance_m + half_m * core::f64::consts::SQRT_2 < footprint.inscribed_radius_m() {
                continue;
            }
            if from_goal.norm() <= reach_m
                && let Some(pose) =
                    self.free_yaw_at(footprint, centre, distance_m, (goal.yaw_rad, tolerance))
            {
                return Some(pose);
            }
            if half_m > half_m_min {
                let half_m = half_m / 2.0;
                let parts = [(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)];
                squares.extend(parts.map(|(x, y)| (centre + Vector2::new(x, y) * half_m, half_m)));
            }
        }
        None
    }

    /// The free pose on the map with about the yaw of `goal` that is nearest to it, found on rings
    /// `RING_STEP_M` apart up to `RING_M_MAX` around it, or around the map's nearest point when it
    /// lies outside; `None` when there is none. Everything static is at least `clearance_m` away, yaws
    /// within `tolerance_rad` of the goal's are tried, and only positions that `accepts` holds for.
    #[must_use]
    pub fn nearest_free_pose(
        &self,
        footprint: &Footprint,
        goal: &Pose,
        tolerance_rad: f64,
        clearance_m: f64,
        accepts: impl Fn(Point2<f64>) -> bool,
    ) -> Option<Pose> {
        let tolerance = Tolerance {
            distance_m: 0.0,
            yaw_rad: tolerance_rad,
        };
        let centre = self.nearest_point_on_map(goal.point());
        let free_at = |at: Point2<f64>| {
            if !accepts(at) {
                return None;
            }
            let distance_m = self.point_distance_m(at);
            self.free_yaw_at(footprint, at, distance_m, (goal.yaw_rad, tolerance))
                .filter(|pose| self.distance_m(footprint, pose) >= clearance_m)
        };
        let mut ring_m = 0.0;
        while ring_m <= RING_M_MAX {
            let step_rad = RING_STEP_M / f64::max(ring_m, RING_STEP_M);
            let mut angle_rad = 0.0;
            while angle_rad < 2.0 * PI {
                let (sin, cos) = f64::sin_cos(angle_rad);
                let pose = free_at(centre + Vector2::new(cos, sin) * ring_m);
                if pose.is_some() {
                    return pose;
                }
                angle_rad += step_rad;
            }
            ring_m += RING_STEP_M;
        }
        None
    }

    /// The point of the map's grid, half a cell inside, that is nearest to `point`.
    fn nearest_point_on_map(&self, point: Point2<f64>) -> Point2<f64> {
        let geometry = self.geometry();
        let (width, height) = geometry.size();
        let low = geometry.centre_of(Cell::new(0, 0));
        let high = geometry.centre_of(Cell::new(width - 1, height - 1));
        Point2::new(point.x.clamp(low.x, high.x), point.y.clamp(low.y, high.y))
    }

    fn free_yaw_at(
        &self,
        footprint: &Footprint,
        at: Point2<f64>,
        distance_m: f64,
        (yaw_rad, tolerance): (f64, Tolerance),
    ) -> Option<Pose> {
        if distance_m < footprint.inscribed_radius_m() || !self.contains(at) {
            return None;
        }
        let free = |yaw_rad: f64| {
            let pose = Pose::new(at.x, at.y, wrap_angle(yaw_rad));
            let surely = distance_m > footprint.circumscribed_radius_m();
            (surely || !self.touches(footprint, &pose)).then_some(pose)
        };
        if let Some(pose) = free(yaw_rad) {
            return Some(pose);
        }
        if footprint.form().is_disc() {
            return None;
        }
        let largest_rad = tolerance.yaw_rad.clamp(0.0, PI);
        let mut turn_rad = 0.0;
        while turn_rad < largest_rad {
            turn_rad = (turn_rad + YAW_STEP_RAD).min(largest_rad);
            for side in [1.0, -1.0] {
                if let Some(pose) = free(yaw_rad + side * turn_rad) {
                    return Some(pose);
                }
            }
        }
        None
    }
}
