//! The acceleration limits: which twist follows which.

use crate::twist::Twist;
use zeronav_msgs::description::Description;

/// The twist nearest to `wanted` that `elapsed_s` of acceleration and braking can reach from
/// `from`; both speeds change on their own. Speeding up is bounded by `a_mps2_max`, slowing down
/// by `brake_mps2`; a change of direction passes through zero at `brake_mps2`.
#[must_use]
pub fn reachable(robot: &Description, from: Twist, wanted: Twist, elapsed_s: f64) -> Twist {
    let up = robot.a_mps2_max * elapsed_s;
    let down = robot.brake_mps2 * elapsed_s;
    let (lowest, highest) = if from.v_mps > 0.0 {
        ((from.v_mps - down).max(-up.min(down)), from.v_mps + up)
    } else if from.v_mps < 0.0 {
        (from.v_mps - up, (from.v_mps + down).min(up.min(down)))
    } else {
        (-up, up)
    };
    let yaw_step = robot.alpha_radps2_max * elapsed_s;
    Twist {
        v_mps: wanted.v_mps.clamp(lowest, highest),
        w_radps: wanted
            .w_radps
            .clamp(from.w_radps - yaw_step, from.w_radps + yaw_step),
    }
}

/// The next twist of a stop: the speed falls by `brake_mps2`, the yaw rate in proportion, so that
/// the robot stays on its arc, but by no more than `alpha_radps2_max`.
#[must_use]
pub fn towards_rest(robot: &Description, from: Twist, elapsed_s: f64) -> Twist {
    let step = robot.brake_mps2 * elapsed_s;
    let v_mps = if from.v_mps.abs() <= step {
        0.0
    } else {
        from.v_mps - step.copysign(from.v_mps)
    };
    let yaw_step = robot.alpha_radps2_max * elapsed_s;
    let on_arc = if from.v_mps.abs() > 0.0 {
        from.w_radps * (v_mps / from.v_mps)
    } else {
        0.0
    };
    Twist {
        v_mps,
        w_radps: on_arc.clamp(from.w_radps - yaw_step, from.w_radps + yaw_step),
    }
}

impl Twist {
    /// The twist from which the next command starts when this was the last one: this twist, as far
    /// as the measured one can have followed it within `lead_s`.
    #[must_use]
    pub fn near(self, robot: &Description, measured: Self, lead_s: f64) -> Self {
        let v = measured.v_mps.clamp(robot.v_mps_min, robot.v_mps_max);
        let w = measured
            .w_radps
            .clamp(-robot.w_radps_max, robot.w_radps_max);
        let up = robot.a_mps2_max.max(robot.brake_mps2) * lead_s;
        let yaw_step = robot.alpha_radps2_max * lead_s;
        Self {
            v_mps: self.v_mps.clamp(v - up, v + up),
            w_radps: self.w_radps.clamp(w - yaw_step, w + yaw_step),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn robot() -> Description {
        Description {
            v_mps_max: 1.0,
            w_radps_max: 2.0,
            a_mps2_max: 1.0,
            brake_mps2: 2.0,
            alpha_radps2_max: 4.0,
            ..Description::default()
        }
    }

    #[test]
    fn speeding_up_and_slowing_down_have_their_own_limits() {
        let robot = robot();
        let from = Twist::new(0.5, 0.0);
        let fast = reachable(&robot, from, Twist::new(1.0, 1.0), 0.1);
        assert!((fast.v_mps - 0.6).abs() < 1e-12 && (fast.w_radps - 0.4).abs() < 1e-12);
        let slow = reachable(&robot, from, Twist::REST, 0.1);
        assert!((slow.v_mps - 0.3).abs() < 1e-12);
        let creeping = Twist::new(0.05, 0.0);
        let back = reachable(&robot, creeping, Twist::new(-1.0, 0.0), 0.1);
        assert!(back.v_mps <= 0.0 && back.v_mps >= -0.1);
    }
}
