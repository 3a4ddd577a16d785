//! Reading every message of a topic as it is: of every author, obeyed or not, accepted or not. For
//! a recorder, which has to keep what there was; whoever acts on messages reads [`crate::Latest`] or
//! [`crate::Stream`].

use crate::middleware::Receiver;

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
