//! The robot's limits, and the two ways a twist is brought within them.
//!
//! The guard keeps arithmetic of its own on purpose (diverse redundancy): a defect in
//! `zeronav_motion`, which the local planner drives by, must not hide itself from the last check
//! before the wheels. `tests/limits.rs` compares the two. They differ where the robot changes
//! direction: the guard lets `brake_mps2` act through zero, so it sweeps at least what the local
//! planner can ask for.

use zeronav_motion::Twist;
use zeronav_msgs::description::Description;

/// The limits of a [`Description`] that bound a command; every number is finite.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// [m/s] fastest forward speed, > 0.
    pub v_mps_max: f64,
    /// [m/s] fastest backward speed as a number <= 0.
    pub v_mps_min: f64,
    /// [rad/s] fastest yaw rate either way, > 0.
    pub w_radps_max: f64,
    /// [m/s^2] acceleration when speeding up, > 0.
    pub a_mps2_max: f64,
    /// [m/s^2] deceleration of the ramp to rest, > 0.
    pub brake_mps2: f64,
    /// [rad/s^2] yaw deceleration of the ramp to rest, > 0.
    pub alpha_radps2_max: f64,
}

impl Limits {
    /// The limits of `description`; `None` when one of them is no usable number.
    #[must_use]
    pub fn of(description: &Description) -> Option<Self> {
        let positive = |value: f64| value.is_finite() && value > 0.0;
        let backward = description.v_mps_min;
        (positive(description.v_mps_max)
            && backward.is_finite()
            && backward <= 0.0
            && positive(description.w_radps_max)
            && positive(description.a_mps2_max)
            && positive(description.brake_mps2)
            && positive(description.alpha_radps2_max))
        .then_some(Self {
            v_mps_max: description.v_mps_max,
            v_mps_min: backward,
            w_radps_max: description.w_radps_max,
            a_mps2_max: description.a_mps2_max,
            brake_mps2: description.brake_mps2,
            alpha_radps2_max: description.alpha_radps2_max,
        })
    }

    /// The fastest twist within the limits on the same arc as `asked`: both speeds shrink by one
    /// factor, so the robot stays where the author of the request looked for obstacles. Backward
    /// motion of a robot that cannot drive backwards becomes rest. `asked` must be finite.
    #[must_use]
    pub fn clamp(&self, asked: Twist) -> Twist {
        let along = if asked.v_mps > self.v_mps_max {
            self.v_mps_max / asked.v_mps
        } else if asked.v_mps < self.v_mps_min {
            self.v_mps_min / asked.v_mps
        } else {
            1.0
        };
        let about = if asked.w_radps.abs() > self.w_radps_max {
            self.w_radps_max / asked.w_radps.abs()
        } else {
            1.0
        };
        let share = along.min(about);
        // The product may exceed the limit by one rounding.
        Twist {
            v_mps: (asked.v_mps * share).clamp(self.v_mps_min, self.v_mps_max),
            w_radps: (asked.w_radps * share).clamp(-self.w_radps_max, self.w_radps_max),
        }
    }

    /// The twist nearest to `wanted` that `elapsed_s` can reach from `from`: speeding up is bounded
    /// by `a_mps2_max`, slowing down by `brake_mps2`, turning by `alpha_radps2_max`.
    #[must_use]
    pub fn towards(&self, from: Twist, wanted: Twist, elapsed_s: f64) -> Twist {
        let up = self.a_mps2_max * elapsed_s;
        let down = self.brake_mps2 * elapsed_s;
        let (lowest, highest) = if from.v_mps > 0.0 {
            (from.v_mps - down, from.v_mps + up)
        } else if from.v_mps < 0.0 {
            (from.v_mps - up, from.v_mps + down)
        } else {
            (-up, up)
        };
        let yaw_step = self.alpha_radps2_max * elapsed_s;
        Twist {
            v_mps: wanted.v_mps.clamp(lowest, highest),
            w_radps: wanted
                .w_radps
                .clamp(from.w_radps - yaw_step, from.w_radps + yaw_step),
        }
    }

    /// The next twist on the way from `last` to rest after `elapsed_s`: the speed falls by
    /// `brake_mps2`, the yaw rate falls in proportion, so that the robot stays on its arc, but
    /// never by more than `alpha_radps2_max`. At rest after at most
    /// `|v| / brake_mps2 + |w| / alpha_radps2_max`.
    #[must_use]
    pub fn towards_rest(&self, last: Twist, elapsed_s: f64) -> Twist {
        let v_mps = approach_zero(last.v_mps, self.brake_mps2 * elapsed_s);
        let yaw_step = self.alpha_radps2_max * elapsed_s;
        let on_arc = if last.v_mps.abs() > 0.0 {
            last.w_radps * (v_mps / last.v_mps)
        } else {
            0.0
        };
        let w_radps = on_arc.clamp(last.w_radps - yaw_step, last.w_radps + yaw_step);
        Twist { v_mps, w_radps }
    }
}

fn approach_zero(value: f64, step: f64) -> f64 {
    if value.abs() <= step {
        0.0
    } else {
        value - step.copysign(value)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIMITS: Limits = Limits {
        v_mps_max: 1.0,
        v_mps_min: 0.0,
        w_radps_max: 2.0,
        a_mps2_max: 1.0,
        brake_mps2: 1.0,
        alpha_radps2_max: 3.0,
    };

    fn twist(v_mps: f64, w_radps: f64) -> Twist {
        Twist { v_mps, w_radps }
    }

    #[test]
    fn clamping_keeps_the_arc() {
        assert_eq!(LIMITS.clamp(twist(2.0, 1.0)), twist(1.0, 0.5));
        assert_eq!(LIMITS.clamp(twist(0.5, -4.0)), twist(0.25, -2.0));
        assert_eq!(LIMITS.clamp(twist(0.5, 1.0)), twist(0.5, 1.0));
    }

    #[test]
    fn a_robot_that_cannot_back_up_does_not() {
        assert_eq!(LIMITS.clamp(twist(-0.3, 1.0)), Twist::REST);
    }

    #[test]
    fn the_ramp_stays_on_its_arc_when_the_yaw_limit_allows() {
        let next = LIMITS.towards_rest(twist(1.0, 0.5), 0.02);
        assert!((next.v_mps - 0.98).abs() < 1e-12);
        assert!((next.w_radps / next.v_mps - 0.5).abs() < 1e-12);
    }

    #[test]
    fn a_turn_on_the_spot_ramps_at_the_yaw_limit() {
        let next = LIMITS.towards_rest(twist(0.0, -1.0), 0.1);
        assert!((next.w_radps + 0.7).abs() < 1e-12);
        assert_eq!(LIMITS.towards_rest(twist(0.0, 0.1), 0.1), Twist::REST);
    }

    #[test]
    fn unusable_descriptions_have_no_limits() {
        assert_eq!(Limits::of(&Description::default()), None);
        let description = Description {
            v_mps_max: f64::NAN,
            w_radps_max: 1.0,
            brake_mps2: 1.0,
            alpha_radps2_max: 1.0,
            ..Description::default()
        };
        assert_eq!(Limits::of(&description), None);
    }
}
