//! The way a robot takes when it obeys a command for the reaction time and then brakes, and
//! whether that way is free.

use crate::hits::Hits;
use crate::limits::Limits;
use crate::outline::Outline;
use nalgebra::Vector2;
use zeronav_motion::Twist;

/// [m] the outline moves at most from one looked-at pose to the next. Half of it is the smallest
/// margin that proves that nothing was touched in between.
pub(crate) const SPACING_M: f64 = 0.02;

/// [m] by which a pose may be off, and a robot inside the margin nearer than before, all together.
/// Steps are shorter by twice as much, so that half of the spacing stays the bound that it is.
const OFF_M: f64 = 1.0e-5;

/// [s] shortest step, so that every step goes on: what a ramp does in it is below rounding.
const STEP_S_MIN: f64 = 1.0e-6;

/// [s] longest step.
pub(crate) const STEP_S_MAX: f64 = 0.05;

/// Most poses of one way.
const POSES_MAX: u32 = 1000;

/// [m] by which a robot inside the margin may come nearer in one way: rounding, not motion.
const TOLERANCE_M: f64 = 1.0e-6;

/// What must be kept free, as of one period.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Space<'a> {
    pub(crate) outline: &'a Outline,
    pub(crate) hits: &'a Hits,
    /// [m] that shall stay free around the outline.
    margin_m: f64,
    /// [m] that is free now, at most the margin. Inside the margin the robot comes no nearer.
    now_m: f64,
}

/// How far a walk has come.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Walked {
    /// In `base` of now. [m]
    at: Vector2<f64>,
    /// Sine and cosine.
    heading: (f64, f64),
    pub(crate) twist: Twist,
    /// Least distance to a hit so far. [m]
    least_m: f64,
    /// What the outline may still move before another look can tell anything new. [m]
    blind_m: f64,
    poses: u32,
}

impl Walked {
    /// Nothing yet: the robot is where it is, and only what is nearer than `enough_m` matters.
    pub(crate) fn none(twist: Twist, enough_m: f64) -> Self {
        Self {
            at: Vector2::zeros(),
            heading: (0.0, 1.0),
            twist,
            least_m: enough_m,
            blind_m: 0.0,
            poses: 0,
        }
    }
}

/// One leg of a walk.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Leg {
    /// Nears a twist for so long. [s]
    Obey(Twist, f64),
    /// Keeps the twist for so long. [s]
    Keep(f64),
    /// Ramps to rest as [`Limits::towards_rest`] does.
    Brake,
}

impl Leg {
    /// [s]; a ramp lasts as long as it takes.
    pub(crate) const fn lasts_s(self) -> f64 {
        match self {
            Self::Obey(_, lasts_s) | Self::Keep(lasts_s) => lasts_s,
            Self::Brake => f64::INFINITY,
        }
    }

    /// The twist behind it.
    pub(crate) fn after(self, limits: &Limits, twist: Twist) -> Twist {
        match self {
            Self::Obey(towards, lasts_s) => limits.obeyed(twist, towards, lasts_s),
            Self::Keep(_) => twist,
            Self::Brake => Twist::REST,
        }
    }

    /// The twist that it nears, if it is not the one that it begins with.
    pub(crate) const fn towards(self) -> Option<Twist> {
        match self {
            Self::Obey(towards, _) => Some(towards),
            Self::Keep(_) => None,
            Self::Brake => Some(Twist::REST),
        }
    }
}

/// What one look leaves for the next.
struct Look {
    /// Room for the outline at a pose.
    placed: Outline,
    /// The run of hits that was nearest.
    nearest: usize,
}

/// What comes nearest to a way.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Nearest {
    /// The hit in `base` of now and its least distance to the outline. [m]
    pub(crate) hit: Option<(Vector2<f64>, f64)>,
    /// The way is free.
    pub(crate) is_free: bool,
}

impl<'a> Space<'a> {
    /// The space around a robot that shall keep `margin_m`.
    pub(crate) fn new(outline: &'a Outline, hits: &'a Hits, margin_m: f64) -> Self {
        let now_m = hits.nearest_m(outline, margin_m, &mut 0);
        Self {
            outline,
            hits,
            margin_m,
            now_m,
        }
    }

    /// Least distance at a pose when that pose is free, at most `enough_m`. [m]
    ///
    /// Where points lie inside the outline already (noise, a person who came too near), each of
    /// them counts for itself: none may get nearer than the margin, or deeper than it is.
    fn free_m(
        &self,
        look: &mut Look,
        at: Vector2<f64>,
        heading: (f64, f64),
        enough_m: f64,
    ) -> Option<f64> {
        let Look { placed, nearest } = look;
        placed.place(self.outline, at, heading);
        let here_m = self.hits.nearest_m(placed, enough_m, nearest);
        if self.now_m > 0.0 {
            return (here_m >= self.margin_m.min(self.now_m - TOLERANCE_M)).then_some(here_m);
        }
        let free = self.hits.iter().all(|hit| {
            let now_m = self.outline.distance_m(hit, self.margin_m);
            let then_m = placed.distance_m(hit, self.margin_m);
            then_m >= self.margin_m.min(now_m - TOLERANCE_M)
        });
        free.then_some(here_m)
    }

    /// The way up to where a command of now takes effect: of what is `walked` already, these legs;
    /// `None` when that is not free.
    pub(crate) fn lead(
        &self,
        limits: &Limits,
        mut walked: Walked,
        legs: impl Iterator<Item = Leg>,
        enough_m: f64,
    ) -> Option<Walked> {
        let mut look = Look {
            placed: *self.outline,
            nearest: 0,
        };
        for leg in legs {
            self.walk(limits, &mut walked, leg, enough_m, |at, heading, far_m| {
                self.free_m(&mut look, at, heading, far_m)
            })?;
        }
        // What follows may have as many poses of its own.
        Some(Walked { poses: 0, ..walked })
    }

    /// Least distance between the outline and the points along the way, at most `enough_m`;
    /// `None` when the way is not free. [m]
    ///
    /// The way begins where the robot has `walked` to, nears `towards` within the limits for
    /// `reaction_s` and ramps to rest as [`Limits::towards_rest`] does.
    pub(crate) fn way(
        &self,
        limits: &Limits,
        (mut walked, towards): (Walked, Twist),
        reaction_s: f64,
        enough_m: f64,
    ) -> Option<f64> {
        let mut look = Look {
            placed: *self.outline,
            nearest: 0,
        };
        for leg in [Leg::Obey(towards, reaction_s), Leg::Brake] {
            self.walk(limits, &mut walked, leg, enough_m, |at, heading, far_m| {
                self.free_m(&mut look, at, heading, far_m)
            })?;
        }
        Some(walked.least_m)
    }

    /// The hit that is nearest to a way of these legs up to the first pose that is not free, if one is
    /// nearer than `enough_m`, and its distance there. [m]
    pub(crate) fn nearest_on_way(
        &self,
        limits: &Limits,
        mut walked: Walked,
        mut legs: impl Iterator<Item = Leg>,
        enough_m: f64,
    ) -> Nearest {
        let mut placed = *self.outline;
        let mut look = Look { placed, nearest: 0 };
        let mut found: Option<(Vector2<f64>, f64)> = None;
        let is_free = legs.all(|leg| {
            let walk = self.walk(limits, &mut walked, leg, enough_m, |at, heading, far_m| {
                let free_m = self.free_m(&mut look, at, heading, far_m);
                placed.place(self.outline, at, heading);
                let mut nearest = look.nearest;
                let (here_m, hit) = self.hits.nearest(&placed, far_m, &mut nearest);
                // What ends the way decides, whatever came nearer before.
                if let Some(hit) = hit
                    && (free_m.is_none() || found.is_none_or(|(_, least_m)| here_m < least_m))
                {
                    found = Some((hit, here_m));
                }
                free_m
            });
            walk.is_some()
        });
        Nearest {
            hit: found.filter(|(_, least_m)| *least_m < enough_m),
            is_free,
        }
    }

    /// Goes on by a leg and asks `look` for the least distance at every pose that can tell anything
    /// new, given by place, sine and cosine of the heading, and how far to look; `None` with the first
    /// that is not free.
    fn walk(
        &self,
        limits: &Limits,
        walked: &mut Walked,
        leg: Leg,
        enough_m: f64,
        mut look: impl FnMut(Vector2<f64>, (f64, f64), f64) -> Option<f64>,
    ) -> Option<()> {
        let mut left_s = leg.lasts_s();
        while walked.poses < POSES_MAX {
            let twist = walked.twist;
            if left_s <= 0.0 || (matches!(leg, Leg::Brake) && twist == Twist::REST) {
                return Some(());
            }
            walked.poses += 1;
            // Both speeds change evenly within a step, so none exceeds what it has at the ends.
            let (end, even_s) = match leg {
                Leg::Obey(towards, _) => (towards, limits.even_towards_s(twist, towards)),
                Leg::Keep(_) => (twist, f64::INFINITY),
                Leg::Brake => (Twist::REST, limits.even_towards_rest_s(twist)),
            };
            let fastest_mps = self.outline.speed_mps(faster(twist, end));
            let step_s = ((SPACING_M - 2.0 * OFF_M) / fastest_mps)
                .min(STEP_S_MAX)
                .min(even_s.min(left_s))
                .max(STEP_S_MIN);
            left_s -= step_s;
            let next = match leg {
                Leg::Obey(towards, _) => limits.towards(twist, towards, step_s),
                Leg::Keep(_) => twist,
                Leg::Brake => limits.towards_rest(twist, step_s),
            };
            let (moved, half) = moved(twist, next, step_s);
            walked.at += turned_by(walked.heading, moved);
            walked.heading = turned(turned(walked.heading, half), half);
            walked.blind_m -= self.outline.speed_mps(faster(twist, next)) * step_s;
            walked.twist = next;
            if walked.blind_m > 0.0 {
                continue;
            }
            // Far enough to see what the next moves cannot reach.
            let far_m = enough_m + 0.5;
            let here_m = look(walked.at, walked.heading, far_m)?;
            walked.least_m = walked.least_m.min(here_m);
            walked.blind_m = here_m - enough_m;
        }
        // A way of so many poses ends nowhere near.
        None
    }
}

/// The larger of each speed, without its direction.
fn faster(a: Twist, b: Twist) -> Twist {
    Twist {
        v_mps: a.v_mps.abs().max(b.v_mps.abs()),
        w_radps: a.w_radps.abs().max(b.w_radps.abs()),
    }
}

/// The motion of a step in which both speeds change evenly: in `base` before it [m], and sine and
/// cosine of half the angle turned.
///
/// The mean twist drives an arc; the true way curves more where the robot is faster or turns more,
/// and ends beside that arc by the second term of the Magnus expansion (Magnus, "On the exponential
/// solution of differential equations for a linear operator", 1954). What is left out is of the
/// fifth order in the step.
fn moved(from: Twist, to: Twist, step_s: f64) -> (Vector2<f64>, (f64, f64)) {
    let mean = from.mean(to);
    let (chord_m, half) = mean.chord(step_s);
    let (dv_mps, dw_radps) = (to.v_mps - from.v_mps, to.w_radps - from.w_radps);
    let beside_m = (dv_mps * mean.w_radps - mean.v_mps * dw_radps) * step_s * step_s / 12.0;
    (turned_by(half, Vector2::new(chord_m, beside_m)), half)
}

/// A vector turned by an angle given by its sine and cosine.
fn turned_by((sin, cos): (f64, f64), v: Vector2<f64>) -> Vector2<f64> {
    Vector2::new(cos * v.x - sin * v.y, sin * v.x + cos * v.y)
}

/// Sine and cosine of the sum of two angles given by theirs.
fn turned((sin_a, cos_a): (f64, f64), (sin_b, cos_b): (f64, f64)) -> (f64, f64) {
    (sin_a * cos_b + cos_a * sin_b, cos_a * cos_b - sin_a * sin_b)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use zeronav_msgs::description::{Corner, Description};

    /// Where a stop ends in very small steps, independent of how the sweep cuts its own.
    fn slowly(limits: &Limits, (from, towards): (Twist, Twist), reaction_s: f64) -> [f64; 3] {
        let mut at = [0.0_f64; 3];
        let mut drive = |from: Twist, to: Twist, step_s: f64| {
            let mean = from.mean(to);
            let (sin, cos) = (at[2] + 0.5 * mean.w_radps * step_s).sin_cos();
            at[0] += mean.v_mps * step_s * cos;
            at[1] += mean.v_mps * step_s * sin;
            at[2] += mean.w_radps * step_s;
            to
        };
        let mut twist = from;
        let obeyed = 20_000;
        for _ in 0..obeyed {
            let mut step_s = reaction_s / f64::from(obeyed);
            if twist.v_mps * limits.towards(twist, towards, step_s).v_mps < 0.0 {
                // First to rest.
                let braking_s = twist.v_mps.abs() / limits.brake_mps2;
                let turned = limits.towards(twist, towards, braking_s);
                twist = drive(twist, Twist::new(0.0, turned.w_radps), braking_s);
                step_s -= braking_s;
            }
            twist = drive(twist, limits.towards(twist, towards, step_s), step_s);
        }
        let step_s = 1.0e-4;
        while twist != Twist::REST {
            twist = drive(twist, limits.towards_rest(twist, step_s), step_s);
        }
        at
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        /// The poses are those of the motion itself, and no two of them are farther apart than
        /// what the margin allows for.
        #[test]
        fn poses_are_where_the_robot_will_be(
            limits in (0.3..4.0_f64, 0.3..4.0_f64, 0.5..10.0_f64),
            from in (-1.5..3.0_f64, -4.0..4.0_f64),
            towards in (-1.5..3.0_f64, -4.0..4.0_f64),
            reaction_s in 0.0..0.3_f64,
            disc in any::<bool>(),
        ) {
            let limits = Limits {
                v_mps_max: 3.0,
                v_mps_min: -1.5,
                w_radps_max: 4.0,
                a_mps2_max: limits.0,
                brake_mps2: limits.1,
                alpha_radps2_max: limits.2,
            };
            let corners = [(0.6, 0.0), (-0.2, 0.3), (-0.3, 0.0), (-0.2, -0.3)]
                .map(|(x_m, y_m)| Corner { x_m, y_m });
            let description = Description { circumscribed_radius_m: 0.3, ..Description::default() };
            let outline = Outline::new(&description, if disc { &[] } else { &corners });
            let hits = Hits::default();
            let space = Space::new(&outline, &hits, 0.01);
            let ends = (Twist::new(from.0, from.1), Twist::new(towards.0, towards.1));
            let (mut last, mut gap_m) = ((Vector2::zeros(), (0.0, 1.0)), 0.0_f64);
            let mut walked = Walked::none(ends.0, 0.02);
            let mut look = |at: Vector2<f64>, heading, _: f64| {
                let moved_m = if disc { (at - last.0).norm() } else {
                    let place = |(at, heading), corner: &Corner| {
                        let corner = Vector2::new(corner.x_m, corner.y_m);
                        let there: Vector2<f64> = turned_by(heading, corner);
                        there + at
                    };
                    let moved = |corner| (place((at, heading), corner) - place(last, corner)).norm();
                    corners.iter().map(moved).fold(0.0, f64::max)
                };
                gap_m = gap_m.max(moved_m);
                last = (at, heading);
                // As near as a look has to be at every pose.
                Some(0.02)
            };
            let mut legs = [Leg::Obey(ends.1, reaction_s), Leg::Brake].into_iter();
            let way = legs.try_for_each(|leg| space.walk(&limits, &mut walked, leg, 0.02, &mut look));
            // A way of too many poses is not looked at to its end.
            prop_assume!(way.is_some());
            prop_assert!(gap_m <= SPACING_M - OFF_M, "{gap_m} m between two poses");
            let [x, y, yaw] = slowly(&limits, ends, reaction_s);
            let off_m = (last.0 - Vector2::new(x, y)).norm();
            prop_assert!(off_m < 0.5 * OFF_M, "{off_m} m off");
            let off_rad = (yaw.sin() - last.1.0).hypot(yaw.cos() - last.1.1);
            prop_assert!(off_rad < 0.5 * OFF_M, "{off_rad} rad off");
        }
    }

    /// A point inside the outline may stay as deep as it is: a robot that drives along a wall that it
    /// touches is not held.
    #[test]
    fn a_point_inside_may_stay_as_deep_but_get_no_deeper() {
        let corners = [(0.3, 0.2), (-0.3, 0.2), (-0.3, -0.2), (0.3, -0.2)]
            .map(|(x_m, y_m)| Corner { x_m, y_m });
        let outline = Outline::new(&Description::default(), &corners);
        let limits = Limits {
            v_mps_max: 1.0,
            v_mps_min: -1.0,
            w_radps_max: 1.0,
            a_mps2_max: 1.0,
            brake_mps2: 1.0,
            alpha_radps2_max: 1.0,
        };
        let free = |hit: (f64, f64), v_mps: f64| {
            let mut hits = Hits::default();
            hits.refill([Vector2::new(hit.0, hit.1)].into_iter());
            let space = Space::new(&outline, &hits, 0.01);
            let twist = Twist::new(v_mps, 0.0);
            let here = Walked::none(twist, 0.02);
            space.way(&limits, (here, twist), 0.1, 0.02).is_some()
        };
        // 1 cm inside the left edge, and inside the front.
        assert!(free((0.0, 0.19), 0.1) && free((0.0, 0.19), -0.1));
        assert!(!free((0.29, 0.0), 0.1) && free((0.29, 0.0), -0.1));
        // Outside, within the margin.
        assert!(free((0.0, 0.205), 0.1) && !free((0.305, 0.0), 0.1));
    }
}
