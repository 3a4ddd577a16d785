//! `health/<role>`: the one heartbeat.

use crate::message::{Refusal, ZeroCopySend};
use crate::{codes, message};

codes! {
    /// How a process is.
    pub enum HealthState: u16 {
        /// Opening its ports or reading its first inputs.
        Starting = 0 => "starting",
        /// Able to answer.
        Ready = 1 => "ready",
        /// Working with less than it should have, see the reasons.
        Degraded = 2 => "degraded",
        /// Going away because it was asked to.
        Stopping = 3 => "stopping",
    }
}

/// Age of the newest heartbeat from which on a service is silent. [ns] Hearts beat every 100 ms and more often.
pub const SILENT_AFTER_NS: u64 = 500_000_000;

/// Reason bit: the scan is too old or missing.
pub const REASON_SCAN: u32 = 1;
/// Reason bit: odometry is too old or missing.
pub const REASON_ODOMETRY: u32 = 1 << 1;
/// Reason bit: the map is too old, missing or out of step.
pub const REASON_MAP: u32 = 1 << 2;
/// Reason bit: the path is too old or missing.
pub const REASON_PATH: u32 = 1 << 3;
/// Reason bit: the velocity request is too old or missing.
pub const REASON_REQUEST: u32 = 1 << 4;
/// Reason bit: messages were refused since the last beat.
pub const REASON_REFUSED: u32 = 1 << 5;
/// Reason bit: an output could not be sent for lack of memory.
pub const REASON_NO_LOAN: u32 = 1 << 6;
/// Reason bit: an output was longer than its writer was opened for and was dropped, since the
/// start.
pub const REASON_TOO_LONG: u32 = 1 << 7;
/// Reason bit: no transforms say where the robot's lidar is.
pub const REASON_TRANSFORM: u32 = 1 << 8;
/// Reason bit: the robot's own clock was set, or stands still.
pub const REASON_CLOCK: u32 = 1 << 9;
/// Reason bit: two nodes publish what the robot measures.
pub const REASON_PUBLISHERS: u32 = 1 << 10;
/// Reason bit: the way to the other host, on which the process runs, is cut.
pub const REASON_LINK: u32 = 1 << 11;
/// Reason bit: the zones that hold have not come.
pub const REASON_ZONES: u32 = 1 << 12;

/// The reason bits and a word for each.
pub const REASONS: [(u32, &str); 13] = [
    (REASON_SCAN, "scan"),
    (REASON_ODOMETRY, "odometry"),
    (REASON_MAP, "map"),
    (REASON_PATH, "path"),
    (REASON_REQUEST, "request"),
    (REASON_REFUSED, "rejected"),
    (REASON_NO_LOAN, "no_memory"),
    (REASON_TOO_LONG, "too_long"),
    (REASON_TRANSFORM, "transform"),
    (REASON_CLOCK, "clock"),
    (REASON_PUBLISHERS, "publishers"),
    (REASON_LINK, "link"),
    (REASON_ZONES, "zones"),
];

/// The words for a sum of reason bits; unknown bits have none.
#[must_use]
pub fn reason_labels(reasons: u32) -> Vec<&'static str> {
    let set = REASONS.iter().filter(|(bit, _)| reasons & bit != 0);
    set.map(|(_, label)| *label).collect()
}

message! {
    /// Fixed fields of the heartbeat; the slice is empty.
    pub struct Health = "zeronav.Health.v1" {
        /// [count] Grows with every wake (at least every 50 ms, also when idle) and with long work.
        pub progress: u64,
        /// Code of [`HealthState`].
        pub state: u16,
        /// Written as 0.
        pub spare: u16,
        /// [bits] Sum of the reason bits.
        pub reasons: u32,
        /// [number] Process id.
        pub pid: u32,
        /// Written as 0.
        pub spare2: u32,
        /// [count] Messages refused since the start.
        pub refused: u64,
        /// [count] Inputs overtaken by newer ones since the start.
        pub superseded: u64,
        /// Run time lost because the process was late, robot only. [ns]
        pub slipped_ns: u64,
    }
}

impl Health {
    /// The state.
    #[must_use]
    pub const fn state(&self) -> Option<HealthState> {
        HealthState::from_code(self.state)
    }

    /// Accepts known states.
    ///
    /// # Errors
    /// [`Refusal::Code`] for an unknown state.
    pub fn check(&self) -> Result<(), Refusal> {
        self.state().map(|_| ()).ok_or(Refusal::Code("state"))
    }
}
