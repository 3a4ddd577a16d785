//! The robot's limits, and the two ways a twist is brought within them.
//!
//! The guard keeps arithmetic of its own on purpose (diverse redundancy): a defect in
//! `zeronav_motion`, which the local planner drives by, must not hide itself from the last check
//! before the wheels. `tests/decisions/limits.rs` compares the two. They differ where the robot changes
//! direction within one step: here `brake_mps2` acts through zero. The sweep ends a step there
//! ([`Limits::even_towards_s`]), because beyond zero it is `a_mps2_max` that counts.

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

    /// [s] for which [`Self::towards`] changes both speeds evenly: until one of them arrives, or the
    /// forward speed is zero, where braking ends and speeding up begins. Infinite when both have
    /// arrived.
    pub(crate) fn even_towards_s(&self, from: Twist, wanted: Twist) -> f64 {
        let reverses = from.v_mps * wanted.v_mps < 0.0;
        let change_mps = if reverses {
            from.v_mps
        } else {
            wanted.v_mps - from.v_mps
        };
        let slows = reverses || wanted.v_mps.abs() < from.v_mps.abs();
        let rate = if slows {
            self.brake_mps2
        } else {
            self.a_mps2_max
        };
        let turn_radps = wanted.w_radps - from.w_radps;
        until_s(change_mps, rate).min(until_s(turn_radps, self.alpha_radps2_max))
    }

    /// The twist after obeying `towards` for `lasts_s`.
    pub(crate) fn obeyed(&self, from: Twist, towards: Twist, lasts_s: f64) -> Twist {
        let (mut twist, mut left_s) = (from, lasts_s);
        // To rest, on from there, and until the turn is what it should be.
        for _ in 0..2 {
            let step_s = self.even_towards_s(twist, towards).min(left_s);
            twist = self.towards(twist, towards, step_s);
            left_s -= step_s;
        }
        self.towards(twist, towards, left_s.max(0.0))
    }

    /// [s] for which [`Self::towards_rest`] changes both speeds evenly.
    pub(crate) fn even_towards_rest_s(&self, last: Twist) -> f64 {
        // The yaw rate is zero with the speed, or later, and then falls on its own.
        if last.v_mps.abs() > 0.0 {
            until_s(last.v_mps, self.brake_mps2)
        } else {
            until_s(last.w_radps, self.alpha_radps2_max)
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

/// [s] that a change takes at this rate; infinite for none.
fn until_s(change: f64, rate: f64) -> f64 {
    if change.abs() > 0.0 {
        change.abs() / rate
    } else {
        f64::INFINITY
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
    fn a_change_is_even_until_a_speed_arrives_or_turns_round() {
        // 1 m/s^2 faster, 2 m/s^2 slower, 3 rad/s^2.
        let limits = Limits {
            brake_mps2: 2.0,
            ..LIMITS
        };
        for (from, wanted, even_s) in [
            ((0.2, 0.0), (0.8, 0.0), 0.6),
            ((0.8, 0.0), (0.2, 0.0), 0.3),
            ((-0.8, 0.0), (-0.2, 0.0), 0.3),
            ((-0.2, 0.0), (-0.8, 0.0), 0.6),
            // Through rest: braking ends there, whatever comes behind it.
            ((0.4, 0.0), (-1.0, 0.0), 0.2),
            ((-0.4, 0.0), (0.1, 0.0), 0.2),
            ((0.0, 0.0), (-0.5, 0.0), 0.5),
            ((0.4, 0.0), (0.0, 0.0), 0.2),
            ((0.4, -0.3), (0.4, 0.3), 0.2),
            ((0.4, 0.3), (1.4, 0.0), 0.1),
            ((0.4, 0.3), (0.5, 0.9), 0.1),
            ((0.4, 0.3), (0.4, 0.3), f64::INFINITY),
        ] {
            let found = limits.even_towards_s(twist(from.0, from.1), twist(wanted.0, wanted.1));
            let same = (found - even_s).abs() < 1e-12 || found.total_cmp(&even_s).is_eq();
            assert!(same, "{from:?} to {wanted:?}: {found}");
        }
        for (last, even_s) in [
            ((0.4, 5.0), 0.2),
            ((-0.4, -5.0), 0.2),
            ((0.0, -0.6), 0.2),
            ((0.0, 0.0), f64::INFINITY),
        ] {
            let found = limits.even_towards_rest_s(twist(last.0, last.1));
            let same = (found - even_s).abs() < 1e-12 || found.total_cmp(&even_s).is_eq();
            assert!(same, "{last:?} to rest: {found}");
        }
    }

    #[test]
    fn towards_is_bounded_by_the_rate_of_its_direction() {
        let limits = Limits {
            brake_mps2: 2.0,
            ..LIMITS
        };
        for (from, wanted, next) in [
            ((0.2, 0.0), (1.0, 1.0), (0.3, 0.3)),
            ((0.8, 0.0), (0.0, -1.0), (0.6, -0.3)),
            ((-0.2, 0.5), (-1.0, 0.5), (-0.3, 0.5)),
            ((-0.8, 0.5), (0.0, 0.4), (-0.6, 0.4)),
            ((0.0, 0.0), (1.0, 0.0), (0.1, 0.0)),
            ((0.0, 0.0), (-1.0, 0.0), (-0.1, 0.0)),
        ] {
            let found = limits.towards(twist(from.0, from.1), twist(wanted.0, wanted.1), 0.1);
            let off = (found.v_mps - next.0)
                .abs()
                .max((found.w_radps - next.1).abs());
            assert!(off < 1e-12, "{from:?} to {wanted:?}: {found:?}");
        }
    }

    #[test]
    fn clamping_takes_the_tighter_of_both_limits() {
        let limits = Limits {
            v_mps_min: -0.5,
            ..LIMITS
        };
        for (asked, clamped) in [
            ((2.0, 8.0), (0.5, 2.0)),
            ((4.0, 4.0), (1.0, 1.0)),
            ((-1.0, 1.0), (-0.5, 0.5)),
            ((-2.0, 2.0), (-0.5, 0.5)),
            ((-0.5, 0.0), (-0.5, 0.0)),
            ((1.0, 2.0), (1.0, 2.0)),
            ((0.0, -4.0), (0.0, -2.0)),
        ] {
            let found = limits.clamp(twist(asked.0, asked.1));
            assert_eq!(found, twist(clamped.0, clamped.1), "{asked:?}");
        }
    }

    #[test]
    fn unusable_descriptions_have_no_limits() {
        assert_eq!(Limits::of(&Description::default()), None);
        let right = Description {
            v_mps_max: 1.0,
            v_mps_min: -0.5,
            w_radps_max: 2.0,
            a_mps2_max: 3.0,
            brake_mps2: 4.0,
            alpha_radps2_max: 5.0,
            ..Description::default()
        };
        let limits = Limits {
            v_mps_max: 1.0,
            v_mps_min: -0.5,
            w_radps_max: 2.0,
            a_mps2_max: 3.0,
            brake_mps2: 4.0,
            alpha_radps2_max: 5.0,
        };
        assert_eq!(Limits::of(&right), Some(limits));
        let positive: [fn(&mut Description) -> &mut f64; 5] = [
            |it| &mut it.v_mps_max,
            |it| &mut it.w_radps_max,
            |it| &mut it.a_mps2_max,
            |it| &mut it.brake_mps2,
            |it| &mut it.alpha_radps2_max,
        ];
        for (n, of) in positive.iter().enumerate() {
            for value in [f64::NAN, f64::INFINITY, 0.0, -1.0] {
                let mut wrong = right;
                *of(&mut wrong) = value;
                assert_eq!(Limits::of(&wrong), None, "number {n}: {value}");
            }
        }
        for v_mps_min in [f64::NAN, f64::NEG_INFINITY, 0.1] {
            let wrong = Description { v_mps_min, ..right };
            assert_eq!(Limits::of(&wrong), None, "{v_mps_min}");
        }
        let ahead_only = Description {
            v_mps_min: 0.0,
            ..right
        };
        assert!(Limits::of(&ahead_only).is_some());
    }
}
