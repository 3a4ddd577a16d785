//! A pose in the plane.

use crate::message;
use crate::message::{COORDINATE_M_MAX, Refusal, ZeroCopySend, number};
use nalgebra::{Isometry2, Point2, Vector2};

message! {
    /// Position and yaw of one frame in another.
    pub struct Pose = "zeronav.Pose.v1" {
        /// [m]
        pub x_m: f64,
        /// [m]
        pub y_m: f64,
        /// [rad] counter-clockwise from +x.
        pub yaw_rad: f64,
    }
}

impl Pose {
    /// A pose from its three numbers.
    #[must_use]
    pub const fn new(x_m: f64, y_m: f64, yaw_rad: f64) -> Self {
        Self { x_m, y_m, yaw_rad }
    }

    /// The position alone.
    #[must_use]
    pub fn point(&self) -> Point2<f64> {
        Point2::new(self.x_m, self.y_m)
    }

    /// The rigid motion that takes points of this pose's frame into its parent.
    #[must_use]
    pub fn isometry(&self) -> Isometry2<f64> {
        Isometry2::new(Vector2::new(self.x_m, self.y_m), self.yaw_rad)
    }

    /// `map_from_odom.then(&odom_from_base)` is `map_from_base`.
    #[must_use]
    pub fn then(&self, next: &Self) -> Self {
        Self::from(self.isometry() * next.isometry())
    }

    /// Where `point` of this pose's frame lies in its parent.
    #[must_use]
    pub fn transform(&self, point: Point2<f64>) -> Point2<f64> {
        let (sin, cos) = self.yaw_rad.sin_cos();
        Point2::new(
            self.x_m + cos * point.x - sin * point.y,
            self.y_m + sin * point.x + cos * point.y,
        )
    }

    /// Straight distance between two positions. [m]
    #[must_use]
    pub fn distance_m(&self, other: &Self) -> f64 {
        (self.point() - other.point()).norm()
    }

    /// Accepts finite poses inside the range of coordinates, yaw within ten turns.
    ///
    /// # Errors
    /// [`Refusal::NotFinite`] or [`Refusal::OutOfRange`], naming `field`.
    pub fn check(&self, field: &'static str) -> Result<(), Refusal> {
        number(self.x_m, -COORDINATE_M_MAX, COORDINATE_M_MAX, field)?;
        number(self.y_m, -COORDINATE_M_MAX, COORDINATE_M_MAX, field)?;
        number(self.yaw_rad, -62.9, 62.9, field)
    }
}

impl From<Isometry2<f64>> for Pose {
    fn from(isometry: Isometry2<f64>) -> Self {
        Self::new(
            isometry.translation.x,
            isometry.translation.y,
            isometry.rotation.angle(),
        )
    }
}

/// `angle_rad` wrapped to (-pi, pi].
#[must_use]
pub fn wrap_angle(angle_rad: f64) -> f64 {
    use core::f64::consts::{PI, TAU};
    let wrapped = angle_rad - TAU * (angle_rad / TAU).round();
    if wrapped <= -PI {
        wrapped + TAU
    } else {
        wrapped
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f64::consts::{FRAC_PI_2, PI};

    #[test]
    fn composition_follows_the_frames() {
        let map_from_odom = Pose::new(1.0, 2.0, FRAC_PI_2);
        let odom_from_base = Pose::new(3.0, 0.0, 0.25);
        let map_from_base = map_from_odom.then(&odom_from_base);
        assert!((map_from_base.x_m - 1.0).abs() < 1e-12);
        assert!((map_from_base.y_m - 5.0).abs() < 1e-12);
        assert!((map_from_base.yaw_rad - (FRAC_PI_2 + 0.25)).abs() < 1e-12);
        let nose = map_from_base.transform(Point2::new(0.0, 0.0));
        assert!((nose - map_from_base.point()).norm() < 1e-12);
    }

    #[test]
    fn angles_wrap_into_the_half_open_turn() {
        assert!((wrap_angle(3.0 * PI) - PI).abs() < 1e-12);
        assert!((wrap_angle(-PI) - PI).abs() < 1e-12);
        assert!((wrap_angle(0.5) - 0.5).abs() < 1e-15);
        assert!((wrap_angle(-7.0) - (-7.0 + 2.0 * PI)).abs() < 1e-12);
    }
}
