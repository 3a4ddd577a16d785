//! One thread reads the stack, another one writes the file: a disk that stalls for a moment loses no
//! message. Between them lie at most [`QUEUE_BYTES_MAX`]; beyond that nothing is read, and what the
//! stack's queues then lose is counted.
//!
//! In real time the writing thread runs on otherwise idle processors only. When it does not keep up, or at the end,
//! another thread that has a share of its own takes over its work.

use crate::logs::Logs;
use crate::native::NativeTopic;
use crate::orders::{Order, Shared, Start, World, WriteError};
use crate::priority;
use crate::taps::Message;
use crate::writer::{Ended, Writer};
use std::collections::{BTreeMap, VecDeque};
use std::fs::File;
use std::sync::atomic::Ordering;
use std::sync::mpsc::{Sender, channel};
use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};
use zeronav_msgs::topics::TopicRow;

/// Most that waits to be written. [bytes]
const QUEUE_BYTES_MAX: usize = 64 << 20;

/// How long a message may wait to be written before a thread with a share of the processors takes over.
const WAIT_MAX: Duration = Duration::from_millis(500);

/// The end of the recorder that takes messages.
pub(crate) struct Recorder {
    orders: Sender<Order>,
    shared: Arc<Shared>,
    /// All that was handed on so far. [bytes]
    handed_bytes: usize,
    /// How much was handed on at a moment since when some of it has waited to be written. [bytes]
    waits: Option<(Instant, usize)>,
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
            handed_bytes: 0,
            waits: None,
            writer: Some(spawn(writer)?),
            done: None,
        })
    }

    /// True while no more is to be read.
    pub(crate) fn is_full(&self) -> bool {
        self.queued_bytes() > QUEUE_BYTES_MAX
    }

    /// True when the map can only be shown with a keyframe, and none is on its way.
    pub(crate) fn needs_keyframe(&self) -> bool {
        self.queued_bytes() == 0 && self.shared.needs_keyframe.load(Ordering::Relaxed)
    }

    fn queued_bytes(&self) -> usize {
        self.shared.queued_bytes.load(Ordering::Relaxed)
    }

    /// Messages of one more topic will come.
    pub(crate) fn add(&self, topic: NativeTopic) {
        // When the writer has ended, it says why itself.
        let _ = self.orders.send(Order::Topic(topic));
    }

    /// Hands messages on; false when the file can be written no longer.
    pub(crate) fn write(&mut self, messages: &mut VecDeque<Message>) -> bool {
        if messages.is_empty() {
            return self.done.is_none();
        }
        let bytes = messages.iter().map(|it| it.bytes.len()).sum();
        self.handed_bytes = self.handed_bytes.wrapping_add(bytes);
        self.shared.queued_bytes.fetch_add(bytes, Ordering::Relaxed);
        let order = Order::Write(core::mem::take(messages));
        self.orders.send(order).is_ok()
    }

    /// Lets another thread write when messages wait for too long: to be called again and again. False when the file can
    /// be written no longer.
    pub(crate) fn keep_up(&mut self) -> bool {
        let (now, queued) = (Instant::now(), self.queued_bytes());
        match self.waits {
            Some((since, handed)) if queued > self.handed_bytes.wrapping_sub(handed) => {
                if now.duration_since(since) > WAIT_MAX {
                    self.shared.hurry.store(true, Ordering::Relaxed);
                }
            }
            _ => self.waits = (queued > 0).then_some((now, self.handed_bytes)),
        }
        if let Some(ended) = self.writer.take_if(|writer| writer.is_finished()) {
            match joined(ended) {
                Ended::Done(done) => self.done = Some(done),
                Ended::HandedOver(mut writer) => {
                    writer.gives_way = false;
                    match spawn(writer) {
                        Ok(writer) => self.writer = Some(writer),
                        Err(error) => self.done = Some(Err(error)),
                    }
                }
            }
        }
        self.done.is_none()
    }

    /// Ends the file with these fields of its verdict. A thread that gives way writes its present message; all that is
    /// left is written by the calling one.
    pub(crate) fn finish(self, verdict: BTreeMap<String, String>) -> Result<World, WriteError> {
        // First, or a thread without a share of the processors ends the file.
        self.shared.hurry.store(true, Ordering::Release);
        // When the writer has ended, it says why itself.
        let _ = self.orders.send(Order::Finish(verdict));
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
fn spawn(writer: Box<Writer>) -> Result<JoinHandle<Ended>, WriteError> {
    // Where there is no thread, the file still says why it ends.
    let slot = Arc::new(Mutex::new(Some(writer)));
    let take = |slot: &Mutex<Option<Box<Writer>>>| slot.lock().ok().and_then(|mut it| it.take());
    let of_thread = Arc::clone(&slot);
    let thread = std::thread::Builder::new().name("writer".to_owned());
    let spawned = thread.spawn(move || {
        let Some(writer) = take(&of_thread) else {
            return Ended::Done(Err(WriteError::Ended));
        };
        if writer.gives_way {
            priority::when_idle();
        }
        writer.run()
    });
    spawned.map_err(|error| {
        if let Some(writer) = take(&slot) {
            writer.give_up(&error.to_string());
        }
        error.into()
    })
}

/// How a thread has ended, for which this waits.
fn joined(writer: JoinHandle<Ended>) -> Ended {
    let ended = writer.join();
    ended.unwrap_or(Ended::Done(Err(WriteError::Ended)))
}

#[cfg(test)]
mod tests;
