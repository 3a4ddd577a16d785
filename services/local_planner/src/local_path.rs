//! The stretch of the path ahead of the robot, evenly sampled, and what it asks of the speed.

#![allow(clippy::cast_possible_truncation, reason = "indices of 32 samples")]

use crate::fan::LANES_MAX;
use crate::field::ClearanceField;
use crate::lanes::nearest_keys;
use crate::progress::{PathTracker, Place};
use crate::surroundings::narrow;
use nalgebra::{Point2, Vector2};
use zeronav_msgs::path::Waypoint;

/// [m] where unused samples are put.
const FAR_M: f32 = 1.0e9;

/// Samples of the stretch, a power of two.
pub(crate) const SAMPLES: usize = 32;

/// [m] closest samples: with [`TURN_SPAN`] some 20 cm, the scale of a turn.
const SPACING_M_MIN: f64 = 0.06;

/// Samples behind the robot, so that a corner is still seen while it is taken.
const BEHIND: usize = 3;

/// Samples to either side over which a turn of the path is measured, so that the staircase of a
/// grid path does not look like a row of corners.
const TURN_SPAN: usize = 3;

/// Samples to either side over which the direction of the path is taken.
const SMOOTH_SPAN: usize = 2;

/// [m] by which the inscribed disc must overlap an obstacle before the path counts as blocked:
/// a path runs one cell beside the walls, and the pose and the scan have errors.
const OVERLAP_M: f64 = 0.05;

/// A point's place on the stretch.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Projection {
    /// [m] along the path from the robot's place, negative behind it.
    pub(crate) along: f32,
    /// [m] beside the path.
    pub(crate) beside: f32,
    /// Direction of the path there, in the map; zero for a path that is a single point.
    pub(crate) direction: (f32, f32),
}

/// The way from a sample to the next one. [m]
#[derive(Debug, Clone, Copy, Default)]
struct Segment {
    x: f32,
    y: f32,
    /// One over its squared length; 0 for none. [1/m^2]
    inverse: f32,
    /// Along the path, more than the length where a corner is cut.
    arc: f32,
}

/// Positions relative to the robot along the axes of the map. [m]
#[derive(Debug, Clone, Default)]
pub(crate) struct LocalPath {
    x: [f32; SAMPLES],
    y: [f32; SAMPLES],
    /// From every sample to the next one.
    segments: [Segment; SAMPLES],
    /// Direction of the path at every sample, over its neighbours.
    directions: [(f32, f32); SAMPLES],
    n: usize,
    /// Samples before the robot's place.
    behind: usize,
    spacing_m: f64,
    /// [m] from the robot's place to the last sample.
    pub(crate) ahead_m: f64,
}

impl LocalPath {
    /// Samples `path` from a little behind `place` to `reach_m` ahead of it, or to its end.
    pub(crate) fn sample(
        &mut self,
        tracker: &PathTracker,
        path: &[Waypoint],
        place: &Place,
        robot: Point2<f64>,
        reach_m: f64,
    ) {
        let ahead = SAMPLES - 1 - BEHIND;
        self.spacing_m =
            (reach_m / f64::from(u32::try_from(ahead).unwrap_or(1))).max(SPACING_M_MIN);
        self.n = 0;
        self.behind = 0;
        self.ahead_m = 0.0;
        for i in 0..SAMPLES {
            let steps = f64::from(u32::try_from(i).unwrap_or(0))
                - f64::from(u32::try_from(BEHIND).unwrap_or(0));
            let along_m = steps * self.spacing_m;
            if i < BEHIND && place.arc_m + along_m < 0.0 {
                continue;
            }
            let last = along_m >= place.remaining_m;
            let along_m = along_m.min(place.remaining_m);
            let at = tracker.point_at(path, place.arc_m + along_m) - robot;
            self.x[self.n] = narrow(at.x);
            self.y[self.n] = narrow(at.y);
            self.behind += usize::from(i < BEHIND);
            self.n += 1;
            self.ahead_m = along_m.max(0.0);
            if last && i >= BEHIND {
                break;
            }
        }
        self.x[self.n..].fill(FAR_M);
        self.y[self.n..].fill(FAR_M);
        for i in 0..self.n.saturating_sub(1) {
            let (x, y) = (self.x[i + 1] - self.x[i], self.y[i + 1] - self.y[i]);
            let squared = x * x + y * y;
            self.segments[i] = Segment {
                x,
                y,
                inverse: if squared > 1.0e-12 {
                    1.0 / squared
                } else {
                    0.0
                },
                arc: self.arc_of(i + 1) - self.arc_of(i),
            };
        }
        for i in 0..self.n {
            let (from, to) = (
                i.saturating_sub(SMOOTH_SPAN),
                (i + SMOOTH_SPAN).min(self.n - 1),
            );
            let (dx, dy) = (self.x[to] - self.x[from], self.y[to] - self.y[from]);
            let length = dx.hypot(dy);
            self.directions[i] = if length > 1.0e-6 {
                (dx / length, dy / length)
            } else {
                (0.0, 0.0)
            };
        }
    }

    /// The nearest places on the stretch of `x.len()` points. A point beyond the end is beside it.
    pub(crate) fn project_all(&self, x: &[f32], y: &[f32], found: &mut [Projection]) {
        let mut keys = [0; LANES_MAX];
        let n = x.len().min(LANES_MAX);
        // Where there is no sample the nearest one is infinitely far away.
        let samples = self.n.max(1);
        nearest_keys(
            &self.x[..samples],
            &self.y[..samples],
            &x[..n],
            &y[..n],
            &mut keys[..n],
        );
        for (i, found) in found.iter_mut().enumerate().take(n) {
            *found = self.refine(x[i], y[i], keys[i]);
        }
    }

    /// The nearest place on the stretch. A point beyond the end is beside it.
    pub(crate) fn project(&self, x: f32, y: f32) -> Projection {
        let mut found = [Projection::default()];
        self.project_all(&[x], &[y], &mut found);
        found[0]
    }

    /// The nearest place beside the sample of a key of [`nearest_keys`].
    #[inline]
    fn refine(&self, x: f32, y: f32, key: u32) -> Projection {
        const INDEX: u32 = SAMPLES as u32 - 1;
        let (nearest, beside) = ((key & INDEX) as usize, f32::from_bits(key & !INDEX).sqrt());
        let mut found = Projection {
            along: f32::INFINITY,
            beside,
            direction: self.directions[nearest],
        };
        // The nearest point lies on one of the two segments that meet at the nearest sample.
        let first = nearest.saturating_sub(1);
        let mut squared = f32::INFINITY;
        for i in first..(nearest + 1).min(self.n.saturating_sub(1)) {
            let segment = &self.segments[i];
            let (dx, dy) = (x - self.x[i], y - self.y[i]);
            let along = ((dx * segment.x + dy * segment.y) * segment.inverse).clamp(0.0, 1.0);
            let (dx, dy) = (dx - along * segment.x, dy - along * segment.y);
            let distance = dx * dx + dy * dy;
            if distance < squared {
                squared = distance;
                found.along = self.arc_of(i) + along * segment.arc;
            }
        }
        if squared.is_finite() {
            found.beside = squared.sqrt();
        }
        if found.along.is_infinite() {
            found.along = self.arc_of(nearest);
        }
        found
    }

    /// [m] along the path from the robot's place to a sample.
    #[allow(clippy::cast_precision_loss, reason = "at most 32 samples")]
    fn arc_of(&self, index: usize) -> f32 {
        let steps = index as f32 - self.behind as f32;
        (steps * narrow(self.spacing_m)).min(narrow(self.ahead_m))
    }

    /// The point to steer for: at most `lookahead_m` ahead, shortened until the straight way to
    /// it is free for the inscribed disc. Relative to the robot along the map's axes. [m]
    pub(crate) fn local_goal(
        &self,
        field: &ClearanceField,
        inscribed_m: f64,
        lookahead_m: f64,
    ) -> Vector2<f64> {
        let first = (self.behind + 1).min(self.n.saturating_sub(1));
        let mut index = first;
        for i in first..self.n {
            if f64::from(self.arc_of(i)) > lookahead_m || !self.sees(field, i, inscribed_m) {
                break;
            }
            index = i;
        }
        Vector2::new(f64::from(self.x[index]), f64::from(self.y[index]))
    }

    fn sees(&self, field: &ClearanceField, index: usize, inscribed_m: f64) -> bool {
        const CHECKS: u8 = 8;
        let need = narrow(inscribed_m);
        (1..=CHECKS).all(|step| {
            let share = f32::from(step) / f32::from(CHECKS);
            field.bound_m(self.x[index] * share, self.y[index] * share) >= need
        })
    }

    /// [m] along the path to the first place where the inscribed disc overlaps an obstacle;
    /// `None` when the stretch is free.
    pub(crate) fn blocked_m(&self, field: &ClearanceField, inscribed_m: f64) -> Option<f64> {
        let need = narrow(inscribed_m - OVERLAP_M.min(0.3 * inscribed_m));
        (self.behind..self.n)
            .find(|&i| field.bound_m(self.x[i], self.y[i]) + 0.25 * field.slack_m() < need)
            .map(|i| f64::from(self.arc_of(i)).max(0.0))
    }

    /// [m/s] fastest speed from which every corner ahead can still be taken: at a corner that
    /// turns by `phi` an arc that stays within `deviation_m` of it has the radius
    /// `deviation / (1 / cos(phi / 2) - 1)`, driven at `w_radps`; before it the robot slows down
    /// by `decel_mps2`.
    pub(crate) fn corner_speed_mps(
        &self,
        deviation_m: f64,
        w_radps: f64,
        decel_mps2: f64,
        least_mps: f64,
    ) -> f64 {
        let mut fastest = f64::INFINITY;
        for i in TURN_SPAN..self.n.saturating_sub(TURN_SPAN) {
            let at = Vector2::new(self.x[i], self.y[i]);
            let before = at - Vector2::new(self.x[i - TURN_SPAN], self.y[i - TURN_SPAN]);
            let after = Vector2::new(self.x[i + TURN_SPAN], self.y[i + TURN_SPAN]) - at;
            let turn_rad = f64::from(before.perp(&after).atan2(before.dot(&after)).abs());
            if turn_rad < 0.2 {
                continue;
            }
            let excess = 1.0 / (0.5 * turn_rad).cos().max(1.0e-3) - 1.0;
            let there = (w_radps * deviation_m / excess).max(least_mps);
            let along_m = f64::from(self.arc_of(i)).max(0.0);
            fastest = fastest.min((there * there + 2.0 * decel_mps2 * along_m).sqrt());
        }
        fastest
    }
}
