//! Two things measured in turn, round by round: the ratio of their medians, and how sure it is.
//!
//! What a round has in common for both (the minute, the phase of the machine) cancels in its ratio, so
//! the rounds are the samples: the mean of the logarithms of their ratios is bootstrapped over them.
//! So few samples make the percentile bootstrap too narrow; its tails are moved outwards as Hesterberg
//! does (What Teachers Should Know About the Bootstrap, The American Statistician 69, 2015, section
//! 4.3, expanded percentile interval).

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use zeronav_casts::Cast;
use zeronav_observe::statistics::{median, percentile};

/// Rounds of each side. With fewer, all ratios lie on one side of 1 by chance too often for any
/// interval over them: 1 time in 8 with four.
pub const ROUNDS: usize = 6;

/// Share of the resamplings beyond either end of a 95 % interval of so many rounds:
/// Phi(-sqrt(n / (n - 1)) t(0.975, n - 1)).
const TAIL: f64 = 0.002_431;

/// Resamplings.
const RESAMPLES: usize = 20_000;

/// Seed of every interval.
const SEED: u64 = 0x5eed;

/// The ratio of the medians of two sides.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ratio {
    /// Median of the second side over that of the first.
    pub ratio: f64,
    /// Its 95 % interval.
    pub interval: [f64; 2],
}

/// The ratio of the second side's median to the first's over rounds in which both have samples;
/// `None` with fewer than [`ROUNDS`] of them. [ns]
#[must_use]
pub fn ratio(rounds: &[(Vec<u64>, Vec<u64>)]) -> Option<Ratio> {
    let logarithms: Vec<f64> = rounds.iter().filter_map(logarithm).collect();
    let n = logarithms.len();
    if n < ROUNDS {
        return None;
    }
    let mut random = Pcg64Mcg::seed_from_u64(SEED);
    let mut means: Vec<f64> = (0..RESAMPLES)
        .map(|_| mean((0..n).map(|_| logarithms[random.random_range(0..n)]), n))
        .collect();
    means.sort_by(f64::total_cmp);
    let beyond = (RESAMPLES.to_f64() * TAIL).to_usize();
    let [low, high] = [beyond, RESAMPLES - 1 - beyond].map(|place| means[place].exp());
    Some(Ratio {
        ratio: mean(logarithms.iter().copied(), n).exp(),
        interval: [low, high],
    })
}

/// Logarithm of the ratio of the medians of a round; `None` without samples, and where a median is 0.
fn logarithm((first, second): &(Vec<u64>, Vec<u64>)) -> Option<f64> {
    let middle = |times_ns: &[u64]| {
        let middle_ns = p50_ns(times_ns).filter(|middle_ns| *middle_ns > 0.0);
        middle_ns.map(f64::ln)
    };
    Some(middle(second)? - middle(first)?)
}

/// The 50th percentile of a round; `None` without samples. [ns]
fn p50_ns(times_ns: &[u64]) -> Option<f64> {
    percentile(&mut times_ns.to_vec(), 0.5).map(Cast::to_f64)
}

fn mean(values: impl Iterator<Item = f64>, n: usize) -> f64 {
    values.sum::<f64>() / n.to_f64()
}

/// Median over the rounds of the medians of one side; `None` without samples. [ns]
pub fn middle_ns<'a>(rounds: impl Iterator<Item = &'a Vec<u64>>) -> Option<f64> {
    median(rounds.filter_map(|times_ns| p50_ns(times_ns)))
}

impl Ratio {
    /// True when the interval does not tell the ratio from 1.
    #[must_use]
    pub fn is_no_difference(&self) -> bool {
        self.interval[0] <= 1.0 && 1.0 <= self.interval[1]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rounds of `n` times with a long tail. Each round has a pace of its own, which both sides share,
    /// and a little that they do not.
    fn rounds(seed: u64, rounds: usize, n: usize, factor: f64) -> Vec<(Vec<u64>, Vec<u64>)> {
        let mut random = Pcg64Mcg::seed_from_u64(seed);
        let mut uniform = move || random.random::<f64>();
        let mut round = || {
            let pace = (uniform() - 0.5).exp();
            let mut side = |factor: f64| -> Vec<u64> {
                let own = (0.1 * (uniform() - 0.5)).exp();
                let mut time = || {
                    let tail = -0.3 * (1.0 - uniform()).ln();
                    (1.0e6 * factor * pace * own * (1.0 + tail))
                        .round()
                        .to_u64()
                };
                (0..n).map(|_| time()).collect()
            };
            (side(1.0), side(factor))
        };
        (0..rounds).map(|_| round()).collect()
    }

    #[test]
    fn two_equal_sides_differ_as_seldom_as_the_interval_says() {
        let differ = |seed: &u64| {
            let ratio = ratio(&rounds(*seed, ROUNDS, 5, 1.0)).expect("a ratio");
            !ratio.is_no_difference()
        };
        let wrong = (0..400).filter(differ).count();
        // 5 % of 400 are 20, with a standard deviation of 4.4.
        assert!((7..=36).contains(&wrong), "{wrong} of 400");
    }

    #[test]
    fn a_difference_is_found_and_the_true_ratio_lies_in_the_interval() {
        let (mut found, mut holds) = (0, 0);
        for seed in 0..200 {
            let ratio = ratio(&rounds(seed, ROUNDS, 5, 1.5)).expect("a ratio");
            found += u32::from(!ratio.is_no_difference() && ratio.ratio > 1.0);
            holds += u32::from((ratio.interval[0]..=ratio.interval[1]).contains(&1.5));
        }
        assert!(found >= 190, "{found} of 200");
        assert!((178..=199).contains(&holds), "{holds} of 200");
    }

    #[test]
    fn swapped_sides_give_the_inverse_and_too_few_rounds_nothing() {
        let there = rounds(3, ROUNDS, 5, 1.2);
        let back: Vec<_> = there.iter().cloned().map(|(a, b)| (b, a)).collect();
        let (there, back) = (
            ratio(&there).expect("a ratio"),
            ratio(&back).expect("a ratio"),
        );
        assert!((there.ratio * back.ratio - 1.0).abs() < 1.0e-12);
        assert_eq!(ratio(&rounds(3, ROUNDS - 1, 5, 1.0)), None);
        let mut with_empty = rounds(3, ROUNDS, 5, 1.0);
        with_empty[2].1.clear();
        assert_eq!(ratio(&with_empty), None);
        assert_eq!(ratio(&[]), None);
        assert_eq!(ratio(&vec![(vec![0, 0], vec![5, 5]); ROUNDS]), None);
    }
}
