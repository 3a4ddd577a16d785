//! `[services.X.scheduling]` of a scenario: how the kernel is asked to schedule a service.

use zeronav_params::{choices, parameters};

choices! {
    /// A scheduling policy of Linux, see `sched(7)`.
    pub enum Policy {
        /// Shares the processors by the nice value.
        #[default]
        Other = "other",
        /// As `other`, but never takes a processor from a running process when it wakes.
        Batch = "batch",
        /// Runs where nothing else wants to.
        Idle = "idle",
        /// Real time: runs until it waits or a higher priority wants to.
        Fifo = "fifo",
        /// Real time: as `fifo`, in turn with others of its priority.
        RoundRobin = "rr",
    }
}

parameters! {
    /// `[services.X.scheduling]` of a scenario: for every process in the seat.
    pub struct SchedulingSpec {
        /// Policy.
        policy: Policy = Policy::Other;
        /// Priority of `fifo` and `rr`, 1 to 99.
        priority: i32 = 0, [0, 99];
        /// Nice value of `other` and `batch`.
        nice: i32 = 0, [-20, 19];
        /// Processors that it may use; empty for all.
        cpus: Vec<usize> = Vec::new(), [0, 1023];
        /// Keeps its memory from being paged out.
        lock_memory: bool = false;
    }
    relations |own| {
        priority: own.policy.is_real_time() == (own.priority > 0),
            "must be 1 to 99 with the policies fifo and rr, and 0 with any other";
        nice: own.nice == 0 || matches!(own.policy, Policy::Other | Policy::Batch),
            "must be 0 but with the policies other and batch";
    }
}

impl Policy {
    /// True for the policies with a priority.
    #[must_use]
    pub const fn is_real_time(self) -> bool {
        matches!(self, Self::Fifo | Self::RoundRobin)
    }
}
