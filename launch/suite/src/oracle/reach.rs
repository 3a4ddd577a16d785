//! Where the robot can be some time after a state at most, and whether it touches something wherever
//! it is.

use super::robot::{Abilities, Disc, State};
use nalgebra::Point2;
use zeronav_casts::Cast;

/// Steps of the integrals over a look.
const FINE: u32 = 20;

/// Largest sides of a part of the box in which the robot is taken to stand in the middle. [m], [m],
/// [rad]
const PART: [f64; 3] = [0.02, 0.02, 0.04];

/// Parts beyond which nothing is said.
const PARTS_MAX: usize = 20_000;

/// The box, in the robot's frame at the beginning, that holds every position that it can have.
#[derive(Debug)]
pub(super) struct Reach<'a> {
    state: State,
    abilities: &'a Abilities,
    t_s: f64,
    x_m: [f64; 2],
    y_m: [f64; 2],
    turned_rad: [f64; 2],
}

impl<'a> Reach<'a> {
    /// A moment without length.
    pub(super) fn new(state: &State, abilities: &'a Abilities) -> Self {
        Self {
            state: *state,
            abilities,
            t_s: 0.0,
            x_m: [0.0; 2],
            y_m: [0.0; 2],
            turned_rad: [0.0; 2],
        }
    }

    /// Grows by the time of one look. A fine step has the speeds of its end, which are the widest, and the
    /// angles of its beginning and its end.
    pub(super) fn advance(&mut self, look_s: f64) {
        let step_s = look_s / f64::from(FINE);
        for _ in 0..FINE {
            self.t_s += step_s;
            let Abilities {
                v_mps,
                w_radps_max,
                a_mps2_max,
                alpha_radps2_max,
                ..
            } = *self.abilities;
            let State {
                v_mps: v,
                w_radps: w,
                ..
            } = self.state;
            let (dv, dw) = (a_mps2_max * self.t_s, alpha_radps2_max * self.t_s);
            let speeds = [(v - dv).max(v_mps[0].min(v)), (v + dv).min(v_mps[1].max(v))];
            let rates = [
                (w - dw).max((-w_radps_max).min(w)),
                (w + dw).min(w_radps_max.max(w)),
            ];
            let before = self.turned_rad;
            self.turned_rad[0] += rates[0] * step_s;
            self.turned_rad[1] += rates[1] * step_s;
            let right = before[0].min(self.turned_rad[0]);
            let left = before[1].max(self.turned_rad[1]);
            let along = span(speeds, [right, left]);
            // sin a = cos(a - pi / 2).
            let quarter = core::f64::consts::FRAC_PI_2;
            let across = span(speeds, [right - quarter, left - quarter]);
            for (bounds, per_s) in [(&mut self.x_m, along), (&mut self.y_m, across)] {
                bounds[0] += per_s[0] * step_s;
                bounds[1] += per_s[1] * step_s;
            }
        }
    }

    /// True when a point within `slack_m` of `at_m` is in the box.
    pub(super) fn holds(&self, at_m: [f64; 2], slack_m: f64) -> bool {
        let (sin, cos) = self.state.yaw_rad.sin_cos();
        let (dx, dy) = (at_m[0] - self.state.at_m[0], at_m[1] - self.state.at_m[1]);
        let (x, y) = (cos * dx + sin * dy, cos * dy - sin * dx);
        let within = |value: f64, bounds: [f64; 2]| {
            value >= bounds[0] - slack_m && value <= bounds[1] + slack_m
        };
        within(x, self.x_m) && within(y, self.y_m)
    }

    /// True when the robot touches one of these discs wherever in the box and however turned it is.
    /// False when the box is too large to tell.
    pub(super) fn touches_anyhow(&self, discs: &[Disc]) -> bool {
        let bounds = [self.x_m, self.y_m, self.turned_rad];
        let mut parts = [1, 1, 1];
        for (n, [low, high]) in bounds.into_iter().enumerate() {
            parts[n] = (1..=PARTS_MAX)
                .find(|parts| (high - low) <= PART[n] * count(*parts))
                .unwrap_or(PARTS_MAX);
        }
        if parts.iter().product::<usize>() > PARTS_MAX {
            return false;
        }
        let side = |n: usize| (bounds[n][1] - bounds[n][0]) / count(parts[n]);
        let middle = |n: usize, part: usize| bounds[n][0] + (count(part) + 0.5) * side(n);
        // From the middle of a part no point of the robot is farther in any of it.
        let slack_m = 0.5 * (side(0).hypot(side(1)) + side(2) * self.abilities.reach_m);
        let (sin, cos) = self.state.yaw_rad.sin_cos();
        let discs: Vec<Disc> = discs
            .iter()
            .map(|([x, y], radius_m)| {
                let (dx, dy) = (x - self.state.at_m[0], y - self.state.at_m[1]);
                ([cos * dx + sin * dy, cos * dy - sin * dx], *radius_m)
            })
            .collect();
        (0..parts[2]).all(|turned| {
            let (sin, cos) = middle(2, turned).sin_cos();
            (0..parts[0]).all(|along| {
                (0..parts[1]).all(|across| {
                    let (x, y) = (middle(0, along), middle(1, across));
                    discs.iter().any(|([disc_x, disc_y], radius_m)| {
                        let (dx, dy) = (disc_x - x, disc_y - y);
                        let in_base = Point2::new(cos * dx + sin * dy, cos * dy - sin * dx);
                        self.abilities.outline.distance_to_point_m(in_base) + slack_m < *radius_m
                    })
                })
            })
        })
    }
}

fn count(n: usize) -> f64 {
    n.to_f64()
}

/// Least and largest `v cos a` for `v` and `a` in these intervals.
fn span(v: [f64; 2], angles: [f64; 2]) -> [f64; 2] {
    use core::f64::consts::{PI, TAU};
    // The largest cosine is 1 when a multiple of 2 pi lies in the interval.
    let has = |of: f64| ((angles[0] - of) / TAU).ceil() * TAU + of <= angles[1];
    let ends = [angles[0].cos(), angles[1].cos()];
    let largest = if has(0.0) { 1.0 } else { ends[0].max(ends[1]) };
    let least = if has(PI) { -1.0 } else { ends[0].min(ends[1]) };
    let products = [v[0] * least, v[0] * largest, v[1] * least, v[1] * largest];
    [
        products.into_iter().fold(f64::INFINITY, f64::min),
        products.into_iter().fold(f64::NEG_INFINITY, f64::max),
    ]
}
