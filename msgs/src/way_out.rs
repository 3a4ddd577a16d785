//! The way by which a robot that is in a keepout zone is let out.

use crate::message;
use crate::message::{COORDINATE_M_MAX, Refusal, ZeroCopySend, number};
use crate::zone_shape::distance_m;
use nalgebra::Point2;

message! {
    /// The straight way by which a robot that is in a keepout zone is let out.
    pub struct WayOut = "zeronav.WayOut.v1" {
        /// [m] map frame, where it begins.
        pub from_m: [f64; 2],
        /// [m] map frame, where it ends, outside of all keepout zones.
        pub until_m: [f64; 2],
        /// [m] to either side of the line between them; 0 = no way is open.
        pub radius_m: f64,
    }
}

impl WayOut {
    /// True when there is one.
    #[must_use]
    pub fn is_open(&self) -> bool {
        self.radius_m > 0.0
    }

    /// From a point in the map frame to the line. [m]
    #[must_use]
    pub fn distance_m(&self, at: Point2<f64>) -> f64 {
        distance_m(&[self.from_m, self.until_m].map(Point2::from), at)
    }

    /// From a point in the map frame to its end. [m]
    #[must_use]
    pub fn left_m(&self, at: Point2<f64>) -> f64 {
        (Point2::from(self.until_m) - at).norm()
    }

    /// Accepts numbers of a map.
    ///
    /// # Errors
    /// The first field that is wrong.
    pub fn check(&self) -> Result<(), Refusal> {
        for value in self.from_m.into_iter().chain(self.until_m) {
            number(value, -COORDINATE_M_MAX, COORDINATE_M_MAX, "way_out")?;
        }
        number(self.radius_m, 0.0, COORDINATE_M_MAX, "way_out.radius_m")
    }
}
