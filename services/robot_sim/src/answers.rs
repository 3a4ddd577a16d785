//! Which ticks the other seats have answered: in lockstep the robot waits for all of them.

use zeronav_msgs::role::Role;
use zeronav_msgs::seats::{Answers, SEATS};
use zeronav_msgs::span::SpanKind;
use zeronav_shell::records::SpanReader;
use zeronav_shell::{Peer, Roster, StartError};

/// Processes whose answers are remembered: two per seat run at a time.
const PROCESSES_MAX: usize = 32;

/// Reads `run/spans`.
pub(crate) struct AnswerReader {
    spans: SpanReader,
    /// Role, epoch and highest answered tick of each process, the newest process last.
    answered: Vec<(u16, u32, u64)>,
}

impl AnswerReader {
    pub(crate) fn open(peer: &Peer) -> Result<Self, StartError> {
        Ok(Self {
            spans: peer.span_reader()?,
            answered: Vec::with_capacity(PROCESSES_MAX),
        })
    }

    /// Takes in what has come. A span is written after the messages of its answer: polled before
    /// the commands, it is never ahead of them.
    pub(crate) fn poll(&mut self) {
        let answered = &mut self.answered;
        self.spans.drain(|span| {
            if span.kind() != Some(SpanKind::Answer) {
                return;
            }
            let process = (answered.iter_mut())
                .find(|(role, epoch, _)| (*role, *epoch) == (span.role, span.epoch));
            if let Some((_, _, tick)) = process {
                *tick = (*tick).max(span.tick);
                return;
            }
            if answered.len() == PROCESSES_MAX {
                answered.remove(0);
            }
            answered.push((span.role, span.epoch, span.tick));
        });
    }

    fn answered_by(&self, role: Role, epoch: u32) -> u64 {
        let of = |it: &&(u16, u32, u64)| (it.0, it.1) == (role.code(), epoch);
        (self.answered.iter().find(of)).map_or(0, |(_, _, tick)| *tick)
    }

    /// True when every seat has answered what it owes up to `tick`, and so has the second process of
    /// a seat that has two; the newest scan is of `scan_tick`.
    pub(crate) fn are_complete(&self, roster: &Roster, tick: u64, scan_tick: u64) -> bool {
        SEATS
            .iter()
            .filter(|seat| seat.role != Role::Robot)
            .all(|seat| {
                let owed = match seat.answers {
                    Answers::EveryTick => tick,
                    Answers::TicksWithScan => scan_tick,
                };
                let Some(processes) = roster.seat(seat.role) else {
                    return true;
                };
                [processes.epoch, processes.other]
                    .into_iter()
                    .filter(|epoch| *epoch != 0 && processes.answers_as(*epoch, owed))
                    // What came before it was answered by the process before it.
                    .filter(|epoch| owed >= processes.hears_from(*epoch))
                    .all(|epoch| self.answered_by(seat.role, epoch) >= owed)
            })
    }
}
