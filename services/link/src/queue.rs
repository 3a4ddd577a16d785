//! The queues between the link's loop and Zenoh's threads. Nothing is put into one that has no room: what is to be sent
//! stays in the topics' own queues, where the newest message takes the place of the oldest, and what comes waits in the
//! transport. One frame, of whatever length, may stand out.

use std::collections::VecDeque;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};

/// Bytes of frames after which there is no room for more.
pub const ROOM_BYTES: usize = 16 * 1024;

#[derive(Debug, Default)]
struct Inner {
    frames: VecDeque<Vec<u8>>,
    bytes: usize,
    closed: bool,
}

/// A queue of frames.
#[derive(Debug, Default)]
pub struct FrameQueue {
    inner: Mutex<Inner>,
    changed: Condvar,
}

impl FrameQueue {
    fn lock(&self) -> MutexGuard<'_, Inner> {
        self.inner.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// True while less than [`ROOM_BYTES`] lie in it: one more frame fits, of whatever length.
    #[must_use]
    pub fn has_room(&self) -> bool {
        self.lock().bytes < ROOM_BYTES
    }

    /// Puts in a frame; it is for the caller to see whether there is room.
    pub fn push(&self, frame: Vec<u8>) {
        let mut inner = self.lock();
        inner.bytes += frame.len();
        inner.frames.push_back(frame);
        self.changed.notify_all();
    }

    /// Waits until there is room, or the queue is closed, and puts in a frame.
    pub fn push_when_there_is_room(&self, frame: Vec<u8>) {
        let mut inner = self.lock();
        while inner.bytes >= ROOM_BYTES && !inner.closed {
            inner = (self.changed.wait(inner)).unwrap_or_else(PoisonError::into_inner);
        }
        if inner.closed {
            return;
        }
        inner.bytes += frame.len();
        inner.frames.push_back(frame);
        self.changed.notify_all();
    }

    /// The next frame, if there is one.
    pub fn take(&self) -> Option<Vec<u8>> {
        self.pop(&mut self.lock())
    }

    /// Waits for the next frame; `None` once the queue is closed and empty.
    pub fn wait(&self) -> Option<Vec<u8>> {
        let mut inner = self.lock();
        loop {
            if let Some(frame) = self.pop(&mut inner) {
                return Some(frame);
            }
            if inner.closed {
                return None;
            }
            inner = (self.changed.wait(inner)).unwrap_or_else(PoisonError::into_inner);
        }
    }

    fn pop(&self, inner: &mut Inner) -> Option<Vec<u8>> {
        let frame = inner.frames.pop_front()?;
        inner.bytes -= frame.len();
        self.changed.notify_all();
        Some(frame)
    }

    /// Nobody waits any more.
    pub fn close(&self) {
        self.lock().closed = true;
        self.changed.notify_all();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_come_in_order_and_room_is_counted_in_bytes() {
        let queue = FrameQueue::default();
        assert!(queue.has_room() && queue.take().is_none());
        queue.push(vec![1]);
        queue.push(vec![2; ROOM_BYTES - 1]);
        assert!(!queue.has_room());
        assert_eq!(queue.take(), Some(vec![1]));
        assert!(queue.has_room());
        assert_eq!(queue.wait().map(|frame| frame.len()), Some(ROOM_BYTES - 1));
        queue.close();
        assert_eq!(queue.wait(), None);
    }

    #[test]
    fn who_waits_for_room_gets_it() {
        let queue = FrameQueue::default();
        queue.push(vec![0; ROOM_BYTES]);
        std::thread::scope(|scope| {
            scope.spawn(|| queue.push_when_there_is_room(vec![7]));
            assert_eq!(queue.wait().map(|frame| frame.len()), Some(ROOM_BYTES));
            assert_eq!(queue.wait(), Some(vec![7]));
        });
        // Nobody waits for a queue that nobody empties any more.
        queue.push(vec![0; ROOM_BYTES]);
        queue.close();
        queue.push_when_there_is_room(vec![8]);
    }
}
