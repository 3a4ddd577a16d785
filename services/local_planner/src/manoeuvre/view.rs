//! What a manoeuvre is to know in a period, and places relative to the robot.

use super::targets::is_inside;
use crate::progress::PathTracker;
use crate::situation::Situation;
use crate::surroundings::Surroundings;
use core::f64::consts::PI;
use zeronav_msgs::Pose;

/// [m] of path ahead that a manoeuvre leads along at most.
pub(super) const REACH_M: f64 = 2.6;

/// [m] of path from which its direction at a place is taken.
const DIRECTION_M: f64 = 0.4;

/// [m] from a goal, besides the outline's diameter, at which an approach to its yaw begins.
const APPROACH_M: f64 = 1.0;

/// What a manoeuvre is to know in a period.
#[derive(Debug, Clone, Copy)]
pub(crate) struct View<'a> {
    pub(crate) situation: &'a Situation<'a>,
    pub(crate) near: &'a Surroundings,
    pub(crate) odom_from_base: &'a Pose,
    pub(crate) tracker: &'a PathTracker,
    /// [m] that every command keeps free.
    pub(crate) margin_m: f64,
}

impl View<'_> {
    /// A pose of the map, relative to the robot along the axes of the map.
    pub(super) fn relative_to_robot(&self, in_map: &Pose) -> Pose {
        let here = self.situation.map_from_base;
        Pose::new(in_map.x_m - here.x_m, in_map.y_m - here.y_m, in_map.yaw_rad)
    }

    /// Where the robot is.
    pub(super) fn here(&self) -> Pose {
        Pose::new(0.0, 0.0, self.situation.map_from_base.yaw_rad)
    }

    /// The pose along the path at a place on it, relative to the robot. [m]
    pub(super) fn on_path(&self, arc_m: f64) -> Pose {
        let path = self.situation.path;
        let at = self.tracker.point_at(path, arc_m);
        let ahead = self.tracker.point_at(path, arc_m + DIRECTION_M);
        let mut way = ahead - at;
        if way.norm() < 0.5 * DIRECTION_M {
            way = ahead - self.tracker.point_at(path, arc_m - DIRECTION_M);
        }
        self.relative_to_robot(&Pose::new(at.x, at.y, way.y.atan2(way.x)))
    }

    /// True for a robot with corners that comes near a goal with a yaw.
    pub(crate) fn may_approach(&self) -> bool {
        let (goal, footprint) = (self.situation.goal, &self.near.footprint);
        let within_m = (APPROACH_M + 2.0 * footprint.circumscribed_m).min(REACH_M);
        !footprint.is_disc()
            && goal.yaw_tolerance_rad < PI
            && self
                .tracker
                .place()
                .is_some_and(|place| place.remaining_m <= within_m)
            && !self.is_at_goal()
            && is_inside(&self.relative_to_robot(&goal.pose), footprint)
    }

    pub(super) fn is_at_goal(&self) -> bool {
        let goal = self.situation.goal;
        self.situation.map_from_base.distance_m(&goal.pose) <= goal.tolerance_m
    }
}
