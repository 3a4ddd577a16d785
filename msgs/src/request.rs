//! `plan/request`: the local planner needs another path.

use crate::message::{Refusal, ZeroCopySend, number};
use crate::{codes, message};

codes! {
    /// Why the current path does not serve.
    pub enum RequestReason: u16 {
        /// Nothing is asked.
        None = 0 => "none",
        /// An obstacle is on the path.
        Blocked = 1 => "blocked",
        /// The robot is too far from the path.
        OffPath = 2 => "off_path",
        /// The robot has not come closer for too long.
        NoProgress = 3 => "no_progress",
    }
}

message! {
    /// Fixed fields of a request; the slice is empty.
    pub struct PlanRequest = "zeronav.PlanRequest.v1" {
        /// Code of [`RequestReason`].
        pub reason: u16,
        /// Written as 0.
        pub spare: [u16; 3],
        /// [m] along the path from the robot to what blocks it, >= 0.
        pub blocked_arc_m: f64,
    }
}

impl PlanRequest {
    /// The reason.
    #[must_use]
    pub const fn reason(&self) -> Option<RequestReason> {
        RequestReason::from_code(self.reason)
    }

    /// Accepts known reasons.
    ///
    /// # Errors
    /// The first field that is wrong.
    pub fn check(&self) -> Result<(), Refusal> {
        self.reason().ok_or(Refusal::Code("reason"))?;
        number(self.blocked_arc_m, 0.0, 1.0e6, "blocked_arc_m")
    }
}
