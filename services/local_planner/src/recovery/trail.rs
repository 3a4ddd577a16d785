//! The track that the robot came by, as odometry told it.

use nalgebra::Point2;
use zeronav_msgs::Pose;

/// Poses kept.
const POSES: usize = 256;

/// [m] and [rad] from one pose to the next.
const SPACING_M: f64 = 0.03;
const SPACING_RAD: f64 = 0.1;

/// [m] between two periods beyond which odometry has jumped and the track before it is none.
const JUMP_M: f64 = 0.3;

/// The last metres, oldest first, `odom_from_base`; driving back along them forgets them.
#[derive(Debug, Clone)]
pub(crate) struct Trail {
    poses: Vec<Pose>,
    last: Option<Pose>,
}

impl Trail {
    pub(crate) fn new() -> Self {
        Self {
            poses: Vec::with_capacity(POSES),
            last: None,
        }
    }

    /// Takes in where the robot is.
    pub(crate) fn note(&mut self, odom_from_base: &Pose) {
        if self
            .last
            .is_some_and(|last| last.distance_m(odom_from_base) > JUMP_M)
        {
            self.poses.clear();
        }
        self.last = Some(*odom_from_base);
        let far = self.poses.last().is_none_or(|last| {
            let turned_rad = zeronav_msgs::pose::wrap_angle(last.yaw_rad - odom_from_base.yaw_rad);
            last.distance_m(odom_from_base) >= SPACING_M || turned_rad.abs() >= SPACING_RAD
        });
        if !far {
            return;
        }
        if self.poses.len() == POSES {
            self.poses.remove(0);
        }
        self.poses.push(*odom_from_base);
    }

    /// Forgets what lies ahead of a robot that drives back: poses that it has passed.
    pub(crate) fn retrace(&mut self, odom_from_base: &Pose) {
        let base_from_odom = odom_from_base.isometry().inverse();
        while let Some(last) = self.poses.last() {
            let in_base: Point2<f64> = base_from_odom * last.point();
            if in_base.x < -0.5 * SPACING_M || self.poses.len() == 1 {
                break;
            }
            self.poses.pop();
        }
        self.last = Some(*odom_from_base);
    }

    /// The poses of the last `length_m`, the newest first, in the `base` of now.
    pub(crate) fn back(
        &self,
        odom_from_base: &Pose,
        length_m: f64,
    ) -> impl Iterator<Item = Pose> + '_ {
        let base_from_odom = odom_from_base.isometry().inverse();
        let yaw_rad = odom_from_base.yaw_rad;
        let (mut from, mut along_m) = (odom_from_base.point(), 0.0);
        self.poses.iter().rev().map_while(move |pose| {
            along_m += (pose.point() - from).norm();
            from = pose.point();
            let at = base_from_odom * pose.point();
            let turned_rad = zeronav_msgs::pose::wrap_angle(pose.yaw_rad - yaw_rad);
            (along_m <= length_m).then(|| Pose::new(at.x, at.y, turned_rad))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two metres along a quarter circle to the left.
    fn driven() -> (Trail, Pose) {
        let mut trail = Trail::new();
        let mut pose = Pose::default();
        for i in 0..=200 {
            let angle = core::f64::consts::FRAC_PI_2 * f64::from(i) / 200.0;
            let radius = 4.0 / core::f64::consts::PI;
            pose = Pose::new(
                5.0 + radius * angle.sin(),
                radius * (1.0 - angle.cos()),
                angle,
            );
            trail.note(&pose);
        }
        (trail, pose)
    }

    #[test]
    fn the_way_back_is_the_way_that_was_driven() {
        let (trail, pose) = driven();
        let back: Vec<Pose> = trail.back(&pose, 1.0).collect();
        let end = back.last().expect("poses");
        // A metre back on a circle of 4/pi m: the chord's end, and the angle.
        let radius = 4.0 / core::f64::consts::PI;
        let angle = 1.0 / radius;
        assert!((end.x_m + radius * angle.sin()).abs() < 0.04, "{end:?}");
        assert!(
            (end.y_m - radius * (1.0 - angle.cos())).abs() < 0.04,
            "{end:?}"
        );
        assert!((end.yaw_rad + angle).abs() < 0.04, "{end:?}");
        assert!(back.windows(2).all(|pair| pair[1].x_m < pair[0].x_m));
    }

    #[test]
    fn who_goes_back_forgets_what_he_has_passed() {
        let (mut trail, pose) = driven();
        let half = trail.back(&pose, 1.0).last().expect("poses");
        let there = pose.then(&half);
        trail.retrace(&there);
        let next = trail.back(&there, 0.2).next().expect("poses before");
        assert!(next.x_m < 0.0 && next.x_m > -0.1, "{next:?}");
    }

    #[test]
    fn a_jump_leaves_nothing_to_go_back_by() {
        let (mut trail, pose) = driven();
        let elsewhere = Pose::new(pose.x_m + 3.0, pose.y_m, pose.yaw_rad);
        trail.note(&elsewhere);
        assert_eq!(trail.back(&elsewhere, 9.0).count(), 1);
    }

    #[test]
    fn the_track_is_bounded() {
        let mut trail = Trail::new();
        for i in 0..2000 {
            trail.note(&Pose::new(0.05 * f64::from(i), 0.0, 0.0));
        }
        assert_eq!(trail.poses.len(), POSES);
        assert_eq!(trail.poses.capacity(), POSES);
    }
}
