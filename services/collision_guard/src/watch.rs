//! Inputs that lie about time: going back, standing still, jumping.

use zeronav_msgs::Pose;
use zeronav_msgs::odometry::Odometry;
use zeronav_msgs::pose::wrap_angle;
use zeronav_msgs::time::seconds;

/// Messages in a row that must go forward in time after one that went back.
const FORWARD_MIN: u8 = 2;

/// [m/s] and [rad/s] above which odometry that keeps its pose contradicts itself.
const MOVING: (f64, f64) = (0.05, 0.1);

/// Share of the fastest motion, and the slack in [m] and [rad], beyond which a new pose is a jump
/// and no motion.
const JUMP: (f64, f64, f64) = (1.5, 0.03, 0.05);

/// Whether messages of one kind go forward in run time.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Order {
    id: u64,
    run_ns: u64,
    forward: u8,
}

impl Order {
    /// Takes in a message by its id; true when it is a new one.
    pub(crate) fn take(&mut self, id: u64, run_ns: u64) -> bool {
        if id == self.id {
            return false;
        }
        self.forward = if self.id == 0 {
            FORWARD_MIN
        } else if run_ns > self.run_ns {
            (self.forward + 1).min(FORWARD_MIN)
        } else {
            0
        };
        self.id = id;
        self.run_ns = run_ns;
        true
    }

    /// False from a message that went back in time until enough went forward again.
    pub(crate) const fn is_forward(&self) -> bool {
        self.forward >= FORWARD_MIN
    }
}

/// Whether scans change while the robot moves.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct FrozenScan {
    hash: u64,
    /// `odom_from_base` at the first of the scans that are alike.
    since: Pose,
    moved: (f64, f64),
}

impl FrozenScan {
    /// Takes in a new scan's ranges and where the robot was.
    pub(crate) fn take(&mut self, ranges: &[f32], odom_from_base: &Pose) {
        let hash = hash(ranges);
        // Nothing in sight looks alike from everywhere.
        let empty = !ranges.iter().any(|range| range.is_finite());
        if hash != self.hash || empty {
            self.hash = hash;
            self.since = *odom_from_base;
        }
        let turned_rad = wrap_angle(odom_from_base.yaw_rad - self.since.yaw_rad).abs();
        self.moved = (odom_from_base.distance_m(&self.since), turned_rad);
    }

    /// True when the robot has moved by so much while the scans stayed bitwise alike.
    pub(crate) fn is_frozen(&self, moved_m: f64, turned_rad: f64) -> bool {
        self.moved.0 > moved_m || self.moved.1 > turned_rad
    }
}

/// FNV-1a over the bits of the ranges, a word at a time.
fn hash(ranges: &[f32]) -> u64 {
    ranges.iter().fold(0xcbf2_9ce4_8422_2325, |hash, range| {
        (hash ^ u64::from(range.to_bits())).wrapping_mul(0x0000_0100_0000_01b3)
    })
}

/// Whether odometry agrees with itself.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct OdometrySense {
    last: Option<(Pose, u64)>,
    /// Run time since which the pose is constant while the twist is not zero. [ns]
    still_since_ns: Option<u64>,
}

impl OdometrySense {
    /// Takes in new odometry; true when the pose has jumped by more than a robot with these
    /// fastest speeds can move.
    pub(crate) fn take(&mut self, odometry: &Odometry, run_ns: u64, fastest: (f64, f64)) -> bool {
        let pose = odometry.pose;
        let before = self.last.replace((pose, run_ns));
        let moving = odometry.v_mps.abs() > MOVING.0 || odometry.w_radps.abs() > MOVING.1;
        let unchanged = before.is_some_and(|(last, _)| last == pose);
        self.still_since_ns = if moving && unchanged {
            self.still_since_ns.or(Some(run_ns))
        } else {
            None
        };
        before.is_some_and(|(last, last_ns)| {
            let elapsed_s = seconds(run_ns.saturating_sub(last_ns));
            let turned_rad = wrap_angle(pose.yaw_rad - last.yaw_rad).abs();
            pose.distance_m(&last) > JUMP.0 * fastest.0 * elapsed_s + JUMP.1
                || turned_rad > JUMP.0 * fastest.1 * elapsed_s + JUMP.2
        })
    }

    /// [s] for which the pose has stood still although the twist says that the robot moves.
    pub(crate) fn frozen_s(&self, run_ns: u64) -> f64 {
        self.still_since_ns
            .map_or(0.0, |since| seconds(run_ns.saturating_sub(since)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn time_that_goes_back_is_not_believed_until_it_goes_forward_twice() {
        let mut order = Order::default();
        for (id, run_ns, forward) in [
            (1, 100, true),
            (2, 200, true),
            (3, 150, false),
            (3, 150, false),
            (4, 160, false),
            (5, 170, true),
            (6, 170, false),
        ] {
            order.take(id, run_ns);
            assert_eq!(order.is_forward(), forward, "message {id}");
        }
    }

    #[test]
    fn equal_scans_are_frozen_once_the_robot_has_moved() {
        let mut frozen = FrozenScan::default();
        let at = |x_m| Pose::new(x_m, 0.0, 0.0);
        for (x_m, ranges, expected) in [
            (0.0, [1.0, 2.0], false),
            (0.1, [1.0, 2.0], false),
            (0.12, [1.0, 2.0], true),
            (0.14, [1.0, 2.1], false),
            (0.3, [f32::INFINITY; 2], false),
            (0.6, [f32::INFINITY; 2], false),
        ] {
            frozen.take(&ranges, &at(x_m));
            assert_eq!(frozen.is_frozen(0.1, 0.2), expected, "at {x_m}");
        }
    }

    /// A single bit of a single range is noise enough.
    #[test]
    fn scans_that_differ_in_one_bit_are_not_frozen() {
        let ranges = [1.0_f32, 2.5, 0.1, f32::INFINITY];
        for beam in 0..ranges.len() {
            for bit in 0..32 {
                let mut frozen = FrozenScan::default();
                frozen.take(&ranges, &Pose::default());
                let mut other = ranges;
                other[beam] = f32::from_bits(ranges[beam].to_bits() ^ 1 << bit);
                frozen.take(&other, &Pose::new(1.0, 0.0, 0.0));
                assert!(!frozen.is_frozen(0.1, 0.2), "bit {bit} of beam {beam}");
            }
        }
    }

    #[test]
    fn equal_scans_are_frozen_once_the_robot_has_turned() {
        let mut frozen = FrozenScan::default();
        for (yaw_rad, expected) in [(3.0, false), (3.1, false), (-3.05, true)] {
            frozen.take(&[1.0, 2.0], &Pose::new(0.0, 0.0, yaw_rad));
            assert_eq!(frozen.is_frozen(0.1, 0.2), expected, "at {yaw_rad}");
        }
    }

    #[test]
    fn odometry_that_jumps_or_stands_while_it_moves_is_noticed() {
        let mut sense = OdometrySense::default();
        let at = |x_m, v_mps| Odometry {
            pose: Pose::new(x_m, 0.0, 0.0),
            v_mps,
            ..Odometry::default()
        };
        let ms = 1_000_000;
        let fastest = (1.0, 2.0);
        assert!(!sense.take(&at(0.0, 1.0), 20 * ms, fastest));
        assert!(!sense.take(&at(0.02, 1.0), 40 * ms, fastest));
        assert!(sense.take(&at(0.3, 1.0), 60 * ms, fastest));
        for tick in 4..10 {
            assert!(!sense.take(&at(0.3, 1.0), tick * 20 * ms, fastest));
        }
        assert!((sense.frozen_s(180 * ms) - 0.1).abs() < 1e-9);
        sense.take(&at(0.32, 1.0), 200 * ms, fastest);
        assert!(sense.frozen_s(300 * ms) < 1e-9);
    }

    #[test]
    fn a_jump_is_half_as_much_again_as_the_fastest_motion_and_some_slack() {
        // 20 ms at 1 m/s and 2 rad/s: 0.03 + 0.03 m, 0.06 + 0.05 rad.
        let jumps = |pose: Pose| {
            let mut sense = OdometrySense::default();
            let at = |pose| Odometry {
                pose,
                ..Odometry::default()
            };
            sense.take(&at(Pose::new(1.0, 2.0, 3.1)), 40_000_000, (1.0, 2.0));
            sense.take(&at(pose), 60_000_000, (1.0, 2.0))
        };
        for (pose, jumped) in [
            (Pose::new(1.059, 2.0, 3.1), false),
            (Pose::new(1.061, 2.0, 3.1), true),
            (Pose::new(1.0, 1.939, 3.1), true),
            (Pose::new(1.0, 2.0, 3.209 - core::f64::consts::TAU), false),
            (Pose::new(1.0, 2.0, 3.211), true),
            (Pose::new(1.0, 2.0, 2.989), true),
        ] {
            assert_eq!(jumps(pose), jumped, "{pose:?}");
        }
    }

    #[test]
    fn the_slack_itself_is_no_jump() {
        for (pose, jumped) in [
            (Pose::new(0.03, 0.0, 0.0), false),
            (Pose::new(0.031, 0.0, 0.0), true),
            (Pose::new(0.0, 0.0, 0.05), false),
            (Pose::new(0.0, 0.0, 0.051), true),
        ] {
            let mut sense = OdometrySense::default();
            let standing = Odometry::default();
            // Two messages of one moment.
            sense.take(&standing, 20_000_000, (1.0, 2.0));
            let moved = Odometry { pose, ..standing };
            let found = sense.take(&moved, 20_000_000, (1.0, 2.0));
            assert_eq!(found, jumped, "{pose:?}");
        }
    }

    #[test]
    fn only_a_twist_that_moves_contradicts_a_pose_that_stays() {
        for (v_mps, w_radps, stands) in [
            (0.05, 0.1, false),
            (0.051, 0.0, true),
            (-0.051, 0.0, true),
            (0.0, 0.101, true),
            (0.0, -0.101, true),
        ] {
            let mut sense = OdometrySense::default();
            let odometry = Odometry {
                v_mps,
                w_radps,
                ..Odometry::default()
            };
            sense.take(&odometry, 1_000_000_000, (1.0, 2.0));
            sense.take(&odometry, 2_000_000_000, (1.0, 2.0));
            let stood = sense.frozen_s(3_000_000_000);
            let expected = if stands { 1.0 } else { 0.0 };
            assert!(
                (stood - expected).abs() < 1e-9,
                "{v_mps} m/s, {w_radps} rad/s: {stood} s"
            );
        }
    }
}
