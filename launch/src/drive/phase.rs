//! How far a drive is, and when it came there.

use crate::disturbance::Reading;
use std::time::Instant;
use zeronav_measure::start_up::StartStamps;

/// How far a drive is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Phase {
    /// Services start.
    Starting,
    /// Every service can answer.
    Ready,
    /// No request changes anything any more.
    Ending {
        /// Every service could answer once.
        was_ready: bool,
    },
}

impl Phase {
    /// True once every service could answer.
    pub(super) fn is_ready(self) -> bool {
        matches!(self, Self::Ready | Self::Ending { was_ready: true })
    }

    pub(super) fn is_ending(self) -> bool {
        matches!(self, Self::Ending { .. })
    }

    pub(super) fn end(&mut self) {
        let was_ready = self.is_ready();
        *self = Self::Ending { was_ready };
    }
}

/// The begin of a drive.
#[derive(Debug)]
pub(super) struct Begin {
    pub(super) at: Instant,
    /// Moments of the start.
    pub(super) stamps: StartStamps,
    /// Run time at which the first goals were sent. [ns]
    pub(super) goals_run_ns: u64,
    /// The kernel's counters then; in real time only.
    pub(super) reading: Option<Reading>,
}

impl Begin {
    /// Now.
    pub(super) fn now() -> Self {
        Self {
            at: Instant::now(),
            stamps: StartStamps::default(),
            goals_run_ns: 0,
            reading: None,
        }
    }
}
