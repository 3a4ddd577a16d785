//! The ports of a service in C++, by the number of their topic.

use core::ffi::c_void;
use zeronav_msgs::topics::{Topic, TopicRow, TopicVisitor, visit_topics};
use zeronav_shell::{Draft, Input, Latest, Peer, Roster, Sent, Shell, StartError, Writer};

/// A message as it lies in shared memory; valid until the next poll of its reader.
#[repr(C)]
#[derive(Debug)]
pub struct RawView {
    /// Header and fixed fields.
    pub envelope: *const c_void,
    /// The first item.
    pub items: *const c_void,
    /// How many.
    pub len: usize,
    /// When it came in. [ns]
    pub came_ns: u64,
}

/// The reader of some topic.
pub(crate) trait AnyReader {
    /// As [`Latest::poll`].
    fn poll(&mut self, roster: &Roster) -> bool;
    /// The newest message.
    fn get(&self) -> Option<RawView>;
    /// As [`Latest::spoken_tick`].
    fn spoken_tick(&self) -> u64;
    /// What it counts.
    fn input(&self) -> &dyn Input;
}

impl<T: Topic> AnyReader for Latest<T> {
    fn poll(&mut self, roster: &Roster) -> bool {
        Self::poll(self, roster)
    }

    fn get(&self) -> Option<RawView> {
        let view = Self::get(self)?;
        Some(RawView {
            // The header is the first field of the envelope.
            envelope: core::ptr::from_ref(view.header).cast(),
            items: view.items.as_ptr().cast(),
            len: view.items.len(),
            came_ns: self.received()?.came_ns,
        })
    }

    fn spoken_tick(&self) -> u64 {
        Self::spoken_tick(self)
    }

    fn input(&self) -> &dyn Input {
        self
    }
}

/// The writer of some topic.
pub(crate) trait AnyWriter {
    /// Sends a message; `None` when its bytes are not those of the topic, or as [`Shell::send`].
    fn send(&mut self, shell: &mut Shell, draft: &Draft, meta: &[u8], items: &[u8])
    -> Option<Sent>;
    /// As [`Writer::refresh`].
    fn refresh(&self);
}

impl<T: Topic> AnyWriter for Writer<T> {
    fn send(
        &mut self,
        shell: &mut Shell,
        draft: &Draft,
        meta: &[u8],
        items: &[u8],
    ) -> Option<Sent> {
        let meta = bytemuck::try_pod_read_unaligned(meta).ok()?;
        let items = bytemuck::try_cast_slice(items).ok()?;
        shell.send(draft, self, meta, items)
    }

    fn refresh(&self) {
        Self::refresh(self);
    }
}

/// Opens the reader of the topic with this number.
///
/// # Errors
/// As [`Peer::latest`]; [`StartError::Usage`] for a number without a topic.
pub(crate) fn reader(peer: &Peer, number: usize) -> Result<Box<dyn AnyReader>, StartError> {
    let mut opener = ReaderOpener {
        peer,
        number,
        opened: None,
    };
    visit_topics(&mut opener)?;
    opened(opener.opened, number)
}

/// Opens the writer of the topic with this number, with slices of up to `len` items.
///
/// # Errors
/// As [`Peer::writer`]; [`StartError::Usage`] for a number without a topic.
pub(crate) fn writer(
    peer: &Peer,
    number: usize,
    len: usize,
) -> Result<Box<dyn AnyWriter>, StartError> {
    let mut opener = WriterOpener {
        peer,
        number,
        len,
        opened: None,
    };
    visit_topics(&mut opener)?;
    opened(opener.opened, number)
}

fn opened<P>(opened: Option<P>, number: usize) -> Result<P, StartError> {
    opened.ok_or_else(|| StartError::Usage(format!("there is no topic {number} to open")))
}

struct ReaderOpener<'a> {
    peer: &'a Peer,
    number: usize,
    opened: Option<Box<dyn AnyReader>>,
}

impl TopicVisitor for ReaderOpener<'_> {
    type Error = StartError;

    fn topic<T: Topic>(&mut self, row: &'static TopicRow) -> Result<(), StartError> {
        if row.number == self.number {
            self.opened = Some(Box::new(self.peer.latest_on::<T>(row)?));
        }
        Ok(())
    }

    fn records(&mut self, _row: &'static TopicRow) -> Result<(), StartError> {
        Ok(())
    }
}

struct WriterOpener<'a> {
    peer: &'a Peer,
    number: usize,
    len: usize,
    opened: Option<Box<dyn AnyWriter>>,
}

impl TopicVisitor for WriterOpener<'_> {
    type Error = StartError;

    fn topic<T: Topic>(&mut self, row: &'static TopicRow) -> Result<(), StartError> {
        // A heartbeat is the shell's own.
        if row.number == self.number && row.number == T::ROW.number {
            self.opened = Some(Box::new(self.peer.writer::<T>(self.len)?));
        }
        Ok(())
    }

    fn records(&mut self, _row: &'static TopicRow) -> Result<(), StartError> {
        Ok(())
    }
}
