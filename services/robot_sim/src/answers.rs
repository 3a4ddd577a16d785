//! Which ticks the other seats have answered: in lockstep the robot waits for all of them.

use zeronav_msgs::role::Role;
use zeronav_msgs::seats::{Answers, SEATS};
use zeronav_msgs::span::SpanKind;
use zeronav_shell::records::SpanReader;
use zeronav_shell::{Peer, Roster, StartError};

/// Processes whose answers are remembered: two per seat run at a time.
const PROCESSES_MAX: usize = 32;

/// How far each process has answered.
#[derive(Debug, Default)]
struct Answered {
    /// Role, epoch and highest answered tick.
    processes: Vec<(u16, u32, u64)>,
}

impl Answered {
    fn note(&mut self, role: u16, epoch: u32, tick: u64) {
        let known = (self.processes.iter_mut()).find(|it| (it.0, it.1) == (role, epoch));
        if let Some((_, _, highest)) = known {
            *highest = (*highest).max(tick);
            return;
        }
        // The one that is farthest behind has ended: those that run answer every scan, however long ago
        // they began.
        if self.processes.len() == PROCESSES_MAX
            && let Some(behind) = (0..PROCESSES_MAX).min_by_key(|at| self.processes[*at].2)
        {
            self.processes.swap_remove(behind);
        }
        self.processes.push((role, epoch, tick));
    }

    fn by(&self, role: Role, epoch: u32) -> u64 {
        let of = |it: &&(u16, u32, u64)| (it.0, it.1) == (role.code(), epoch);
        (self.processes.iter().find(of)).map_or(0, |(_, _, tick)| *tick)
    }
}

/// Reads `run/spans`.
pub(crate) struct AnswerReader {
    spans: SpanReader,
    answered: Answered,
}

impl AnswerReader {
    pub(crate) fn open(peer: &Peer) -> Result<Self, StartError> {
        Ok(Self {
            spans: peer.span_reader()?,
            answered: Answered::default(),
        })
    }

    /// Takes in what has come. A span is written after the messages of its answer: polled before
    /// the commands, it is never ahead of them.
    pub(crate) fn poll(&mut self) {
        let answered = &mut self.answered;
        self.spans.drain(|span| {
            if span.kind() == Some(SpanKind::Answer) {
                answered.note(span.role, span.epoch, span.tick);
            }
        });
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
                    .all(|epoch| self.answered.by(seat.role, epoch) >= owed)
            })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn who_still_answers_is_remembered_however_many_others_came_and_went() {
        let (guard, mapping) = (Role::CollisionGuard, Role::Mapping);
        let mut answered = Answered::default();
        for epoch in 1..100 {
            let tick = 10 * u64::from(epoch);
            answered.note(guard.code(), 1, tick);
            // A successor's first answer, after the other's to the same tick.
            answered.note(mapping.code(), epoch, tick);
            assert_eq!(answered.by(guard, 1), tick, "{epoch} processes");
            assert_eq!(answered.by(mapping, epoch), tick);
            assert!(answered.processes.len() <= PROCESSES_MAX);
        }
    }
}
