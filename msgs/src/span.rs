//! `run/spans`: one record per cycle and process, enough to explain every latency afterwards.

use crate::message::{Refusal, ZeroCopySend, ensure};
use crate::role::Role;
use crate::{codes, message};

codes! {
    /// What a cycle was.
    pub enum SpanKind: u16 {
        /// The idle output that says the process is ready.
        Idle = 1 => "idle",
        /// The answer to a tick.
        Answer = 2 => "answer",
        /// A further answer to a tick that was answered before; real time only.
        Extra = 3 => "extra",
        /// Robot only: a velocity command reached the wheels; `started_ns` is that moment.
        Applied = 4 => "applied",
    }
}

message! {
    /// A self-contained record of one cycle. Sent without a header.
    pub struct Span = "zeronav.Span.v2" {
        /// Code of the [`Role`].
        pub role: u16,
        /// Code of [`SpanKind`].
        pub kind: u16,
        /// [number] Epoch of the process.
        pub epoch: u32,
        /// [tick] Tick that was answered.
        pub tick: u64,
        /// [id] Inputs: id on `robot/odometry`, or the robot's own tick.
        pub odometry: u64,
        /// [id] Inputs: id on `robot/scan`; from the robot: the scan it published.
        pub scan: u64,
        /// [id] Inputs: revision of the map.
        pub map: u64,
        /// [id] Inputs: id on `plan/path`.
        pub path: u64,
        /// [id] Inputs: id of the request, or of the velocity command that the robot applied.
        pub request: u64,
        /// [id] Inputs: id on `task/goal`.
        pub goal: u64,
        /// [id] Id of the main message that was published; 0 = none.
        pub output: u64,
        /// [ns] Moment of the data that came in: the scan's capture; for the robot its own.
        pub capture_ns: u64,
        /// [ns] return from the wait.
        pub woken_ns: u64,
        /// [ns] inputs taken in.
        pub started_ns: u64,
        /// [ns] main message sent.
        pub published_ns: u64,
        /// [count] Inputs that a newer one had overtaken, in this cycle.
        pub superseded: u32,
        /// [count] Work done in units of the role: beams, expansions, rollouts.
        pub work: u32,
        /// [number] FNV-1a of what the cycle published (headers without stamps, and payload);
        /// lockstep only.
        pub hash: u64,
        /// [ns] between the wake and the end of the cycle in which the thread did not run: it was
        /// preempted, waited for a page, or slept for a delay put in on purpose.
        pub off_processor_ns: u64,
        /// Robot only, real time: `CLOCK_MONOTONIC_RAW` at `capture_ns`, of a command that was applied
        /// at `started_ns`; 0 = none. [ns]
        pub raw_ns: u64,
    }
}

impl Span {
    /// The role.
    #[must_use]
    pub const fn role(&self) -> Option<Role> {
        Role::from_code(self.role)
    }

    /// The kind.
    #[must_use]
    pub const fn kind(&self) -> Option<SpanKind> {
        SpanKind::from_code(self.kind)
    }

    /// Accepts records of known roles and kinds with an epoch.
    ///
    /// # Errors
    /// The first field that is wrong.
    pub fn check(&self) -> Result<(), Refusal> {
        self.role().ok_or(Refusal::Code("role"))?;
        self.kind().ok_or(Refusal::Code("kind"))?;
        ensure(self.epoch > 0, Refusal::Identity)
    }
}
