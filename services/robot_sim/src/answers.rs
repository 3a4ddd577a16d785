//! Which ticks the other seats have answered: in lockstep the robot waits for all of them.

use zeronav_msgs::role::Role;
use zeronav_msgs::seats::{Answers, SEATS};
use zeronav_msgs::span::SpanKind;
use zeronav_shell::records::SpanReader;
use zeronav_shell::{Peer, Roster, StartError};

/// Reads `run/spans`.
pub(crate) struct AnswerReader {
    spans: SpanReader,
    /// Highest tick that each role has answered, by its code.
    ticks: [u64; 16],
}

impl AnswerReader {
    pub(crate) fn open(peer: &Peer) -> Result<Self, StartError> {
        Ok(Self {
            spans: peer.span_reader()?,
            ticks: [0; 16],
        })
    }

    /// Takes in what has come. A span is written after the messages of its answer: polled before
    /// the commands, it is never ahead of them.
    pub(crate) fn poll(&mut self) {
        let ticks = &mut self.ticks;
        self.spans.drain(|span| {
            if span.kind() == Some(SpanKind::Answer)
                && let Some(tick) = ticks.get_mut(usize::from(span.role))
            {
                *tick = (*tick).max(span.tick);
            }
        });
    }

    /// True when every seat has answered what it owes up to `tick`; the newest scan is of
    /// `scan_tick`.
    pub(crate) fn are_complete(&self, roster: &Roster, tick: u64, scan_tick: u64) -> bool {
        SEATS
            .iter()
            .filter(|seat| seat.role != Role::Robot)
            .all(|seat| {
                let owed = match seat.answers {
                    Answers::EveryTick => tick,
                    Answers::TicksWithScan => scan_tick,
                };
                let answered = self.ticks[usize::from(seat.role.code())];
                !roster.answers(seat.role, owed) || answered >= owed
            })
    }
}
