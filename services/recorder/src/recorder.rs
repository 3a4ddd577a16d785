//! One thread reads the stack, another one writes the file: a disk that stalls for a moment loses no
//! message. Between them lie at most [`QUEUE_BYTES_MAX`]; beyond that nothing is read, and what the
//! stack's queues then lose is counted.
//!
//! In real time the writing thread takes only what nobody else wants of the processors. When it does not keep up, or at
//! the end, another thread goes on with its work that has a share of its own.

use crate::logs::Logs;
use crate::native::NativeTopic;
use crate::orders::{Order, Shared, Start, World, WriteError};
use crate::priority;
use crate::taps::Message;
use crate::writer::{Ended, Writer};
use std::collections::{BTreeMap, VecDeque};
use std::fs::File;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::sync::mpsc::{Sender, channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};
use zeronav_msgs::topics::TopicRow;

/// Most that waits to be written. [bytes]
const QUEUE_BYTES_MAX: usize = 64 << 20;

/// How long something may wait to be written before the writing thread gets a share of the processors.
const WAIT_MAX: Duration = Duration::from_millis(500);

/// The end of the recorder that takes messages.
pub(crate) struct Recorder {
    orders: Sender<Order>,
    shared: Arc<Shared>,
    /// Since when something has waited to be written.
    waits_since: Option<Instant>,
    /// `None` once it has ended with `done`.
    writer: Option<JoinHandle<Ended>>,
    done: Option<Result<World, WriteError>>,
}

impl Recorder {
    /// Begins a recording of the topics in `rows` and of `logs` in `file`, of which something is on the disk when this
    /// returns.
    pub(crate) fn start(
        file: File,
        rows: &[&'static TopicRow],
        start: &Start,
        logs: Option<Logs>,
    ) -> Result<Self, WriteError> {
        let (orders, received) = channel();
        let shared = Arc::new(Shared::default());
        let told = (received, Arc::clone(&shared));
        let mut writer = Box::new(Writer::new(file, rows, (start, logs), told)?);
        writer.gives_way = start.times.is_real_time();
        Ok(Self {
            orders,
            shared,
            waits_since: None,
            writer: Some(spawn(writer)?),
            done: None,
        })
    }

    /// True while no more is to be read.
    pub(crate) fn is_full(&self) -> bool {
        self.shared.queued_bytes.load(Ordering::Relaxed) > QUEUE_BYTES_MAX
    }

    /// True when the map can only be shown with a keyframe.
    pub(crate) fn needs_keyframe(&self) -> bool {
        self.shared.needs_keyframe.load(Ordering::Relaxed)
    }

    /// Messages of one more topic will come.
    pub(crate) fn add(&self, topic: NativeTopic) {
        // When the writer has ended, it says why itself.
        let _ = self.orders.send(Order::Topic(topic));
    }

    /// Hands messages on; false when the file can be written no longer.
    pub(crate) fn write(&mut self, messages: &mut VecDeque<Message>) -> bool {
        self.keep_up();
        if messages.is_empty() {
            return self.done.is_none();
        }
        let bytes = messages.iter().map(|it| it.bytes.len()).sum();
        self.shared.queued_bytes.fetch_add(bytes, Ordering::Relaxed);
        let order = Order::Write(core::mem::take(messages));
        self.orders.send(order).is_ok()
    }

    /// Gives the writer a share of the processors when something waits for too long.
    fn keep_up(&mut self) {
        let now = Instant::now();
        if self.shared.queued_bytes.load(Ordering::Relaxed) == 0 {
            self.waits_since = None;
        } else if now.duration_since(*self.waits_since.get_or_insert(now)) > WAIT_MAX {
            self.shared.hurry.store(true, Ordering::Relaxed);
        }
        let Some(ended) = self.writer.take_if(|writer| writer.is_finished()) else {
            return;
        };
        match joined(ended) {
            Ended::Done(done) => self.done = Some(done),
            Ended::HandedOver(mut writer) => {
                writer.gives_way = false;
                match spawn(writer) {
                    Ok(writer) => self.writer = Some(writer),
                    Err(error) => self.done = Some(Err(error.into())),
                }
            }
        }
    }

    /// Ends the file with these fields of its verdict. What is not written yet is written by the calling thread.
    pub(crate) fn finish(self, verdict: BTreeMap<String, String>) -> Result<World, WriteError> {
        // When the writer has ended, it says why itself.
        let _ = self.orders.send(Order::Finish(verdict));
        self.shared.hurry.store(true, Ordering::Relaxed);
        let ended = match (self.done, self.writer) {
            (Some(done), _) => return done,
            (None, Some(writer)) => joined(writer),
            (None, None) => return Err(WriteError::Ended),
        };
        let ended = match ended {
            Ended::HandedOver(mut writer) => {
                writer.gives_way = false;
                writer.run()
            }
            done @ Ended::Done(_) => done,
        };
        match ended {
            Ended::Done(done) => done,
            Ended::HandedOver(_) => Err(WriteError::Ended),
        }
    }
}

/// Starts the writing thread.
fn spawn(writer: Box<Writer>) -> std::io::Result<JoinHandle<Ended>> {
    let thread = std::thread::Builder::new().name("writer".to_owned());
    thread.spawn(move || {
        if writer.gives_way {
            priority::when_idle();
        }
        writer.run()
    })
}

/// How a thread has ended, for which this waits.
fn joined(writer: JoinHandle<Ended>) -> Ended {
    let ended = writer.join();
    ended.unwrap_or(Ended::Done(Err(WriteError::Ended)))
}

#[cfg(test)]
mod tests;
