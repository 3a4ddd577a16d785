//! How an error of a pose, (x, y, yaw), carries over from one pose to another.

use nalgebra::{Matrix3, Rotation2, Vector2};

/// Least standard deviations of the pose, for what neither scan nor map can tell. [m, rad]
const FLOOR: (f64, f64) = (0.005, 0.002);

/// Largest standard deviations: a robot that has been lost for long is not lost everywhere.
pub(crate) const CEILING: (f64, f64) = (0.5, 0.2);

/// How an error of a pose changes when the robot has come a way from there, in the axes of the way: a
/// wrong yaw swings its end around its beginning.
pub(crate) fn swing(came: &Vector2<f64>) -> Matrix3<f64> {
    let mut step = Matrix3::identity();
    step[(0, 2)] = -came.y;
    step[(1, 2)] = came.x;
    step
}

/// Turns the axes of an error of a pose.
pub(crate) fn turned(yaw_rad: f64) -> Matrix3<f64> {
    Rotation2::new(yaw_rad).to_homogeneous()
}

/// Keeps a covariance between the floor and standard deviations of `most`. [m, rad]
pub(crate) fn limit(covariance: &mut Matrix3<f64>, most: (f64, f64)) {
    for (axis, (low, high)) in [(FLOOR.0, most.0), (FLOOR.0, most.0), (FLOOR.1, most.1)]
        .into_iter()
        .enumerate()
    {
        let variance = covariance[(axis, axis)];
        if variance < low * low {
            covariance[(axis, axis)] = low * low;
        } else if variance > high * high {
            let shrink = high / variance.sqrt();
            for other in 0..3 {
                covariance[(axis, other)] *= shrink;
                covariance[(other, axis)] *= shrink;
            }
        }
    }
}
