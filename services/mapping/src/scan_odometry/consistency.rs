//! Whether a scan speaks against odometry: asked of a few points, and of all where these may.

use super::{
    EXPLAINS_MORE, FOUND_MIN, FOUND_SHARE, GATE, LETS_GO_M, Laid, POINT_WORTH, POINTS_MAX, SIGMA_M,
    ScanOdometry, between, weight,
};
use crate::near_points::is_linked;
use crate::pose_error::swing;
use crate::slip::{Ends, apart};
use nalgebra::{Matrix3, Point2, Vector3};
use zeronav_casts::Cast;
use zeronav_msgs::Pose;

/// By how much a few points may contradict odometry, squared, in standard deviations, and share of them by which
/// another motion may explain more, for all of them not to be looked at.
const SURE: (f64, f64) = (1.0, 0.5 * EXPLAINS_MORE);

/// Shares of two sums of the same points differ by less when they are one.
const ROUNDING: f64 = 1.0e-9;

impl ScanOdometry {
    /// True when a few ends do not speak against odometry, whose step since the last scan has the covariance `noise`, or
    /// something moves: the robot has moved along. Otherwise nothing has changed.
    pub(crate) fn goes_along(
        &mut self,
        odom_from_base: &Pose,
        noise: &Matrix3<f64>,
        few: &Ends<'_>,
        something_moves: bool,
    ) -> bool {
        let by_odometry = between(&self.odom_from_key, odom_from_base);
        let came = swing(&(by_odometry.point() - self.odometry.point()));
        let drift = came * self.drift * came.transpose() + noise;
        let step = between(&self.odometry, &by_odometry);
        if !something_moves {
            let Some(share) = self.agreement(few, (&by_odometry, &drift), &step) else {
                return false;
            };
            self.share = share;
        }
        (self.drift, self.last) = (drift, step);
        (self.odometry, self.key_from_base) = (by_odometry, by_odometry);
        true
    }

    /// This scan is the next key scan, after [`Self::goes_along`].
    pub(crate) fn next_key(&mut self, odom_from_base: &Pose, ends: &[Point2<f64>]) {
        let mut linked = core::mem::take(&mut self.linked);
        let all = Ends::of((ends, &[]), 0.0, true);
        let last = self.last;
        self.begin(odom_from_base, linked.of(&all, is_linked).at);
        self.last = last;
        self.linked = linked;
    }

    /// Share of a few ends that lies on lines where odometry has the robot, to a covariance; `None` when they may speak
    /// against its last step.
    fn agreement(
        &mut self,
        few: &Ends<'_>,
        (by_odometry, drift): (&Pose, &Matrix3<f64>),
        step: &Pose,
    ) -> Option<f64> {
        let at = Vector3::new(by_odometry.x_m, by_odometry.y_m, by_odometry.yaw_rad);
        let sums = self.sums(few.at, &at, self.lets_go_m(LETS_GO_M));
        let share = sums.near / sums.all.max(1.0);
        if sums.found < FOUND_MIN || share < FOUND_SHARE.1 {
            return None;
        }
        // As much as all that are laid tell.
        let sigma_m = SIGMA_M.max(self.key.noise_m());
        let worth = POINT_WORTH / (sigma_m * sigma_m) * (POINTS_MAX.to_f64() / sums.all);
        let prior = (drift + Matrix3::from_diagonal(&Vector3::repeat(1.0e-8))).try_inverse()?;
        let off = (prior + sums.normal * worth).try_inverse()? * sums.right * worth;
        let agrees =
            off.dot(&(prior * off)) <= SURE.0 && !self.another_explains(few, step, share + SURE.1);
        agrees.then_some(share)
    }

    /// True when the scan is not where odometry's `step` has it, or another motion explains more of it.
    pub(super) fn is_contradicted(
        &mut self,
        ends: &Ends<'_>,
        laid: Option<&Laid>,
        step: &Pose,
    ) -> bool {
        let Some(laid) = laid.filter(|laid| laid.surprise <= GATE) else {
            return true;
        };
        self.another_explains(ends, step, laid.share + EXPLAINS_MORE)
    }

    /// True when a motion that wheels do not tell, and not odometry's `step`, explains more than `enough` of the scan.
    fn another_explains(&mut self, ends: &Ends<'_>, step: &Pose, enough: f64) -> bool {
        let others = [Pose::default(), self.last, self.back_to_key()];
        (0..others.len()).any(|n| {
            let other = &others[n];
            let is_new = others[..n].iter().all(|before| apart(before, other));
            is_new
                && apart(other, step)
                && self.explained(ends, (step, other), LETS_GO_M, enough) > enough
        })
    }

    /// The motion of a robot that has stood since the key scan: wheels that slip slowly among noisy
    /// returns are noticed late.
    pub(super) fn back_to_key(&self) -> Pose {
        Pose::from(self.key_from_base.isometry().inverse())
    }

    /// Share of the points that lie on lines after a motion since the last scan, given odometry's `step`; anything up to
    /// `enough` where it is not more than that.
    pub(super) fn explained(
        &mut self,
        ends: &Ends<'_>,
        (step, motion): (&Pose, &Pose),
        lets_go_m: f64,
        enough: f64,
    ) -> f64 {
        if enough >= 1.0 {
            return 0.0;
        }
        let every = ends.at.len().div_ceil(POINTS_MAX).max(1);
        let mut left = ends.at.len().div_ceil(every).to_f64();
        ends.along(&mut self.ends, step, motion);
        let at = self.key_from_base.then(motion);
        let (sin, cos) = at.yaw_rad.sin_cos();
        let lets_go_m = self.lets_go_m(lets_go_m);
        let (mut near, mut n) = (0.0, 0.0_f64);
        for end in self.ends.iter().step_by(every) {
            // What is left cannot make it enough any more.
            if near + left < enough * (n + left) - ROUNDING {
                return 0.0;
            }
            left -= 1.0;
            let place = Point2::new(
                at.x_m + cos * end.x - sin * end.y,
                at.y_m + sin * end.x + cos * end.y,
            );
            if !self.key.is_in_view(place) {
                continue;
            }
            n += 1.0;
            if let Some(line) = self.key.line_near(place) {
                let distance_m = (place - line.at).dot(&line.normal);
                near += weight(distance_m, lets_go_m);
            }
        }
        near / n.max(1.0)
    }
}
