//! How the robot moves: by script, whatever is in its way.

use nalgebra::Point2;
use zeronav_msgs::Pose;
use zeronav_msgs::pose::wrap_angle;

/// Speed on the way. [m/s]
const SPEED_MPS: f64 = 1.0;

/// Yaw rate for each radian that the robot is off. [1/s]
const STEER: f64 = 2.0;

/// Fastest turn. [rad/s]
const TURN_RADPS_MAX: f64 = 1.2;

/// How far it sways to either side, and how often: a robot among others does not go straight. [rad], [Hz]
const SWAY_RAD: f64 = 0.4;
const SWAY_HZ: f64 = 0.15;

/// How near it comes to an end before it turns round. [m]
const END_M: f64 = 0.5;

/// To and fro between two ends, swaying. In contact with something the robot stands, until that has
/// gone on.
#[derive(Debug)]
pub(super) struct Shuttle {
    ends: [Point2<f64>; 2],
    /// Which end it drives to.
    to: usize,
}

impl Shuttle {
    /// From `start` to `goal` first.
    pub(super) fn new(start: &Pose, goal: &Pose) -> Self {
        Self {
            ends: [start.point(), goal.point()],
            to: 1,
        }
    }

    /// The set point `(v, w)` of a robot at `map_from_base`, `run_s` after the start.
    /// [m/s], [rad/s]
    pub(super) fn set_point(&mut self, map_from_base: &Pose, run_s: f64) -> (f64, f64) {
        if (self.ends[self.to] - map_from_base.point()).norm() < END_M {
            self.to = 1 - self.to;
        }
        let way = self.ends[self.to] - map_from_base.point();
        let sway_rad = SWAY_RAD * (core::f64::consts::TAU * SWAY_HZ * run_s).sin();
        let off_rad = wrap_angle(way.y.atan2(way.x) + sway_rad - map_from_base.yaw_rad);
        let v_mps = SPEED_MPS * off_rad.cos().max(0.0);
        (
            v_mps,
            (STEER * off_rad).clamp(-TURN_RADPS_MAX, TURN_RADPS_MAX),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_goes_to_and_fro() {
        let (start, goal) = (Pose::default(), Pose::new(4.0, 0.0, 0.0));
        let mut shuttle = Shuttle::new(&start, &goal);
        let (mut pose, mut turned) = (start, 0);
        let mut was_to = shuttle.to;
        for n in 0..600 {
            let (v_mps, w_radps) = shuttle.set_point(&pose, 0.05 * f64::from(n));
            assert!((0.0..=SPEED_MPS).contains(&v_mps) && w_radps.abs() <= TURN_RADPS_MAX);
            let (sin, cos) = pose.yaw_rad.sin_cos();
            let step_m = 0.05 * v_mps;
            pose = Pose::new(
                pose.x_m + step_m * cos,
                pose.y_m + step_m * sin,
                wrap_angle(pose.yaw_rad + 0.05 * w_radps),
            );
            assert!(
                (-1.0..=5.0).contains(&pose.x_m) && pose.y_m.abs() < 2.0,
                "{pose:?}"
            );
            turned += u32::from(shuttle.to != was_to);
            was_to = shuttle.to;
        }
        assert!((3..=7).contains(&turned), "{turned}");
    }
}
