//! The forces of the papers, each the full negative gradient of its potential.

use super::law::{Body, LawInput};
use nalgebra::{Point2, Vector2};

/// [m] below which a distance is taken as this: forces stay finite.
const RHO_MIN_M: f64 = 0.02;

/// Largest norm of one force.
const FORCE_MAX: f64 = 1.0e4;

/// Gains of a field.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gains {
    /// Of the attraction (`K_att`, `K`).
    pub attract: f64,
    /// Of the repulsion (`K_rep`, `eta`).
    pub repel: f64,
    /// Distance within which obstacles repel (`rho_o`, `P0`). [m or cells]
    pub reach: f64,
}

impl Gains {
    /// [JU]: 40, 5, 2 m.
    pub const JU: Self = Self {
        attract: 40.0,
        repel: 5.0,
        reach: 2.0,
    };

    /// [LWX], in cells: 5, 1, 1.5.
    pub const LWX: Self = Self {
        attract: 5.0,
        repel: 1.0,
        reach: 1.5,
    };

    /// [LWX] in metres, with cells of half a metre for a robot of that size. With cells of c metres
    /// `K d / c` balances `K_rep c^3 (1/rho - 1/P0) / rho^2`, so that
    /// `K_rep` is `c^4` of that in cells.
    pub const LWX_M: Self = Self {
        attract: 5.0,
        repel: 0.0625,
        reach: 0.75,
    };
}

/// [JU] eq. 5 with the vector instead of its norm: `-K_att (X - Xg)`.
#[must_use]
pub fn attraction(gain: f64, at: Point2<f64>, goal: Point2<f64>) -> Vector2<f64> {
    (goal - at) * gain
}

/// Distance to a repelling point, floored, and the direction away from it; `None` beyond `reach`.
fn away(reach: f64, at: Point2<f64>, from: Point2<f64>) -> Option<(f64, Vector2<f64>)> {
    let offset = at - from;
    let distance = offset.norm();
    let direction = offset.try_normalize(1.0e-12).unwrap_or_else(Vector2::x);
    (distance <= reach).then_some((distance.max(RHO_MIN_M), direction))
}

/// [JU] eq. 4: `1/2 K_rep (1/rho - 1/rho_o)^2` within `rho_o`, else 0.
#[must_use]
pub fn repulsion_potential(gains: &Gains, at: Point2<f64>, from: Point2<f64>) -> f64 {
    away(gains.reach, at, from).map_or(0.0, |(rho, _)| {
        0.5 * gains.repel * (1.0 / rho - 1.0 / gains.reach).powi(2)
    })
}

/// [JU] eq. 6 with the unit vector: `K_rep (1/rho - 1/rho_o) / rho^2` away from the obstacle.
#[must_use]
pub fn repulsion(gains: &Gains, at: Point2<f64>, from: Point2<f64>) -> Vector2<f64> {
    away(gains.reach, at, from).map_or_else(Vector2::zeros, |(rho, direction)| {
        let size = gains.repel * (1.0 / rho - 1.0 / gains.reach) / (rho * rho);
        direction * size.min(FORCE_MAX)
    })
}

/// [ZM] eq. 6: the repulsion's potential times `d^n`, `d` the distance to the goal.
#[must_use]
pub fn goal_repulsion_potential(
    gains: &Gains,
    n: i32,
    at: Point2<f64>,
    from: Point2<f64>,
    goal: Point2<f64>,
) -> f64 {
    repulsion_potential(gains, at, from) * (at - goal).norm().powi(n)
}

/// [ZM] eq. 7 and 8 as the full gradient, with `1/rho^2` and the part towards the goal.
#[must_use]
pub fn goal_repulsion(
    gains: &Gains,
    n: i32,
    at: Point2<f64>,
    from: Point2<f64>,
    goal: Point2<f64>,
) -> Vector2<f64> {
    let to_goal = goal - at;
    let d = to_goal.norm();
    let Some((rho, direction)) = away(gains.reach, at, from) else {
        return Vector2::zeros();
    };
    let nearness = 1.0 / rho - 1.0 / gains.reach;
    let first = direction * (gains.repel * nearness / (rho * rho) * d.powi(n)).min(FORCE_MAX);
    let towards = to_goal
        .try_normalize(1.0e-12)
        .unwrap_or_else(Vector2::zeros);
    let half_n = 0.5 * f64::from(n);
    let size = half_n * gains.repel * nearness * nearness * d.powi(n - 1);
    first + towards * size.min(FORCE_MAX)
}

/// The gain of the repulsion by the distance to the obstacle, [ZM] eq. 5.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Eta {
    /// Gain near the obstacle, above 1.
    pub alpha: f64,
    /// Slope further away. [1/m]
    pub beta: f64,
    /// Distance within which obstacles repel. [m]
    pub p0: f64,
    /// Whether the gain is differentiated like the rest of the potential (`F_rep3`).
    pub is_differentiated: bool,
}

impl Eta {
    /// The gain and its slope at a distance.
    fn at(&self, rho: f64) -> (f64, f64) {
        if rho <= self.p0 / self.alpha {
            let gain = self.alpha * (rho - self.p0).exp();
            (gain, gain)
        } else if rho <= self.p0 {
            (self.beta * rho, self.beta)
        } else {
            (0.0, 0.0)
        }
    }
}

/// [ZM] eq. 6 with the gain of eq. 5.
#[must_use]
pub fn eta_repulsion_potential(
    eta: &Eta,
    n: i32,
    at: Point2<f64>,
    from: Point2<f64>,
    goal: Point2<f64>,
) -> f64 {
    let Some((rho, _)) = away(eta.p0, at, from) else {
        return 0.0;
    };
    let nearness = 1.0 / rho - 1.0 / eta.p0;
    0.5 * eta.at(rho).0 * nearness * nearness * (at - goal).norm().powi(n)
}

/// [ZM] eq. 7 and 8 with the gain of eq. 5: the gradient for the gain as it is there, and that of the
/// gain too when it is differentiated.
#[must_use]
pub fn eta_repulsion(
    eta: &Eta,
    n: i32,
    at: Point2<f64>,
    from: Point2<f64>,
    goal: Point2<f64>,
) -> Vector2<f64> {
    let Some((rho, direction)) = away(eta.p0, at, from) else {
        return Vector2::zeros();
    };
    let (gain, slope) = eta.at(rho);
    let gains = Gains {
        attract: 0.0,
        repel: gain,
        reach: eta.p0,
    };
    let force = goal_repulsion(&gains, n, at, from, goal);
    if !eta.is_differentiated {
        return force;
    }
    let nearness = 1.0 / rho - 1.0 / eta.p0;
    force - direction * (0.5 * slope * nearness * nearness * (at - goal).norm().powi(n))
}

/// [ZM] eq. 11 by vectors: sideways, to the side to which the relative motion leans, strongest
/// head-on; nothing from what recedes or is farther than `reach`.
#[must_use]
pub fn velocity_repulsion(
    gain: f64,
    reach: f64,
    at: Point2<f64>,
    velocity: Vector2<f64>,
    body: &Body,
) -> Vector2<f64> {
    let q = body.at - at;
    let v = velocity - body.velocity;
    let distance = q.norm();
    if q.dot(&v) <= 0.0 || distance > reach || distance < RHO_MIN_M {
        return Vector2::zeros();
    }
    let theta = q.perp(&v).atan2(q.dot(&v));
    let side = if theta < 0.0 { -1.0 } else { 1.0 };
    let left = Vector2::new(-q.y, q.x) / distance;
    left * (side * gain * v.norm() / distance * theta.cos())
}

/// Sum of [`repulsion`] over the bodies of an input.
#[must_use]
pub fn all_repulsions(gains: &Gains, input: &LawInput<'_>) -> Vector2<f64> {
    input.bodies.iter().fold(Vector2::zeros(), |sum, body| {
        sum + repulsion(gains, input.at, body.nearest(input.at, input.literal))
    })
}

/// Sum of [`goal_repulsion`] over the bodies of an input.
#[must_use]
pub fn all_goal_repulsions(
    gains: &Gains,
    n: i32,
    input: &LawInput<'_>,
    goal: Point2<f64>,
) -> Vector2<f64> {
    input.bodies.iter().fold(Vector2::zeros(), |sum, body| {
        let from = body.nearest(input.at, input.literal);
        sum + goal_repulsion(gains, n, input.at, from, goal)
    })
}
