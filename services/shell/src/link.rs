//! The way of the messages of a topic to one reader, which launch may disturb on purpose: some are
//! lost, late, or have a bit flipped. Otherwise they are read in place, in shared memory.

use crate::middleware::{Receiver, Sample};
use crate::roster::Roster;
use bytemuck::{bytes_of_mut, cast_slice, cast_slice_mut, from_bytes};
use std::collections::VecDeque;
use zeronav_msgs::header::Header;
use zeronav_msgs::run::{TopicFault, TopicFaultKind};
use zeronav_msgs::topics::{Envelope, Topic, TopicRow};

/// A message as it lies in shared memory.
#[derive(Debug)]
pub struct View<'a, T: Topic> {
    /// Author, identity, times, parents.
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

/// Most messages that are on their way, so that a delay takes no unbounded memory; the oldest arrive
/// early.
const LATE_MAX: usize = 64;

/// How often a process looks for late messages. [ns]
pub(crate) const LOOK_NS: u64 = 1_000_000;

/// A received message.
pub(crate) enum Message<T: Topic> {
    /// As it lies in shared memory.
    Shared(Sample),
    /// A copy that was late, or has a bit flipped.
    Copied(Box<(T::Envelope, Vec<T::Item>)>),
}

impl<T: Topic> core::fmt::Debug for Message<T> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Message")
            .field("header", self.envelope().header())
            .finish_non_exhaustive()
    }
}

impl<T: Topic> Message<T> {
    pub(crate) fn envelope(&self) -> &T::Envelope {
        match self {
            Self::Shared(sample) => from_bytes(sample.envelope()),
            Self::Copied(copy) => &copy.0,
        }
    }

    pub(crate) fn items(&self) -> &[T::Item] {
        match self {
            Self::Shared(sample) => cast_slice(sample.items()),
            Self::Copied(copy) => &copy.1,
        }
    }

    pub(crate) fn view(&self) -> View<'_, T> {
        let envelope = self.envelope();
        View {
            header: envelope.header(),
            meta: envelope.meta(),
            items: self.items(),
        }
    }

    fn copied(self) -> Self {
        match self {
            Self::Shared(_) => Self::Copied(Box::new((*self.envelope(), self.items().to_vec()))),
            Self::Copied(_) => self,
        }
    }

    /// With one bit flipped: of the header, the fixed fields or the slice, by `draw`.
    fn corrupted(self, draw: u64) -> Self {
        let mut copied = self.copied();
        if let Self::Copied(copy) = &mut copied {
            let (envelope, items) = &mut **copy;
            flip(draw, bytes_of_mut(envelope), cast_slice_mut(items));
        }
        copied
    }
}

/// Flips one bit: of the header in front of the fixed fields, of these, or of the slice.
fn flip(draw: u64, envelope: &mut [u8], items: &mut [u8]) {
    let header_bytes = size_of::<Header>().min(envelope.len());
    let (header, meta) = envelope.split_at_mut(header_bytes);
    let parts = [header, meta, items]
        .into_iter()
        .filter(|part| !part.is_empty());
    let mut parts: Vec<&mut [u8]> = parts.collect();
    let pick = |draw: u64, n: usize| usize::try_from(draw % n.max(1) as u64).unwrap_or(0);
    let (part, draw) = (pick(draw, parts.len()), draw >> 8);
    if let Some(part) = parts.get_mut(part) {
        let bit = pick(draw, part.len() * 8);
        part[bit / 8] ^= 1 << (bit % 8);
    }
}

/// The receiving end.
#[derive(Debug)]
pub(crate) struct Link<T: Topic> {
    row: &'static TopicRow,
    receiver: Receiver,
    /// When each message arrives, by this process's clock [ns]; the next one first.
    late: VecDeque<(u64, Message<T>)>,
}

impl<T: Topic> Link<T> {
    pub(crate) fn new(row: &'static TopicRow, receiver: Receiver) -> Self {
        Self {
            row,
            receiver,
            late: VecDeque::new(),
        }
    }

    /// True when something has come that [`Self::receive`] has not returned yet.
    pub(crate) fn waits(&self) -> bool {
        self.receiver.waits()
    }

    /// The next message.
    pub(crate) fn receive(&mut self, roster: &Roster) -> Option<Message<T>> {
        let topic_fault = roster.topic_fault(self.row.number);
        if topic_fault.is_none() && self.late.is_empty() {
            return self.take();
        }
        let delay_ns = topic_fault.map_or(0, TopicFault::delay_ns);
        if delay_ns > 0 {
            while let Some(message) = self.take() {
                let arrives_ns = roster.woken_ns.saturating_add(delay_ns);
                self.late.push_back((arrives_ns, message.copied()));
            }
        }
        if let Some((arrives_ns, _)) = self.late.front() {
            let is_due = *arrives_ns <= roster.woken_ns || delay_ns == 0;
            return if is_due || self.late.len() > LATE_MAX {
                self.late.pop_front().map(|(_, message)| message)
            } else {
                None
            };
        }
        let topic_fault = topic_fault.filter(|_| delay_ns == 0)?;
        loop {
            let message = self.take()?;
            let reader = roster.own.map_or(0, |(role, _)| role.code());
            let draw = topic_fault.draw(reader, message.envelope().header().id);
            match topic_fault.kind() {
                Some(TopicFaultKind::Drop) if topic_fault.hits(draw) => {}
                Some(TopicFaultKind::Corrupt) if topic_fault.hits(draw) => {
                    return Some(message.corrupted(draw.rotate_left(32)));
                }
                _ => return Some(message),
            }
        }
    }

    fn take(&self) -> Option<Message<T>> {
        self.receiver.receive().map(Message::Shared)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use zeronav_msgs::run::SHARE_ALL;

    #[test]
    fn one_bit_flips_and_every_part_is_hit() {
        let header_bytes = size_of::<Header>();
        let mut hits = [0_u32; 3];
        for seed in 0..3000 {
            let fault = TopicFault {
                seed,
                ..TopicFault::default()
            };
            let mut envelope = vec![0_u8; header_bytes + 24];
            let mut items = vec![0_u8; 40];
            flip(fault.draw(1, 7).rotate_left(32), &mut envelope, &mut items);
            let (header, meta) = envelope.split_at(header_bytes);
            let ones = [header, meta, &items[..]]
                .map(|part| part.iter().map(|byte| byte.count_ones()).sum::<u32>());
            assert_eq!(ones.iter().sum::<u32>(), 1, "seed {seed}");
            for (hit, one) in hits.iter_mut().zip(ones) {
                *hit += one;
            }
        }
        assert!(hits.iter().all(|n| (900..1100).contains(n)), "{hits:?}");
        // A message without a slice.
        flip(u64::MAX, &mut vec![0; header_bytes + 8], &mut []);
    }

    #[test]
    fn the_share_of_messages_is_hit_and_the_readers_differ() {
        let fault = TopicFault {
            topic: 6,
            share: 3 * SHARE_ALL / 10,
            seed: 11,
            ..TopicFault::default()
        };
        // A reader in another language draws the same.
        assert_eq!(fault.draw(4, 7), 0x224a_fe67_07a4_e6f8);
        let hit = |role, id| fault.hits(fault.draw(role, id));
        let n = (0..10_000).filter(|id| hit(4, *id)).count();
        assert!((2850..3150).contains(&n), "{n} of 10000");
        let same = (0..10_000).filter(|id| hit(4, *id) == hit(5, *id)).count();
        assert!((5500..6100).contains(&same), "{same} of 10000");
    }
}
