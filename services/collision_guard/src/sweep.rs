//! The way a robot takes when it obeys a command for the reaction time and then brakes, and
//! whether that way is free.

use crate::limits::{Limits, Twist};
use crate::outline::Outline;
use nalgebra::Point2;

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
    /// Hits in `base` of now. [m]
    pub(crate) points: &'a [Point2<f64>],
    /// [m] that shall stay free around the outline.
    margin_m: f64,
    /// [m] that is free now, at most the margin. Inside the margin the robot comes no nearer.
    now_m: f64,
}

impl<'a> Space<'a> {
    /// The space around a robot that shall keep `margin_m`.
    pub(crate) fn new(outline: &'a Outline, points: &'a [Point2<f64>], margin_m: f64) -> Self {
        let now_m = nearest_m(outline, points, Point2::origin(), (0.0, 1.0), margin_m);
        Self {
            outline,
            points,
            margin_m,
            now_m,
        }
    }

    /// Least distance at a pose when that pose is free, at most `enough_m`. [m]
    ///
    /// Where points lie inside the outline already (noise, a person who came too near), each of
    /// them counts for itself: none may get nearer than the margin, or deeper than it is.
    fn free_m(&self, at: Point2<f64>, heading: (f64, f64), enough_m: f64) -> Option<f64> {
        let outline = self.outline;
        let here_m = nearest_m(outline, self.points, at, heading, enough_m);
        if self.now_m > 0.0 {
            return (here_m >= self.margin_m.min(self.now_m - TOLERANCE_M)).then_some(here_m);
        }
        let origin = Point2::origin();
        let free = self.points.iter().all(|point| {
            let now_m = outline.distance_from_m(origin, (0.0, 1.0), *point, self.margin_m);
            let then_m = outline.distance_from_m(at, heading, *point, self.margin_m);
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
        from: Twist,
        towards: Twist,
        reaction_s: f64,
        enough_m: f64,
    ) -> Option<f64> {
        let mut twist = from;
        let mut left_s = reaction_s;
        let (mut x, mut y, mut yaw) = (0.0, 0.0, 0.0_f64);
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
            let moved = mean.arc(step_s);
            let (sin, cos) = yaw.sin_cos();
            x += cos * moved.x_m - sin * moved.y_m;
            y += sin * moved.x_m + cos * moved.y_m;
            yaw += moved.yaw_rad;
            twist = next;
            blind_m -= self.outline.speed_mps(mean) * step_s;
            if blind_m > 0.0 {
                continue;
            }
            // Far enough to see what the next moves cannot reach.
            let far_m = enough_m + 0.5;
            let heading = yaw.sin_cos();
            let here_m = self.free_m(Point2::new(x, y), heading, far_m)?;
            least_m = least_m.min(here_m);
            blind_m = here_m - enough_m;
        }
        // A way of so many poses ends nowhere near.
        None
    }
}

/// Least signed distance between the outline at a pose and the points, at most `enough_m`. [m]
fn nearest_m(
    outline: &Outline,
    points: &[Point2<f64>],
    at: Point2<f64>,
    (sin, cos): (f64, f64),
    enough_m: f64,
) -> f64 {
    if outline.is_disc() {
        let squared = points.iter().fold(f64::INFINITY, |least, point| {
            let (dx, dy) = (point.x - at.x, point.y - at.y);
            least.min(dx * dx + dy * dy)
        });
        return (squared.sqrt() - outline.radius_m).min(enough_m);
    }
    let mut least_m = enough_m;
    for point in points {
        let reach_m = outline.radius_m + least_m.max(0.0);
        let (dx, dy) = (point.x - at.x, point.y - at.y);
        if dx * dx + dy * dy < reach_m * reach_m {
            least_m = least_m.min(outline.distance_from_m(at, (sin, cos), *point, least_m));
        }
    }
    least_m
}
