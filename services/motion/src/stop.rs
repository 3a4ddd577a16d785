//! How a stop unfolds: its length, its angle, its poses.

use crate::limits::towards_rest;
use crate::twist::Twist;
use nalgebra::Point2;
use zeronav_msgs::Pose;
use zeronav_msgs::description::Description;

/// [m] driven until rest from `v_mps` when braking begins after `reaction_s`.
#[must_use]
pub fn stop_distance_m(robot: &Description, v_mps: f64, reaction_s: f64) -> f64 {
    robot.braking_distance_m(v_mps) + v_mps.abs() * reaction_s
}

/// [rad] turned until rest from `w_radps` when braking begins after `reaction_s`.
#[must_use]
pub fn stop_angle_rad(robot: &Description, w_radps: f64, reaction_s: f64) -> f64 {
    w_radps * w_radps / (2.0 * robot.alpha_radps2_max) + w_radps.abs() * reaction_s
}

/// The poses of a stop that begins after `reaction_s` at `twist`, in the current `base`.
///
/// The step is 5 ms to 100 ms long.
#[derive(Debug, Clone)]
pub struct Stop<'a> {
    robot: &'a Description,
    twist: Twist,
    pose: Pose,
    reaction_s: f64,
    step_s: f64,
    arc_m: f64,
    steps: u32,
}

/// Bound on the poses of one stop: 10 s of the shortest step.
const STOP_STEPS_MAX: u32 = 2000;

impl<'a> Stop<'a> {
    /// The stop of `robot` from `twist`: braking begins after `reaction_s`, and no point within
    /// `reach_m` of the origin moves by more than `spacing_m` from pose to pose.
    #[must_use]
    pub fn new(
        robot: &'a Description,
        twist: Twist,
        reaction_s: f64,
        reach_m: f64,
        spacing_m: f64,
    ) -> Self {
        let fastest_mps = twist.v_mps.abs() + twist.w_radps.abs() * reach_m;
        let step_s = (spacing_m / fastest_mps.max(1.0e-3)).clamp(0.005, 0.1);
        Self {
            robot,
            twist,
            pose: Pose::default(),
            reaction_s,
            step_s,
            arc_m: 0.0,
            steps: 0,
        }
    }

    /// [s] from pose to pose.
    #[must_use]
    pub const fn step_s(&self) -> f64 {
        self.step_s
    }

    /// [m] driven up to the last pose returned.
    #[must_use]
    pub const fn arc_m(&self) -> f64 {
        self.arc_m
    }
}

impl Iterator for Stop<'_> {
    /// `base_now_from_base_then`, and the twist there.
    type Item = (Pose, Twist);

    fn next(&mut self) -> Option<Self::Item> {
        if self.twist == Twist::REST || self.steps >= STOP_STEPS_MAX {
            return None;
        }
        self.steps += 1;
        let ramped = if self.reaction_s > 0.0 {
            self.reaction_s -= self.step_s;
            self.twist
        } else {
            towards_rest(self.robot, self.twist, self.step_s)
        };
        let mean = self.twist.mean(ramped);
        let step = mean.arc(self.step_s);
        let at = self.pose.transform(Point2::new(step.x_m, step.y_m));
        self.pose = Pose::new(at.x, at.y, self.pose.yaw_rad + step.yaw_rad);
        self.arc_m += mean.v_mps.abs() * self.step_s;
        self.twist = ramped;
        Some((self.pose, ramped))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stop_drives_the_stop_distance() {
        let robot = Description {
            brake_mps2: 2.0,
            alpha_radps2_max: 4.0,
            ..Description::default()
        };
        let mut stop = Stop::new(&robot, Twist::new(1.0, 0.0), 0.1, 0.3, 0.005);
        let mut last = Pose::default();
        for (pose, _) in stop.by_ref() {
            last = pose;
        }
        let expected = stop_distance_m(&robot, 1.0, 0.1);
        assert!((stop.arc_m() - expected).abs() < 0.01);
        assert!((last.x_m - expected).abs() < 0.01);
    }

    #[test]
    fn stops_have_closed_forms() {
        let robot = Description {
            brake_mps2: 2.0,
            alpha_radps2_max: 4.0,
            ..Description::default()
        };
        // 1 m/s: 0.25 m of braking, 0.1 m before it. 2 rad/s: 0.5 rad and 0.2 rad.
        assert!((stop_distance_m(&robot, -1.0, 0.1) - 0.35).abs() < 1e-12);
        assert!((stop_angle_rad(&robot, -2.0, 0.1) - 0.7).abs() < 1e-12);
    }

    #[test]
    fn a_stop_on_an_arc_has_poses_no_farther_apart_than_asked() {
        let robot = Description {
            brake_mps2: 2.0,
            alpha_radps2_max: 40.0,
            ..Description::default()
        };
        let stop = Stop::new(&robot, Twist::new(1.0, 2.0), 0.0, 0.5, 0.02);
        // 2 m/s at the outermost point.
        assert!((stop.step_s() - 0.01).abs() < 1e-12);
        let poses: Vec<(Pose, Twist)> = stop.collect();
        let (last, twist) = poses[poses.len() - 1];
        assert_eq!(twist, Twist::REST);
        // A quarter of a metre on a circle of half a metre.
        assert!((last.yaw_rad - 0.5).abs() < 1e-9, "{last:?}");
        assert!((last.x_m - 0.5 * 0.5_f64.sin()).abs() < 1e-4, "{last:?}");
        assert!(
            (last.y_m - 0.5 * (1.0 - 0.5_f64.cos())).abs() < 1e-4,
            "{last:?}"
        );
        let slow = Stop::new(&robot, Twist::new(0.0, 0.0), 0.0, 0.5, 0.02);
        assert!((slow.step_s() - 0.1).abs() < 1e-12 && slow.count() == 0);
        let fast = Stop::new(&robot, Twist::new(100.0, 0.0), 0.0, 0.5, 0.02);
        assert!((fast.step_s() - 0.005).abs() < 1e-12);
        assert_eq!(fast.count(), 2000, "bounded");
    }
}
