//! Twists within the robot's limits: what the next period can reach, how a stop unfolds, and the
//! exact arc of a constant twist.

use nalgebra::Point2;
use zeronav_msgs::Pose;
use zeronav_msgs::description::Description;

/// Forward speed and yaw rate in `base`.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Twist {
    /// [m/s] forward.
    pub v_mps: f64,
    /// [rad/s] counter-clockwise.
    pub w_radps: f64,
}

impl Twist {
    /// No motion.
    pub const REST: Self = Self::new(0.0, 0.0);

    /// A twist from its two numbers.
    #[must_use]
    pub const fn new(v_mps: f64, w_radps: f64) -> Self {
        Self { v_mps, w_radps }
    }

    /// True when both speeds are so small that a robot counts as standing.
    #[must_use]
    pub fn is_standing(self) -> bool {
        self.v_mps.abs() < 0.02 && self.w_radps.abs() < 0.05
    }

    /// Where the next command starts from when this one was the last: as far as the measured twist
    /// can have followed it within `lead_s`.
    pub(crate) fn near(self, robot: &Description, measured: Self, lead_s: f64) -> Self {
        let v = measured.v_mps.clamp(robot.v_mps_min, robot.v_mps_max);
        let w = measured
            .w_radps
            .clamp(-robot.w_radps_max, robot.w_radps_max);
        let up = robot.a_mps2_max.max(robot.brake_mps2) * lead_s;
        let about = robot.alpha_radps2_max * lead_s;
        Self {
            v_mps: self.v_mps.clamp(v - up, v + up),
            w_radps: self.w_radps.clamp(w - about, w + about),
        }
    }

    /// `base` before the motion from `base` after `elapsed_s` of this twist: the exact arc
    /// (Fox, Burgard, Thrun 1997, Eq. 7, with the limit of a straight line).
    #[must_use]
    pub fn arc(self, elapsed_s: f64) -> Pose {
        let yaw_rad = self.w_radps * elapsed_s;
        let half = 0.5 * yaw_rad;
        // The chord of an arc of length s and angle 2h is s sin(h) / h long and points along h.
        let chord_m = self.v_mps * elapsed_s * sinc(half);
        Pose::new(chord_m * half.cos(), chord_m * half.sin(), yaw_rad)
    }
}

/// `sin(x) / x`, 1 at 0.
pub(crate) fn sinc(x: f64) -> f64 {
    if x.abs() < 1.0e-4 {
        1.0 - x * x / 6.0
    } else {
        x.sin() / x
    }
}

/// The twist nearest to `wanted` that `elapsed_s` of acceleration and braking can reach from
/// `from`; both speeds change on their own. Speeding up is bounded by `a_mps2_max`, slowing down
/// by `brake_mps2`; a change of direction passes through zero at `brake_mps2`.
#[must_use]
pub fn reachable(robot: &Description, from: Twist, wanted: Twist, elapsed_s: f64) -> Twist {
    let up = robot.a_mps2_max * elapsed_s;
    let down = robot.brake_mps2 * elapsed_s;
    let (lowest, highest) = if from.v_mps > 0.0 {
        ((from.v_mps - down).max(-up.min(down)), from.v_mps + up)
    } else if from.v_mps < 0.0 {
        (from.v_mps - up, (from.v_mps + down).min(up.min(down)))
    } else {
        (-up, up)
    };
    let yaw_step = robot.alpha_radps2_max * elapsed_s;
    Twist {
        v_mps: wanted.v_mps.clamp(lowest, highest),
        w_radps: wanted
            .w_radps
            .clamp(from.w_radps - yaw_step, from.w_radps + yaw_step),
    }
}

/// The next twist of a stop: the speed falls by `brake_mps2`, the yaw rate in proportion, so that
/// the robot stays on its arc, but by no more than `alpha_radps2_max`. The guard ramps alike.
#[must_use]
pub fn towards_rest(robot: &Description, from: Twist, elapsed_s: f64) -> Twist {
    let step = robot.brake_mps2 * elapsed_s;
    let v_mps = if from.v_mps.abs() <= step {
        0.0
    } else {
        from.v_mps - step.copysign(from.v_mps)
    };
    let yaw_step = robot.alpha_radps2_max * elapsed_s;
    let on_arc = if from.v_mps.abs() > 0.0 {
        from.w_radps * (v_mps / from.v_mps)
    } else {
        0.0
    };
    Twist {
        v_mps,
        w_radps: on_arc.clamp(from.w_radps - yaw_step, from.w_radps + yaw_step),
    }
}

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

/// The poses of a stop that begins after `reaction_s` at `twist`, in the `base` of now.
///
/// The step is as long as the time in which no point of a footprint of `reach_m` around the
/// origin moves by more than `spacing_m` at the first twist, and at least 5 ms.
pub(crate) struct Stop<'a> {
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
    pub(crate) fn new(
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
    pub(crate) const fn step_s(&self) -> f64 {
        self.step_s
    }

    /// [m] driven up to the last pose given out.
    pub(crate) const fn arc_m(&self) -> f64 {
        self.arc_m
    }
}

impl Iterator for Stop<'_> {
    /// `base` of now from `base` then, and the twist there.
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
        let mean = Twist::new(
            0.5 * (self.twist.v_mps + ramped.v_mps),
            0.5 * (self.twist.w_radps + ramped.w_radps),
        );
        let step = mean.arc(self.step_s);
        let at = self.pose.transform(Point2::new(step.x_m, step.y_m));
        self.pose = Pose::new(at.x, at.y, self.pose.yaw_rad + step.yaw_rad);
        self.arc_m += mean.v_mps.abs() * self.step_s;
        self.twist = ramped;
        Some((self.pose, ramped))
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// One that may drive backwards, too.
    pub(crate) fn reversing() -> Description {
        Description {
            v_mps_min: -0.3,
            ..robot()
        }
    }

    fn robot() -> Description {
        Description {
            v_mps_max: 1.0,
            w_radps_max: 2.0,
            a_mps2_max: 1.0,
            brake_mps2: 2.0,
            alpha_radps2_max: 4.0,
            ..Description::default()
        }
    }

    #[test]
    fn the_arc_agrees_with_small_euler_steps() {
        let twist = Twist::new(0.8, -1.3);
        let (mut x, mut y, mut yaw) = (0.0, 0.0, 0.0_f64);
        let n = 200_000;
        let dt = 1.5 / f64::from(n);
        for _ in 0..n {
            x += twist.v_mps * dt * yaw.cos();
            y += twist.v_mps * dt * yaw.sin();
            yaw += twist.w_radps * dt;
        }
        let arc = twist.arc(1.5);
        assert!((arc.x_m - x).abs() < 1e-5 && (arc.y_m - y).abs() < 1e-5);
        assert!((arc.yaw_rad - yaw).abs() < 1e-9);
        let straight = Twist::new(0.8, 0.0).arc(2.0);
        assert!((straight.x_m - 1.6).abs() < 1e-15 && straight.y_m.abs() < 1e-15);
    }

    #[test]
    fn speeding_up_and_slowing_down_have_their_own_limits() {
        let robot = robot();
        let from = Twist::new(0.5, 0.0);
        let fast = reachable(&robot, from, Twist::new(1.0, 1.0), 0.1);
        assert!((fast.v_mps - 0.6).abs() < 1e-12 && (fast.w_radps - 0.4).abs() < 1e-12);
        let slow = reachable(&robot, from, Twist::REST, 0.1);
        assert!((slow.v_mps - 0.3).abs() < 1e-12);
        let creeping = Twist::new(0.05, 0.0);
        let back = reachable(&robot, creeping, Twist::new(-1.0, 0.0), 0.1);
        assert!(back.v_mps <= 0.0 && back.v_mps >= -0.1);
    }

    #[test]
    fn a_stop_drives_the_stop_distance() {
        let robot = robot();
        let mut stop = Stop::new(&robot, Twist::new(1.0, 0.0), 0.1, 0.3, 0.005);
        let mut last = Pose::default();
        for (pose, _) in stop.by_ref() {
            last = pose;
        }
        let expected = stop_distance_m(&robot, 1.0, 0.1);
        assert!((stop.arc_m() - expected).abs() < 0.01);
        assert!((last.x_m - expected).abs() < 0.01);
    }
}
