//! The motion between two scans and what it rests on.

use nalgebra::Matrix3;
use zeronav_msgs::Pose;

/// Standard deviation to which the scans must tell a motion that odometry does not. [m]
pub(crate) const TOLD_M: f64 = 0.03;

/// What the motion between two scans rests on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Basis {
    /// Odometry, corrected by the scans as far as they tell.
    Odometry,
    /// The scans: they contradict odometry.
    Scans,
    /// Nothing: the scans contradict odometry and tell no motion.
    Nothing,
}

/// What two scans say about the motion between them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Moved {
    /// `last_from_base`.
    pub(crate) last_from_base: Pose,
    /// The step's covariance before the scans were looked at.
    pub(crate) noise: Matrix3<f64>,
    /// What is left of an error of that step, in the axes of `base`.
    pub(crate) left: Matrix3<f64>,
    /// What this rests on.
    pub(crate) basis: Basis,
    /// Share of the points that it explains; 0 where they were not matched.
    pub(crate) share: f64,
}

impl Moved {
    /// How far the motion may be off, where that is more than odometry's errors: the scans contradict
    /// it and tell no motion, or not along every direction. [m, rad]
    pub(crate) fn unknown(&self) -> Option<(f64, f64)> {
        if self.basis == Basis::Odometry {
            return None;
        }
        let (place_m, yaw_rad) = deviations(&self.left, &self.noise);
        (self.basis == Basis::Nothing || place_m > TOLD_M).then_some((place_m, yaw_rad))
    }
}

/// Largest standard deviations of place and yaw of what is `left` of an error. [m, rad]
pub(crate) fn deviations(left: &Matrix3<f64>, noise: &Matrix3<f64>) -> (f64, f64) {
    let added = left * noise * left.transpose();
    let place = added.fixed_view::<2, 2>(0, 0).symmetric_eigenvalues().max();
    (place.max(0.0).sqrt(), added[(2, 2)].max(0.0).sqrt())
}
