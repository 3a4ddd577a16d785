//! Gaussian noise of ranges, drawn from the seed of the run.

use core::f64::consts::TAU;
use rand::{RngExt as _, SeedableRng as _};
use rand_pcg::Pcg64Mcg;

/// The noise of one lidar.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RangeNoise {
    seed: u64,
    sigma_m: f64,
}

/// The noise of one scan, beam after beam.
#[derive(Debug, Clone)]
pub struct ScanNoise {
    rng: Pcg64Mcg,
    sigma_m: f64,
    second_m: Option<f64>,
}

impl RangeNoise {
    /// Noise with standard deviation `sigma_m` (>= 0); 0 is no noise.
    #[must_use]
    pub const fn new(seed: u64, sigma_m: f64) -> Self {
        Self { seed, sigma_m }
    }

    /// The noise of scan `scan_index`: equal for equal seed and scan, whatever was drawn before
    /// and whatever there was to see.
    #[must_use]
    pub fn of_scan(&self, scan_index: u64) -> ScanNoise {
        let mut bytes = [0; 16];
        bytes[..8].copy_from_slice(&mix(self.seed).to_le_bytes());
        bytes[8..].copy_from_slice(&mix(!scan_index).to_le_bytes());
        ScanNoise {
            rng: Pcg64Mcg::from_seed(bytes),
            sigma_m: self.sigma_m,
            second_m: None,
        }
    }
}

impl ScanNoise {
    /// Error of the next range. [m] They come in pairs (Box and Muller, "A Note on the Generation
    /// of Random Normal Deviates", 1958).
    pub fn next_m(&mut self) -> f64 {
        if self.sigma_m <= 0.0 {
            return 0.0;
        }
        if let Some(second_m) = self.second_m.take() {
            return second_m;
        }
        // 1 - [0, 1) leaves out the 0 whose logarithm is infinite.
        let radius_m = self.sigma_m * (-2.0 * (1.0 - self.rng.random::<f64>()).ln()).sqrt();
        let (sin, cos) = (TAU * self.rng.random::<f64>()).sin_cos();
        self.second_m = Some(radius_m * sin);
        radius_m * cos
    }
}

/// Spreads neighbouring numbers over all bits: the finaliser of `SplitMix64` (Steele, Lea, Flood,
/// "Fast Splittable Pseudorandom Number Generators", 2014).
const fn mix(seed: u64) -> u64 {
    let mut z = seed.wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_are_normal_with_mean_zero_and_the_given_sigma() {
        let seed = 42;
        let noise = RangeNoise::new(seed, 0.02);
        let n = 200_000.0;
        let (mut sum, mut squares, mut beyond, mut products) = (0.0, 0.0, 0.0, 0.0);
        let mut last = 0.0;
        for scan in 1..=200 {
            let mut errors = noise.of_scan(scan);
            for _ in 0..1000 {
                let error_m = errors.next_m();
                sum += error_m;
                squares += error_m * error_m;
                products += error_m * last;
                beyond += f64::from(u8::from(error_m.abs() > 0.04));
                last = error_m;
            }
        }
        let (mean, sigma) = (sum / n, (squares / n).sqrt());
        let (tail, correlation) = (beyond / n, products / squares);
        eprintln!("seed {seed}: {mean} {sigma} {tail} {correlation}");
        // Five standard errors of each estimate.
        assert!(mean.abs() < 5.0 * 0.02 / n.sqrt(), "{mean}");
        assert!(
            (sigma - 0.02).abs() < 5.0 * 0.02 / (2.0 * n).sqrt(),
            "{sigma}"
        );
        assert!(
            (tail - 0.0455).abs() < 5.0 * (0.0455_f64 * 0.9545 / n).sqrt(),
            "{tail}"
        );
        assert!(correlation.abs() < 5.0 / n.sqrt(), "{correlation}");
    }

    #[test]
    fn the_first_errors_of_neighbouring_scans_and_seeds_are_not_alike() {
        let first = |seed, scan| RangeNoise::new(seed, 1.0).of_scan(scan).next_m();
        let n = 4000_u32;
        for step in [(0, 1), (1, 0), (1, 1)] {
            let product: f64 = (0..u64::from(n))
                .map(|i| first(i, 7 * i) * first(i + step.0, 7 * i + step.1))
                .sum::<f64>()
                / f64::from(n);
            assert!(
                product.abs() < 5.0 / f64::from(n).sqrt(),
                "{step:?}: {product}"
            );
        }
    }

    #[test]
    fn no_sigma_is_no_noise() {
        let mut errors = RangeNoise::new(1, 0.0).of_scan(1);
        assert_eq!((0..9).map(|_| errors.next_m()).sum::<f64>().to_bits(), 0);
    }
}
