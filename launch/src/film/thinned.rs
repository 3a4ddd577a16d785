//! Samples over time within a budget of bytes: when it is used up, every second one goes and the
//! rate is halved.

/// Something that is sampled.
pub(super) trait Sample: Sized {
    /// About what it takes in a file. [bytes]
    fn bytes(&self) -> usize;

    /// One sample, and its time, in place of two that follow each other.
    fn join(earlier: (u64, Self), later: (u64, Self)) -> (u64, Self) {
        drop(later);
        earlier
    }
}

/// Samples over time. Times are run times. [ns]
#[derive(Debug)]
pub(super) struct Thinned<T> {
    period_ns: u64,
    bytes_max: usize,
    bytes: usize,
    samples: Vec<(u64, T)>,
}

impl<T: Sample> Thinned<T> {
    /// At first one sample per `period_ns`, and never more than `bytes_max`.
    pub(super) const fn new(period_ns: u64, bytes_max: usize) -> Self {
        Self {
            period_ns,
            bytes_max,
            bytes: 0,
            samples: Vec::new(),
        }
    }

    /// True when the next sample is wanted.
    pub(super) fn is_due(&self, run_ns: u64) -> bool {
        let last = self.samples.last();
        last.is_none_or(|(last_ns, _)| run_ns >= last_ns.saturating_add(self.period_ns))
    }

    /// Adds a sample, in order of time, whether or not it is due.
    pub(super) fn push(&mut self, run_ns: u64, sample: T) {
        self.bytes += sample.bytes();
        self.samples.push((run_ns, sample));
        while self.bytes > self.bytes_max && self.samples.len() > 1 {
            self.halve();
        }
        // One sample alone that is beyond all bounds shows nothing.
        if self.bytes > self.bytes_max {
            self.samples.clear();
            self.bytes = 0;
        }
    }

    /// From one sample to the next. [ns]
    pub(super) const fn period_ns(&self) -> u64 {
        self.period_ns
    }

    /// The samples, oldest first.
    pub(super) fn samples(&self) -> &[(u64, T)] {
        &self.samples
    }

    fn halve(&mut self) {
        self.period_ns = self.period_ns.saturating_mul(2).max(1);
        let mut kept = Vec::with_capacity(self.samples.len().div_ceil(2));
        let mut all = core::mem::take(&mut self.samples).into_iter();
        while let Some(earlier) = all.next() {
            kept.push(match all.next() {
                Some(later) => T::join(earlier, later),
                None => earlier,
            });
        }
        self.bytes = kept.iter().map(|(_, sample)| sample.bytes()).sum();
        self.samples = kept;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    impl Sample for String {
        fn bytes(&self) -> usize {
            self.len()
        }
    }

    /// Of several, the bits of all.
    #[derive(Debug, PartialEq)]
    struct Bits(u64);

    impl Sample for Bits {
        fn bytes(&self) -> usize {
            1
        }

        fn join(earlier: (u64, Self), later: (u64, Self)) -> (u64, Self) {
            (later.0, Self(earlier.1.0 | later.1.0))
        }
    }

    #[test]
    fn the_budget_holds_and_the_rate_is_halved() {
        let mut thinned = Thinned::new(10, 100);
        for at in 0..100_000_u64 {
            if thinned.is_due(at * 10) {
                thinned.push(at * 10, "123456789".to_owned());
            }
            assert!(thinned.bytes <= 100);
        }
        let times: Vec<u64> = thinned.samples().iter().map(|(at, _)| *at).collect();
        // Eleven would fit; after the last halving there are at least half of them.
        assert!((5..=11).contains(&times.len()), "{times:?}");
        assert_eq!(times[0], 0, "the first one stays");
        assert!(
            times
                .windows(2)
                .all(|pair| pair[1] - pair[0] == thinned.period_ns()),
            "{times:?}"
        );
        assert!(times[times.len() - 1] >= 1_000_000 - thinned.period_ns());
    }

    #[test]
    fn what_is_joined_is_not_lost() {
        let mut thinned = Thinned::new(0, 4);
        for at in 0..64_u64 {
            thinned.push(at, Bits(1 << at));
        }
        let all = thinned
            .samples()
            .iter()
            .fold(0, |all, (_, bits)| all | bits.0);
        assert_eq!(all, u64::MAX);
        assert!(thinned.samples().len() <= 4);
        let last = thinned.samples().last().expect("a sample");
        assert_eq!(last.0, 63, "a joined one has the time of the later one");
    }

    #[test]
    fn one_sample_beyond_the_budget_is_not_kept() {
        let mut thinned = Thinned::new(1, 4);
        thinned.push(0, "12345".to_owned());
        assert_eq!(thinned.samples(), []);
        thinned.push(1, "1234".to_owned());
        assert_eq!(thinned.samples().len(), 1);
    }
}
