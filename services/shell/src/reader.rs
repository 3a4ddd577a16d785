//! The reading ends of a topic. Foreign bytes are checked here and nowhere else.

use crate::input::Input;
use crate::link::{Link, Message, View};
use crate::middleware::Receiver;
use crate::received::Received;
use crate::roster::Roster;
use zeronav_msgs::header::{Header, Id};
use zeronav_msgs::message::Refusal;
use zeronav_msgs::role::Role;
use zeronav_msgs::topics::{Envelope, HEALTH, MapKeyframe, MapUpdate, Topic, TopicRow, decode};

/// Decides which messages are heard, and remembers what was wrong with rejected ones.
#[derive(Debug)]
struct Gate {
    row: &'static TopicRow,
    is_health: bool,
    is_map: bool,
    refused: u64,
    /// Tick of the last message, when its sender is obeyed and its content was rejected; 0 otherwise.
    refused_tick: u64,
    /// Rejected messages by the epoch in their header, as far as that can be read.
    refused_of: Vec<(u32, u64)>,
    seen: Vec<Refusal>,
}

/// Epochs of which rejected messages are told apart.
const EPOCHS_MAX: usize = 8;

impl Gate {
    fn new(row: &'static TopicRow) -> Self {
        Self {
            row,
            is_health: HEALTH.iter().any(|health| health.number == row.number),
            is_map: [MapUpdate::ROW.number, MapKeyframe::ROW.number].contains(&row.number),
            refused: 0,
            refused_tick: 0,
            refused_of: Vec::new(),
            seen: Vec::new(),
        }
    }

    fn note_author(&mut self, epoch: u32) {
        let known = self.refused_of.iter().position(|(of, _)| *of == epoch);
        match known {
            Some(at) => self.refused_of[at].1 += 1,
            None if self.refused_of.len() < EPOCHS_MAX => self.refused_of.push((epoch, 1)),
            None => {}
        }
    }

    fn admits<T: Topic>(&mut self, message: &Message<T>, roster: &Roster) -> bool {
        let envelope = message.envelope();
        let header = envelope.header();
        if let Err(refusal) = decode::<T>(self.row, envelope, message.items()) {
            self.refused += 1;
            // A header in which a bit was changed may name anything.
            let is_whole = refusal != Refusal::Checksum;
            if is_whole && header.check(self.row.schema, self.row.writers).is_ok() {
                self.note_author(header.id().epoch());
                if self.hears(header, roster) {
                    self.refused_tick = header.tick;
                }
            }
            if !self.seen.contains(&refusal) {
                self.seen.push(refusal);
                tracing::warn!(topic = self.row.name, id = %header.id(), %refusal, "message refused");
            }
            return false;
        }
        let is_heard = self.hears(header, roster);
        if is_heard {
            self.refused_tick = 0;
        }
        is_heard
    }

    /// In lockstep an idle output would take effect at a tick that depends on the speed of the
    /// machine: it is heard of the first process in a seat only, which sends it before the first
    /// tick. The map is also heard from before the reader's own first tick, as it is the sum of its
    /// updates.
    fn hears(&self, header: &Header, roster: &Roster) -> bool {
        let is_untimed = header.tick == 0 && !self.is_health && roster.lockstep();
        if is_untimed && roster.is_taken_over(header) {
            return false;
        }
        roster.hears(header) || (self.is_map && roster.obeys(header))
    }
}

/// Keeps the newest message of a latest or latched topic, in place in shared memory.
#[derive(Debug)]
pub struct Latest<T: Topic> {
    gate: Gate,
    link: Link<T>,
    held: Option<Message<T>>,
    /// When it came in. [ns]
    came_ns: u64,
    superseded: u64,
}

impl<T: Topic> Latest<T> {
    pub(crate) fn new(row: &'static TopicRow, receiver: Receiver) -> Self {
        Self {
            gate: Gate::new(row),
            link: Link::new(row, receiver),
            held: None,
            came_ns: 0,
            superseded: 0,
        }
    }

    /// Takes in what has come; true when there is a newer message than before.
    ///
    /// Messages of several writers arrive writer by writer, so the newest is the one with the
    /// highest id and not the one that came last; those of the process that is obeyed now are newer
    /// than those of the one before it. Before it is known which processes are obeyed, messages of
    /// services are left where they are: a latched one comes once and would be rejected.
    pub fn poll(&mut self, roster: &Roster) -> bool {
        if roster.seats.is_empty() && !self.gate.row.writers.contains(&Role::Launch) {
            return false;
        }
        let mut fresh = false;
        while let Some(message) = self.link.receive(roster) {
            if !self.gate.admits::<T>(&message, roster) {
                continue;
            }
            let newer = self.held.as_ref().is_none_or(|held| {
                let rank = |header: &Header| (roster.is_current(header), header.id);
                let held = held.view().header;
                rank(message.view().header) > rank(held) || !roster.hears(held)
            });
            if newer {
                self.superseded += u64::from(fresh);
                self.held = Some(message);
                self.came_ns = roster.woken_ns;
                fresh = true;
            } else {
                self.superseded += 1;
            }
        }
        fresh
    }

    /// True when something has come that [`Self::poll`] has not taken in yet.
    #[must_use]
    pub fn waits(&self) -> bool {
        self.link.waits()
    }

    /// The newest message.
    #[must_use]
    pub fn get(&self) -> Option<View<'_, T>> {
        self.held.as_ref().map(Message::view)
    }

    /// Gives the newest message back to its writer, once it has been used. Large and rare messages
    /// have few places: an old one that is kept takes a place from the next.
    pub fn release(&mut self) {
        self.held = None;
    }

    /// When the newest message was captured and received.
    #[must_use]
    pub fn received(&self) -> Option<Received> {
        self.get()
            .map(|view| Received::of(view.header, self.came_ns))
    }

    /// Identity of the newest message; [`Id::NONE`] before the first.
    #[must_use]
    pub fn id(&self) -> Id {
        self.get().map_or(Id::NONE, |view| view.header.id())
    }

    /// Tick of the newest message; 0 before the first.
    #[must_use]
    pub fn tick(&self) -> u64 {
        self.get().map_or(0, |view| view.header.tick)
    }

    /// Tick up to which the writer has answered, whether its message was accepted or rejected; in
    /// lockstep a rejected message is not waited for any longer. It answers until the next message
    /// comes: its tick may be any number.
    #[must_use]
    pub fn spoken_tick(&self) -> u64 {
        self.tick().max(self.gate.refused_tick)
    }
}

impl<T: Topic> Input for Latest<T> {
    fn refused(&self) -> u64 {
        self.gate.refused
    }

    fn superseded(&self) -> u64 {
        self.superseded
    }
}

/// Sees every message of a topic in order.
#[derive(Debug)]
pub struct Stream<T: Topic> {
    gate: Gate,
    link: Link<T>,
    last: Id,
    gaps: u64,
    missed: u64,
}

impl<T: Topic> Stream<T> {
    pub(crate) fn new(row: &'static TopicRow, receiver: Receiver) -> Self {
        Self {
            gate: Gate::new(row),
            link: Link::new(row, receiver),
            last: Id::NONE,
            gaps: 0,
            missed: 0,
        }
    }

    /// Shows every message that has come to `see`, oldest first.
    pub fn drain(&mut self, roster: &Roster, mut see: impl FnMut(View<'_, T>)) {
        while self.take(roster, &mut see).is_some() {}
    }

    /// Shows the oldest message that has come to `see`, and gives it back to its writer; `None` when
    /// there is no more.
    pub fn take<R>(&mut self, roster: &Roster, see: impl FnOnce(View<'_, T>) -> R) -> Option<R> {
        loop {
            let message = self.link.receive(roster)?;
            if !self.gate.admits::<T>(&message, roster) {
                continue;
            }
            let message = message.view();
            let id = message.header.id();
            if id.epoch() == self.last.epoch() && id > self.last.next() {
                self.gaps += 1;
                self.missed += id.0 - self.last.next().0;
            }
            self.last = id;
            return Some(see(message));
        }
    }

    /// Rejected messages whose header cannot be read, so that nothing says of whom they are.
    #[must_use]
    pub fn refused_of_nobody(&self) -> u64 {
        let named: u64 = self.gate.refused_of.iter().map(|(_, n)| *n).sum();
        self.gate.refused - named
    }

    /// Rejected messages whose header names this epoch; those with a broken header name none.
    #[must_use]
    pub fn refused_of(&self, epoch: u32) -> u64 {
        let of = self.gate.refused_of.iter().find(|(of, _)| *of == epoch);
        of.map_or(0, |(_, n)| *n)
    }

    /// How often messages were missing.
    #[must_use]
    pub fn gaps(&self) -> u64 {
        self.gaps
    }

    /// How many messages were missing, of processes of which a later one came.
    #[must_use]
    pub fn missed(&self) -> u64 {
        self.missed
    }
}

impl<T: Topic> Input for Stream<T> {
    fn refused(&self) -> u64 {
        self.gate.refused
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use zeronav_msgs::run::{RunClock, RunMode, Seat};
    use zeronav_msgs::topics::{ControlRequest, health_of};

    #[test]
    fn heartbeats_and_the_map_are_heard_whatever_their_tick() {
        let seat = |role: Role, epoch, hear_tick| Seat {
            role: role.code(),
            epoch,
            hear_tick,
            ..Seat::default()
        };
        let roster = Roster {
            clock: RunClock {
                mode: RunMode::Lockstep.code(),
                ..RunClock::default()
            },
            seats: vec![seat(Role::Mapping, 2, 10), seat(Role::LocalPlanner, 3, 20)],
            own: Some((Role::LocalPlanner, 3)),
            ..Roster::default()
        };
        let of_mapping = |tick| Header {
            id: Id::new(2, 7).0,
            role: Role::Mapping.code(),
            tick,
            ..Header::default()
        };
        let hears = |row, tick| Gate::new(row).hears(&of_mapping(tick), &roster);
        let health = health_of(Role::Mapping).expect("a row");
        assert!(hears(health, 0), "it belongs to no tick");
        let others = ControlRequest::ROW;
        assert!(!hears(others, 0) && !hears(others, 19) && hears(others, 20));
        for row in [MapUpdate::ROW, MapKeyframe::ROW] {
            assert!(!hears(row, 0) && hears(row, 10), "{}", row.name);
        }
    }
}
