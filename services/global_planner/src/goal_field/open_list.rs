//! What a search has yet to look at, by key.

use crate::bucket_queue::BucketQueue;
use core::cmp::Reverse;
use std::collections::BinaryHeap;
use zeronav_casts::low_u32;

/// See the module's description.
pub(super) trait OpenList {
    fn reset(&mut self, key: u32, span: u32);
    fn push(&mut self, key: u32, item: u32);
    fn pop(&mut self) -> Option<u32>;
    /// No key that is pushed may be lower.
    fn least(&self) -> u32;
}

impl OpenList for BucketQueue {
    #[inline]
    fn reset(&mut self, key: u32, span: u32) {
        Self::reset(self, key, span);
    }

    #[inline]
    fn push(&mut self, key: u32, item: u32) {
        Self::push(self, key, item);
    }

    #[inline]
    fn pop(&mut self) -> Option<u32> {
        Self::pop(self)
    }

    #[inline]
    fn least(&self) -> u32 {
        self.key()
    }
}

/// An open list whose keys may fall, as they do along the previous way when the field is weighted.
#[derive(Debug, Default)]
pub(super) struct HeapQueue {
    items: BinaryHeap<Reverse<u64>>,
    peak: usize,
}

impl OpenList for HeapQueue {
    fn reset(&mut self, _key: u32, _span: u32) {
        self.items.clear();
        self.peak = 0;
    }

    fn push(&mut self, key: u32, item: u32) {
        self.items
            .push(Reverse(u64::from(key) << 32 | u64::from(item)));
        self.peak = self.peak.max(self.items.len());
    }

    fn pop(&mut self) -> Option<u32> {
        self.items.pop().map(|item| low_u32(item.0))
    }

    fn least(&self) -> u32 {
        0
    }
}

impl HeapQueue {
    /// Longest that the list was since the last reset.
    pub(super) const fn peak(&self) -> u64 {
        self.peak as u64
    }

    pub(super) fn bytes(&self) -> usize {
        self.items.capacity() * size_of::<Reverse<u64>>()
    }
}
