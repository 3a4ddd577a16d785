//! `run/spans`: records without header, one per cycle and process.

use crate::middleware::{Receiver, Sender};
use bytemuck::{bytes_of, try_from_bytes};
use zeronav_msgs::header::SHADOW_EPOCH_MIN;
use zeronav_msgs::span::Span;

/// The writing end.
#[derive(Debug)]
pub struct SpanWriter {
    sender: Sender,
    failed: u64,
}

impl SpanWriter {
    pub(crate) fn new(sender: Sender) -> Self {
        Self { sender, failed: 0 }
    }

    /// Sends one record.
    pub fn write(&mut self, span: Span) {
        let mut fill = |_: &mut [u8], item: &mut [u8]| item.copy_from_slice(bytes_of(&span));
        if self.sender.send(1, &mut fill).is_err() {
            self.failed += 1;
        }
    }

    /// Records that could not be sent.
    #[must_use]
    pub fn failed(&self) -> u64 {
        self.failed
    }
}

/// The reading end.
#[derive(Debug)]
pub struct SpanReader {
    receiver: Receiver,
    refused: u64,
}

impl SpanReader {
    pub(crate) fn new(receiver: Receiver) -> Self {
        Self {
            receiver,
            refused: 0,
        }
    }

    /// Shows every record that has come to `see`; of one process in order. What a shadow did
    /// counts nowhere, so its records are left out.
    pub fn drain(&mut self, mut see: impl FnMut(&Span)) {
        while let Some(span) = self.take() {
            see(&span);
        }
    }

    /// The oldest record that has come, as [`Self::drain`] shows it.
    pub fn take(&mut self) -> Option<Span> {
        loop {
            let sample = self.receiver.receive()?;
            // How many bytes there are, the writer says.
            match try_from_bytes::<Span>(sample.items()) {
                Ok(span) if span.check().is_ok() => {
                    if span.epoch < SHADOW_EPOCH_MIN {
                        return Some(*span);
                    }
                }
                _ => self.refused += 1,
            }
        }
    }

    /// Records that were refused.
    #[must_use]
    pub fn refused(&self) -> u64 {
        self.refused
    }
}
