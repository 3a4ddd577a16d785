//! What a swap works on.

use crate::collect::Collector;
use zeronav_msgs::time::nanoseconds;
use zeronav_supervise::hang::Limit;
use zeronav_supervise::stack::Stack;

/// What a swap works on.
#[derive(Debug)]
pub(crate) struct Scene<'a> {
    /// The processes.
    pub stack: &'a mut Stack,
    /// What was heard of them.
    pub collector: &'a mut Collector,
    /// True in lockstep.
    pub lockstep: bool,
    /// From tick to tick. [ns]
    pub tick_ns: u64,
    /// When a process counts as hung.
    pub hang: Limit,
    /// True while the seat has no process that answers.
    pub is_vacant: bool,
}

impl Scene<'_> {
    /// True when every role has answered every tick up to `tick`.
    pub(super) fn all_answered(&self, tick: u64) -> bool {
        self.collector.all_answered(tick, &self.stack.roster)
    }

    /// A time in ticks.
    pub(super) fn ticks(&self, time_s: f64) -> u64 {
        nanoseconds(time_s).div_ceil(self.tick_ns.max(1))
    }
}
