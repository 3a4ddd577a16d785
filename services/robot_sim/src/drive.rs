//! Differential drive: how a unicycle moves towards a set point within its limits.
//!
//! A tick is cut where an acceleration begins or ends, so inside each phase forward and yaw
//! acceleration are constant. The whole tick can be asked for its state at any moment: contacts and
//! scans fall between ticks.

use crate::drive_state::DriveState;
use crate::phase::{Phase, Ramp};
use zeronav_motion::Twist;

/// What the motors can do. All but `v_mps_min` are positive.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DriveLimits {
    /// [m/s] fastest forward speed.
    pub v_mps_max: f64,
    /// [m/s] fastest backward speed, <= 0.
    pub v_mps_min: f64,
    /// [rad/s] fastest yaw rate either way.
    pub w_radps_max: f64,
    /// [m/s^2] largest change of speed away from zero.
    pub speed_up_mps2: f64,
    /// [m/s^2] largest change of speed towards zero.
    pub slow_down_mps2: f64,
    /// [rad/s^2] largest change of yaw rate.
    pub alpha_radps2: f64,
}

impl DriveLimits {
    /// The twist nearest to `asked` that the motors can hold; a NaN anywhere means stop.
    #[must_use]
    pub fn clamp(&self, asked: Twist) -> Twist {
        if asked.v_mps.is_nan() || asked.w_radps.is_nan() {
            return Twist::REST;
        }
        Twist {
            v_mps: asked.v_mps.clamp(self.v_mps_min, self.v_mps_max),
            w_radps: asked.w_radps.clamp(-self.w_radps_max, self.w_radps_max),
        }
    }
}

/// Two breaks each of speed and yaw rate (zero crossing, set point) make five phases.
const PHASES_MAX: usize = 5;

/// The motion of one tick, if nothing is in the way.
#[derive(Debug, Clone, Copy)]
pub struct Motion {
    phases: [Phase; PHASES_MAX],
    n_phases: usize,
    duration_s: f64,
}

impl Motion {
    /// From `start` towards the velocity `target` for `duration_s` (>= 0), as fast as `limits`
    /// allow, then holding it. `target` is taken as it is; see [`DriveLimits::clamp`].
    #[must_use]
    pub fn towards(
        start: DriveState,
        target: Twist,
        limits: &DriveLimits,
        duration_s: f64,
    ) -> Self {
        let idle = Phase {
            from_s: 0.0,
            start,
            a_mps2: 0.0,
            alpha_radps2: 0.0,
        };
        let mut motion = Self {
            phases: [idle; PHASES_MAX],
            n_phases: 0,
            duration_s,
        };
        let mut state = start;
        let mut from_s = 0.0;
        while motion.n_phases < PHASES_MAX {
            let v = Ramp::of(
                state.twist.v_mps,
                target.v_mps,
                limits.speed_up_mps2,
                limits.slow_down_mps2,
            );
            let w = Ramp::of(
                state.twist.w_radps,
                target.w_radps,
                limits.alpha_radps2,
                limits.alpha_radps2,
            );
            let phase = Phase {
                from_s,
                start: state,
                a_mps2: v.rate,
                alpha_radps2: w.rate,
            };
            motion.phases[motion.n_phases] = phase;
            motion.n_phases += 1;
            let lasts_s = v.lasts_s.min(w.lasts_s);
            if from_s + lasts_s >= duration_s {
                break;
            }
            from_s += lasts_s;
            state = phase.at(lasts_s);
            // Exactly the end of the ramp, not a rounding beside it.
            if v.lasts_s <= lasts_s {
                state.twist.v_mps = v.end;
            }
            if w.lasts_s <= lasts_s {
                state.twist.w_radps = w.end;
            }
        }
        motion
    }

    /// The same motion of the wheels as the ground sees it when `forward` of their speed and `turn`
    /// of their yaw rate reach it, both 0 to 1, from the same pose.
    #[must_use]
    pub fn slipped(&self, forward: f64, turn: f64) -> Self {
        let mut slipped = *self;
        let mut pose = self.phases[0].start.pose;
        for index in 0..self.n_phases {
            let phase = &mut slipped.phases[index];
            phase.start.pose = pose;
            phase.start.twist.v_mps *= forward;
            phase.start.twist.w_radps *= turn;
            phase.a_mps2 *= forward;
            phase.alpha_radps2 *= turn;
            if index + 1 < self.n_phases {
                pose = phase.at(self.phases[index + 1].from_s - phase.from_s).pose;
            }
        }
        slipped
    }

    /// State `t_s` seconds after the start, clamped to `0..=duration`.
    #[must_use]
    pub fn at(&self, t_s: f64) -> DriveState {
        let t_s = t_s.clamp(0.0, self.duration_s);
        let phase = self.phase_at(t_s);
        phase.at(t_s - phase.from_s)
    }

    /// Length of the way driven in the first `t_s` seconds, forwards and backwards. [m]
    #[must_use]
    pub fn driven_m(&self, t_s: f64) -> f64 {
        let t_s = t_s.clamp(0.0, self.duration_s);
        let mut driven_m = 0.0;
        for (i, phase) in self.phases[..self.n_phases].iter().enumerate() {
            if phase.from_s > t_s {
                break;
            }
            let to_s = match self.phases[..self.n_phases].get(i + 1) {
                Some(next) => next.from_s.min(t_s),
                None => t_s,
            };
            // Phases end where the speed changes sign, so this is the length, not only the shift.
            driven_m += phase.advance_m(to_s - phase.from_s).abs();
        }
        driven_m
    }

    /// Largest speed and yaw rate on the way, both as positive numbers.
    #[must_use]
    pub fn fastest(&self) -> Twist {
        let end = self.at(self.duration_s);
        self.phases[..self.n_phases]
            .iter()
            .map(|phase| phase.start.twist)
            .chain([end.twist])
            .fold(Twist::REST, |most, twist| Twist {
                v_mps: most.v_mps.max(twist.v_mps.abs()),
                w_radps: most.w_radps.max(twist.w_radps.abs()),
            })
    }

    /// How long it lasts. [s]
    #[must_use]
    pub const fn duration_s(&self) -> f64 {
        self.duration_s
    }

    fn phase_at(&self, t_s: f64) -> &Phase {
        self.phases[..self.n_phases]
            .iter()
            .rev()
            .find(|phase| phase.from_s <= t_s)
            .unwrap_or(&self.phases[0])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f64::consts::{FRAC_PI_2, PI};
    use rand::RngExt as _;
    use rand::SeedableRng as _;
    use rand_pcg::Pcg64Mcg;
    use zeronav_msgs::Pose;
    use zeronav_msgs::pose::wrap_angle;

    const LIMITS: DriveLimits = DriveLimits {
        v_mps_max: 1.5,
        v_mps_min: -0.5,
        w_radps_max: 2.0,
        speed_up_mps2: 1.0,
        slow_down_mps2: 2.0,
        alpha_radps2: 4.0,
    };

    fn state(pose: Pose, v_mps: f64, w_radps: f64) -> DriveState {
        DriveState {
            pose,
            twist: Twist { v_mps, w_radps },
        }
    }

    fn twist(v_mps: f64, w_radps: f64) -> Twist {
        Twist { v_mps, w_radps }
    }

    #[track_caller]
    fn close(a: f64, b: f64, tolerance: f64) {
        assert!((a - b).abs() <= tolerance, "{a} is not {b} +- {tolerance}");
    }

    /// The same motion by very many small Euler-midpoint steps.
    fn brute(start: DriveState, target: Twist, duration_s: f64) -> DriveState {
        let n = 200_000_u32;
        let h = duration_s / f64::from(n);
        let mut s = start;
        for _ in 0..n {
            let step = |value: f64, target: f64, up: f64, down: f64| {
                let slows = (target - value) * value < 0.0;
                let most = if slows { down } else { up } * h;
                value + (target - value).clamp(-most, most)
            };
            let v = step(
                s.twist.v_mps,
                target.v_mps,
                LIMITS.speed_up_mps2,
                LIMITS.slow_down_mps2,
            );
            let w = step(
                s.twist.w_radps,
                target.w_radps,
                LIMITS.alpha_radps2,
                LIMITS.alpha_radps2,
            );
            let (vm, wm) = (0.5 * (v + s.twist.v_mps), 0.5 * (w + s.twist.w_radps));
            let heading = s.pose.yaw_rad + 0.5 * wm * h;
            s.pose.x_m += vm * h * heading.cos();
            s.pose.y_m += vm * h * heading.sin();
            s.pose.yaw_rad += wm * h;
            s.twist = twist(v, w);
        }
        s.pose.yaw_rad = wrap_angle(s.pose.yaw_rad);
        s
    }

    #[test]
    fn a_steady_twist_is_an_exact_arc() {
        // Radius 0.5 m, a quarter turn to the left around (1, 2.5).
        let start = state(Pose::new(1.0, 2.0, 0.0), 0.5, 1.0);
        let motion = Motion::towards(start, start.twist, &LIMITS, FRAC_PI_2);
        let end = motion.at(FRAC_PI_2);
        close(end.pose.x_m, 1.5, 1e-12);
        close(end.pose.y_m, 2.5, 1e-12);
        close(end.pose.yaw_rad, FRAC_PI_2, 1e-12);
        close(motion.driven_m(FRAC_PI_2), 0.5 * FRAC_PI_2, 1e-12);
        let half = motion.at(0.25 * PI);
        let (sin, cos) = (0.25 * PI).sin_cos();
        close(half.pose.x_m, 1.0 + 0.5 * sin, 1e-12);
        close(half.pose.y_m, 2.5 - 0.5 * cos, 1e-12);
    }

    #[test]
    fn the_stop_distance_is_v_squared_over_twice_the_brake() {
        let start = state(Pose::new(0.0, 0.0, PI / 6.0), 1.5, 0.0);
        let motion = Motion::towards(start, Twist::REST, &LIMITS, 2.0);
        let stop_m = 1.5 * 1.5 / (2.0 * 2.0);
        let end = motion.at(2.0);
        close(end.pose.distance_m(&start.pose), stop_m, 1e-12);
        close(motion.driven_m(2.0), stop_m, 1e-12);
        close(end.pose.y_m, 0.5 * stop_m, 1e-12);
        assert_eq!(end.twist, Twist::REST);
        close(motion.at(0.75 - 1e-6).twist.v_mps, 2e-6, 1e-12);
    }

    #[test]
    fn reversing_brakes_first_and_counts_both_ways() {
        // 1 m/s to zero in 0.5 s over 0.25 m, then back: 0.5 m/s after 0.5 s and 0.125 m.
        let start = state(Pose::new(0.0, 0.0, 0.0), 1.0, 0.0);
        let motion = Motion::towards(start, twist(-0.5, 0.0), &LIMITS, 1.0);
        close(motion.at(0.5).pose.x_m, 0.25, 1e-12);
        close(motion.at(1.0).pose.x_m, 0.125, 1e-12);
        close(motion.at(1.0).twist.v_mps, -0.5, 1e-12);
        close(motion.driven_m(1.0), 0.375, 1e-12);
        close(motion.fastest().v_mps, 1.0, 1e-12);
    }

    #[test]
    fn ramps_on_curves_agree_with_brute_force() {
        let seed = 7;
        let mut rng = Pcg64Mcg::seed_from_u64(seed);
        for case in 0..12 {
            let start = state(
                Pose::new(rng.random(), rng.random(), rng.random_range(-3.0..3.0)),
                rng.random_range(-0.5..1.5),
                rng.random_range(-2.0..2.0),
            );
            let target = twist(rng.random_range(-0.5..1.5), rng.random_range(-2.0..2.0));
            let duration_s = rng.random_range(0.01..2.0);
            let exact = Motion::towards(start, target, &LIMITS, duration_s).at(duration_s);
            let brute = brute(start, target, duration_s);
            eprintln!("seed {seed} case {case}: {exact:?} {brute:?}");
            // The brute steps overlook where in a step a ramp ends: first order there.
            close(exact.pose.x_m, brute.pose.x_m, 1e-4);
            close(exact.pose.y_m, brute.pose.y_m, 1e-4);
            close(
                wrap_angle(exact.pose.yaw_rad - brute.pose.yaw_rad),
                0.0,
                1e-4,
            );
            close(exact.twist.v_mps, brute.twist.v_mps, 1e-4);
            close(exact.twist.w_radps, brute.twist.w_radps, 1e-4);
        }
    }

    #[test]
    fn cutting_a_motion_in_two_changes_nothing() {
        let start = state(Pose::new(0.3, -0.2, 1.0), -0.4, 1.7);
        let target = twist(1.5, -2.0);
        let whole = Motion::towards(start, target, &LIMITS, 1.6);
        let first = Motion::towards(start, target, &LIMITS, 0.7).at(0.7);
        let second = Motion::towards(first, target, &LIMITS, 0.9).at(0.9);
        let end = whole.at(1.6);
        close(second.pose.x_m, end.pose.x_m, 1e-11);
        close(second.pose.y_m, end.pose.y_m, 1e-11);
        close(second.pose.yaw_rad, end.pose.yaw_rad, 1e-11);
        close(
            whole.driven_m(1.6),
            whole.driven_m(0.7) + Motion::towards(first, target, &LIMITS, 0.9).driven_m(0.9),
            1e-11,
        );
    }

    #[test]
    fn slip_scales_the_motion_and_full_grip_changes_nothing() {
        let start = state(Pose::new(0.3, -0.2, 1.0), -0.4, 0.0);
        let wheels = Motion::towards(start, twist(1.5, 0.0), &LIMITS, 1.6);
        let ground = wheels.slipped(0.5, 0.1);
        for t_s in [0.0, 0.3, 0.9, 1.6] {
            close(ground.driven_m(t_s), 0.5 * wheels.driven_m(t_s), 1e-12);
            let (a, b) = (ground.at(t_s), wheels.at(t_s));
            close(a.pose.x_m - 0.3, 0.5 * (b.pose.x_m - 0.3), 1e-12);
            close(a.twist.v_mps, 0.5 * b.twist.v_mps, 1e-12);
        }
        // On a curve: the same as wheels that are told to do less, phase by phase.
        let start = state(Pose::new(0.3, -0.2, 1.0), 1.0, 0.5);
        let wheels = Motion::towards(start, twist(1.5, -2.0), &LIMITS, 1.6);
        assert_eq!(wheels.slipped(1.0, 1.0).at(1.6), wheels.at(1.6));
        let steady = Motion::towards(start, start.twist, &LIMITS, 2.0).slipped(0.8, 0.6);
        let less = state(start.pose, 0.8, 0.3);
        let same = Motion::towards(less, less.twist, &LIMITS, 2.0);
        close(steady.at(2.0).pose.x_m, same.at(2.0).pose.x_m, 1e-12);
        close(
            steady.at(2.0).pose.yaw_rad,
            same.at(2.0).pose.yaw_rad,
            1e-12,
        );
    }

    #[test]
    fn set_points_are_clamped_and_nan_stops() {
        assert_eq!(LIMITS.clamp(twist(9.0, -9.0)), twist(1.5, -2.0));
        assert_eq!(LIMITS.clamp(twist(-9.0, 0.1)), twist(-0.5, 0.1));
        assert_eq!(LIMITS.clamp(twist(f64::INFINITY, 0.0)), twist(1.5, 0.0));
        assert_eq!(LIMITS.clamp(twist(f64::NAN, 1.0)), Twist::REST);
        assert_eq!(LIMITS.clamp(twist(1.0, f64::NAN)), Twist::REST);
    }

    #[test]
    fn no_time_is_no_motion() {
        let start = state(Pose::new(1.0, 1.0, 1.0), 1.0, 1.0);
        let motion = Motion::towards(start, Twist::REST, &LIMITS, 0.0);
        assert_eq!(motion.at(0.0), start);
        assert_eq!(motion.at(5.0), start);
        close(motion.driven_m(1.0), 0.0, 0.0);
    }
}
