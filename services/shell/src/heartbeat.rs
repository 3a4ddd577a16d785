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
