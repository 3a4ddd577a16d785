//! A stretch of constant accelerations.
//!
//! Without acceleration it is an exact arc, a straight ramp is the exact parabola, and a ramp on a
//! curve (a Cornu spiral, which has no closed form) is integrated by Gauss-Legendre quadrature to
//! some 1e-12 m.

use crate::drive_state::DriveState;
use nalgebra::Vector2;
use zeronav_casts::Cast;
use zeronav_motion::Twist;
use zeronav_msgs::Pose;
use zeronav_msgs::pose::wrap_angle;

/// A stretch of constant accelerations.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Phase {
    /// When it begins. [s]
    pub(crate) from_s: f64,
    /// How.
    pub(crate) start: DriveState,
    /// [m/s^2]
    pub(crate) a_mps2: f64,
    /// [rad/s^2]
    pub(crate) alpha_radps2: f64,
}

/// One velocity on its way to its set point: the rate of change, for how long, and where it ends.
pub(crate) struct Ramp {
    /// [1/s of the velocity's unit]
    pub(crate) rate: f64,
    /// [s] infinite at the set point.
    pub(crate) lasts_s: f64,
    /// The set point, or 0 on the way through it.
    pub(crate) end: f64,
}

impl Ramp {
    /// From `value` to `target`, changing by `up` away from zero and by `down` towards it.
    pub(crate) fn of(value: f64, target: f64, up: f64, down: f64) -> Self {
        let way = target - value;
        if way == 0.0 {
            return Self {
                rate: 0.0,
                lasts_s: f64::INFINITY,
                end: target,
            };
        }
        // Towards zero while the value points away from the way to go, at most to zero.
        let slows = value * way < 0.0;
        let (end, size) = match (slows, value * target < 0.0) {
            (true, true) => (0.0, down),
            (true, false) => (target, down),
            (false, _) => (target, up),
        };
        Self {
            rate: size.copysign(way),
            lasts_s: (end - value).abs() / size,
            end,
        }
    }
}

/// Nodes and weights of five-point Gauss-Legendre quadrature on [-1, 1], exact for polynomials of
/// degree 9 (Abramowitz & Stegun, table 25.4).
const GAUSS: [(f64, f64); 5] = [
    (-0.906_179_845_938_664, 0.236_926_885_056_189_08),
    (-0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
    (0.0, 0.568_888_888_888_888_9),
    (0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
    (0.906_179_845_938_664, 0.236_926_885_056_189_08),
];

/// Largest turn of one quadrature panel. [rad] Its error then stays below 1e-12 of the way.
const PANEL_RAD: f64 = 0.5;

impl Phase {
    /// Signed way along the path after `t_s`. [m]
    pub(crate) fn advance_m(&self, t_s: f64) -> f64 {
        (self.start.twist.v_mps + 0.5 * self.a_mps2 * t_s) * t_s
    }

    fn turn_rad(&self, t_s: f64) -> f64 {
        (self.start.twist.w_radps + 0.5 * self.alpha_radps2 * t_s) * t_s
    }

    /// State `t_s` after its beginning.
    pub(crate) fn at(&self, t_s: f64) -> DriveState {
        let Pose { x_m, y_m, yaw_rad } = self.start.pose;
        let turn_rad = self.turn_rad(t_s);
        let turns = self.start.twist.w_radps != 0.0 || self.alpha_radps2 != 0.0;
        let steady = self.a_mps2 == 0.0 && self.alpha_radps2 == 0.0;
        let shift = if !turns || steady {
            // The chord of a circle: sin(h) / h of the arc, h half the turn, in the middle direction.
            let half = 0.5 * turn_rad;
            let chord_m = self.advance_m(t_s) * sinc(half);
            let (sin, cos) = (yaw_rad + half).sin_cos();
            Vector2::new(chord_m * cos, chord_m * sin)
        } else {
            self.integrate(t_s)
        };
        DriveState {
            pose: Pose::new(x_m + shift.x, y_m + shift.y, wrap_angle(yaw_rad + turn_rad)),
            twist: Twist {
                v_mps: self.start.twist.v_mps + self.a_mps2 * t_s,
                w_radps: self.start.twist.w_radps + self.alpha_radps2 * t_s,
            },
        }
    }

    /// Shift in the map frame after `t_s` on a curve with changing velocities. [m]
    fn integrate(&self, t_s: f64) -> Vector2<f64> {
        let w_end = self.start.twist.w_radps + self.alpha_radps2 * t_s;
        let w_most = self.start.twist.w_radps.abs().max(w_end.abs());
        let n_panels = (w_most * t_s / PANEL_RAD)
            .ceil()
            .clamp(1.0, 1.0e4)
            .to_usize();
        let half_s = 0.5 * t_s / n_panels.to_f64();
        let mut shift = Vector2::zeros();
        for panel in 0..n_panels {
            let middle_s = (2 * panel + 1).to_f64() * half_s;
            for (node, weight) in GAUSS {
                let at_s = middle_s + node * half_s;
                let v_mps = self.start.twist.v_mps + self.a_mps2 * at_s;
                let (sin, cos) = (self.start.pose.yaw_rad + self.turn_rad(at_s)).sin_cos();
                shift += Vector2::new(cos, sin) * (weight * half_s * v_mps);
            }
        }
        shift
    }
}

/// `sin(x) / x`, also at 0.
fn sinc(x: f64) -> f64 {
    if x.abs() < 1.0e-4 {
        1.0 - x * x / 6.0
    } else {
        x.sin() / x
    }
}
