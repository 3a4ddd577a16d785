//! How long a seat takes to answer after a fault: the global planner with a path that it has found.

use zeronav_msgs::header::Header;
use zeronav_msgs::role::Role;
use zeronav_msgs::span::{Span, SpanKind};

/// Faults after which an answer is waited for at a time; the oldest go first.
const AWAITED_MAX: usize = 256;

/// A seat whose next answer is waited for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Awaited {
    /// Number of the fault.
    pub id: u64,
    /// The seat.
    pub role: Role,
    /// A process whose answers do not count: the one that broke; 0 = none.
    pub not_epoch: u32,
    /// The answer is to a later tick.
    pub after_tick: u64,
    /// Since when. Monotonic. [ns]
    pub since_ns: u64,
}

/// An answer that was waited for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Answered {
    /// What was waited for.
    pub awaited: Awaited,
    /// Its tick.
    pub tick: u64,
    /// When it was sent. Monotonic. [ns]
    pub published_ns: u64,
}

/// See the module's description.
#[derive(Debug, Default)]
pub struct Recoveries {
    awaited: Vec<Awaited>,
    answered: Vec<Answered>,
}

impl Recoveries {
    /// Waits for an answer, in place of another one after the same fault.
    pub fn wait_for(&mut self, awaited: Awaited) {
        self.awaited.retain(|before| before.id != awaited.id);
        if self.awaited.len() == AWAITED_MAX {
            self.awaited.remove(0);
        }
        self.awaited.push(awaited);
    }

    /// Takes in the record of an answer that counts.
    pub fn note(&mut self, span: &Span) {
        if self.awaited.is_empty() || span.kind() != Some(SpanKind::Answer) || span.output == 0 {
            return;
        }
        // Of a planner without a map there are answers without a path.
        if span.role != Role::GlobalPlanner.code() {
            self.answer(span.role, span.epoch, span.tick, span.published_ns);
        }
    }

    /// Takes in a path that the global planner has found.
    pub fn note_path(&mut self, header: &Header) {
        let published_ns = header.stamps.published_ns;
        self.answer(header.role, header.id().epoch(), header.tick, published_ns);
    }

    fn answer(&mut self, role: u16, epoch: u32, tick: u64, published_ns: u64) {
        let is_it = |it: &mut Awaited| {
            it.role.code() == role && it.not_epoch != epoch && it.after_tick < tick
        };
        let heard = self.awaited.extract_if(.., is_it);
        self.answered.extend(heard.map(|awaited| Answered {
            awaited,
            tick,
            published_ns,
        }));
    }

    /// The answers that have come since the last call.
    pub fn take(&mut self) -> Vec<Answered> {
        core::mem::take(&mut self.answered)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use zeronav_msgs::header::Id;

    fn answer(role: Role, epoch: u32, tick: u64) -> Span {
        Span {
            role: role.code(),
            kind: SpanKind::Answer.code(),
            epoch,
            tick,
            output: 1,
            published_ns: 1000 + tick,
            ..Span::default()
        }
    }

    #[test]
    fn a_planner_has_recovered_when_it_has_found_a_path() {
        let mut recoveries = Recoveries::default();
        let awaited = Awaited {
            id: 1,
            role: Role::GlobalPlanner,
            not_epoch: 1,
            after_tick: 10,
            since_ns: 0,
        };
        recoveries.wait_for(awaited);
        recoveries.note(&answer(Role::GlobalPlanner, 2, 15));
        assert_eq!(recoveries.take(), [], "an answer without a path");
        let path = |epoch, tick| Header {
            id: Id::new(epoch, 7).0,
            role: Role::GlobalPlanner.code(),
            tick,
            ..Header::default()
        };
        recoveries.note_path(&path(1, 20));
        recoveries.note_path(&path(2, 10));
        assert_eq!(recoveries.take(), []);
        recoveries.note_path(&path(2, 20));
        assert_eq!(recoveries.take().len(), 1);
    }

    #[test]
    fn the_first_answer_of_the_seat_that_is_not_of_the_broken_process_counts() {
        let mut recoveries = Recoveries::default();
        let awaited = Awaited {
            id: 4,
            role: Role::Mapping,
            not_epoch: 1,
            after_tick: 10,
            since_ns: 1005,
        };
        recoveries.wait_for(awaited);
        let mut idle = answer(Role::Mapping, 2, 20);
        idle.kind = SpanKind::Idle.code();
        for span in [
            answer(Role::Mapping, 1, 12),
            answer(Role::LocalPlanner, 2, 12),
            answer(Role::Mapping, 2, 10),
            idle,
        ] {
            recoveries.note(&span);
        }
        assert_eq!(recoveries.take(), []);
        recoveries.note(&answer(Role::Mapping, 2, 31));
        recoveries.note(&answer(Role::Mapping, 2, 32));
        let found = recoveries.take();
        assert_eq!(found.len(), 1);
        assert_eq!((found[0].tick, found[0].published_ns), (31, 1031));
        assert_eq!(found[0].awaited, awaited);
        assert_eq!(recoveries.take(), []);
    }
}
