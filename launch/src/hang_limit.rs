//! When the process in a seat counts as hung.

use crate::prepare::Prepared;
use zeronav_msgs::role::Role;
use zeronav_msgs::run::RunMode;
use zeronav_supervise::hang::Limit;

/// How many times as long as on this host a process on the other one may stand still: whether it waits for a
/// processor there is not seen from here.
const TIMES_AS_LONG: u32 = 4;

impl Prepared {
    /// True for a seat whose process this computer sees, or in real time hears: in lockstep no clock decides that one on
    /// the other host hangs.
    pub(crate) fn judges_hangs(&self, role: Role) -> bool {
        self.mode == RunMode::RealTime || !self.remote.contains(&role)
    }

    /// When the process in the seat of `role` is hung.
    pub(crate) fn hang_limit(&self, role: Role) -> Limit {
        let after = self.scenario.restart.hang_after();
        let times = if self.remote.contains(&role) {
            TIMES_AS_LONG
        } else {
            1
        };
        Limit {
            after: after * times,
            lockstep: self.mode == RunMode::Lockstep,
        }
    }
}
