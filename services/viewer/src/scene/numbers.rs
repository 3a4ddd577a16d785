//! Numbers as they are written.

use serde::{Serialize, Serializer};
use zeronav_casts::Cast;
use zeronav_msgs::Pose;

/// A number of a fixed number of decimals.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Rounded(f64);

impl Rounded {
    /// A length [m] to the millimetre, a time [s] to the millisecond, a speed to 1 mm/s.
    #[must_use]
    pub fn thousandths(value: f64) -> Self {
        Self((value * 1.0e3).round() / 1.0e3)
    }

    /// An angle [rad] to 0.1 mrad.
    #[must_use]
    pub fn angle(value_rad: f64) -> Self {
        Self((value_rad * 1.0e4).round() / 1.0e4)
    }
}

impl Serialize for Rounded {
    /// Whole numbers without a point; 0 for what is not finite, which JSON does not have.
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        let value = if self.0.is_finite() { self.0 } else { 0.0 };
        if value.fract() == 0.0 && value.abs() < 9.0e15 {
            to.serialize_i64(value.to_i64())
        } else {
            to.serialize_f64(value)
        }
    }
}

/// `[x, y, yaw]`.
#[must_use]
pub fn pose(pose: &Pose) -> [Rounded; 3] {
    [
        Rounded::thousandths(pose.x_m),
        Rounded::thousandths(pose.y_m),
        Rounded::angle(pose.yaw_rad),
    ]
}

/// `[x, y]`.
#[must_use]
pub fn point(x_m: f64, y_m: f64) -> [Rounded; 2] {
    [Rounded::thousandths(x_m), Rounded::thousandths(y_m)]
}
