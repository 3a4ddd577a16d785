//! Where the outline can be on any way of one period: most hits are settled by one box.

use crate::limits::Limits;
use crate::outline::Outline;
use crate::sweep::{SPACING_M, STEP_S_MAX};
use core::f64::consts::FRAC_PI_2;
use nalgebra::Vector2;
use zeronav_motion::Twist;

/// A box along the axes of the `base` of now. Hits beside it tell nothing.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Swept {
    low: Vector2<f64>,
    high: Vector2<f64>,
}

/// Bounds on one kind of motion: how fast, how far, how long.
struct Drive {
    v_mps: f64,
    stop_m: f64,
    stop_s: f64,
    reaction_s: f64,
}

impl Drive {
    fn new(limits: &Limits, v_mps: f64, reaction_s: f64) -> Self {
        let braking_s = v_mps / limits.brake_mps2;
        Self {
            v_mps,
            // The last step of a ramp is a whole one.
            stop_m: v_mps * reaction_s + 0.5 * v_mps * braking_s + SPACING_M,
            stop_s: reaction_s + braking_s + STEP_S_MAX,
            reaction_s,
        }
    }

    /// [m] sideways while turning by at most `w_radps`: the speed times a heading of `w t`,
    /// integrated over reaction and ramp.
    fn aside_m(&self, w_radps: f64) -> f64 {
        let (r, b) = (self.reaction_s + STEP_S_MAX, self.stop_s - self.reaction_s);
        let turned_m = self.v_mps * w_radps * (0.5 * r * r + 0.5 * r * b + b * b / 6.0);
        (turned_m + SPACING_M).min(self.stop_m)
    }
}

impl Swept {
    /// Holds every point within `around_m` of the outline on every way that begins at one of `ends`,
    /// nears some share in [0, 1] of any of the others for at most `reaction_s` all together and then
    /// ramps to rest.
    ///
    /// Neither speed ever exceeds the larger of the ends of the way or changes to a sign that none of
    /// them has. While the robot ramps, for `v / brake` at most until it does not drive, the yaw rate
    /// only falls; what is left of it then falls by the yaw acceleration.
    pub(crate) fn new(
        limits: &Limits,
        outline: &Outline,
        ends: impl Iterator<Item = Twist>,
        reaction_s: f64,
        around_m: f64,
    ) -> Self {
        let none = [0.0; 4];
        let [ahead_mps, back_mps, left_radps, right_radps] = ends.fold(none, |most, end| {
            let [ahead, back, left, right] = most;
            [
                end.v_mps.max(ahead),
                (-end.v_mps).max(back),
                end.w_radps.max(left),
                (-end.w_radps).max(right),
            ]
        });
        let ahead = Drive::new(limits, ahead_mps, reaction_s);
        let back = Drive::new(limits, back_mps, reaction_s);
        let turned_rad = |w_radps: f64| {
            let driving_s = ahead.stop_s.max(back.stop_s);
            w_radps * (driving_s + STEP_S_MAX) + w_radps * w_radps / (2.0 * limits.alpha_radps2_max)
        };
        let most_rad = turned_rad(left_radps.max(right_radps));
        let (forward, backward, aside) = outline.extents(most_rad);
        // Beyond a quarter turn ahead is back.
        let (far_ahead_m, far_back_m) = if most_rad < FRAC_PI_2 {
            (ahead.stop_m, back.stop_m)
        } else {
            let either_m = ahead.stop_m.max(back.stop_m);
            (either_m, either_m)
        };
        let to_left_m = ahead.aside_m(left_radps).max(back.aside_m(right_radps));
        let to_right_m = ahead.aside_m(right_radps).max(back.aside_m(left_radps));
        Self {
            low: Vector2::new(
                -(far_back_m + backward + around_m),
                -(to_right_m + aside.1 + around_m),
            ),
            high: Vector2::new(
                far_ahead_m + forward + around_m,
                to_left_m + aside.0 + around_m,
            ),
        }
    }

    /// True for a point in `base` that may be within the distance asked for.
    pub(crate) fn holds(&self, point: Vector2<f64>) -> bool {
        point.x >= self.low.x
            && point.x <= self.high.x
            && point.y >= self.low.y
            && point.y <= self.high.y
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hits::Hits;
    use crate::sweep::{Space, Walked};
    use proptest::prelude::*;
    use zeronav_msgs::description::{Corner, Description};

    proptest! {
        /// With and without the points beside the box every way ends alike.
        #[test]
        fn points_beside_the_box_tell_nothing(
            shape in 0_usize..3,
            limits in (0.3..2.5_f64, -1.0..0.0_f64, 0.5..4.0_f64, 0.3..3.0_f64, 0.5..8.0_f64),
            from in (-1.0..1.0_f64, -1.0..1.0_f64),
            towards in (-1.0..1.0_f64, -1.0..1.0_f64),
            share in 0.0..1.0_f64,
            reaction_s in 0.0..0.3_f64,
            points in prop::collection::vec((-2.0..2.0_f64, -2.0..2.0_f64), 1..60),
        ) {
            let corner = |(x_m, y_m)| Corner { x_m, y_m };
            let corners: &[(f64, f64)] = match shape {
                0 => &[],
                1 => &[(0.254, 0.215), (-0.254, 0.215), (-0.254, -0.215), (0.254, -0.215)],
                _ => &[(0.6, 0.0), (-0.2, 0.3), (-0.3, 0.0), (-0.2, -0.3)],
            };
            let corners: Vec<Corner> = corners.iter().copied().map(corner).collect();
            let description = Description {
                circumscribed_radius_m: 0.3,
                ..Description::default()
            };
            let outline = Outline::new(&description, &corners);
            let limits = Limits {
                v_mps_max: limits.0,
                v_mps_min: limits.1,
                w_radps_max: limits.2,
                a_mps2_max: limits.3,
                brake_mps2: limits.3,
                alpha_radps2_max: limits.4,
            };
            let twist = |(v, w): (f64, f64)| Twist {
                v_mps: v * if v > 0.0 { limits.v_mps_max } else { -limits.v_mps_min },
                w_radps: w * limits.w_radps_max,
            };
            let (from, towards) = (twist(from), twist(towards));
            let (margin_m, enough_m) = (0.01, 0.02);
            let swept = Swept::new(&limits, &outline, [from, towards].into_iter(), reaction_s, enough_m);
            let all: Vec<Vector2<f64>> = points.iter().map(|&(x, y)| Vector2::new(x, y)).collect();
            let near: Vec<Vector2<f64>> =
                all.iter().copied().filter(|point| swept.holds(*point)).collect();
            let way = |points: &[Vector2<f64>], reaction_s: f64| {
                let mut hits = Hits::default();
                hits.refill(points.iter().copied());
                let space = Space::new(&outline, &hits, margin_m);
                let here = Walked::none(from, enough_m);
                space.way(&limits, (here, towards.scaled(share)), reaction_s, enough_m)
            };
            for reaction_s in [reaction_s, 0.25 * reaction_s] {
                let (full, fast) = (way(&all, reaction_s), way(&near, reaction_s));
                prop_assert_eq!(full.is_some(), fast.is_some());
                if let (Some(full), Some(fast)) = (full, fast) {
                    prop_assert!((full - fast).abs() < 1.0e-12, "{} {}", full, fast);
                }
            }
        }
    }

    #[test]
    fn the_box_leaves_out_what_is_beyond_any_of_its_sides() {
        let swept = Swept {
            low: Vector2::new(-1.0, -2.0),
            high: Vector2::new(3.0, 4.0),
        };
        for (x, y, holds) in [
            (0.0, 0.0, true),
            (-1.0, -2.0, true),
            (3.0, 4.0, true),
            (-1.1, 0.0, false),
            (3.1, 0.0, false),
            (0.0, -2.1, false),
            (0.0, 4.1, false),
        ] {
            assert_eq!(swept.holds(Vector2::new(x, y)), holds, "({x}, {y})");
        }
    }

    /// The corners of the box, worked out by hand. [m]
    #[test]
    fn the_box_is_as_large_as_its_bounds_say() {
        let limits = |brake_mps2| Limits {
            v_mps_max: 1.0,
            v_mps_min: -1.0,
            w_radps_max: 4.0,
            a_mps2_max: 1.0,
            brake_mps2,
            alpha_radps2_max: 4.0,
        };
        let description = Description {
            circumscribed_radius_m: 0.3,
            ..Description::default()
        };
        let corners = [(0.4, 0.2), (-0.1, 0.2), (-0.1, -0.15), (0.4, -0.15)]
            .map(|(x_m, y_m)| Corner { x_m, y_m });
        let disc = Outline::new(&description, &[]);
        let polygon = Outline::new(&description, &corners);
        let check = |outline, brake_mps2, ends: [(f64, f64); 2], reaction_s, expected: [f64; 4]| {
            let [from, to] = ends.map(|(v, w)| Twist::new(v, w));
            let swept = Swept::new(
                &limits(brake_mps2),
                outline,
                [from, to].into_iter(),
                reaction_s,
                0.05,
            );
            let found = [swept.low.x, swept.low.y, swept.high.x, swept.high.y];
            for (found, expected) in found.into_iter().zip(expected) {
                assert!(
                    (found - expected).abs() < 1e-6,
                    "{found} not {expected}: {swept:?}"
                );
            }
        };
        // 0.47 m ahead; 0.25 s and 0.55 s of turning at 0.5 rad/s: 75 mm to the left.
        let ends = [(1.0, 0.5), (0.6, 0.2)];
        check(&disc, 2.0, ends, 0.2, [-0.37, -0.37, 0.82, 0.445_208_3]);
        // More than a quarter turn: either way as far as the farther.
        let ends = [(-0.5, -3.0), (0.2, 1.0)];
        check(
            &disc,
            1.0,
            ends,
            0.1,
            [-0.545, -0.421_458_3, 0.545, 0.524_375],
        );
        // The polygon turns by 0.04125 rad.
        let ends = [(0.2, 0.1), (0.2, 0.1)];
        let expected = [-0.178_247_7, -0.236_495_3, 0.518_247_7, 0.287_303_6];
        check(&polygon, 1.0, ends, 0.1, expected);
    }
}
