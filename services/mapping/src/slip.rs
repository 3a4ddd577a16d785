//! Motions that the wheels do not tell: which are looked at when scans contradict odometry.
//!
//! Wheels that slip turn for nothing, in part or altogether: the robot has moved by some share of what
//! they say, and has turned by some other share. A robot whose odometry is wrong in another way goes on as it
//! did. A lidar that takes its beams one after the other sees each from another pose; the ends of its
//! beams were put together by odometry, so they change with the motion.

use nalgebra::{Point2, Vector2};
use zeronav_msgs::Pose;
use zeronav_msgs::pose::wrap_angle;

/// Motions that differ by less are one. [m, rad]
const APART: (f64, f64) = (0.01, 0.01);

/// Distance between the shares of a step that are looked at, and the most of them. [m, rad]
const SHARES_APART: (f64, f64) = (0.05, 0.06);
const SHARES_MAX: f64 = 8.0;

/// How far beside a share of odometry's step a motion may lie that slip explains, as a share of the
/// step and besides. [m, rad]
const BESIDE: f64 = 0.2;
const BESIDE_MIN: (f64, f64) = (0.005, 0.01);

/// Where the beams of a scan ended.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Ends<'a> {
    /// In `base` at the last beam, put together by odometry. [m]
    pub(crate) at: &'a [Point2<f64>],
    /// Which share of the scan was still to come, 0 to 1; one for each end, or none where all beams
    /// were taken at once.
    pub(crate) ago: &'a [f64],
    /// Share, 0 to 1, of the time since the scan before that this scan took.
    pub(crate) sweep_share: f64,
    /// True when they are most of what the scan sees: little of it is left out as what may move.
    pub(crate) are_most: bool,
}

/// Memory for some ends of a scan. It is reused.
#[derive(Debug, Default)]
pub(crate) struct EndsOf {
    at: Vec<Point2<f64>>,
    ago: Vec<f64>,
}

impl EndsOf {
    /// Those of the ends, told by their indices, that are kept.
    pub(crate) fn of(
        &mut self,
        ends: &Ends<'_>,
        keep: impl Fn(&[Point2<f64>], usize) -> bool,
    ) -> Ends<'_> {
        self.at.clear();
        self.ago.clear();
        for n in (0..ends.at.len()).filter(|n| keep(ends.at, *n)) {
            self.at.push(ends.at[n]);
            self.ago.extend(ends.ago.get(n));
        }
        Ends {
            at: &self.at,
            ago: &self.ago,
            sweep_share: ends.sweep_share,
            are_most: ends.are_most,
        }
    }
}

impl<'a> Ends<'a> {
    /// Ends, each with which share of the scan was still to come; that counts where the scan took time.
    pub(crate) fn of(
        (at, ago): (&'a [Point2<f64>], &'a [f64]),
        sweep_share: f64,
        are_most: bool,
    ) -> Self {
        Self {
            at,
            ago: if sweep_share > 0.0 { ago } else { &[] },
            sweep_share,
            are_most,
        }
    }

    /// Where they ended when the robot has moved by `motion` since the scan before, and not by
    /// odometry's `step`.
    pub(crate) fn along(&self, ends: &mut Vec<Point2<f64>>, step: &Pose, motion: &Pose) {
        ends.clear();
        if self.ago.is_empty() {
            ends.extend_from_slice(self.at);
            return;
        }
        let off = Vector2::new(step.x_m - motion.x_m, step.y_m - motion.y_m) * self.sweep_share;
        let turned_rad = wrap_angle(step.yaw_rad - motion.yaw_rad) * self.sweep_share;
        ends.extend(self.at.iter().zip(self.ago).map(|(end, ago)| {
            let (sin, cos) = (turned_rad * ago).sin_cos();
            let turned = Point2::new(cos * end.x - sin * end.y, sin * end.x + cos * end.y);
            turned + off * *ago
        }));
    }
}

/// True when two motions differ by more than scans at rest do.
pub(crate) fn apart(a: &Pose, b: &Pose) -> bool {
    a.distance_m(b) > APART.0 || wrap_angle(a.yaw_rad - b.yaw_rad).abs() > APART.1
}

/// The motions of wheels that slip, given odometry's `step`: shares of its way with shares of its turn.
pub(crate) fn motions(step: &Pose) -> impl Iterator<Item = Pose> + use<> {
    let step = *step;
    let n = |size: f64, apart: f64| (size / apart).ceil().clamp(1.0, SHARES_MAX);
    let n_way = n(step.x_m.hypot(step.y_m), SHARES_APART.0);
    let n_turn = n(step.yaw_rad.abs(), SHARES_APART.1);
    let shares = |n: f64| {
        (0_u8..=8)
            .map(move |k| f64::from(k) / n)
            .take_while(|share| *share < 1.0 + 1.0e-9)
    };
    shares(n_way)
        .flat_map(move |way| shares(n_turn).map(move |turn| (way, turn)))
        .map(move |(way, turn)| Pose::new(way * step.x_m, way * step.y_m, turn * step.yaw_rad))
}

/// True when wheels that slip explain a motion: it is some share of what odometry says.
pub(crate) fn is_share_of(motion: &Pose, step: &Pose) -> bool {
    let (way, whole) = (
        Vector2::new(motion.x_m, motion.y_m),
        Vector2::new(step.x_m, step.y_m),
    );
    let share = (way.dot(&whole) / whole.norm_squared().max(1.0e-12)).clamp(0.0, 1.0);
    let beside_m = (way - whole * share).norm();
    let (turned_rad, whole_rad) = (motion.yaw_rad, step.yaw_rad);
    let beside_rad = (turned_rad - turned_rad.clamp(whole_rad.min(0.0), whole_rad.max(0.0))).abs();
    beside_m <= BESIDE_MIN.0 + BESIDE * whole.norm()
        && beside_rad <= BESIDE_MIN.1 + BESIDE * whole_rad.abs()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_motion_of_slipping_wheels_is_near_one_that_is_looked_at() {
        let step = Pose::new(0.12, 0.01, -0.3);
        for way in [0.0, 0.2, 0.55, 1.0] {
            for turn in [0.0, 0.37, 0.8, 1.0] {
                let true_motion = Pose::new(way * step.x_m, way * step.y_m, turn * step.yaw_rad);
                let near = |motion: Pose| {
                    let off_rad = wrap_angle(motion.yaw_rad - true_motion.yaw_rad).abs();
                    motion.distance_m(&true_motion) <= 0.03 && off_rad <= 0.031
                };
                assert!(motions(&step).any(near), "{true_motion:?}");
                assert!(is_share_of(&true_motion, &step));
            }
        }
        assert!(!is_share_of(&Pose::new(0.0, 0.1, 0.0), &step), "sideways");
        assert!(
            !is_share_of(&Pose::new(0.0, 0.0, 0.1), &step),
            "the other way round"
        );
    }

    /// A lidar that drives 0.2 m by odometry while it looks, and does not move in truth.
    #[test]
    fn ends_follow_the_motion_that_beams_were_taken_along() {
        let ago = [1.0, 0.5, 0.0];
        // Put together by odometry, a wall 3 m ahead comes towards the last beam.
        let at = ago.map(|ago| Point2::new(3.0 - 0.2 * ago, 0.0));
        let seen = Ends {
            at: &at,
            ago: &ago,
            sweep_share: 0.5,
            are_most: true,
        };
        let mut ends = Vec::new();
        seen.along(&mut ends, &Pose::new(0.4, 0.0, 0.0), &Pose::default());
        assert!(
            ends.iter().all(|end| (end.x - 3.0).abs() < 1e-12),
            "{ends:?}"
        );
        seen.along(
            &mut ends,
            &Pose::new(0.4, 0.0, 0.0),
            &Pose::new(0.4, 0.0, 0.0),
        );
        assert_eq!(ends, at);
    }
}
