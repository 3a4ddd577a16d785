//! `robot/description`: the only home of the robot's numbers.

use crate::message;
use crate::message::{Refusal, SPEED_MAX, ZeroCopySend, ensure, number};
use crate::pose::Pose;
use crate::scan::BEAMS_MAX;

/// Most corners of a footprint.
pub const FOOTPRINT_CORNERS_MAX: usize = 32;

/// Longest time that a command takes to take effect. [ns]
pub const ACTUATION_DELAY_NS_MAX: u64 = 2_000_000_000;

message! {
    /// A corner of the footprint.
    pub struct Corner = "zeronav.Corner.v1" {
        /// [m] in `base`.
        pub x_m: f64,
        /// [m] in `base`.
        pub y_m: f64,
    }
}

message! {
    /// What the robot is. The slice holds the corners of a convex footprint, counter-clockwise in
    /// `base`; an empty slice is a disc of `circumscribed_radius_m`.
    pub struct Description = "zeronav.Description.v2" {
        /// [m] largest disc around the origin of `base` inside the footprint, > 0.
        pub inscribed_radius_m: f64,
        /// [m] smallest disc around the origin of `base` that holds the footprint.
        pub circumscribed_radius_m: f64,
        /// [m/s] fastest forward speed, > 0.
        pub v_mps_max: f64,
        /// [m/s] fastest backward speed as a number <= 0; 0 = never backwards.
        pub v_mps_min: f64,
        /// [rad/s] fastest yaw rate either way, > 0.
        pub w_radps_max: f64,
        /// [m/s^2] largest acceleration, > 0.
        pub a_mps2_max: f64,
        /// [m/s^2] deceleration that braking can rely on, > 0.
        pub brake_mps2: f64,
        /// [rad/s^2] largest yaw acceleration, > 0.
        pub alpha_radps2_max: f64,
        /// `base_from_laser`.
        pub base_from_laser: Pose,
        /// [rad] direction of beam 0 in `laser`.
        pub angle_min_rad: f64,
        /// [rad] step from beam to beam.
        pub angle_increment_rad: f64,
        /// [m] closest valid range.
        pub range_m_min: f64,
        /// [m] farthest valid range.
        pub range_m_max: f64,
        /// [ns] from scan to scan.
        pub scan_period_ns: u64,
        /// [ns] from a command's arrival to its taking effect; until then the commands before it are
        /// obeyed.
        pub actuation_delay_ns: u64,
        /// [count] Beams of a scan.
        pub n_beams: u32,
        /// [count] Corners in the slice, 0 = disc.
        pub n_corners: u32,
    }
}

impl Description {
    /// Distance the robot needs to stop from `v_mps`. [m]
    #[must_use]
    pub fn braking_distance_m(&self, v_mps: f64) -> f64 {
        v_mps * v_mps / (2.0 * self.brake_mps2)
    }

    /// Accepts descriptions of a robot that can exist.
    ///
    /// # Errors
    /// The first field that is wrong.
    pub fn check(&self, corners: &[Corner]) -> Result<(), Refusal> {
        ensure(
            corners.len() == self.n_corners as usize
                && corners.len() <= FOOTPRINT_CORNERS_MAX
                && (corners.is_empty() || corners.len() >= 3),
            Refusal::Length("corners"),
        )?;
        for corner in corners {
            number(corner.x_m, -100.0, 100.0, "corner")?;
            number(corner.y_m, -100.0, 100.0, "corner")?;
        }
        let positive = f64::MIN_POSITIVE;
        number(self.inscribed_radius_m, 1.0e-3, 100.0, "inscribed_radius_m")?;
        number(
            self.circumscribed_radius_m,
            self.inscribed_radius_m,
            150.0,
            "circumscribed_radius_m",
        )?;
        number(self.v_mps_max, positive, SPEED_MAX, "v_mps_max")?;
        number(self.v_mps_min, -SPEED_MAX, 0.0, "v_mps_min")?;
        number(self.w_radps_max, positive, SPEED_MAX, "w_radps_max")?;
        number(self.a_mps2_max, positive, SPEED_MAX, "a_mps2_max")?;
        number(self.brake_mps2, positive, SPEED_MAX, "brake_mps2")?;
        number(
            self.alpha_radps2_max,
            positive,
            SPEED_MAX,
            "alpha_radps2_max",
        )?;
        self.base_from_laser.check("base_from_laser")?;
        number(self.angle_min_rad, -12.6, 12.6, "angle_min_rad")?;
        number(self.angle_increment_rad, -1.6, 1.6, "angle_increment_rad")?;
        number(self.range_m_min, 0.0, 1.0e3, "range_m_min")?;
        number(self.range_m_max, self.range_m_min, 1.0e3, "range_m_max")?;
        ensure(
            self.scan_period_ns > 0,
            Refusal::OutOfRange("scan_period_ns"),
        )?;
        ensure(
            self.actuation_delay_ns <= ACTUATION_DELAY_NS_MAX,
            Refusal::OutOfRange("actuation_delay_ns"),
        )?;
        ensure(
            (1..=BEAMS_MAX).contains(&(self.n_beams as usize)),
            Refusal::OutOfRange("n_beams"),
        )
    }
}
