//! Sets of positions.

/// Positions from the first to before the last.
pub(super) type Interval = (u32, u32);

/// A set of the positions below a limit, which is asked often.
#[derive(Debug, Default)]
pub(super) struct PositionSet {
    /// Sorted, none touching another.
    intervals: Vec<Interval>,
    bits: Vec<u64>,
}

impl PositionSet {
    /// Forgets all.
    pub(super) fn clear(&mut self) {
        self.intervals.clear();
    }

    /// Adds positions, which count from the next [`Self::close`] on.
    pub(super) fn add(&mut self, interval: Interval) {
        self.intervals.push(interval);
    }

    /// All positions were added; they are below `limit`.
    pub(super) fn close(&mut self, limit: usize) {
        merge(&mut self.intervals);
        self.bits.clear();
        self.bits.resize(limit.div_ceil(64), 0);
        for interval in &self.intervals {
            fill(&mut self.bits, *interval);
        }
    }

    /// True for a position of the set, and for [`u32::MAX`], which is none.
    #[inline]
    pub(super) fn holds(&self, position: u32) -> bool {
        let word = self.bits.get(position as usize >> 6);
        word.is_none_or(|word| word >> (position & 63) & 1 != 0)
    }

    /// True when the set holds all of `part`, or `part` is empty.
    pub(super) fn holds_all(&self, part: Interval) -> bool {
        let holds_from_first = || {
            let behind = (self.intervals).partition_point(|interval| interval.0 <= part.0);
            let around = behind.checked_sub(1).map(|n| self.intervals[n]);
            around.is_some_and(|around| around.1 >= part.1)
        };
        part.0 >= part.1 || self.holds(part.0) && holds_from_first()
    }

    pub(super) fn bytes(&self) -> usize {
        self.intervals.capacity() * size_of::<Interval>() + self.bits.capacity() * size_of::<u64>()
    }
}

/// Sorts intervals and joins those that touch.
pub(super) fn merge(intervals: &mut Vec<Interval>) {
    intervals.sort_unstable();
    intervals.dedup_by(|next, last| {
        let touches = next.0 <= last.1;
        if touches {
            last.1 = last.1.max(next.1);
        }
        touches
    });
}

/// Sets the bits of an interval.
fn fill(bits: &mut [u64], (first, end): Interval) {
    let mut at = first;
    while at < end {
        let next = ((at | 63) + 1).min(end);
        let ones = u64::MAX >> (64 - (next - at)) << (at & 63);
        if let Some(word) = bits.get_mut(at as usize >> 6) {
            *word |= ones;
        }
        at = next;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn a_set_holds_what_its_intervals_hold(
            mut intervals in prop::collection::vec((0_u32..200, 1_u32..80), 0..6),
            part in (0_u32..250, 0_u32..100),
        ) {
            for (first, end) in &mut intervals {
                *end += *first;
            }
            let holds = |position: u32| {
                (intervals.iter()).any(|(first, end)| (*first..*end).contains(&position))
            };
            let mut set = PositionSet::default();
            set.add((7, 270));
            set.close(300);
            set.clear();
            for interval in &intervals {
                set.add(*interval);
            }
            set.close(280);
            prop_assert!(set.intervals.windows(2).all(|pair| pair[0].1 < pair[1].0));
            for position in 0..280 {
                prop_assert_eq!(set.holds(position), holds(position), "{}", position);
            }
            prop_assert!(set.holds(u32::MAX));
            let part = (part.0, part.0 + part.1);
            prop_assert_eq!(set.holds_all(part), (part.0..part.1).all(holds));
        }
    }
}
