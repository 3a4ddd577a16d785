//! Percentiles and medians; nothing else in the project defines one.
//!
//! - A **percentile** is of the samples of a run or a round: the nearest rank, a sample that was measured.
//!   Of `n` samples in order it is the one at rank `ceil(share * n)`, the first for a share of 0.
//! - A **median** is of a few values, such as rounds or repetitions: the middle one in order, the mean of the
//!   middle two of an even number.
//! - **Quartiles** are the spread around such a median: linear between the values in order, as the median
//!   of an even number is (Hyndman and Fan 1996, definition 7).

use core::cmp::Ordering;
use zeronav_casts::Cast;

/// What can be put in order.
pub trait Sample: Copy {
    /// Which of the two comes first.
    fn order(&self, other: &Self) -> Ordering;
}

impl Sample for u64 {
    fn order(&self, other: &Self) -> Ordering {
        self.cmp(other)
    }
}

impl Sample for f64 {
    fn order(&self, other: &Self) -> Ordering {
        self.total_cmp(other)
    }
}

/// The percentile for `share`, from 0 to 1: the sample at the nearest rank. `samples` are reordered.
/// `None` without samples.
pub fn percentile<T: Sample>(samples: &mut [T], share: f64) -> Option<T> {
    let last = samples.len().checked_sub(1)?;
    let (_, value, _) = samples.select_nth_unstable_by(place(last + 1, share), T::order);
    Some(*value)
}

/// Place of the nearest rank among `n` samples in order, at least one.
fn place(n: usize, share: f64) -> usize {
    // Shares such as 0.55 are not exact: 20 of them are not more than 11.
    let rank = (n.to_f64() * share - 1.0e-9).ceil().max(1.0).to_usize();
    rank.min(n) - 1
}

/// The median; `None` without values.
#[must_use]
pub fn median(values: impl IntoIterator<Item = f64>) -> Option<f64> {
    quartiles(values).map(|[_, median, _]| median)
}

/// The first quartile, the median and the third quartile; `None` without values.
#[must_use]
pub fn quartiles(values: impl IntoIterator<Item = f64>) -> Option<[f64; 3]> {
    let mut sorted: Vec<f64> = values.into_iter().collect();
    sorted.sort_by(f64::total_cmp);
    let last = sorted.len().checked_sub(1)?;
    Some([1, 2, 3].map(|quarter| {
        let (at, rest) = (quarter * last / 4, quarter * last % 4);
        match (rest, sorted[at], sorted[(at + 1).min(last)]) {
            (0, low, _) => low,
            (2, low, high) => f64::midpoint(low, high),
            (rest, low, high) => low + (high - low) * if rest == 1 { 0.25 } else { 0.75 },
        }
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_percentile_is_the_sample_at_the_nearest_rank() {
        let mut samples: Vec<u64> = (1..=100).rev().collect();
        for (share, expected) in [(0.0, 1), (0.5, 50), (0.55, 55), (0.99, 99), (1.0, 100)] {
            assert_eq!(percentile(&mut samples, share), Some(expected), "{share}");
        }
        assert_eq!(percentile(&mut [7], 0.99), Some(7));
        assert_eq!(percentile(&mut [4.0, 1.0, 3.0, 2.0], 0.5), Some(2.0));
        let mut twenty: Vec<u64> = (1..=20).collect();
        assert_eq!(
            percentile(&mut twenty, 0.55),
            Some(11),
            "as 0.55 is not exact"
        );
        assert_eq!(percentile::<u64>(&mut [], 0.5), None);
    }

    #[test]
    fn a_median_is_the_middle_and_the_mean_of_the_middle_two() {
        assert_eq!(median([3.0, 1.0, 2.0]), Some(2.0));
        assert_eq!(median([4.0, 1.0, 3.0, 2.0]), Some(2.5));
        assert_eq!(median([7.0]), Some(7.0));
        assert_eq!(median([]), None);
    }

    #[test]
    fn quartiles_lie_between_values_as_the_median_does() {
        assert_eq!(quartiles([4.0, 1.0, 3.0, 2.0]), Some([1.75, 2.5, 3.25]));
        assert_eq!(quartiles([1.0, 2.0, 3.0, 4.0, 5.0]), Some([2.0, 3.0, 4.0]));
        assert_eq!(quartiles([1.0, 2.0, 3.0]), Some([1.5, 2.0, 2.5]));
        assert_eq!(quartiles([]), None);
    }
}
