//! Velocity of a differential-drive robot, and the arc that it drives.

use zeronav_msgs::Pose;
use zeronav_msgs::odometry::Odometry;

/// [m/s] and [rad/s] below which a robot counts as stopped.
const STOPPED: (f64, f64) = (0.02, 0.05);

/// Forward speed and yaw rate in `base`.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Twist {
    /// [m/s] forward.
    pub v_mps: f64,
    /// [rad/s] counter-clockwise.
    pub w_radps: f64,
}

impl Twist {
    /// No motion.
    pub const REST: Self = Self::new(0.0, 0.0);

    /// A twist from its two numbers.
    #[must_use]
    pub const fn new(v_mps: f64, w_radps: f64) -> Self {
        Self { v_mps, w_radps }
    }

    /// The twist that odometry measured.
    #[must_use]
    pub const fn measured(odometry: &Odometry) -> Self {
        Self::new(odometry.v_mps, odometry.w_radps)
    }

    /// True when both speeds are so small that the robot counts as stopped.
    #[must_use]
    pub fn is_stopped(self) -> bool {
        self.v_mps.abs() < STOPPED.0 && self.w_radps.abs() < STOPPED.1
    }

    /// Both speeds times `factor`: the same arc, slower.
    #[must_use]
    pub fn scaled(self, factor: f64) -> Self {
        Self::new(self.v_mps * factor, self.w_radps * factor)
    }

    /// The mean of two twists: the twist of a short step between them.
    #[must_use]
    pub fn mean(self, other: Self) -> Self {
        Self::new(
            0.5 * (self.v_mps + other.v_mps),
            0.5 * (self.w_radps + other.w_radps),
        )
    }

    /// `base` before the motion from `base` after `elapsed_s` of this twist: the exact arc
    /// (Fox, Burgard, Thrun 1997, Eq. 7, with the limit of a straight line).
    #[must_use]
    pub fn arc(self, elapsed_s: f64) -> Pose {
        let (chord_m, (sin, cos)) = self.chord(elapsed_s);
        Pose::new(chord_m * cos, chord_m * sin, self.w_radps * elapsed_s)
    }

    /// The chord of that arc: its length [m] and the sine and cosine of its direction, which is
    /// half the angle turned.
    #[must_use]
    pub fn chord(self, elapsed_s: f64) -> (f64, (f64, f64)) {
        let half = 0.5 * self.w_radps * elapsed_s;
        let (sin, cos) = half.sin_cos();
        // The chord of an arc of length s and angle 2h is s sin(h) / h long and points along h.
        (self.v_mps * elapsed_s * ratio(half, sin), (sin, cos))
    }
}

/// `sin(x) / x`, 1 at 0.
#[must_use]
pub fn sinc(x: f64) -> f64 {
    ratio(x, x.sin())
}

/// `sin / x` for the sine of `x`, by its series near 0.
fn ratio(x: f64, sin: f64) -> f64 {
    if x.abs() < 1.0e-4 {
        1.0 - x * x / 6.0
    } else {
        sin / x
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_arc_agrees_with_small_euler_steps() {
        let twist = Twist::new(0.8, -1.3);
        let (mut x, mut y, mut yaw) = (0.0, 0.0, 0.0_f64);
        let n = 200_000;
        let dt = 1.5 / f64::from(n);
        for _ in 0..n {
            x += twist.v_mps * dt * yaw.cos();
            y += twist.v_mps * dt * yaw.sin();
            yaw += twist.w_radps * dt;
        }
        let arc = twist.arc(1.5);
        assert!((arc.x_m - x).abs() < 1e-5 && (arc.y_m - y).abs() < 1e-5);
        assert!((arc.yaw_rad - yaw).abs() < 1e-9);
        let straight = Twist::new(0.8, 0.0).arc(2.0);
        assert!((straight.x_m - 1.6).abs() < 1e-15 && straight.y_m.abs() < 1e-15);
    }

    #[test]
    fn a_mean_lies_between_and_a_scaled_twist_on_the_same_arc() {
        let mean = Twist::new(0.4, -1.0).mean(Twist::new(0.8, 2.0));
        assert!((mean.v_mps - 0.6).abs() < 1e-12 && (mean.w_radps - 0.5).abs() < 1e-12);
        assert_eq!(Twist::new(0.4, -1.0).scaled(0.5), Twist::new(0.2, -0.5));
    }

    #[test]
    fn stopped_is_slow_in_both_ways_and_either_direction() {
        for (v, w, stopped) in [
            (0.0, 0.0, true),
            (0.019, -0.049, true),
            (-0.019, 0.049, true),
            (0.02, 0.0, false),
            (-0.03, 0.0, false),
            (0.0, 0.05, false),
            (0.0, -0.06, false),
        ] {
            assert_eq!(Twist::new(v, w).is_stopped(), stopped, "{v} m/s, {w} rad/s");
        }
    }

    #[test]
    fn sinc_is_smooth_at_its_series() {
        assert!((sinc(0.0) - 1.0).abs() < 1e-15);
        // The series and the quotient meet, 1e-8 / 6 below 1.
        for x in [0.999e-4, 1.001e-4, -1.001e-4_f64] {
            assert!((sinc(x) - (1.0 - x * x / 6.0)).abs() < 1e-15, "{x}");
        }
        assert!((sinc(0.5 * core::f64::consts::PI) - core::f64::consts::FRAC_2_PI).abs() < 1e-15);
    }
}
