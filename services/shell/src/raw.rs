//! Messages as they are. Reading every one of a topic, of every author, obeyed or not, accepted or not, is for a
//! recorder, which has to keep what there was; whoever acts on messages reads [`crate::Latest`] or
//! [`crate::Stream`]. Writing is for who plays what was recorded.

use crate::middleware::{Erased, Factory, Receiver, Sender};

/// The reading end: bytes, in the order in which each author sent them.
#[derive(Debug)]
pub struct RawReader {
    receiver: Receiver,
}

impl RawReader {
    pub(crate) fn new(receiver: Receiver) -> Self {
        Self { receiver }
    }

    /// Shows header with fixed fields, and items, of the oldest message that has come, and gives it
    /// back to its writer; `None` when there is no more. Both are in shared memory: their length and
    /// content are as the writer left them, and checked by nobody. A record has items alone.
    pub fn take<R>(&mut self, see: impl FnOnce(&[u8], &[u8]) -> R) -> Option<R> {
        let sample = self.receiver.receive()?;
        Some(see(sample.envelope(), sample.items()))
    }
}

/// The writing end: bytes, with the header that they have.
#[derive(Debug)]
pub struct RawWriter {
    sender: Sender,
    item_bytes: usize,
    _topic: Erased<Factory>,
}

/// Why bytes were not sent.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum RawUnsent {
    /// Readers hold all memory of the topic: it may be free a moment later.
    #[error("readers hold all memory of the topic")]
    NoMemory,
    /// They are no message of this topic, or one that is longer than the writer was opened for.
    #[error("its size is that of no message of the topic")]
    Size,
}

impl RawWriter {
    pub(crate) fn new(sender: Sender, topic: Erased<Factory>, item_bytes: usize) -> Self {
        Self {
            sender,
            item_bytes: item_bytes.max(1),
            _topic: topic,
        }
    }

    /// Sends a message: header with fixed fields, then items. Nobody is rung.
    ///
    /// # Errors
    /// [`RawUnsent`].
    pub fn send(&mut self, envelope: &[u8], items: &[u8]) -> Result<(), RawUnsent> {
        let len = items.len() / self.item_bytes;
        if !items.len().is_multiple_of(self.item_bytes) || len > self.sender.len_max() {
            return Err(RawUnsent::Size);
        }
        let mut fits = false;
        let sent = self.sender.send(len, &mut |of_envelope, of_items| {
            fits = of_envelope.len() == envelope.len() && of_items.len() == items.len();
            if fits {
                of_envelope.copy_from_slice(envelope);
                of_items.copy_from_slice(items);
            }
        });
        match sent {
            Ok(()) if fits => Ok(()),
            Ok(()) => Err(RawUnsent::Size),
            Err(_) => Err(RawUnsent::NoMemory),
        }
    }

    /// Brings the last message of a latched topic to readers that joined since.
    pub fn refresh(&self) {
        self.sender.refresh();
    }
}
