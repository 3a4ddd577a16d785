//! The heartbeat of a service: its state, why it is degraded, and what it has counted.

use crate::error::StartError;
use crate::peer::Peer;
use crate::writer::{Draft, Writer};
use zeronav_msgs::health::{Health, HealthState, REASON_NO_LOAN, REASON_REFUSED};
use zeronav_msgs::topics::{HealthTopic, health_of};

/// Time between two heartbeats when nothing changes. [ns]
const BEAT_NS: u64 = 20_000_000;

/// Writes `health/<role>`.
#[derive(Debug)]
pub(crate) struct Heartbeat {
    writer: Writer<HealthTopic>,
    /// What the next beat says, and what the last one said.
    next: Health,
    last: Health,
    last_ns: u64,
    /// [`Health::superseded`] of the last span.
    superseded_in_spans: u64,
}

impl Heartbeat {
    pub(crate) fn open(peer: &Peer) -> Result<Self, StartError> {
        let role = peer.role();
        let row = health_of(role)
            .ok_or_else(|| StartError::Usage(format!("{role} is not the role of a service")))?;
        Ok(Self {
            writer: peer.writer_on(row, 1)?,
            next: Health {
                pid: std::process::id(),
                ..Health::default()
            },
            last: Health::default(),
            last_ns: 0,
            superseded_in_spans: 0,
        })
    }

    pub(crate) fn reason(&mut self, bit: u32, holds: bool) {
        if holds {
            self.next.reasons |= bit;
        } else {
            self.next.reasons &= !bit;
        }
    }

    pub(crate) fn totals(&mut self, rejected: u64, superseded: u64) {
        self.reason(REASON_REFUSED, rejected > self.last.refused);
        self.next.refused = rejected;
        self.next.superseded = self.next.superseded.max(superseded);
    }

    /// Inputs that were superseded since this was last asked.
    pub(crate) fn take_superseded(&mut self) -> u64 {
        let since = self.next.superseded - self.superseded_in_spans;
        self.superseded_in_spans = self.next.superseded;
        since
    }

    pub(crate) fn slipped(&mut self, slipped_ns: u64) {
        self.next.slipped_ns = slipped_ns;
    }

    pub(crate) fn progress(&mut self) {
        self.next.progress += 1;
    }

    pub(crate) fn ready(&mut self) {
        if self.next.state == HealthState::Starting.code() {
            self.next.state = HealthState::Ready.code();
        }
    }

    pub(crate) fn stopping(&mut self) {
        self.next.state = HealthState::Stopping.code();
    }

    /// Publishes at once when state or reasons changed, and otherwise every [`BEAT_NS`].
    pub(crate) fn publish(&mut self, woken_ns: u64, now_ns: u64) {
        let mut beat = self.next;
        if beat.state == HealthState::Ready.code() && beat.reasons != 0 {
            beat.state = HealthState::Degraded.code();
        }
        let changed = beat.state != self.last.state || beat.reasons != self.last.reasons;
        // A clock that is put back must not silence it.
        if !changed && now_ns.abs_diff(self.last_ns) < BEAT_NS {
            return;
        }
        let draft = Draft {
            woken_ns,
            started_ns: now_ns,
            ..Draft::default()
        };
        if self.writer.publish(&draft, beat, &[]).is_some() {
            self.last = beat;
            self.last_ns = now_ns;
            self.next.reasons &= !REASON_NO_LOAN;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::{Beats, Stage, Words};
    use zeronav_msgs::health::{REASON_MAP, REASON_SCAN};
    use zeronav_msgs::role::Role;
    use zeronav_msgs::run::RunMode;

    /// A moment at which the first beat is due. [ns]
    const START_NS: u64 = 1_000_000_000;

    /// The heartbeat of mapping, and who listens to it.
    struct Bench {
        heart: Heartbeat,
        beats: Beats,
        _mapping: Peer,
        _stage: Stage,
    }

    impl Bench {
        fn new() -> Self {
            let stage = Stage::new(Words::of(RunMode::RealTime, &[(Role::Mapping, 1)]));
            let beats = Beats::of(&stage, Role::Mapping);
            let mapping = stage.join(Role::Mapping, 1);
            Self {
                heart: Heartbeat::open(&mapping).expect("a heartbeat"),
                beats,
                _mapping: mapping,
                _stage: stage,
            }
        }

        /// What a beat at this moment says, if there is one. [ns]
        fn at(&mut self, now_ns: u64) -> Option<Health> {
            self.heart.publish(now_ns - 7, now_ns);
            let beats = self.beats.take();
            assert!(beats.len() <= 1, "{beats:?}");
            beats.first().map(|beat| beat.health)
        }

        /// What a beat says that is due.
        fn due(&mut self) -> Health {
            let now_ns = self.heart.last_ns + START_NS;
            self.at(now_ns).expect("a beat")
        }

        /// State and reasons of a beat that is due.
        fn how(&mut self) -> (Option<HealthState>, u32) {
            let health = self.due();
            (health.state(), health.reasons)
        }
    }

    #[test]
    fn a_beat_names_its_process_and_the_moments_of_its_cycle() {
        let mut bench = Bench::new();
        bench.heart.publish(START_NS - 7, START_NS);
        let beats = bench.beats.take();
        assert_eq!(beats.len(), 1);
        assert_eq!(beats[0].health.pid, std::process::id());
        let moments = (beats[0].woken_ns, beats[0].started_ns);
        assert_eq!(moments, (START_NS - 7, START_NS));
    }

    #[test]
    fn without_a_change_a_beat_comes_every_period() {
        let mut bench = Bench::new();
        assert!(bench.at(START_NS).is_some());
        assert!(bench.at(START_NS + 1).is_none());
        assert!(bench.at(START_NS + BEAT_NS - 1).is_none());
        assert!(bench.at(START_NS + BEAT_NS).is_some());
        assert!(bench.at(START_NS + BEAT_NS + 1).is_none(), "a new period");
    }

    #[test]
    fn a_change_of_state_or_reasons_is_told_at_once() {
        let mut bench = Bench::new();
        assert!(bench.at(START_NS).is_some());
        bench.heart.ready();
        let ready = bench.at(START_NS + 1).expect("a change of state");
        assert_eq!(ready.state(), Some(HealthState::Ready));
        bench.heart.stopping();
        bench.heart.reason(REASON_MAP, true);
        assert!(bench.at(START_NS + 2).is_some());
        bench.heart.reason(REASON_SCAN, true);
        let reasons = bench.at(START_NS + 3).expect("a change of reasons alone");
        assert_eq!(reasons.reasons, REASON_MAP | REASON_SCAN);
        bench.heart.progress();
        assert!(bench.at(START_NS + 4).is_none(), "a count is no change");
    }

    #[test]
    fn a_clock_that_is_put_back_does_not_silence_it() {
        let mut bench = Bench::new();
        assert!(bench.at(START_NS).is_some());
        assert!(bench.at(START_NS - BEAT_NS + 1).is_none());
        assert!(bench.at(START_NS - BEAT_NS).is_some());
    }

    #[test]
    fn a_process_with_a_reason_is_degraded_when_it_would_be_ready() {
        let mut bench = Bench::new();
        assert_eq!(bench.how(), (Some(HealthState::Starting), 0));
        bench.heart.reason(REASON_MAP, true);
        assert_eq!(bench.how(), (Some(HealthState::Starting), REASON_MAP));
        bench.heart.ready();
        assert_eq!(bench.how(), (Some(HealthState::Degraded), REASON_MAP));
        bench.heart.reason(REASON_SCAN, true);
        bench.heart.reason(REASON_MAP, false);
        assert_eq!(bench.how(), (Some(HealthState::Degraded), REASON_SCAN));
        bench.heart.reason(REASON_SCAN, false);
        assert_eq!(bench.how(), (Some(HealthState::Ready), 0));
    }

    #[test]
    fn a_process_that_stops_is_not_ready_again() {
        let mut bench = Bench::new();
        bench.heart.stopping();
        bench.heart.ready();
        assert_eq!(bench.how().0, Some(HealthState::Stopping));
    }

    #[test]
    fn messages_that_were_rejected_since_the_last_beat_are_a_reason() {
        let mut bench = Bench::new();
        let mut after = |rejected| {
            bench.heart.totals(rejected, 0);
            let health = bench.due();
            (health.refused, health.reasons)
        };
        assert_eq!(after(0), (0, 0));
        assert_eq!(after(3), (3, REASON_REFUSED));
        assert_eq!(after(3), (3, 0));
        assert_eq!(after(4), (4, REASON_REFUSED));
    }

    #[test]
    fn superseded_inputs_are_handed_out_once_and_their_sum_is_told() {
        let mut bench = Bench::new();
        assert_eq!(bench.heart.take_superseded(), 0);
        bench.heart.totals(0, 2);
        assert_eq!(bench.heart.take_superseded(), 2);
        bench.heart.totals(0, 6);
        // An input that was closed takes its count with it.
        bench.heart.totals(0, 5);
        assert_eq!(bench.heart.take_superseded(), 4);
        assert_eq!(bench.heart.take_superseded(), 0);
        assert_eq!(bench.due().superseded, 6);
    }

    #[test]
    fn progress_and_lost_run_time_are_told() {
        let mut bench = Bench::new();
        assert_eq!(bench.due().progress, 0);
        bench.heart.progress();
        bench.heart.progress();
        bench.heart.slipped(12);
        let health = bench.due();
        assert_eq!((health.progress, health.slipped_ns), (2, 12));
    }

    #[test]
    fn a_lack_of_memory_is_told_in_one_beat_and_other_reasons_stay() {
        let mut bench = Bench::new();
        bench.heart.reason(REASON_MAP | REASON_NO_LOAN, true);
        assert_eq!(bench.how().1, REASON_MAP | REASON_NO_LOAN);
        assert_eq!(bench.how().1, REASON_MAP);
        assert_eq!(bench.how().1, REASON_MAP);
    }

    #[test]
    fn only_services_have_a_heartbeat() {
        let stage = Stage::new(Words::of(RunMode::RealTime, &[(Role::Mapping, 1)]));
        let tap = stage.join(Role::Tap, 1);
        let error = Heartbeat::open(&tap).expect_err("a tap is no service");
        assert!(matches!(error, StartError::Usage(_)), "{error}");
    }
}
