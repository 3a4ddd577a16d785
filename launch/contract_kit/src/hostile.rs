//! Hostile messages on every topic that a seat reads: random bytes, numbers that mean trouble, wrong
//! headers, wrong lengths.
//!
//! A message that its header makes one of the obeyed author has the tick of now and an identity below
//! those that were sent before: a reader decodes it, and rejects it or takes it for an old one. So what
//! is tested is that nothing gets through, and not what a seat does that believes a liar.

use super::bench::{OTHERS_EPOCH, seat_row};
use super::raw::RawPeer;
use super::robot::TICK_NS;
use zeronav_msgs::header::{Header, Id};
use zeronav_msgs::role::Role;
use zeronav_msgs::topics::{
    Envelope, RunClockTopic, RunControlTopic, Topic, TopicRow, TopicVisitor, seal, visit_topics,
};
use zeronav_shell::clock::now_ns;

/// Longest slice that is sent. [bytes]
const BYTES_MAX: usize = 1 << 14;

/// Numbers at the edge of what numbers mean.
const EDGES: [u64; 8] = [
    0,
    u64::MAX,
    0x7ff8_0000_0000_0000, // NaN
    0x7ff0_0000_0000_0000, // infinity
    0xfff0_0000_0000_0000,
    0x7fef_ffff_ffff_ffff, // the largest number
    0x0001_0001_0001_0001,
    0x7fc0_0000_7f80_0000, // NaN and infinity as f32
];

/// A source of numbers.
///
/// Source: Steele, Lea, Flood, "Fast Splittable Pseudorandom Number Generators", 2014.
#[derive(Debug)]
pub(crate) struct Noise(pub u64);

impl Noise {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut word = self.0;
        word = (word ^ (word >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        word = (word ^ (word >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        word ^ (word >> 31)
    }

    fn below(&mut self, limit: usize) -> usize {
        usize::try_from(self.next() % (limit as u64).max(1)).unwrap_or(0)
    }

    fn fill(&mut self, bytes: &mut [u8], with_edges: bool) {
        for chunk in bytes.chunks_mut(8) {
            let word = if with_edges {
                EDGES[self.below(EDGES.len())]
            } else {
                self.next()
            };
            let n = chunk.len();
            chunk.copy_from_slice(&word.to_le_bytes()[..n]);
        }
    }
}

/// Sends one hostile message for a tick; false when the middleware had no place for it.
type Thrower = Box<dyn FnMut(&mut Noise, u64) -> bool>;

/// Sends hostile messages on all inputs of a seat.
pub(crate) struct Hostile {
    throwers: Vec<(&'static TopicRow, Thrower)>,
}

struct Opener<'a> {
    raw: &'a RawPeer,
    role: Role,
    throwers: Vec<(&'static TopicRow, Thrower)>,
}

impl TopicVisitor for Opener<'_> {
    type Error = String;

    fn topic<T: Topic>(&mut self, row: &'static TopicRow) -> Result<(), String> {
        let of_launch = [RunClockTopic::ROW.name, RunControlTopic::ROW.name];
        // On a topic that it writes itself, its own messages could not be told from hostile ones.
        let reads = seat_row(self.role).reads.iter();
        let is_own = row.writers.contains(&self.role);
        if !is_own
            && reads
                .map(|read| read.name)
                .chain(of_launch)
                .any(|name| name == row.name)
        {
            self.throwers.push((row, thrower::<T>(self.raw, row)?));
        }
        Ok(())
    }

    fn records(&mut self, _: &'static TopicRow) -> Result<(), String> {
        Ok(())
    }
}

impl Hostile {
    /// Opens writers of every topic that the seat of `role` reads and does not write.
    ///
    /// # Errors
    /// What the middleware says.
    pub(crate) fn open(raw: &RawPeer, role: Role) -> Result<Self, String> {
        let mut opener = Opener {
            raw,
            role,
            throwers: Vec::new(),
        };
        visit_topics(&mut opener)?;
        Ok(Self {
            throwers: opener.throwers,
        })
    }

    /// Topics that are written.
    pub(crate) fn rows(&self) -> impl Iterator<Item = &'static TopicRow> {
        self.throwers.iter().map(|(row, _)| *row)
    }

    /// Sends one message on each; how many were sent.
    pub(crate) fn throw(&mut self, noise: &mut Noise, tick: u64) -> u64 {
        let throwers = self.throwers.iter_mut();
        throwers
            .map(|(_, throw)| u64::from(throw(noise, tick)))
            .sum()
    }
}

/// What is wrong with a message.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Wrong {
    Everything,
    Checksum,
    Schema,
    Author,
    Length,
    Content,
    Numbers,
}

fn thrower<T: Topic>(raw: &RawPeer, row: &'static TopicRow) -> Result<Thrower, String> {
    let len_max = (row.len_max + 1).min(1 + BYTES_MAX / row.item_bytes.max(1));
    let writer = raw.writer::<T>(row, len_max)?;
    // What launch says is believed: nothing with its header may have a meaning.
    let is_launch = row.writers.contains(&Role::Launch);
    Ok(Box::new(move |noise, tick| {
        let wrong = match noise.below(if is_launch { 5 } else { 7 }) {
            0 => Wrong::Everything,
            1 => Wrong::Checksum,
            2 => Wrong::Schema,
            3 => Wrong::Author,
            4 => Wrong::Length,
            5 => Wrong::Content,
            _ => Wrong::Numbers,
        };
        let mut len = match noise.below(4) {
            0 => noise.below(len_max + 1),
            _ => noise.below(len_max.min(8) + 1),
        };
        if wrong == Wrong::Length {
            // Its fixed fields, all zero, say that there is no item.
            len = len.max(1);
        }
        let Ok(mut sample) = writer.loan_slice(len) else {
            return false;
        };
        let edges = wrong == Wrong::Numbers;
        noise.fill(bytemuck::cast_slice_mut(sample.payload_mut()), edges);
        let mut meta = <T::Meta as Default>::default();
        if wrong != Wrong::Length {
            noise.fill(bytemuck::bytes_of_mut(&mut meta), edges);
        }
        let header = header(row, wrong, noise, tick);
        *sample.user_header_mut() = if matches!(wrong, Wrong::Everything | Wrong::Checksum) {
            T::Envelope::new(header, meta)
        } else {
            seal::<T>(header, meta, sample.payload())
        };
        sample.send().is_ok()
    }))
}

fn header(row: &TopicRow, wrong: Wrong, noise: &mut Noise, tick: u64) -> Header {
    let mut header = Header::default();
    if wrong == Wrong::Everything {
        noise.fill(bytemuck::bytes_of_mut(&mut header), false);
        return header;
    }
    let now_ns = now_ns();
    header.role = row.writers.first().map_or(0, |role| role.code());
    header.schema = u32::try_from(row.schema & 0xffff_ffff).unwrap_or(0);
    let is_launch = row.writers.contains(&Role::Launch);
    header.id = Id::new(if is_launch { 1 } else { OTHERS_EPOCH }, 1).0;
    (header.tick, header.run_ns) = (tick, tick * TICK_NS);
    header.capture_ns = now_ns;
    header.stamps.published_ns = now_ns;
    match wrong {
        Wrong::Schema => header.schema ^= 1 << noise.below(32),
        Wrong::Author => match noise.below(3) {
            0 => header.role = Role::Tap.code(),
            1 => header.id = 0,
            _ => header.robot = 1,
        },
        _ => {}
    }
    header
}
