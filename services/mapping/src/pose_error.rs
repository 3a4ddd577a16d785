//! How an error of a pose, (x, y, yaw), carries over from one pose to another.

use nalgebra::{Matrix3, Rotation2, Vector2};

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
