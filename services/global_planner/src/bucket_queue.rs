//! The open list of a search whose keys are integers and never fall.
//!
//! Source: Dial, "Algorithm 360: Shortest-Path Forest with Topological Ordering", 1969: a ring of
//! buckets, one per key, wide enough for the largest step. Within a bucket the last in is the
//! first out, which for A* means larger `g` first and makes the order of ties fixed. Two levels
//! of bit sets find the next bucket. A binary heap does the same with `log n` cache misses per
//! operation and was two to three times slower on costmaps.

use zeronav_casts::Cast;

const NONE: u32 = u32::MAX;

#[derive(Debug, Clone, Copy)]
struct Entry {
    item: u32,
    next: u32,
}

/// See the module's description.
#[derive(Debug, Default)]
pub(crate) struct BucketQueue {
    /// First entry of each bucket in `entries`.
    heads: Vec<u32>,
    /// Bit per bucket: not empty.
    full: Vec<u64>,
    /// Bit per word of `full`: not 0.
    summary: Vec<u64>,
    entries: Vec<Entry>,
    free: u32,
    mask: u32,
    key: u32,
    len: usize,
    peak: usize,
}

impl BucketQueue {
    /// Empties the queue and makes it ready for keys from `key` on, of which no two in the queue
    /// are ever more than `span` apart.
    pub(crate) fn reset(&mut self, key: u32, span: u32) {
        let buckets = (span + 1).next_power_of_two().max(64);
        self.heads.clear();
        self.heads.resize(buckets as usize, NONE);
        self.full.clear();
        self.full.resize(buckets as usize / 64, 0);
        self.summary.clear();
        self.summary.resize(self.full.len().div_ceil(64), 0);
        self.entries.clear();
        self.free = NONE;
        self.mask = buckets - 1;
        self.key = key;
        self.len = 0;
        self.peak = 0;
    }

    /// Longest that the queue was since the last reset.
    pub(crate) fn peak(&self) -> usize {
        self.peak
    }

    /// Adds `item`. `key` is at least that of the last item popped and within the span of it.
    #[inline]
    pub(crate) fn push(&mut self, key: u32, item: u32) {
        debug_assert!(key >= self.key, "keys never fall");
        debug_assert!(key - self.key <= self.mask, "keys stay within the span");
        let bucket = key & self.mask;
        let next = self.heads[bucket as usize];
        let entry = if self.free == NONE {
            self.entries.push(Entry { item, next });
            (self.entries.len() - 1).to_u32()
        } else {
            let entry = self.free;
            let slot = &mut self.entries[entry as usize];
            self.free = slot.next;
            *slot = Entry { item, next };
            entry
        };
        self.heads[bucket as usize] = entry;
        if next == NONE {
            let word = bucket as usize >> 6;
            self.full[word] |= 1 << (bucket & 63);
            self.summary[word >> 6] |= 1 << (word & 63);
        }
        self.len += 1;
        self.peak = self.peak.max(self.len);
    }

    /// Bytes held.
    pub(crate) fn bytes(&self) -> usize {
        self.heads.capacity() * size_of::<u32>()
            + (self.full.capacity() + self.summary.capacity()) * size_of::<u64>()
            + self.entries.capacity() * size_of::<Entry>()
    }

    /// Key of the item popped last; no key in the queue is lower.
    #[inline]
    pub(crate) const fn key(&self) -> u32 {
        self.key
    }

    /// Like [`Self::pop`], with the item's key before it.
    #[inline]
    pub(crate) fn pop_with_key(&mut self) -> Option<(u32, u32)> {
        self.pop().map(|item| (self.key, item))
    }

    /// Takes an item with the lowest key, of those the one that was added last.
    #[inline]
    pub(crate) fn pop(&mut self) -> Option<u32> {
        if self.len == 0 {
            return None;
        }
        let position = self.key & self.mask;
        let bucket = self.next_bucket(position)?;
        self.key += bucket.wrapping_sub(position) & self.mask;
        let entry = self.heads[bucket as usize];
        let slot = &mut self.entries[entry as usize];
        let (item, next) = (slot.item, slot.next);
        slot.next = self.free;
        self.free = entry;
        self.heads[bucket as usize] = next;
        if next == NONE {
            let word = bucket as usize >> 6;
            self.full[word] &= !(1 << (bucket & 63));
            if self.full[word] == 0 {
                self.summary[word >> 6] &= !(1 << (word & 63));
            }
        }
        self.len -= 1;
        Some(item)
    }

    /// The first bucket that is not empty, from `position` round the ring.
    #[inline]
    fn next_bucket(&self, position: u32) -> Option<u32> {
        let word = position as usize >> 6;
        let here = self.full[word] & (u64::MAX << (position & 63));
        if here != 0 {
            return Some(word.to_u32() << 6 | here.trailing_zeros());
        }
        let word = self.next_word(word + 1).or_else(|| self.next_word(0))?;
        Some(word.to_u32() << 6 | self.full[word].trailing_zeros())
    }

    /// The first word of `full` from `from` on that is not 0.
    fn next_word(&self, from: usize) -> Option<usize> {
        let mut group = from >> 6;
        let mut bits = self.summary.get(group)? & (u64::MAX << (from & 63));
        while bits == 0 {
            group += 1;
            bits = *self.summary.get(group)?;
        }
        Some(group << 6 | bits.trailing_zeros() as usize)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn the_last_of_equal_keys_comes_first() {
        let mut queue = BucketQueue::default();
        queue.reset(10, 100);
        for (key, item) in [(12, 1), (11, 2), (12, 3), (10, 4)] {
            queue.push(key, item);
        }
        let order: Vec<u32> = core::iter::from_fn(|| queue.pop()).collect();
        assert_eq!(order, [4, 2, 3, 1]);
        assert_eq!(queue.peak(), 4);
    }

    #[test]
    fn keys_a_whole_span_apart_have_buckets_of_their_own() {
        for span in [63, 64, 65, 127, 128, 4095, 4096, 8192] {
            let mut queue = BucketQueue::default();
            queue.reset(7, span);
            queue.push(7, 1);
            queue.push(7 + span, 2);
            queue.push(7 + span - 1, 3);
            let order: Vec<u32> = core::iter::from_fn(|| queue.pop()).collect();
            assert_eq!(order, [1, 3, 2], "span {span}");
        }
    }

    proptest! {
        /// Against a sorted list, with keys that run round the ring several times.
        #[test]
        fn items_come_in_the_order_of_their_keys(
            span in 1_u32..9000,
            moves in proptest::collection::vec((0_u32..=u32::MAX, 0_u32..3), 1..400),
        ) {
            let mut queue = BucketQueue::default();
            let mut now = 1000;
            queue.reset(now, span);
            let mut model: Vec<(u32, u32)> = Vec::new();
            for (n, (offset, pops)) in (0_u32..).zip(moves) {
                let key = now + offset % (span + 1);
                queue.push(key, n);
                model.push((key, n));
                for _ in 0..pops {
                    // Lowest key, newest of those.
                    let best = model.iter().copied().min_by_key(|(key, n)| (*key, u32::MAX - n));
                    prop_assert_eq!(queue.pop(), best.map(|(_, n)| n));
                    if let Some(best) = best {
                        now = best.0;
                        model.retain(|entry| *entry != best);
                    }
                }
            }
        }
    }
}
