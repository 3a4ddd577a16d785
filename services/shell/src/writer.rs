//! The writing end of a topic.

use crate::clock::now_ns;
use crate::middleware::{self, Erased, Factory, Sender, Unsent};
use core::marker::PhantomData;
use zeronav_msgs::header::{Header, Id, Parents, Stamps};
use zeronav_msgs::message::{FNV_OFFSET, fnv1a};
use zeronav_msgs::role::Role;
use zeronav_msgs::span::SpanKind;
use zeronav_msgs::stages::STAGES_MAX;
use zeronav_msgs::topics::{Topic, TopicRow, seal};

/// What the author knows about a message before it has an identity.
#[derive(Debug, Clone, Copy)]
pub struct Draft {
    /// What kind of answer it belongs to.
    pub kind: SpanKind,
    /// Tick that is answered, 0 = idle output.
    pub tick: u64,
    /// Run time of it. [ns]
    pub run_ns: u64,
    /// Capture of the newest sensor data in it, 0 = none. [ns]
    pub capture_ns: u64,
    /// What it was made from.
    pub parents: Parents,
    /// Return from the wait. [ns]
    pub woken_ns: u64,
    /// Inputs taken in. [ns]
    pub started_ns: u64,
    /// For the record: the robot's moment on its second clock, 0 = none. [ns]
    pub raw_ns: u64,
    /// For the record: times of the stages, see [`crate::Shell::stage_timer`]. [ns]
    pub stages_ns: [u32; STAGES_MAX],
    /// True when the message counts for the run's hash.
    pub hashed: bool,
}

impl Default for Draft {
    fn default() -> Self {
        Self {
            kind: SpanKind::Idle,
            tick: 0,
            run_ns: 0,
            capture_ns: 0,
            parents: Parents::default(),
            woken_ns: 0,
            started_ns: 0,
            raw_ns: 0,
            stages_ns: [0; STAGES_MAX],
            hashed: false,
        }
    }
}

/// A message that is out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Sent {
    /// Its identity.
    pub id: Id,
    /// The one clock reading in its header. [ns]
    pub published_ns: u64,
    /// FNV-1a of header without stamps, fixed fields and slice; 0 when not hashed.
    pub hash: u64,
}

/// The writing end of topic `T`.
#[derive(Debug)]
pub struct Writer<T: Topic> {
    row: &'static TopicRow,
    sender: Sender,
    topic: Erased<Factory>,
    of: PhantomData<fn(T)>,
    role: Role,
    epoch: u32,
    count: u64,
    failed: u64,
    too_long: u64,
}

impl<T: Topic> Writer<T> {
    pub(crate) fn new(
        row: &'static TopicRow,
        sender: Sender,
        topic: Erased<Factory>,
        role: Role,
        epoch: u32,
    ) -> Self {
        Self {
            row,
            sender,
            topic,
            of: PhantomData,
            role,
            epoch,
            count: 0,
            failed: 0,
            too_long: 0,
        }
    }

    /// The topic's row.
    #[must_use]
    pub fn row(&self) -> &'static TopicRow {
        self.row
    }

    /// Identity that the next message will have.
    #[must_use]
    pub fn next_id(&self) -> Id {
        Id::new(self.epoch, self.count + 1)
    }

    /// Messages that could not be sent, for lack of memory or because they were too long.
    #[must_use]
    pub fn failed(&self) -> u64 {
        self.failed
    }

    /// Messages among them that were longer than [`Self::len_max`]: a mistake of the author.
    #[must_use]
    pub fn too_long(&self) -> u64 {
        self.too_long
    }

    /// True while the topic has a reader; one that was killed counts until it is cleaned up after.
    #[must_use]
    pub fn is_read(&self) -> bool {
        middleware::ports(&self.topic)[1] > 0
    }

    /// Longest slice that fits.
    #[must_use]
    pub fn len_max(&self) -> usize {
        self.sender.len_max()
    }

    /// Sends one message; `None` when there is no free memory, which readers that hold old
    /// messages can cause: keep the data and try at the next wake. `None`, too, when it is longer
    /// than the writer was opened for, which is logged and reported in the heartbeat.
    pub fn publish(&mut self, draft: &Draft, meta: T::Meta, items: &[T::Item]) -> Option<Sent> {
        self.publish_with(draft, items.len(), |slot| {
            slot.copy_from_slice(items);
            meta
        })
    }

    /// Like [`Self::publish`], but the slice of `len` items is filled in place, in shared memory;
    /// what `fill` returns are the fixed fields.
    pub(crate) fn publish_with(
        &mut self,
        draft: &Draft,
        len: usize,
        fill: impl FnOnce(&mut [T::Item]) -> T::Meta,
    ) -> Option<Sent> {
        if len > self.len_max() {
            self.failed += 1;
            self.too_long += 1;
            if self.too_long == 1 {
                let (topic, len_max) = (self.row.name, self.len_max());
                tracing::error!(
                    topic,
                    len,
                    len_max,
                    "dropped: longer than its writer was opened for; said once"
                );
            }
            return None;
        }
        let (id, row, role) = (self.next_id(), self.row, self.role);
        let mut fill = Some(fill);
        let mut sent = None;
        let outcome = self.sender.send(len, &mut |envelope, items| {
            let items: &mut [T::Item] = bytemuck::cast_slice_mut(items);
            let Some(fill) = fill.take() else { return };
            let meta = fill(items);
            let mut header = Header {
                role: role.code(),
                schema: u32::try_from(row.schema & 0xffff_ffff).unwrap_or(0),
                id: id.0,
                tick: draft.tick,
                run_ns: draft.run_ns,
                parents: draft.parents,
                ..Header::default()
            };
            let hash = if draft.hashed {
                let state = fnv1a(FNV_OFFSET, bytemuck::bytes_of(&header));
                let state = fnv1a(state, bytemuck::bytes_of(&meta));
                fnv1a(state, bytemuck::cast_slice(items))
            } else {
                0
            };
            header.capture_ns = draft.capture_ns;
            let published_ns = now_ns();
            header.stamps = Stamps {
                woken_ns: draft.woken_ns,
                started_ns: draft.started_ns,
                published_ns,
            };
            envelope.copy_from_slice(bytemuck::bytes_of(&seal::<T>(header, meta, items)));
            sent = Some(Sent {
                id,
                published_ns,
                hash,
            });
        });
        if let Err(unsent) = outcome {
            if unsent == Unsent::NoMemory && self.failed == self.too_long {
                let topic = self.row.name;
                tracing::warn!(topic, len, "dropped: no free memory; said once");
            }
            self.failed += 1;
            return None;
        }
        self.count += 1;
        sent
    }

    /// Brings the last message of a latched topic to readers that joined since.
    pub fn refresh(&self) {
        self.sender.refresh();
    }
}
