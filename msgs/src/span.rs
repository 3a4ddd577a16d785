//! `run/spans`: one record per cycle and process, enough to explain every latency afterwards.

use crate::message::{Refusal, ZeroCopySend, ensure};
use crate::role::Role;
use crate::stages::{STAGES_MAX, Stage};
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
    pub struct Span = "zeronav.Span.v3" {
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
        /// [ns] Times of the stages of the role ([`Stage::of`]), one after the other from `started_ns`
        /// on and by the same clock; what is left until `published_ns` belongs to none. 0 = did not
        /// run, or was not timed (`stages` of `run/clock`).
        pub stages_ns: [u32; STAGES_MAX],
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

    /// The stages that ran: each with when it began and ended, by the clock of `started_ns`. [ns]
    pub fn stages(&self) -> impl Iterator<Item = (Stage, u64, u64)> + use<> {
        let stages = self.role().map_or(&[][..], Stage::of);
        let mut end_ns = self.started_ns;
        let timed = stages
            .iter()
            .zip(self.stages_ns)
            .map(move |(stage, time_ns)| {
                let began_ns = end_ns;
                end_ns = end_ns.saturating_add(u64::from(time_ns));
                (*stage, began_ns, end_ns)
            });
        timed.filter(|(_, began_ns, end_ns)| began_ns < end_ns)
    }

    /// Accepts records of known roles and kinds with an epoch, and stages that end before the main
    /// message was sent.
    ///
    /// # Errors
    /// The first field that is wrong.
    pub fn check(&self) -> Result<(), Refusal> {
        self.role().ok_or(Refusal::Code("role"))?;
        self.kind().ok_or(Refusal::Code("kind"))?;
        ensure(self.epoch > 0, Refusal::Identity)?;
        let timed_ns: u64 = self.stages_ns.iter().map(|ns| u64::from(*ns)).sum();
        let until_ns = self.started_ns.saturating_add(timed_ns);
        ensure(
            self.output == 0 || timed_ns == 0 || until_ns <= self.published_ns,
            Refusal::OutOfRange("stages_ns"),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn span(role: Role, stages_ns: [u32; STAGES_MAX]) -> Span {
        Span {
            role: role.code(),
            kind: SpanKind::Answer.code(),
            epoch: 1,
            output: 1,
            started_ns: 1000,
            published_ns: 1100,
            stages_ns,
            ..Span::default()
        }
    }

    #[test]
    fn stages_follow_each_other_from_the_start() {
        let stages = |role, stages_ns| span(role, stages_ns).stages().collect::<Vec<_>>();
        assert_eq!(
            stages(Role::GlobalPlanner, [10, 50, 0, 5]),
            [
                (Stage::Map, 1000, 1010),
                (Stage::Search, 1010, 1060),
                (Stage::Settle, 1060, 1065)
            ]
        );
        assert_eq!(stages(Role::Mapping, [0; STAGES_MAX]), []);
        assert_eq!(stages(Role::CollisionGuard, [1; STAGES_MAX]), []);
        let last = Span {
            started_ns: u64::MAX,
            ..span(Role::Robot, [7; STAGES_MAX])
        };
        assert_eq!(last.stages().count(), 0, "no overflow");
    }

    #[test]
    fn records_without_a_known_author_are_refused() {
        let right = span(Role::Mapping, [0; STAGES_MAX]);
        assert_eq!(right.check(), Ok(()));
        for (wrong, refusal) in [
            (Span { role: 99, ..right }, Refusal::Code("role")),
            (Span { kind: 99, ..right }, Refusal::Code("kind")),
            (Span { epoch: 0, ..right }, Refusal::Identity),
        ] {
            assert_eq!(wrong.check(), Err(refusal));
        }
    }

    #[test]
    fn stages_beyond_the_message_are_refused() {
        let refused = Err(Refusal::OutOfRange("stages_ns"));
        assert_eq!(span(Role::Mapping, [40, 0, 60, 0]).check(), Ok(()));
        assert_eq!(span(Role::Mapping, [40, 0, 60, 1]).check(), refused);
        assert_eq!(span(Role::Mapping, [u32::MAX; STAGES_MAX]).check(), refused);
        let without_output = Span {
            output: 0,
            published_ns: 0,
            ..span(Role::GlobalPlanner, [40, 0, 60, 1])
        };
        assert_eq!(without_output.check(), Ok(()));
        let untimed = Span {
            published_ns: 900,
            ..span(Role::Mapping, [0; STAGES_MAX])
        };
        assert_eq!(untimed.check(), Ok(()), "the clock was put back meanwhile");
    }
}
