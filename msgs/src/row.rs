//! What a row of the table of topics says, and what follows from it.

use crate::role::Role;

/// How a topic is read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Discipline {
    /// Only the newest message matters.
    Latest,
    /// Every message matters, in order.
    Stream,
    /// The newest message matters, also to those who come later.
    Latched,
    /// Self-contained records without header, every one matters.
    Records,
}

/// Most readers of a topic, guests included.
pub const READERS_MAX: usize = 12;
/// Most writers of a swappable output: the obeyed process, its successor or what is left of the one
/// before, and shadows.
pub const WRITERS_MAX: usize = 4;
/// Most writers of `run/spans`.
pub const SPAN_WRITERS_MAX: usize = 16;
/// Most processes in a domain.
pub const NODES_MAX: usize = 24;
/// Largest event id on a doorbell.
pub const EVENT_MAX: usize = 63;
/// Event id with which a reader asks mapping for a keyframe.
pub const EVENT_NEED_KEYFRAME: usize = 40;
/// Most processes that may ring one doorbell.
pub const RINGERS_MAX: usize = 20;

/// One row of the table.
#[derive(Debug)]
pub struct TopicRow {
    /// Event id on the doorbells it rings.
    pub number: usize,
    /// Name of the service in the middleware.
    pub name: &'static str,
    /// How it is read.
    pub discipline: Discipline,
    /// Who may write it.
    pub writers: &'static [Role],
    /// Whose doorbell a message rings.
    pub rings: &'static [Role],
    /// Whose doorbell it rings in lockstep besides.
    pub rings_in_lockstep: &'static [Role],
    /// Longest slice that any run may ask for.
    pub len_max: usize,
    /// Bytes of header and fixed fields.
    pub envelope_bytes: usize,
    /// Bytes of one item of the slice.
    pub item_bytes: usize,
    /// Hash of everything a reader must agree on.
    pub schema: u64,
}

impl TopicRow {
    /// Messages that the middleware keeps for a reader. Of a keyframe, which is large and rare, two; of
    /// every other topic enough for a recorder that looks now and then.
    #[must_use]
    pub const fn buffer(&self) -> usize {
        match self.discipline {
            Discipline::Latched if self.is_large() => 2,
            Discipline::Latest | Discipline::Stream | Discipline::Latched => 32,
            Discipline::Records => 1024,
        }
    }

    /// True for a topic whose messages are so large that few places are reserved for them.
    const fn is_large(&self) -> bool {
        self.item_bytes > 1024 && self.history() > 0
    }

    /// Messages that a service asks for; taps ask for [`Self::buffer`].
    #[must_use]
    pub const fn service_buffer(&self) -> usize {
        match self.discipline {
            Discipline::Latest | Discipline::Latched => 2,
            Discipline::Stream | Discipline::Records => self.buffer(),
        }
    }

    /// Messages that a reader may hold at a time: the newest and the one that may be newer.
    #[must_use]
    pub const fn borrowed(&self) -> usize {
        match self.discipline {
            Discipline::Latest | Discipline::Latched => 2,
            Discipline::Stream | Discipline::Records => 1,
        }
    }

    /// Messages kept for readers that join later.
    #[must_use]
    pub const fn history(&self) -> usize {
        match self.discipline {
            Discipline::Latched => 1,
            _ => 0,
        }
    }

    /// Most writers at a time.
    #[must_use]
    pub const fn writers_max(&self) -> usize {
        match self.discipline {
            Discipline::Records => SPAN_WRITERS_MAX,
            _ => WRITERS_MAX,
        }
    }

    /// Messages for which a writer holds memory. With safe overflow every queue holds the same
    /// last `buffer` messages, so the sum over readers that the middleware assumes is not needed.
    /// Keyframes are large and rare: two in the queues, one in a reader's hand and one to write;
    /// when even these are taken, the keyframe waits for the next wake.
    #[must_use]
    pub const fn pool(&self) -> usize {
        if self.is_large() {
            4
        } else {
            self.buffer() + READERS_MAX * self.borrowed() + self.history() + 2
        }
    }

    /// Bytes of shared memory that one writer takes with slices of `len` items.
    #[must_use]
    pub const fn segment_bytes(&self, len: usize) -> usize {
        // 64 bytes of the middleware's own header, each part rounded to 8.
        self.pool()
            * (64
                + self.envelope_bytes.next_multiple_of(8)
                + (len * self.item_bytes).next_multiple_of(8))
    }
}
