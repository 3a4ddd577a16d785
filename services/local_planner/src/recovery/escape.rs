//! Driving back along the track and turning to look around, every piece of it checked.
//!
//! A piece of the track is driven when its poses keep the margin from map and scan and a stop from
//! the next twist is free, by the same check as that of every other command.

use super::trail::Trail;
use crate::controller::{Decision, Situation};
use crate::dwa::options::DwaConfig;
use crate::dynamic_obstacles::{DynamicObstacles, Growth};
use crate::recovery::options::RecoveryConfig;
use crate::shaping::Shaper;
use crate::surroundings::{Reach, Surroundings};
use crate::turn;
use zeronav_motion::{Twist, stop_distance_m, towards_rest};
use zeronav_msgs::Pose;
use zeronav_msgs::command::Validity;

/// [m] of track behind the robot that must be free before it is driven.
const PIECE_M: f64 = 0.15;

/// [m] along the track to the point that is steered for.
const LOOKBACK_M: f64 = 0.25;

/// [rad] of a turn that must be free before it goes on.
const PIECE_RAD: f64 = 0.35;

/// The robot out of the way.
#[derive(Debug, Clone)]
pub(crate) struct Escape {
    config: RecoveryConfig,
    dwa: DwaConfig,
    surroundings: Surroundings,
    moving: DynamicObstacles,
    shaper: Shaper,
    /// Where it began, `odom_from_base`.
    begun: Pose,
    /// Which way round it turns, and by how much so far. [rad]
    direction: f64,
    turned_rad: f64,
    yaw_rad: f64,
}

impl Escape {
    pub(crate) fn new(config: RecoveryConfig, dwa: DwaConfig, shaper: Shaper) -> Self {
        Self {
            config,
            dwa,
            surroundings: Surroundings::default(),
            moving: DynamicObstacles::default(),
            shaper,
            begun: Pose::default(),
            direction: 1.0,
            turned_rad: 0.0,
            yaw_rad: 0.0,
        }
    }

    /// Looks around.
    pub(crate) fn look(&mut self, situation: &Situation<'_>) {
        let robot = situation.robot;
        self.surroundings.describe(robot, situation.corners);
        let stop_m = stop_distance_m(robot, robot.v_mps_max, self.dwa.reaction_s);
        self.surroundings.look(
            situation.map.map(|map| (map, situation.map_cells)),
            &situation.map_from_base,
            situation.scan_points_in_base,
            situation.scan_points_in_base,
            Reach {
                field_m: stop_m.max(2.0 * LOOKBACK_M) + 0.5,
                stop_m: stop_m.max(PIECE_M),
                soft_m: self.dwa.soft_clearance_m,
                margin_m: self.dwa.safety_margin_m,
            },
        );
        self.moving.take(
            situation.obstacles,
            situation.obstacles_age_s,
            &situation.map_from_base,
            Growth::default(),
        );
    }

    /// Begins at `odom_from_base`.
    pub(crate) fn begin(&mut self, odom_from_base: &Pose) {
        self.begun = *odom_from_base;
        self.yaw_rad = odom_from_base.yaw_rad;
        self.turned_rad = 0.0;
        let left = self.turn_is_free(1.0);
        self.direction = if left { 1.0 } else { -1.0 };
    }

    /// The controller drives.
    pub(crate) fn interrupted(&mut self) {
        self.shaper.interrupted();
    }

    /// [m] from where it began.
    pub(crate) fn backed_m(&self, odom_from_base: &Pose) -> f64 {
        self.begun.distance_m(odom_from_base)
    }

    /// [rad] turned since it began.
    pub(crate) const fn turned_rad(&self) -> f64 {
        self.turned_rad
    }

    /// True when the next piece of the track is free and the robot drives backwards at all.
    pub(crate) fn is_free_behind(
        &self,
        situation: &Situation<'_>,
        trail: &Trail,
        odom_from_base: &Pose,
    ) -> bool {
        let mut poses = trail.back(odom_from_base, PIECE_M).peekable();
        situation.robot.v_mps_min < 0.0
            && trail
                .back(odom_from_base, LOOKBACK_M)
                .any(|pose| pose.x_m < -0.5 * PIECE_M)
            && poses.peek().is_some()
            && poses.all(|pose| self.surroundings.keeps_margin(&pose))
    }

    /// True when the robot can turn a good part of the way, either way round.
    pub(crate) fn has_room_to_turn(&self) -> bool {
        self.turn_is_free(1.0) || self.turn_is_free(-1.0)
    }

    fn turn_is_free(&self, direction: f64) -> bool {
        self.surroundings.turn_is_free(PIECE_RAD * direction)
    }

    /// The next command back along the track.
    pub(crate) fn back_up(
        &mut self,
        situation: &Situation<'_>,
        trail: &Trail,
        odom_from_base: &Pose,
        last: Twist,
    ) -> Decision {
        let back_mps = situation.robot.v_mps_min.max(-self.config.back_up_mps);
        // The arc through a point of the track: curvature 2 y / l^2, driven backwards.
        let target = trail.back(odom_from_base, LOOKBACK_M).last();
        let curvature = target.map_or(0.0, |at| {
            2.0 * at.y_m / (at.x_m * at.x_m + at.y_m * at.y_m).max(0.01)
        });
        let w_radps =
            (back_mps * curvature).clamp(-situation.robot.w_radps_max, situation.robot.w_radps_max);
        let wanted = Twist::new(back_mps, w_radps);
        let free = self.is_free_behind(situation, trail, odom_from_base);
        self.publish(situation, last, free.then_some(wanted))
    }

    /// The next command of a turn to look around.
    pub(crate) fn rotate(
        &mut self,
        situation: &Situation<'_>,
        odom_from_base: &Pose,
        last: Twist,
    ) -> Decision {
        let step_rad = zeronav_msgs::pose::wrap_angle(odom_from_base.yaw_rad - self.yaw_rad);
        self.turned_rad += step_rad * self.direction;
        self.yaw_rad = odom_from_base.yaw_rad;
        let left_rad = (self.config.rotate_rad - self.turned_rad).max(0.05) * self.direction;
        let wanted = Twist::new(0.0, turn::rate_radps(situation.robot, left_rad));
        let free = self.turn_is_free(self.direction);
        self.publish(situation, last, free.then_some(wanted))
    }

    /// The shaped step towards `wanted` when a stop from it is free, else the first of a stop.
    fn publish(
        &mut self,
        situation: &Situation<'_>,
        last: Twist,
        wanted: Option<Twist>,
    ) -> Decision {
        let (robot, period_s) = (situation.robot, situation.period_s);
        let from = last.near(
            robot,
            Twist::new(situation.v_mps, situation.w_radps),
            self.dwa.command_lead_s,
        );
        let moving = wanted.and_then(|wanted| {
            let next = self.shaper.next(robot, from, wanted, period_s);
            let reaction_s = self.dwa.reaction_s;
            let arc_m = self
                .surroundings
                .stop_arc_m(robot, next, reaction_s, &self.moving)?;
            Some((next, Validity::Drive, arc_m))
        });
        let (twist, validity, braking_arc_m) = moving.unwrap_or_else(|| {
            let rest = towards_rest(robot, from, period_s);
            let braking_m = stop_distance_m(robot, rest.v_mps, 0.0);
            (rest, Validity::Blocked, braking_m)
        });
        if validity == Validity::Drive {
            self.shaper.published(from, twist, period_s);
        } else {
            self.shaper.interrupted();
        }
        Decision {
            v_mps: twist.v_mps,
            w_radps: twist.w_radps,
            validity,
            braking_arc_m,
            turns: false,
            rollouts: 1,
            blocked_arc_m: None,
        }
    }
}
