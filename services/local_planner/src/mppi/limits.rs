//! What the robot can do within a step of a sample.

use crate::lanes::data::{least, most, narrow};
use zeronav_msgs::description::Description;

/// [m/s] fastest speed backwards: only the map and the lidar see there.
const BACK_MPS: f64 = 0.2;

/// Limits of the speeds and of their changes in one step.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Limits {
    /// [s]
    pub(crate) step_s: f32,
    /// [m/s]
    v_min: f32,
    v_max: f32,
    /// [rad/s]
    w_max: f32,
    /// [m/s] per step, away from rest and towards it.
    up: f32,
    down: f32,
    /// [rad/s] per step.
    turn: f32,
    /// [m] to the goal, and twice the deceleration before it. [m/s^2]
    left_m: f32,
    twice_mps2: f32,
}

/// [m/s] that are allowed however near the goal is.
const CREEP_MPS: f32 = 0.03;

impl Limits {
    /// Of a robot that shall not drive faster than `fastest_mps` and slows down by `decel_mps2`
    /// before a goal that is `left_m` away.
    pub(crate) fn new(
        robot: &Description,
        fastest_mps: f64,
        step_s: f64,
        (left_m, decel_mps2): (f64, f64),
    ) -> Self {
        Self {
            step_s: narrow(step_s),
            v_min: narrow(robot.v_mps_min.max(-BACK_MPS)),
            v_max: narrow(fastest_mps.clamp(0.0, robot.v_mps_max)),
            w_max: narrow(robot.w_radps_max),
            up: narrow(robot.a_mps2_max * step_s),
            down: narrow(robot.brake_mps2 * step_s),
            turn: narrow(robot.alpha_radps2_max * step_s),
            left_m: narrow(left_m),
            twice_mps2: narrow(2.0 * decel_mps2),
        }
    }

    /// The twist nearest to the one asked for that a step reaches after `arc_m` driven. What is
    /// faster than allowed slows down as fast as the robot brakes.
    pub(crate) fn follow(&self, from: (f32, f32), asked: (f32, f32), arc_m: f32) -> (f32, f32) {
        let (v, w) = from;
        let forward = v >= 0.0;
        let (fall, rise) = if forward {
            (self.down, self.up)
        } else {
            (self.up, self.down)
        };
        let goal_mps = (self.twice_mps2 * most(self.left_m - arc_m, 0.0)).sqrt();
        let v_max = least(self.v_max, most(goal_mps, CREEP_MPS));
        let v_asked = least(most(asked.0, self.v_min), v_max);
        let w_asked = least(most(asked.1, -self.w_max), self.w_max);
        (
            least(most(v_asked, v - fall), v + rise),
            least(most(w_asked, w - self.turn), w + self.turn),
        )
    }
}
