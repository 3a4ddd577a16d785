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

    #[test]
    fn every_change_has_its_own_limit_in_either_direction() {
        let robot = robot();
        // From, wanted, and what 0.1 s reaches: 0.1 m/s faster, 0.2 m/s slower, 0.4 rad/s.
        for (from, wanted, reached) in [
            ((0.5, 0.0), (2.0, 3.0), (0.6, 0.4)),
            ((0.5, 1.0), (0.0, -3.0), (0.3, 0.6)),
            ((-0.5, 0.0), (-2.0, 0.0), (-0.6, 0.0)),
            ((-0.5, 0.0), (0.0, 0.0), (-0.3, 0.0)),
            ((0.0, 0.0), (2.0, 0.0), (0.1, 0.0)),
            ((0.0, 0.0), (-2.0, 0.0), (-0.1, 0.0)),
            ((0.05, 0.0), (-2.0, 0.0), (-0.1, 0.0)),
            ((-0.05, 0.0), (2.0, 0.0), (0.1, 0.0)),
            ((0.5, 0.2), (0.55, 0.3), (0.55, 0.3)),
        ] {
            let twist = |(v, w)| Twist::new(v, w);
            let found = reachable(&robot, twist(from), twist(wanted), 0.1);
            let off = (found.v_mps - reached.0)
                .abs()
                .max((found.w_radps - reached.1).abs());
            assert!(off < 1e-12, "{from:?} to {wanted:?}: {found:?}");
        }
    }

    #[test]
    fn a_stop_stays_on_its_arc_as_far_as_the_yaw_limit_allows() {
        let robot = robot();
        for (from, next) in [
            ((1.0, 0.5), (0.8, 0.4)),
            ((-1.0, 0.5), (-0.8, 0.4)),
            // The arc would need 2 rad/s less.
            ((0.2, 2.0), (0.0, 1.6)),
            ((0.0, -1.0), (0.0, -0.6)),
            ((0.0, 0.3), (0.0, 0.0)),
            ((0.1, 0.0), (0.0, 0.0)),
        ] {
            let found = towards_rest(&robot, Twist::new(from.0, from.1), 0.1);
            let off = (found.v_mps - next.0)
                .abs()
                .max((found.w_radps - next.1).abs());
            assert!(off < 1e-12, "{from:?}: {found:?}");
        }
    }

    #[test]
    fn the_last_command_is_as_far_ahead_as_the_robot_can_have_followed() {
        let robot = robot();
        // Within 0.1 s: 0.2 m/s and 0.4 rad/s, whichever way.
        let near = |last: (f64, f64), measured: (f64, f64)| {
            let last = Twist::new(last.0, last.1);
            let near = last.near(&robot, Twist::new(measured.0, measured.1), 0.1);
            (near.v_mps, near.w_radps)
        };
        let is = |found: (f64, f64), v: f64, w: f64| {
            assert!(
                (found.0 - v).abs() < 1e-12 && (found.1 - w).abs() < 1e-12,
                "{found:?}"
            );
        };
        is(near((0.55, 0.1), (0.5, 0.0)), 0.55, 0.1);
        is(near((1.0, 2.0), (0.5, 0.0)), 0.7, 0.4);
        is(near((0.0, -2.0), (0.5, 0.0)), 0.3, -0.4);
        // What is measured beyond the limits counts as the limit.
        is(near((3.0, 9.0), (2.0, 5.0)), 1.2, 2.4);
        is(near((3.0, -9.0), (2.0, -5.0)), 1.2, -2.4);
    }
}
