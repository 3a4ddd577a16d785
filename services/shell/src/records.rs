//! `run/spans`: records without header, one per cycle and process.

use crate::middleware::Kept;
use iceoryx2::port::publisher::Publisher;
use iceoryx2::port::subscriber::Subscriber;
use iceoryx2::prelude::ipc;
use zeronav_msgs::header::SHADOW_EPOCH_MIN;
use zeronav_msgs::span::Span;

/// The writing end.
#[derive(Debug)]
pub struct SpanWriter {
    publisher: Kept<Publisher<ipc::Service, Span, ()>>,
    failed: u64,
}

impl SpanWriter {
    pub(crate) fn new(publisher: Publisher<ipc::Service, Span, ()>) -> Self {
        Self {
            publisher: Kept::new(publisher),
            failed: 0,
        }
    }

    /// Sends one record.
    pub fn write(&mut self, span: Span) {
        let sent = self
            .publisher
            .loan_uninit()
            .map(|slot| slot.write_payload(span).send());
        if !matches!(sent, Ok(Ok(_))) {
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
    subscriber: Kept<Subscriber<ipc::Service, Span, ()>>,
    refused: u64,
}

impl SpanReader {
    pub(crate) fn new(subscriber: Subscriber<ipc::Service, Span, ()>) -> Self {
        Self {
            subscriber: Kept::new(subscriber),
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
            let span = *self.subscriber.receive().ok().flatten()?;
            if span.check().is_err() {
                self.refused += 1;
            } else if span.epoch < SHADOW_EPOCH_MIN {
                return Some(span);
            }
        }
    }

    /// Records that were refused.
    #[must_use]
    pub fn refused(&self) -> u64 {
        self.refused
    }
}
