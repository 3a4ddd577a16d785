//! By how much the clock of the other host is ahead, from the times of beats that went to and fro.
//!
//! Source: the clock filter of NTP (Mills, RFC 5905, section 10): of the last exchanges the one with the
//! shortest way tells most, and half of its way bounds the error.

use zeronav_casts::Cast;

/// Exchanges that are kept.
const KEPT: usize = 16;

/// By how much two clocks may drift apart: the kernel slews each by up to 500 parts per million. [ns per ns]
const DRIFT: f64 = 1.0e-3;

/// One exchange: a beat went out, and one came back that says when it had arrived and when it left.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Exchange {
    /// [ns] of the own clock: the first one was sent.
    pub sent_ns: u64,
    /// [ns] of the other clock: it came.
    pub came_there_ns: u64,
    /// [ns] of the other clock: the answer was sent.
    pub sent_there_ns: u64,
    /// [ns] of the own clock: the answer came.
    pub came_ns: u64,
}

/// The estimate.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Offset {
    /// [ns] by which the other clock is ahead of the own.
    pub ahead_ns: i64,
    /// [ns] The true value lies within this of it.
    pub uncertainty_ns: u64,
}

#[derive(Debug, Clone, Copy)]
#[allow(clippy::struct_field_names, reason = "names end in their unit")]
struct Sample {
    ahead_ns: i64,
    /// Time on the way there and back. [ns]
    way_ns: u64,
    came_ns: u64,
}

impl Sample {
    /// The true offset at `now_ns` lies within this of it. [ns]
    fn uncertainty_ns(&self, now_ns: u64) -> u64 {
        self.way_ns / 2 + drifted_ns(now_ns.saturating_sub(self.came_ns))
    }
}

/// Estimates the offset.
#[derive(Debug, Default)]
pub struct ClockFilter {
    samples: Vec<Sample>,
}

impl ClockFilter {
    /// Takes in an exchange. One in which time runs backwards is ignored.
    pub fn add(&mut self, exchange: Exchange) {
        let Exchange {
            sent_ns,
            came_there_ns,
            sent_there_ns,
            came_ns,
        } = exchange;
        let (Some(there_and_back), Some(stay)) = (
            came_ns.checked_sub(sent_ns),
            sent_there_ns.checked_sub(came_there_ns),
        ) else {
            return;
        };
        // What the clocks drifted apart meanwhile looks like a longer or a shorter way, and the estimate is that of the
        // middle of the stay.
        let drifted = drifted_ns(there_and_back);
        let longest = there_and_back.saturating_add(drifted);
        let Some(way_ns) = longest.checked_sub(stay) else {
            return;
        };
        let way_ns = way_ns.saturating_add(drifted);
        let apart = |there: u64, here: u64| i128::from(there) - i128::from(here);
        let sum = apart(came_there_ns, sent_ns) + apart(sent_there_ns, came_ns);
        let Ok(ahead_ns) = i64::try_from(sum / 2) else {
            return;
        };
        let new = Sample {
            ahead_ns,
            way_ns,
            came_ns,
        };
        let apart_ns = |sample: &Sample| sample.ahead_ns.abs_diff(ahead_ns);
        let within_ns = |sample: &Sample| sample.uncertainty_ns(came_ns) + way_ns / 2;
        // A clock of a computer that was suspended has jumped: nothing from before holds.
        if (self.samples.iter()).any(|sample| apart_ns(sample) > within_ns(sample)) {
            self.samples.clear();
        }
        self.samples.push(new);
        if self.samples.len() > KEPT {
            // Evicts the least certain one: after a way that was cut all new exchanges were long under way.
            let worst = (0..self.samples.len())
                .max_by_key(|index| self.samples[*index].uncertainty_ns(came_ns));
            worst.map(|index| self.samples.swap_remove(index));
        }
    }

    /// The estimate at `now_ns` of the own clock; `None` before the first exchange.
    #[must_use]
    pub fn offset(&self, now_ns: u64) -> Option<Offset> {
        let judged = self.samples.iter().map(|sample| Offset {
            ahead_ns: sample.ahead_ns,
            uncertainty_ns: sample.uncertainty_ns(now_ns),
        });
        judged.min_by_key(|offset| offset.uncertainty_ns)
    }
}

/// How far two clocks may have drifted apart. [ns]
fn drifted_ns(since_ns: u64) -> u64 {
    (since_ns.to_f64() * DRIFT).ceil().to_u64()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// An exchange with these ways out and back, with a clock that is ahead.
    fn exchange(at_ns: u64, ahead_ns: i64, out_ns: u64, back_ns: u64) -> Exchange {
        let there = |ns: u64| ns.saturating_add_signed(ahead_ns);
        let came = at_ns + out_ns;
        let left = came + 3_000_000;
        Exchange {
            sent_ns: at_ns,
            came_there_ns: there(came),
            sent_there_ns: there(left),
            came_ns: left + back_ns,
        }
    }

    proptest! {
        /// Whatever the ways are, the true offset is within the uncertainty.
        #[test]
        fn the_truth_is_within_the_uncertainty(
            ahead_ns in -4_000_000_000_000_i64..4_000_000_000_000,
            ways in prop::collection::vec((0_u64..50_000_000, 0_u64..50_000_000), 1..40),
        ) {
            let mut filter = ClockFilter::default();
            let mut at_ns = 5_000_000_000_000;
            for (out_ns, back_ns) in ways {
                let exchange = exchange(at_ns, ahead_ns, out_ns, back_ns);
                filter.add(exchange);
                at_ns = exchange.came_ns + 100_000_000;
                let offset = filter.offset(exchange.came_ns).expect("an exchange");
                let error_ns = offset.ahead_ns.abs_diff(ahead_ns);
                prop_assert!(error_ns <= offset.uncertainty_ns + 1, "{offset:?}");
            }
        }

        /// And where one clock runs faster than the other, too, up to the drift that is allowed for.
        #[test]
        fn a_clock_that_drifts_stays_within_the_uncertainty(
            ppm in -900_i64..=900,
            out_ns in 0_u64..9_000_000,
            stay_ns in 0_u64..10_000_000_000,
        ) {
            let mut filter = ClockFilter::default();
            let ahead = |at_ns: u64| i64::try_from(at_ns / 1_000_000).unwrap_or(0) * ppm;
            for n in 0..60_u64 {
                let at_ns = 100_000_000_000 + n * 100_000_000;
                // Only the first way is short.
                let way_ns = if n == 0 { out_ns } else { out_ns + 20_000_000 };
                // An old beat is answered again and again while one direction is silent.
                let (came, left) = (at_ns + way_ns, at_ns + way_ns + stay_ns);
                let there = |ns: u64| ns.saturating_add_signed(ahead(ns));
                let exchange = Exchange {
                    sent_ns: at_ns,
                    came_there_ns: there(came),
                    sent_there_ns: there(left),
                    came_ns: left + way_ns / 3,
                };
                filter.add(exchange);
                let now_ns = exchange.came_ns;
                let offset = filter.offset(now_ns).expect("an exchange");
                let error_ns = offset.ahead_ns.abs_diff(ahead(now_ns));
                prop_assert!(error_ns <= offset.uncertainty_ns + 3_000, "{n}: {offset:?}, {error_ns}");
            }
        }
    }

    #[test]
    fn the_shortest_way_of_the_last_exchanges_counts() {
        let mut filter = ClockFilter::default();
        assert_eq!(filter.offset(0), None);
        for (n, way_ns) in [9_000_000, 40_000, 7_000_000].into_iter().enumerate() {
            filter.add(exchange(
                1_000_000_000 * (n as u64 + 1),
                -500,
                way_ns,
                way_ns / 2,
            ));
        }
        let offset = filter.offset(3_100_000_000).expect("exchanges");
        // 40 and 20 us on the way, and two clocks for a second.
        assert_eq!(offset.ahead_ns, -500 + 10_000);
        assert!((1_030_000..1_200_000).contains(&offset.uncertainty_ns));
        // Nothing that is long under way takes its place: neither many of them, nor for long.
        for n in 0..100 {
            filter.add(exchange(
                3_200_000_000 + 50_000_000 * n,
                -500,
                900_000_000,
                0,
            ));
        }
        let later = filter.offset(9_000_000_000).expect("exchanges");
        assert_eq!(later.ahead_ns, offset.ahead_ns);
        assert!((6_500_000..7_500_000).contains(&later.uncertainty_ns));
        let offset = filter.offset(3_100_000_000).expect("exchanges");
        // Impossible times change nothing.
        filter.add(Exchange {
            sent_ns: 10,
            came_there_ns: 5,
            sent_there_ns: 4,
            came_ns: 11,
        });
        assert_eq!(filter.offset(3_100_000_000), Some(offset));
    }

    /// The monotonic clock of a computer stands still while that is suspended.
    #[test]
    fn a_clock_that_has_jumped_is_compared_anew() {
        let mut filter = ClockFilter::default();
        filter.add(exchange(100_000_000_000, 0, 50_000, 50_000));
        filter.add(exchange(101_000_000_000, -60_000_000_000, 400_000, 400_000));
        let offset = filter.offset(101_100_000_000).expect("an exchange");
        assert_eq!(offset.ahead_ns, -60_000_000_000);
    }
}
