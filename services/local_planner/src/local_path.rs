//! The stretch of the path ahead of the robot, evenly sampled, and what it asks of the speed.

use crate::field::ClearanceField;
use crate::lanes::data::{Projections, SAMPLES, Stretch, narrow};
use crate::lanes::places_on;
use crate::progress::{PathTracker, Place};
use nalgebra::{Point2, Vector2};
use zeronav_casts::Cast;
use zeronav_msgs::path::Waypoint;

/// [m] where unused samples are put.
const FAR_M: f32 = 1.0e9;

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

/// The stretch and where the robot is on it.
#[derive(Debug, Clone, Default)]
pub(crate) struct LocalPath {
    stretch: Stretch,
    /// Samples before the robot's place.
    behind: usize,
    spacing_m: f64,
    /// [m] from the robot's place to the last sample.
    pub(crate) ahead_m: f64,
}

impl Stretch {
    /// Fills what follows from the samples and their places along the path.
    fn connect(&mut self) {
        for i in 0..self.n.saturating_sub(1) {
            let (x, y) = (self.x[i + 1] - self.x[i], self.y[i + 1] - self.y[i]);
            let squared = x * x + y * y;
            self.step_x[i] = x;
            self.step_y[i] = y;
            self.inverse[i] = if squared > 1.0e-12 {
                1.0 / squared
            } else {
                0.0
            };
            self.arc[i] = self.start[i + 1] - self.start[i];
        }
        for i in 0..self.n {
            let (from, to) = (
                i.saturating_sub(SMOOTH_SPAN),
                (i + SMOOTH_SPAN).min(self.n - 1),
            );
            let (dx, dy) = (self.x[to] - self.x[from], self.y[to] - self.y[from]);
            let length = dx.hypot(dy);
            (self.direction_x[i], self.direction_y[i]) = if length > 1.0e-6 {
                (dx / length, dy / length)
            } else {
                (0.0, 0.0)
            };
        }
    }
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
        self.behind = 0;
        self.ahead_m = 0.0;
        let stretch = &mut self.stretch;
        stretch.n = 0;
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
            stretch.x[stretch.n] = narrow(at.x);
            stretch.y[stretch.n] = narrow(at.y);
            self.behind += usize::from(i < BEHIND);
            stretch.n += 1;
            self.ahead_m = along_m.max(0.0);
            if last && i >= BEHIND {
                break;
            }
        }
        stretch.x[stretch.n..].fill(FAR_M);
        stretch.y[stretch.n..].fill(FAR_M);
        for i in 0..self.stretch.n {
            self.stretch.start[i] = self.arc_of(i);
        }
        self.stretch.connect();
    }

    /// The nearest places on the stretch of points, a multiple of [`crate::lanes::WIDTH`] and at
    /// most [`LANES_MAX`]. A point beyond the end is beside it.
    pub(crate) fn project_all(&self, x: &[f32], y: &[f32], found: &mut Projections) {
        places_on(&self.stretch, x, y, found);
    }

    /// [m] along the path from the robot's place to a sample.
    fn arc_of(&self, index: usize) -> f32 {
        let steps = index.to_f32() - self.behind.to_f32();
        (steps * narrow(self.spacing_m)).min(narrow(self.ahead_m))
    }

    /// Distance from the stretch of a point relative to the robot along the map's axes; infinite
    /// without a stretch. [m]
    pub(crate) fn distance_m(&self, at: Vector2<f64>) -> f64 {
        let stretch = &self.stretch;
        let (x, y) = (narrow(at.x), narrow(at.y));
        let pieces = 0..stretch.n.saturating_sub(1);
        let squared = pieces.map(|i| {
            let (dx, dy) = (x - stretch.x[i], y - stretch.y[i]);
            let along = dx * stretch.step_x[i] + dy * stretch.step_y[i];
            let share = (along * stretch.inverse[i]).clamp(0.0, 1.0);
            let (ox, oy) = (
                dx - share * stretch.step_x[i],
                dy - share * stretch.step_y[i],
            );
            ox * ox + oy * oy
        });
        f64::from(squared.fold(f32::INFINITY, f32::min).sqrt())
    }

    /// The point to steer for: at most `lookahead_m` ahead, shortened until the straight way to
    /// it is free for the inscribed disc. Relative to the robot along the map's axes. [m]
    pub(crate) fn local_goal(
        &self,
        field: &ClearanceField,
        inscribed_m: f64,
        lookahead_m: f64,
    ) -> Vector2<f64> {
        let first = (self.behind + 1).min(self.stretch.n.saturating_sub(1));
        let mut index = first;
        for i in first..self.stretch.n {
            if f64::from(self.arc_of(i)) > lookahead_m || !self.sees(field, i, inscribed_m) {
                break;
            }
            index = i;
        }
        Vector2::new(
            f64::from(self.stretch.x[index]),
            f64::from(self.stretch.y[index]),
        )
    }

    fn sees(&self, field: &ClearanceField, index: usize, inscribed_m: f64) -> bool {
        const CHECKS: u8 = 8;
        let need = narrow(inscribed_m);
        (1..=CHECKS).all(|step| {
            let share = f32::from(step) / f32::from(CHECKS);
            field.bound_m(self.stretch.x[index] * share, self.stretch.y[index] * share) >= need
        })
    }

    /// [m] along the path to the first place where the inscribed disc overlaps an obstacle;
    /// `None` when the stretch is free.
    pub(crate) fn blocked_m(&self, field: &ClearanceField, inscribed_m: f64) -> Option<f64> {
        let need = narrow(inscribed_m - OVERLAP_M.min(0.3 * inscribed_m));
        (self.behind..self.stretch.n)
            .find(|&i| {
                field.bound_m(self.stretch.x[i], self.stretch.y[i]) + 0.25 * field.slack_m() < need
            })
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
        for i in TURN_SPAN..self.stretch.n.saturating_sub(TURN_SPAN) {
            let at = Vector2::new(self.stretch.x[i], self.stretch.y[i]);
            let before =
                at - Vector2::new(self.stretch.x[i - TURN_SPAN], self.stretch.y[i - TURN_SPAN]);
            let after =
                Vector2::new(self.stretch.x[i + TURN_SPAN], self.stretch.y[i + TURN_SPAN]) - at;
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
