//! `control/velocity_request` and `robot/velocity_command`: what the wheels shall do.

use crate::message::{Refusal, SPEED_MAX, ZeroCopySend, number};
use crate::{codes, message};

codes! {
    /// What a velocity request or command means. Anything but `Drive` is a stop.
    pub enum Validity: u16 {
        /// Idle: there is no path to follow.
        NoPath = 0 => "no_path",
        /// Drive as asked.
        Drive = 1 => "drive",
        /// The goal is reached.
        AtGoal = 2 => "at_goal",
        /// No motion is admissible now.
        Blocked = 3 => "blocked",
        /// An input is too old or missing.
        Stale = 4 => "stale",
        /// Guard only: no request came yet.
        NoRequest = 5 => "no_request",
        /// The task was cancelled or the run is stopping.
        Stopped = 6 => "stopped",
    }
}

codes! {
    /// What the guard did to a request.
    pub enum Intervention: u16 {
        /// Passed on as it was.
        None = 0 => "none",
        /// Brought into the robot's limits.
        Clamped = 1 => "clamped",
        /// Refused: not a number.
        Refused = 2 => "refused",
        /// Slowed to a stop because the request is too old or missing.
        RequestStale = 3 => "request_stale",
        /// Slowed to a stop because the scan is too old or missing.
        ScanStale = 4 => "scan_stale",
        /// Slowed to a stop because odometry is too old or missing.
        OdometryStale = 5 => "odometry_stale",
        /// Slowed because something is in the way.
        Slowed = 6 => "slowed",
        /// Stopped because something is in the way.
        StoppedShort = 7 => "stopped_short",
    }
}

message! {
    /// Fixed fields of a velocity request; the slice is empty.
    pub struct VelocityRequest = "zeronav.VelocityRequest.v1" {
        /// [m/s] forward speed in `base`.
        pub v_mps: f64,
        /// [rad/s] yaw rate in `base`.
        pub w_radps: f64,
        /// Code of [`Validity`].
        pub validity: u16,
        /// Written as 0.
        pub spare: [u16; 3],
        /// [m] length of the arc on which the author can still stop, >= 0.
        pub braking_arc_m: f64,
    }
}

message! {
    /// Fixed fields of a velocity command; the slice is empty.
    pub struct VelocityCommand = "zeronav.VelocityCommand.v1" {
        /// [m/s] forward speed in `base`.
        pub v_mps: f64,
        /// [rad/s] yaw rate in `base`.
        pub w_radps: f64,
        /// Code of [`Validity`].
        pub validity: u16,
        /// Code of [`Intervention`].
        pub intervention: u16,
        /// Written as 0.
        pub spare: [u16; 2],
    }
}

impl VelocityRequest {
    /// The meaning.
    #[must_use]
    pub const fn validity(&self) -> Option<Validity> {
        Validity::from_code(self.validity)
    }

    /// Accepts finite requests with a known meaning.
    ///
    /// # Errors
    /// The first field that is wrong.
    pub fn check(&self) -> Result<(), Refusal> {
        self.validity().ok_or(Refusal::Code("validity"))?;
        number(self.v_mps, -SPEED_MAX, SPEED_MAX, "v_mps")?;
        number(self.w_radps, -SPEED_MAX, SPEED_MAX, "w_radps")?;
        number(self.braking_arc_m, 0.0, 1.0e6, "braking_arc_m")
    }
}

impl VelocityCommand {
    /// The meaning.
    #[must_use]
    pub const fn validity(&self) -> Option<Validity> {
        Validity::from_code(self.validity)
    }

    /// What the guard did.
    #[must_use]
    pub const fn intervention(&self) -> Option<Intervention> {
        Intervention::from_code(self.intervention)
    }

    /// Accepts finite commands with known codes.
    ///
    /// # Errors
    /// The first field that is wrong.
    pub fn check(&self) -> Result<(), Refusal> {
        self.validity().ok_or(Refusal::Code("validity"))?;
        self.intervention().ok_or(Refusal::Code("intervention"))?;
        number(self.v_mps, -SPEED_MAX, SPEED_MAX, "v_mps")?;
        number(self.w_radps, -SPEED_MAX, SPEED_MAX, "w_radps")
    }
}
