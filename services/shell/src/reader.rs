//! The reading ends of a topic. Foreign bytes are checked here, once, for everybody.

use crate::roster::Roster;
use iceoryx2::prelude::ipc;
use iceoryx2::sample::Sample;
use zeronav_msgs::header::{Header, Id};
use zeronav_msgs::message::Refusal;
use zeronav_msgs::role::Role;
use zeronav_msgs::topics::{Envelope, Topic, TopicRow, decode};

pub(crate) type Subscriber<T> = iceoryx2::port::subscriber::Subscriber<
    ipc::Service,
    [<T as Topic>::Item],
    <T as Topic>::Envelope,
>;

type Received<T> = Sample<ipc::Service, [<T as Topic>::Item], <T as Topic>::Envelope>;

/// A message as it lies in shared memory.
#[derive(Debug)]
pub struct View<'a, T: Topic> {
    /// Who, which, when, because of what.
    pub header: &'a Header,
    /// The fixed fields.
    pub meta: &'a T::Meta,
    /// The slice.
    pub items: &'a [T::Item],
}

impl<T: Topic> Clone for View<'_, T> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<T: Topic> Copy for View<'_, T> {}

fn view<T: Topic>(sample: &Received<T>) -> View<'_, T> {
    let envelope: &T::Envelope = sample.user_header();
    View {
        header: envelope.header(),
        meta: envelope.meta(),
        items: sample.payload(),
    }
}

/// Decides which messages are heard, and remembers what was wrong with the others.
#[derive(Debug)]
struct Gate {
    row: &'static TopicRow,
    refused: u64,
    /// Newest tick of a message whose sender is heard though its content is refused.
    refused_tick: u64,
    seen: Vec<Refusal>,
}

impl Gate {
    fn new(row: &'static TopicRow) -> Self {
        Self {
            row,
            refused: 0,
            refused_tick: 0,
            seen: Vec::new(),
        }
    }

    fn admits<T: Topic>(&mut self, sample: &Received<T>, roster: &Roster) -> bool {
        let envelope: &T::Envelope = sample.user_header();
        let header = envelope.header();
        if let Err(refusal) = decode::<T>(self.row, envelope, sample.payload()) {
            self.refused += 1;
            if header.check(self.row.schema, self.row.writers).is_ok() && roster.hears(header) {
                self.refused_tick = self.refused_tick.max(header.tick);
            }
            if !self.seen.contains(&refusal) {
                self.seen.push(refusal);
                tracing::warn!(topic = self.row.name, id = %header.id(), %refusal, "message refused");
            }
            return false;
        }
        roster.hears(header)
    }
}

/// Keeps the newest message of a latest or latched topic, in place in shared memory.
#[derive(Debug)]
pub struct Latest<T: Topic> {
    gate: Gate,
    subscriber: Subscriber<T>,
    held: Option<Received<T>>,
    superseded: u64,
}

impl<T: Topic> Latest<T> {
    pub(crate) fn new(row: &'static TopicRow, subscriber: Subscriber<T>) -> Self {
        Self {
            gate: Gate::new(row),
            subscriber,
            held: None,
            superseded: 0,
        }
    }

    /// Takes in what has come; true when there is a newer message than before.
    ///
    /// Messages of several writers arrive writer by writer, so the newest is the one with the
    /// highest id and not the one that came last. Before it is known who is obeyed, messages of
    /// services are left where they are: a latched one comes once, and nobody would believe it yet.
    pub fn poll(&mut self, roster: &Roster) -> bool {
        if roster.seats.is_empty() && !self.gate.row.writers.contains(&Role::Launch) {
            return false;
        }
        let mut fresh = false;
        while let Ok(Some(sample)) = self.subscriber.receive() {
            if !self.gate.admits::<T>(&sample, roster) {
                continue;
            }
            let newer = self.held.as_ref().is_none_or(|held| {
                let held = view::<T>(held).header;
                view::<T>(&sample).header.id > held.id || !roster.hears(held)
            });
            if newer {
                self.superseded += u64::from(fresh);
                self.held = Some(sample);
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
        self.subscriber.has_samples().unwrap_or(false)
    }

    /// The newest message.
    #[must_use]
    pub fn get(&self) -> Option<View<'_, T>> {
        self.held.as_ref().map(view::<T>)
    }

    /// Gives the newest message back to its writer, once it has been used. Messages that are large
    /// and rare have few places; whoever keeps an old one takes a place from the next.
    pub fn release(&mut self) {
        self.held = None;
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

    /// Tick up to which the writer has spoken, whether what it said could be used or not; in
    /// lockstep nobody waits any longer for a message that was refused.
    #[must_use]
    pub fn spoken_tick(&self) -> u64 {
        self.tick().max(self.gate.refused_tick)
    }

    /// Messages overtaken by newer ones before they were looked at.
    #[must_use]
    pub fn superseded(&self) -> u64 {
        self.superseded
    }

    /// Messages that were refused.
    #[must_use]
    pub fn refused(&self) -> u64 {
        self.gate.refused
    }
}

/// Sees every message of a topic in order.
#[derive(Debug)]
pub struct Stream<T: Topic> {
    gate: Gate,
    subscriber: Subscriber<T>,
    last: Id,
    gaps: u64,
}

impl<T: Topic> Stream<T> {
    pub(crate) fn new(row: &'static TopicRow, subscriber: Subscriber<T>) -> Self {
        Self {
            gate: Gate::new(row),
            subscriber,
            last: Id::NONE,
            gaps: 0,
        }
    }

    /// Shows every message that has come to `see`, oldest first.
    pub fn drain(&mut self, roster: &Roster, mut see: impl FnMut(View<'_, T>)) {
        while let Ok(Some(sample)) = self.subscriber.receive() {
            if !self.gate.admits::<T>(&sample, roster) {
                continue;
            }
            let message = view::<T>(&sample);
            let id = message.header.id();
            if id.epoch() == self.last.epoch() && id > self.last.next() {
                self.gaps += 1;
            }
            self.last = id;
            see(message);
        }
    }

    /// How often messages were missing.
    #[must_use]
    pub fn gaps(&self) -> u64 {
        self.gaps
    }

    /// Messages that were refused.
    #[must_use]
    pub fn refused(&self) -> u64 {
        self.gate.refused
    }
}
