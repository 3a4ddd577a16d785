//! What the wheels, and a gyro where there is one, say about the way: their own motion, with errors
//! that grow by distance and by angle.

use crate::noise::{Draws, Stream};
use nalgebra::Matrix3;
use zeronav_msgs::Pose;
use zeronav_msgs::pose::wrap_angle;
use zeronav_robot_description::OdometrySpec;

/// Dead reckoning of one run. Its frame is `map` at the start.
#[derive(Debug, Clone)]
pub struct Odometer {
    spec: OdometrySpec,
    seed: u64,
    pose: Pose,
    /// Of x, y and yaw.
    covariance: Matrix3<f64>,
}

/// What the wheels did in a tick.
#[derive(Debug, Clone, Copy)]
pub struct WheelMotion {
    /// Pose at the end of the tick in the frame of its beginning, if nothing slips.
    pub shift: Pose,
    /// By how much the robot really turned. [rad]
    pub turned_rad: f64,
    /// Way of the wheels' middle, forwards and backwards. [m] >= 0
    pub distance_m: f64,
}

impl WheelMotion {
    /// The shift of wheels that roll as far, on an arc that turns as far as the robot really did.
    fn turned_by_gyro(&self) -> Pose {
        let (sin, cos) = (0.5 * self.shift.yaw_rad).sin_cos();
        let chord_m = cos * self.shift.x_m + sin * self.shift.y_m;
        let (sin, cos) = (0.5 * self.turned_rad).sin_cos();
        Pose::new(chord_m * cos, chord_m * sin, self.turned_rad)
    }
}

impl Odometer {
    /// An odometer that starts from `start`, `map_from_base`.
    #[must_use]
    pub fn new(spec: OdometrySpec, seed: u64, start: Pose) -> Self {
        Self {
            spec,
            seed,
            pose: start,
            covariance: Matrix3::zeros(),
        }
    }

    /// `odom_from_base`.
    #[must_use]
    pub const fn pose(&self) -> Pose {
        self.pose
    }

    /// The yaw rate that it says of wheels that turn with `wheels_radps` under a robot that turns
    /// with `robot_radps`. [rad/s]
    #[must_use]
    pub const fn w_radps(&self, wheels_radps: f64, robot_radps: f64) -> f64 {
        if self.spec.gyro {
            robot_radps
        } else {
            wheels_radps
        }
    }

    /// Variances of x [m^2], y [m^2] and yaw [rad^2] since the start, to first order.
    #[must_use]
    pub fn variance(&self) -> [f64; 3] {
        let diagonal = self.covariance.diagonal();
        [diagonal.x, diagonal.y, diagonal.z]
    }

    /// Says at once that the robot has moved by `shift` in its own frame; the variances stay.
    pub fn jump(&mut self, shift: &Pose) {
        self.pose = self.pose.then(shift);
    }

    /// Counts a tick that ends at `run_ns`.
    pub fn count(&mut self, wheels: &WheelMotion, run_ns: u64) {
        let spec = &self.spec;
        let shift = if spec.gyro {
            wheels.turned_by_gyro()
        } else {
            wheels.shift
        };
        let turned_rad = shift.yaw_rad.abs();
        let variance_of = |by_distance: f64, by_turn: f64| {
            by_distance.powi(2) * wheels.distance_m + by_turn.powi(2) * turned_rad
        };
        let distance_m2 = variance_of(spec.distance_per_distance, spec.distance_per_turn);
        let turn_rad2 = variance_of(spec.turn_per_distance, spec.turn_per_turn);
        let mut draws = Draws::new(self.seed, Stream::Odometry, run_ns);
        let (along_m, turn_rad) = (
            distance_m2.sqrt() * draws.normal(),
            turn_rad2.sqrt() * draws.normal(),
        );
        // The error along the way points where the wheels do in the middle of the tick.
        let (sin, cos) = (0.5 * shift.yaw_rad).sin_cos();
        let seen = Pose::new(
            shift.x_m + cos * along_m,
            shift.y_m + sin * along_m,
            wrap_angle(shift.yaw_rad + turn_rad),
        );
        let before = self.pose;
        self.pose = before.then(&seen);
        let (x, y) = (self.pose.x_m - before.x_m, self.pose.y_m - before.y_m);
        let carry = Matrix3::new(1.0, 0.0, -y, 0.0, 1.0, x, 0.0, 0.0, 1.0);
        let (sin, cos) = (before.yaw_rad + 0.5 * shift.yaw_rad).sin_cos();
        let added = Matrix3::new(
            cos * cos * distance_m2,
            cos * sin * distance_m2,
            0.0,
            cos * sin * distance_m2,
            sin * sin * distance_m2,
            0.0,
            0.0,
            0.0,
            turn_rad2,
        );
        self.covariance = carry * self.covariance * carry.transpose() + added;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TICK_NS: u64 = 20_000_000;

    const SPEC: OdometrySpec = OdometrySpec {
        distance_per_distance: 0.02,
        distance_per_turn: 0.01,
        turn_per_turn: 0.03,
        turn_per_distance: 0.01,
        gyro: false,
    };

    /// Error after `ticks` ticks of the same motion, and the variances that the odometer claims.
    fn drive(seed: u64, ticks: u64, tick_ns: u64, shift: Pose) -> ([f64; 3], [f64; 3]) {
        let mut odometer = Odometer::new(SPEC, seed, Pose::new(1.0, 2.0, 0.5));
        let mut truth = odometer.pose();
        let wheels = WheelMotion {
            shift,
            turned_rad: shift.yaw_rad,
            distance_m: shift.x_m.abs(),
        };
        for tick in 1..=ticks {
            odometer.count(&wheels, tick * tick_ns);
            truth = truth.then(&shift);
        }
        let found = odometer.pose();
        let error = [
            found.x_m - truth.x_m,
            found.y_m - truth.y_m,
            wrap_angle(found.yaw_rad - truth.yaw_rad),
        ];
        (error, odometer.variance())
    }

    #[test]
    fn errors_are_as_large_as_the_odometer_says() {
        // 4 m straight, a turn on the spot of 2 rad, and a curve.
        for shift in [
            Pose::new(0.01, 0.0, 0.0),
            Pose::new(0.0, 0.0, 0.005),
            Pose::new(0.01, 0.0, 0.005),
        ] {
            let n = 2000_u32;
            let mut squares = [0.0; 3];
            let mut claimed = [0.0; 3];
            for seed in 0..u64::from(n) {
                let (error, variance) = drive(seed, 400, TICK_NS, shift);
                for axis in 0..3 {
                    squares[axis] += error[axis].powi(2) / f64::from(n);
                    claimed[axis] += variance[axis] / f64::from(n);
                }
            }
            for axis in 0..3 {
                if claimed[axis] < 1e-12 {
                    assert!(squares[axis] < 1e-12, "axis {axis}: {squares:?}");
                    continue;
                }
                // Five standard errors of a variance, and what the first order leaves out.
                let ratio = squares[axis] / claimed[axis];
                assert!((ratio - 1.0).abs() < 0.2, "{shift:?} axis {axis}: {ratio}");
            }
        }
    }

    #[test]
    fn a_gyro_sees_the_robot_turn_and_not_its_wheels() {
        let exact = |gyro| OdometrySpec {
            distance_per_distance: 0.0,
            distance_per_turn: 0.0,
            turn_per_turn: 0.0,
            turn_per_distance: 0.0,
            gyro,
        };
        // The wheels roll 2 m on an arc of 1 rad; half of the turning is lost.
        let yaw_rad = 0.005_f64;
        let radius_m = 0.01 / yaw_rad;
        let wheels = WheelMotion {
            shift: Pose::new(
                radius_m * yaw_rad.sin(),
                radius_m * (1.0 - yaw_rad.cos()),
                yaw_rad,
            ),
            turned_rad: 0.5 * yaw_rad,
            distance_m: 0.01,
        };
        let driven = |gyro| {
            let mut odometer = Odometer::new(exact(gyro), 1, Pose::default());
            for tick in 1..=200 {
                odometer.count(&wheels, tick * TICK_NS);
            }
            odometer.pose()
        };
        let arc = |turned: f64| {
            Pose::new(
                2.0 * turned.sin() / turned,
                2.0 * (1.0 - turned.cos()) / turned,
                turned,
            )
        };
        for (pose, truth) in [(driven(false), arc(1.0)), (driven(true), arc(0.5))] {
            assert!(pose.distance_m(&truth) < 1e-4, "{pose:?} {truth:?}");
            assert!((pose.yaw_rad - truth.yaw_rad).abs() < 1e-9);
        }
    }

    #[test]
    fn variances_grow_with_the_way_and_not_with_the_ticks() {
        let (_, coarse) = drive(1, 200, TICK_NS, Pose::new(0.02, 0.0, 0.0));
        let (_, fine) = drive(1, 400, TICK_NS / 2, Pose::new(0.01, 0.0, 0.0));
        // 4 m: 0.02^2 * 4 along the way, 0.01^2 * 4 of yaw.
        for variances in [coarse, fine] {
            assert!((variances[2] - 4.0e-4).abs() < 1e-9, "{variances:?}");
        }
        assert!((coarse[0] / fine[0] - 1.0).abs() < 0.02);
    }

    #[test]
    fn a_jump_is_in_the_frame_of_the_robot_and_leaves_the_variances() {
        let mut odometer =
            Odometer::new(SPEC, 1, Pose::new(1.0, 2.0, core::f64::consts::FRAC_PI_2));
        odometer.jump(&Pose::new(0.3, 0.1, 0.2));
        let pose = odometer.pose();
        assert!((pose.x_m - 0.9).abs() < 1e-12 && (pose.y_m - 2.3).abs() < 1e-12);
        assert!((pose.yaw_rad - core::f64::consts::FRAC_PI_2 - 0.2).abs() < 1e-12);
        assert!(odometer.variance().iter().all(|variance| *variance < 1e-30));
    }

    #[test]
    fn a_robot_that_stands_counts_nothing() {
        let (error, variance) = drive(1, 1000, TICK_NS, Pose::default());
        assert_eq!((error, variance), ([0.0; 3], [0.0; 3]));
    }
}
