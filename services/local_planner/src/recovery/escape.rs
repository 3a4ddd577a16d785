//! Driving back along the track and turning to look around, every piece of it checked.
//!
//! A piece of the track is driven when its poses keep the margin from map and scan. The pilot checks
//! the stop from the next twist, as from every other command.

use super::trail::Trail;
use crate::recovery::options::RecoveryConfig;
use crate::surroundings::Surroundings;
use crate::turn;
use zeronav_motion::Twist;
use zeronav_msgs::Pose;
use zeronav_msgs::description::Description;
use zeronav_msgs::pose::wrap_angle;

/// [m] of track behind the robot that must be free before it is driven.
pub(crate) const PIECE_M: f64 = 0.15;

/// [m] along the track to the point that is steered for.
pub(crate) const LOOKBACK_M: f64 = 0.25;

/// [rad] of a turn that must be free before it goes on.
const PIECE_RAD: f64 = 0.35;

/// The robot out of the way.
#[derive(Debug, Clone)]
pub(crate) struct Escape {
    config: RecoveryConfig,
    /// Where it began, `odom_from_base`.
    begun: Pose,
    /// Which way round it turns, and by how much so far. [rad]
    direction: f64,
    turned_rad: f64,
    yaw_rad: f64,
}

impl Escape {
    pub(crate) fn new(config: RecoveryConfig) -> Self {
        Self {
            config,
            begun: Pose::default(),
            direction: 1.0,
            turned_rad: 0.0,
            yaw_rad: 0.0,
        }
    }

    /// Begins at `odom_from_base`.
    pub(crate) fn begin(&mut self, near: &Surroundings, odom_from_base: &Pose) {
        self.begun = *odom_from_base;
        self.yaw_rad = odom_from_base.yaw_rad;
        self.turned_rad = 0.0;
        let left = near.turn_is_free(PIECE_RAD);
        self.direction = if left { 1.0 } else { -1.0 };
    }

    /// [m] from where it began.
    pub(crate) fn backed_m(&self, odom_from_base: &Pose) -> f64 {
        self.begun.distance_m(odom_from_base)
    }

    /// [rad] turned since it began.
    pub(crate) const fn turned_rad(&self) -> f64 {
        self.turned_rad
    }

    /// The twist back along the track, where that is free.
    pub(crate) fn back_up(
        &self,
        near: &Surroundings,
        robot: &Description,
        (trail, odom_from_base): (&Trail, &Pose),
    ) -> Option<Twist> {
        if !is_free_behind(near, robot, trail, odom_from_base) {
            return None;
        }
        let back_mps = robot.v_mps_min.max(-self.config.back_up_mps);
        // The arc through a point of the track: curvature 2 y / l^2, driven backwards.
        let target = trail.back(odom_from_base, LOOKBACK_M).last();
        let curvature = target.map_or(0.0, |at| {
            2.0 * at.y_m / (at.x_m * at.x_m + at.y_m * at.y_m).max(0.01)
        });
        let w_radps = (back_mps * curvature).clamp(-robot.w_radps_max, robot.w_radps_max);
        Some(Twist::new(back_mps, w_radps))
    }

    /// The twist of a turn to look around, where there is room for it.
    pub(crate) fn rotate(
        &mut self,
        near: &Surroundings,
        robot: &Description,
        odom_from_base: &Pose,
    ) -> Option<Twist> {
        let step_rad = wrap_angle(odom_from_base.yaw_rad - self.yaw_rad);
        self.turned_rad += step_rad * self.direction;
        self.yaw_rad = odom_from_base.yaw_rad;
        let left_rad = (self.config.rotate_rad - self.turned_rad).max(0.05) * self.direction;
        let free = near.turn_is_free(PIECE_RAD * self.direction);
        free.then(|| Twist::new(0.0, turn::rate_radps(robot, left_rad)))
    }
}

/// True when the next piece of the track is free and the robot drives backwards at all.
pub(crate) fn is_free_behind(
    near: &Surroundings,
    robot: &Description,
    trail: &Trail,
    odom_from_base: &Pose,
) -> bool {
    let mut poses = trail.back(odom_from_base, PIECE_M).peekable();
    robot.v_mps_min < 0.0
        && trail
            .back(odom_from_base, LOOKBACK_M)
            .any(|pose| pose.x_m < -0.5 * PIECE_M)
        && poses.peek().is_some()
        && poses.all(|pose| near.keeps_margin(&pose))
}

/// True when the robot can turn a good part of the way, either way round.
pub(crate) fn has_room_to_turn(near: &Surroundings) -> bool {
    near.turn_is_free(PIECE_RAD) || near.turn_is_free(-PIECE_RAD)
}
