//! Times in the order in which they were measured, so that more can be said of them than a histogram
//! can: percentiles with intervals.

use super::distribution::Distribution;
use crate::result::latency::Figures;

/// Times of one kind in one round, in order; `None` = no answer before the deadline. [ns]
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Series {
    samples: Vec<Option<u64>>,
}

impl Series {
    /// Adds a time. [ns]
    pub fn add(&mut self, time_ns: u64) {
        self.samples.push(Some(time_ns));
    }

    /// Adds a sample without an answer.
    pub fn censor(&mut self) {
        self.samples.push(None);
    }

    /// Samples, censored ones included.
    #[must_use]
    pub fn len(&self) -> usize {
        self.samples.len()
    }

    /// True without samples.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.samples.is_empty()
    }

    /// The figures. A censored sample ranks at `deadline_ns`.
    #[must_use]
    pub fn figures(&self, deadline_ns: u64) -> Figures {
        let mut distribution = Distribution::new();
        for sample in &self.samples {
            match sample {
                Some(time_ns) => distribution.add(*time_ns),
                None => distribution.censor(deadline_ns),
            }
        }
        distribution.figures()
    }

    /// The times, censored ones at `deadline_ns`. [ns]
    #[must_use]
    pub fn times_ns(&self, deadline_ns: u64) -> Vec<u64> {
        let time_ns = |sample: &Option<u64>| sample.unwrap_or(deadline_ns);
        self.samples.iter().map(time_ns).collect()
    }
}

impl FromIterator<Option<u64>> for Series {
    fn from_iter<I: IntoIterator<Item = Option<u64>>>(samples: I) -> Self {
        Self {
            samples: samples.into_iter().collect(),
        }
    }
}
