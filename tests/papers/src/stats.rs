//! Means and shares with their 95 % intervals.

use rand::{RngExt as _, SeedableRng as _};
use rand_pcg::Pcg64Mcg;
use zeronav_casts::Cast;

/// Resamples of a bootstrap.
const RESAMPLES: usize = 2_000;

/// Seed of the resampling, so that the same samples give the same interval.
const SEED: u64 = 0x0b00_75ab;

/// A mean or a share and its interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// The value.
    pub mean: f64,
    /// 95 % interval.
    pub interval: [f64; 2],
    /// Samples.
    pub n: usize,
}

/// Mean of samples with its percentile bootstrap interval (Efron 1979); `None` without a sample.
#[must_use]
pub fn mean(samples: &[f64]) -> Option<Estimate> {
    if samples.is_empty() {
        return None;
    }
    let n = samples.len();
    let mean = samples.iter().sum::<f64>() / n.to_f64();
    let mut rng = Pcg64Mcg::seed_from_u64(SEED);
    let mut means: Vec<f64> = (0..RESAMPLES)
        .map(|_| (0..n).map(|_| samples[rng.random_range(0..n)]).sum::<f64>() / n.to_f64())
        .collect();
    means.sort_by(f64::total_cmp);
    let at = |share: f64| means[(share * (RESAMPLES - 1).to_f64()).round().to_usize()];
    Some(Estimate {
        mean,
        interval: [at(0.025), at(0.975)],
        n,
    })
}

/// Share of `n` with its interval (Wilson 1927); `None` of nothing.
#[must_use]
pub fn share(hits: usize, n: usize) -> Option<Estimate> {
    const Z: f64 = 1.96;
    if n == 0 {
        return None;
    }
    let (of, p) = (n.to_f64(), hits.to_f64() / n.to_f64());
    let middle = p + Z * Z / (2.0 * of);
    let half = Z * (p * (1.0 - p) / of + Z * Z / (4.0 * of * of)).sqrt();
    Some(Estimate {
        mean: p,
        interval: [middle - half, middle + half]
            .map(|bound| (bound / (1.0 + Z * Z / of)).clamp(0.0, 1.0)),
        n,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_interval_of_wilson_is_that_of_the_textbook() {
        // Newcombe, "Two-sided confidence intervals for the single proportion" (1998): 81 of 263.
        let found = share(81, 263).unwrap();
        assert!((found.interval[0] - 0.2553).abs() < 1e-4, "{found:?}");
        assert!((found.interval[1] - 0.3662).abs() < 1e-4, "{found:?}");
        assert_eq!(share(0, 0), None);
    }

    #[test]
    fn a_bootstrap_interval_is_as_wide_as_the_normal_one() {
        let mut rng = Pcg64Mcg::seed_from_u64(1);
        let samples: Vec<f64> = (0..400).map(|_| rng.random_range(0.0..1.0)).collect();
        let found = mean(&samples).unwrap();
        // 1.96 / sqrt(12 * 400) to either side.
        let half = 0.5 * (found.interval[1] - found.interval[0]);
        assert!((0.025..0.032).contains(&half), "{found:?}");
        assert!(found.interval[0] < found.mean && found.mean < found.interval[1]);
        assert_eq!(mean(&samples), Some(found), "the same again");
        assert_eq!(mean(&[]), None);
        let one = mean(&[2.0]).unwrap();
        assert!(one.interval.iter().all(|bound| (bound - 2.0).abs() < 1e-12));
    }
}
