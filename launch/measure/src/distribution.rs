//! A distribution of times, honest about how many there are and how many never came.

use crate::result::latency::Figures;
use hdrhistogram::Histogram;
use zeronav_casts::Cast;
pub use zeronav_observe::hop_chain::to_us;

/// Times and the samples that found no answer before their deadline.
#[derive(Debug, Clone)]
pub struct Distribution {
    histogram: Histogram<u64>,
    censored: u64,
}

/// Longest time that is told apart. [ns]
const LONGEST_NS: u64 = 600_000_000_000;

impl Default for Distribution {
    fn default() -> Self {
        Self::new()
    }
}

impl Distribution {
    /// An empty distribution, exact to 0.1 %.
    ///
    /// # Panics
    /// Never: the bounds are constants that the histogram accepts.
    #[must_use]
    pub fn new() -> Self {
        let histogram = Histogram::new_with_bounds(1, LONGEST_NS, 3)
            .unwrap_or_else(|error| unreachable!("constant bounds: {error}"));
        Self {
            histogram,
            censored: 0,
        }
    }

    /// Adds a time. [ns]
    pub fn add(&mut self, time_ns: u64) {
        self.histogram
            .saturating_record(time_ns.clamp(1, LONGEST_NS));
    }

    /// Adds a sample without an answer; it ranks at its deadline. [ns]
    pub fn censor(&mut self, deadline_ns: u64) {
        self.censored += 1;
        self.add(deadline_ns);
    }

    /// Samples, censored ones included.
    #[must_use]
    pub fn len(&self) -> u64 {
        self.histogram.len()
    }

    /// True without samples.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Interval of the quantile `q` at 95 % [us]: the samples whose ranks are 1.96 standard
    /// deviations of the binomial distribution away. Samples count as independent. `None` when
    /// there are too few.
    #[must_use]
    pub fn interval_us(&self, q: f64) -> Option<[f64; 2]> {
        let n = self.len().to_f64();
        let half = 1.96 * (n * q * (1.0 - q)).sqrt();
        let ranks = [(n * q - half).floor(), (n * q + half).ceil() + 1.0];
        if ranks[0] < 1.0 || ranks[1] > n {
            return None;
        }
        let at = |rank: f64| self.histogram.value_at_quantile(rank / n);
        Some(ranks.map(|rank| to_us(at(rank))))
    }

    /// The figures.
    #[must_use]
    pub fn figures(&self) -> Figures {
        let us = |time_ns: u64| Some(to_us(time_ns));
        if self.is_empty() {
            return Figures::default();
        }
        Figures {
            n: self.len(),
            censored: self.censored,
            p50_us: us(self.histogram.value_at_quantile(0.50)),
            p90_us: us(self.histogram.value_at_quantile(0.90)),
            p99_us: us(self.histogram.value_at_quantile(0.99)),
            max_us: us(self.histogram.max()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(value: Option<f64>, expected: f64) {
        let value = value.expect("a figure");
        assert!(
            (value - expected).abs() <= expected * 0.002,
            "{value} is not {expected}"
        );
    }

    #[test]
    fn percentiles_are_nearest_rank_and_censored_samples_rank_worst() {
        let mut distribution = Distribution::new();
        for time_us in 1..=99_u64 {
            distribution.add(time_us * 1000);
        }
        distribution.censor(5_000_000_000);
        let figures = distribution.figures();
        assert_eq!((figures.n, figures.censored), (100, 1));
        near(figures.p50_us, 50.0);
        near(figures.p90_us, 90.0);
        near(figures.p99_us, 99.0);
        near(figures.max_us, 5_000_000.0);
    }

    #[test]
    fn rounds_give_the_median_of_their_percentiles_and_the_worst_of_all() {
        let round = |n, p50, max| Figures {
            n,
            censored: 1,
            p50_us: Some(p50),
            p90_us: Some(2.0 * p50),
            p99_us: Some(3.0 * p50),
            max_us: Some(max),
        };
        let three = [
            round(67, 5.0, 9.0),
            round(67, 1.0, 50.0),
            round(66, 2.0, 7.0),
        ];
        let all = Figures::of_rounds(&three);
        assert_eq!((all.n, all.censored), (200, 3));
        assert_eq!(
            (all.p50_us, all.p90_us, all.p99_us, all.max_us),
            (Some(2.0), Some(4.0), Some(6.0), Some(50.0))
        );
        let two = Figures::of_rounds(&three[..2]);
        assert_eq!(two.p50_us, Some(3.0));
        // A round without answers has no percentiles to give.
        let with_empty = Figures::of_rounds(&[Figures::default(), three[0]]);
        assert_eq!(with_empty.p50_us, Some(5.0));
    }

    #[test]
    fn percentiles_that_the_samples_do_not_support_are_not_shown() {
        for (n, shown) in [
            (1, [false, false, false]),
            (3, [true, false, false]),
            (10, [true, true, false]),
            (99, [true, true, false]),
            (100, [true, true, true]),
        ] {
            let mut distribution = Distribution::new();
            for time_us in 1..=n {
                distribution.add(1000 * time_us);
            }
            let json = serde_json::to_value(distribution.figures()).expect("JSON");
            for (name, shown) in ["p50_us", "p90_us", "p99_us"].iter().zip(shown) {
                assert_eq!(json[name].is_f64(), shown, "{name} of {n}: {json}");
            }
            assert!(json["max_us"].is_f64(), "{json}");
        }
    }

    #[test]
    fn intervals_hold_the_quantile_and_need_samples() {
        let mut distribution = Distribution::new();
        for time_us in 1..=5_u64 {
            distribution.add(time_us * 1000);
        }
        assert_eq!(distribution.interval_us(0.5), None);
        for time_us in 6..=100_u64 {
            distribution.add(time_us * 1000);
        }
        // 50 - 9.8 and 50 + 9.8, outwards, and one more.
        let [low, high] = distribution.interval_us(0.5).expect("an interval");
        near(Some(low), 40.0);
        near(Some(high), 61.0);
        assert_eq!(distribution.interval_us(0.99), None);
        assert_eq!(Distribution::new().interval_us(0.5), None);
    }

    #[test]
    fn nothing_measured_says_nothing() {
        assert_eq!(Distribution::new().figures(), Figures::default());
    }
}
