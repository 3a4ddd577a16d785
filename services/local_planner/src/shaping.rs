//! Velocity shaping: the next twist on the way to a wanted one, within the accelerations and the
//! jerk.
//!
//! Shaping comes before the check that the robot can stop, so what is checked is what is published.
//! **Braking before an obstacle, for a stale input or at the end of the run is exempt from the jerk**
//! ([`zeronav_motion::towards_rest`]): the verified stop brakes at once, and a limit there would only
//! make it longer.

use zeronav_motion::{Twist, reachable};
use zeronav_msgs::description::Description;
use zeronav_params::parameters;

parameters! {
    /// How fast accelerations change; emergency braking is exempt.
    #[derive(Copy)]
    pub struct ShapingConfig {
        /// Largest jerk along the driving direction.
        jerk_mps3: f64 = 300.0, [0.1, 1.0e6] "m/s^3";
        /// Largest angular jerk.
        jerk_radps3: f64 = 2000.0, [0.1, 1.0e6] "rad/s^3";
    }
}

impl ShapingConfig {
    /// Accelerations may jump.
    pub const OFF: Self = Self {
        jerk_mps3: 1.0e6,
        jerk_radps3: 1.0e6,
    };
}

/// A speed that is none: whatever led to it has ended there. [m/s], [rad/s]
const STANDING: f64 = 1.0e-9;

/// Remembers the acceleration of the last command.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shaper {
    config: ShapingConfig,
    /// [m/s^2] and [rad/s^2] that led to it.
    a_mps2: f64,
    alpha_radps2: f64,
}

impl Shaper {
    /// At rest.
    #[must_use]
    pub const fn new(config: ShapingConfig) -> Self {
        Self {
            config,
            a_mps2: 0.0,
            alpha_radps2: 0.0,
        }
    }

    /// The twist nearest to `wanted` that a command of `period_s` reaches from `from`: within the
    /// accelerations of the robot, and with accelerations that change by no more than the jerk and
    /// can end at `wanted`. Never across rest unless `wanted` lies there, and never beyond the
    /// robot's speeds: the jerk yields to both. `from` may lie beside the last command, because the
    /// robot follows late; the acceleration that was asked for last goes on all the same.
    #[must_use]
    pub fn next(&self, robot: &Description, from: Twist, wanted: Twist, period_s: f64) -> Twist {
        let straight = reachable(robot, from, wanted, period_s);
        let known = |now: f64, rate: f64| if now.abs() > STANDING { rate } else { 0.0 };
        let a = known(from.v_mps, self.a_mps2);
        let alpha = known(from.w_radps, self.alpha_radps2);
        let jerk = &self.config;
        let v = ease(from.v_mps, wanted.v_mps, a, jerk.jerk_mps3, period_s);
        let w = ease(
            from.w_radps,
            wanted.w_radps,
            alpha,
            jerk.jerk_radps3,
            period_s,
        );
        // What the accelerations allow is on the same side as `straight`, or between it and rest.
        let bounds = |to: f64| reachable(robot, from, Twist::new(to, 0.0), period_s).v_mps;
        let mut v_mps = v.clamp(bounds(f64::NEG_INFINITY), bounds(f64::INFINITY));
        if from.v_mps * v_mps < 0.0 && from.v_mps * wanted.v_mps >= 0.0 {
            v_mps = 0.0;
        }
        let turn = robot.alpha_radps2_max * period_s;
        let w_radps = w.clamp(from.w_radps - turn, from.w_radps + turn);
        // Within the speeds; one beyond them falls towards them.
        let v_mps = if (robot.v_mps_min..=robot.v_mps_max).contains(&from.v_mps) {
            v_mps.clamp(robot.v_mps_min, robot.v_mps_max)
        } else {
            straight.v_mps
        };
        let w_radps = if from.w_radps.abs() <= robot.w_radps_max {
            w_radps.clamp(-robot.w_radps_max, robot.w_radps_max)
        } else {
            straight.w_radps
        };
        Twist::new(v_mps, w_radps)
    }

    /// Takes in that the robot brakes or does what another one decided: the way back from there is
    /// no jerk of ours, or one period of braking would go on for as long as the jerk takes to end it.
    pub fn interrupted(&mut self) {
        (self.a_mps2, self.alpha_radps2) = (0.0, 0.0);
    }

    /// Takes in the command that was published after `from`.
    pub fn published(&mut self, from: Twist, twist: Twist, period_s: f64) {
        self.a_mps2 = (twist.v_mps - from.v_mps) / period_s;
        self.alpha_radps2 = (twist.w_radps - from.w_radps) / period_s;
    }
}

/// The next value on the way from `from` to `wanted` when its rate is `rate` and may change by
/// `jerk * period`: as fast as the rate can still be brought to zero at `wanted`.
fn ease(from: f64, wanted: f64, rate: f64, jerk: f64, period_s: f64) -> f64 {
    let left = wanted - from;
    let step = jerk * period_s;
    // n periods with rates that fall by `step` cover rate^2 / (2 jerk) + rate period / 2.
    let landing = (0.25 * step * step + 2.0 * jerk * left.abs()).sqrt() - 0.5 * step;
    let straight = left / period_s;
    let best = straight.clamp(-landing.max(0.0), landing.max(0.0));
    // The last bit is done in one go when a change of the rate by one step does it.
    let best = if straight.abs() <= step {
        straight
    } else {
        best
    };
    from + best.clamp(rate - step, rate + step) * period_s
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_robot::robot;
    use proptest::prelude::*;

    const PERIOD_S: f64 = 0.02;

    fn config() -> ShapingConfig {
        ShapingConfig {
            jerk_mps3: 10.0,
            jerk_radps3: 60.0,
        }
    }

    #[test]
    fn a_step_is_an_s_that_ends_where_it_should() {
        for (from, to) in [(0.0, 0.8), (0.8, 0.2), (0.5, -0.2), (-0.3, 0.9), (0.8, 0.0)] {
            let mut shaper = Shaper::new(config());
            let mut twist = Twist::new(from, 0.0);
            let (mut rate, mut most) = (0.0_f64, 0.0_f64);
            for _ in 0..250 {
                let next = shaper.next(&robot(), twist, Twist::new(to, 0.0), PERIOD_S);
                shaper.published(twist, next, PERIOD_S);
                let now = (next.v_mps - twist.v_mps) / PERIOD_S;
                assert!(now.abs() <= 2.0 + 1e-9);
                // Passing rest is where braking becomes accelerating, with limits of their own.
                if twist.v_mps * next.v_mps > 1e-9 || (from >= 0.0 && to >= 0.0) {
                    assert!(
                        (now - rate).abs() <= 10.0 * PERIOD_S + 1e-9,
                        "{rate} to {now}"
                    );
                }
                most = most.max(now.abs());
                (rate, twist) = (now, next);
            }
            assert!((twist.v_mps - to).abs() < 1e-6, "{from} to {to}: {twist:?}");
            assert!(most > 0.5, "{from} to {to} with {most} at most");
        }
    }

    #[test]
    fn after_braking_nothing_of_its_acceleration_is_left() {
        let from = Twist::new(0.5, 0.6);
        let braked = zeronav_motion::towards_rest(&robot(), from, PERIOD_S);
        let mut shaper = Shaper::new(config());
        shaper.published(from, braked, PERIOD_S);
        let wanted = Twist::new(0.9, 1.5);
        // A command of its own goes on for as long as the jerk takes to end it.
        let slower = shaper.next(&robot(), braked, wanted, PERIOD_S);
        assert!(slower.v_mps < braked.v_mps && slower.w_radps < braked.w_radps);
        // The way back from a stop begins at once, with the jerk's first step.
        shaper.interrupted();
        let next = shaper.next(&robot(), braked, wanted, PERIOD_S);
        let (a, alpha) = (
            (next.v_mps - braked.v_mps) / PERIOD_S,
            (next.w_radps - braked.w_radps) / PERIOD_S,
        );
        assert!((a - 10.0 * PERIOD_S).abs() < 1e-9, "{a}");
        assert!((alpha - 60.0 * PERIOD_S).abs() < 1e-9, "{alpha}");
    }

    proptest! {
        #[test]
        fn commands_keep_the_limits_whatever_is_wanted(
            wanted in proptest::collection::vec((-1.0_f64..1.5, -3.0_f64..3.0, 1_usize..25), 1..30),
            brakes in proptest::collection::vec(0_usize..400, 0..3),
        ) {
            let robot = robot();
            let mut shaper = Shaper::new(config());
            let mut twist = Twist::REST;
            let (mut a, mut alpha) = (0.0_f64, 0.0_f64);
            let (mut was_at_rest, mut was_emergency) = (true, false);
            let periods = wanted.iter().flat_map(|(v, w, n)| std::iter::repeat_n((*v, *w), *n));
            for (period, (v, w)) in periods.enumerate() {
                let wanted = Twist::new(
                    v.clamp(robot.v_mps_min, robot.v_mps_max),
                    w.clamp(-robot.w_radps_max, robot.w_radps_max),
                );
                let emergency = brakes.contains(&period);
                let next = if emergency {
                    zeronav_motion::towards_rest(&robot, twist, PERIOD_S)
                } else {
                    shaper.next(&robot, twist, wanted, PERIOD_S)
                };
                if emergency {
                    shaper.interrupted();
                } else {
                    shaper.published(twist, next, PERIOD_S);
                }
                let now = (next.v_mps - twist.v_mps) / PERIOD_S;
                let turning = (next.w_radps - twist.w_radps) / PERIOD_S;
                prop_assert!(next.v_mps >= robot.v_mps_min - 1e-9);
                prop_assert!(next.v_mps <= robot.v_mps_max + 1e-9);
                prop_assert!(next.w_radps.abs() <= robot.w_radps_max + 1e-9);
                // Away from rest the acceleration holds, towards it the brakes'.
                let away = next.v_mps.abs() > twist.v_mps.abs() && twist.v_mps * next.v_mps >= 0.0;
                let bound = if away { 1.0 } else { 2.0 };
                prop_assert!(now.abs() <= bound + 1e-9, "{twist:?} to {next:?}");
                prop_assert!(turning.abs() <= 4.0 + 1e-9);
                // Exempt: emergencies, the way back from them, and where a speed ends or turns round.
                let at_rest = twist.v_mps * next.v_mps <= 1e-9;
                let at_limit = next.v_mps >= robot.v_mps_max - 1e-9
                    || next.v_mps <= robot.v_mps_min + 1e-9;
                if !emergency && !was_emergency && !at_rest && !was_at_rest && !at_limit {
                    prop_assert!((now - a).abs() <= 10.0 * PERIOD_S + 1e-9, "{a} to {now}");
                }
                let turn_ends = twist.w_radps.abs() <= 1e-9
                    || next.w_radps.abs() >= robot.w_radps_max - 1e-9;
                if !emergency && !was_emergency && !turn_ends {
                    let change = (turning - alpha).abs();
                    prop_assert!(change <= 60.0 * PERIOD_S + 1e-9, "{alpha} to {turning}");
                }
                (a, alpha, twist) = (now, turning, next);
                (was_at_rest, was_emergency) = (at_rest, emergency);
            }
        }
    }
}
