//! Intervals of percentiles by resampling: first the rounds, then the samples within each.
//!
//! Rounds differ by more than their samples say (another start, another minute of the machine), so
//! the rounds are drawn, too (Davison and Hinkley, Bootstrap Methods and their Application, 1997,
//! section 3.8). Times of consecutive scans resemble each other: they are drawn in blocks (Künsch
//! 1989). The seed is a constant, so the same samples always give the same interval.

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use zeronav_casts::Cast;
use zeronav_observe::statistics::{median, percentile};

/// Resamplings. The ends of a 95 % interval are the 10th from either end.
const RESAMPLES: usize = 400;

/// Share of the resamplings beyond either end.
const TAIL: f64 = 0.025;

/// Seed of every interval.
const SEED: u64 = 0x5eed;

/// The percentiles that have intervals.
pub const QUANTILES: [f64; 3] = [0.50, 0.90, 0.99];

/// 95 % intervals of [`QUANTILES`] of several rounds: each is the median over the rounds of the
/// nearest-rank percentile of a round. `block` is the number of consecutive samples that are drawn
/// together. `None` without two samples in some round. [ns]
#[must_use]
pub fn intervals(rounds: &[Vec<u64>], block: usize) -> Option<[[f64; 2]; 3]> {
    let rounds: Vec<&Vec<u64>> = rounds.iter().filter(|round| !round.is_empty()).collect();
    if rounds.iter().all(|round| round.len() < 2) {
        return None;
    }
    let mut random = Pcg64Mcg::seed_from_u64(SEED);
    let mut values: [Vec<f64>; 3] = Default::default();
    let mut drawn = Vec::new();
    for _ in 0..RESAMPLES {
        let mut of_rounds: [Vec<f64>; 3] = Default::default();
        for _ in &rounds {
            let round = rounds[random.random_range(0..rounds.len())];
            draw(round, block, &mut random, &mut drawn);
            for (values, quantile) in of_rounds.iter_mut().zip(QUANTILES) {
                values.extend(percentile(&mut drawn, quantile).map(Cast::to_f64));
            }
        }
        for (values, of_rounds) in values.iter_mut().zip(of_rounds) {
            values.extend(median(of_rounds));
        }
    }
    Some(values.map(|values| ends(values).unwrap_or_default()))
}

/// As many samples as `from` has, in blocks of `block` that begin anywhere; the end is followed by
/// the beginning.
pub fn draw(from: &[u64], block: usize, random: &mut Pcg64Mcg, into: &mut Vec<u64>) {
    into.clear();
    let n = from.len();
    while into.len() < n {
        let at = random.random_range(0..n);
        let length = block.clamp(1, n - into.len());
        into.extend((0..length).map(|step| from[(at + step) % n]));
    }
}

/// The ends of the middle 95 % of `values`; `None` without values.
pub fn ends(mut values: Vec<f64>) -> Option<[f64; 2]> {
    values.sort_by(f64::total_cmp);
    let beyond = (values.len().to_f64() * TAIL).to_usize();
    let low = values.get(beyond)?;
    let high = values.get(values.len() - 1 - beyond)?;
    Some([*low, *high])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Exponential times with a mean of 1 ms, and a factor that each round has for itself.
    fn rounds(seed: u64, n: usize, spread: f64) -> Vec<Vec<u64>> {
        let mut random = Pcg64Mcg::seed_from_u64(seed);
        let mut round = |_| {
            let factor = (spread * (random.random::<f64>() - 0.5)).exp();
            let mut time = || {
                let time_ns = -1.0e6 * (1.0 - random.random::<f64>()).ln() * factor;
                time_ns.round().to_u64()
            };
            (0..n).map(|_| time()).collect()
        };
        (0..3).map(&mut round).collect()
    }

    #[test]
    fn the_interval_holds_the_true_median_about_as_often_as_it_says() {
        let true_ns = 1.0e6 * core::f64::consts::LN_2;
        let holds = |seed: &u64| {
            let [p50, ..] = intervals(&rounds(*seed, 40, 0.0), 1).expect("an interval");
            (p50[0]..=p50[1]).contains(&true_ns)
        };
        let n = (0..200).filter(holds).count();
        // 95 %, and a little more because three rounds are drawn from three.
        assert!((184..200).contains(&n), "{n} of 200");
    }

    #[test]
    fn rounds_that_differ_widen_the_interval() {
        let width = |spread| {
            let [p50, ..] = intervals(&rounds(7, 200, spread), 1).expect("an interval");
            p50[1] - p50[0]
        };
        assert!(width(2.0) > 2.0 * width(0.0));
    }

    #[test]
    fn the_same_samples_give_the_same_interval_and_one_sample_gives_none() {
        let samples = rounds(1, 30, 0.5);
        assert_eq!(intervals(&samples, 4), intervals(&samples, 4));
        assert_eq!(intervals(&[vec![5], vec![]], 1), None);
        assert_eq!(intervals(&[], 1), None);
        let equal = intervals(&[vec![5, 5, 5]], 10).expect("an interval");
        assert_eq!(equal, [[5.0, 5.0]; 3]);
    }

    #[test]
    fn blocks_keep_neighbours_together() {
        let mut random = Pcg64Mcg::seed_from_u64(3);
        let from: Vec<u64> = (0..100).collect();
        let mut drawn = Vec::new();
        draw(&from, 10, &mut random, &mut drawn);
        assert_eq!(drawn.len(), 100);
        let follows = |pair: &&[u64]| pair[1] == (pair[0] + 1) % 100;
        assert!(drawn.windows(2).filter(follows).count() >= 90);
    }
}
