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

/// [s] shortest step, so that a stop has a bounded number of poses.
const STEP_S_MIN: f64 = 2.0e-3;

/// [s] longest step, over which a ramp is taken as one mean twist.
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

    /// Least distance between the outline and the points along the way, at most `enough_m`;
    /// `None` when the way is not free. [m]
    ///
    /// The way begins at `from`, nears `towards` within the limits for `reaction_s` and ramps to
    /// rest as [`Limits::towards_rest`] does.
    pub(crate) fn way(
        &self,
        limits: &Limits,
        ends: (Twist, Twist),
        reaction_s: f64,
        enough_m: f64,
    ) -> Option<f64> {
        let mut look = Look {
            placed: *self.outline,
            nearest: 0,
        };
        self.walk(limits, ends, reaction_s, enough_m, |at, heading, far_m| {
            self.free_m(&mut look, at, heading, far_m)
        })
    }

    /// The hit that is nearest to that way up to the first pose that is not free, if one is nearer
    /// than `enough_m`, and its distance there. [m]
    pub(crate) fn nearest_on_way(
        &self,
        limits: &Limits,
        ends: (Twist, Twist),
        reaction_s: f64,
        enough_m: f64,
    ) -> Nearest {
        let mut placed = *self.outline;
        let mut look = Look { placed, nearest: 0 };
        let mut found: Option<(Vector2<f64>, f64)> = None;
        let way = self.walk(limits, ends, reaction_s, enough_m, |at, heading, far_m| {
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
        Nearest {
            hit: found.filter(|(_, least_m)| *least_m < enough_m),
            is_free: way.is_some(),
        }
    }

    /// Follows a way and asks `look` for the least distance at every pose that can tell anything new,
    /// given by place, sine and cosine of the heading, and how far to look; ends with the first that
    /// is not free.
    fn walk(
        &self,
        limits: &Limits,
        (from, towards): (Twist, Twist),
        reaction_s: f64,
        enough_m: f64,
        mut look: impl FnMut(Vector2<f64>, (f64, f64), f64) -> Option<f64>,
    ) -> Option<f64> {
        let mut twist = from;
        let mut left_s = reaction_s;
        let (mut at, mut heading) = (Vector2::zeros(), (0.0, 1.0));
        let mut least_m = enough_m;
        // What the outline may still move before another look can tell anything new.
        let mut blind_m = 0.0;
        for _ in 0..POSES_MAX {
            let braking = left_s <= 0.0;
            if braking && twist == Twist::REST {
                return Some(least_m);
            }
            let fastest = self
                .outline
                .speed_mps(twist)
                .max(
                    self.outline
                        .speed_mps(if braking { twist } else { towards }),
                );
            let mut step_s = (SPACING_M / fastest.max(1.0e-6)).clamp(STEP_S_MIN, STEP_S_MAX);
            let next = if braking {
                limits.towards_rest(twist, step_s)
            } else {
                step_s = step_s.min(left_s);
                left_s -= step_s;
                limits.towards(twist, towards, step_s)
            };
            let mean = Twist {
                v_mps: 0.5 * (twist.v_mps + next.v_mps),
                w_radps: 0.5 * (twist.w_radps + next.w_radps),
            };
            let (chord_m, half) = mean.chord(step_s);
            let (sin, cos) = turned(heading, half);
            at += chord_m * Vector2::new(cos, sin);
            heading = turned((sin, cos), half);
            twist = next;
            blind_m -= self.outline.speed_mps(mean) * step_s;
            if blind_m > 0.0 {
                continue;
            }
            // Far enough to see what the next moves cannot reach.
            let far_m = enough_m + 0.5;
            let here_m = look(at, heading, far_m)?;
            least_m = least_m.min(here_m);
            blind_m = here_m - enough_m;
        }
        // A way of so many poses ends nowhere near.
        None
    }
}

/// Sine and cosine of the sum of two angles given by theirs.
fn turned((sin_a, cos_a): (f64, f64), (sin_b, cos_b): (f64, f64)) -> (f64, f64) {
    (sin_a * cos_b + cos_a * sin_b, cos_a * cos_b - sin_a * sin_b)
}
