//! Chance, drawn from the seed of the run: the same on every machine.
//!
//! Every source of noise has a stream of its own, and every scan or stretch of time a place in it,
//! so what one source draws does not depend on what another saw or drew. The generator is
//! PCG's (`rand_pcg`), and logarithm, sine and cosine come from `libm`, which computes them alike
//! everywhere; those of the system's library differ in the last bit from machine to machine.

use core::f64::consts::TAU;
use rand::{RngExt as _, SeedableRng as _};
use rand_pcg::Pcg64Mcg;

/// A source of noise.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u64)]
pub enum Stream {
    /// Errors of ranges.
    Range = 0,
    /// Which returns get lost.
    Dropout = 1,
    /// Which returns come from something nearer, and from where.
    Short = 2,
    /// Which beams mix both sides of an edge, and how.
    Edge = 3,
    /// Errors of odometry.
    Odometry = 4,
    /// How much the wheels slip.
    Slip = 5,
}

/// The numbers at one place of a stream.
#[derive(Debug, Clone)]
pub struct Draws {
    rng: Pcg64Mcg,
    second: Option<f64>,
}

impl Draws {
    /// The numbers at place `index` of `stream`: equal for equal seed, stream and place, whatever
    /// was drawn before.
    #[must_use]
    pub fn new(seed: u64, stream: Stream, index: u64) -> Self {
        // Seed, stream and place are in every bit of both halves: with the seed in one half alone
        // the first numbers of all its places would lean to one side.
        let key = mix(mix(mix(seed) ^ stream as u64) ^ index);
        let mut bytes = [0; 16];
        bytes[..8].copy_from_slice(&mix(key).to_le_bytes());
        bytes[8..].copy_from_slice(&mix(!key).to_le_bytes());
        Self {
            rng: Pcg64Mcg::from_seed(bytes),
            second: None,
        }
    }

    /// Uniform in [0, 1).
    pub fn uniform(&mut self) -> f64 {
        self.rng.random()
    }

    /// Normal with mean 0 and deviation 1. They come in pairs (Box and Muller, "A Note on the
    /// Generation of Random Normal Deviates", 1958).
    pub fn normal(&mut self) -> f64 {
        if let Some(second) = self.second.take() {
            return second;
        }
        // 1 - [0, 1) leaves out the 0 whose logarithm is infinite.
        let radius = (-2.0 * libm::log(1.0 - self.uniform())).sqrt();
        let (sin, cos) = libm::sincos(TAU * self.uniform());
        self.second = Some(radius * sin);
        radius * cos
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
    fn draws_are_normal_with_mean_zero_and_deviation_one() {
        let seed = 42;
        let n = 200_000.0;
        let (mut sum, mut squares, mut beyond, mut products) = (0.0, 0.0, 0.0, 0.0);
        let mut last = 0.0;
        for scan in 1..=200 {
            let mut draws = Draws::new(seed, Stream::Range, scan);
            for _ in 0..1000 {
                let error = draws.normal();
                sum += error;
                squares += error * error;
                products += error * last;
                beyond += f64::from(u8::from(error.abs() > 2.0));
                last = error;
            }
        }
        let (mean, sigma) = (sum / n, (squares / n).sqrt());
        let (tail, correlation) = (beyond / n, products / squares);
        eprintln!("seed {seed}: {mean} {sigma} {tail} {correlation}");
        // Five standard errors of each estimate.
        assert!(mean.abs() < 5.0 / n.sqrt(), "{mean}");
        assert!((sigma - 1.0).abs() < 5.0 / (2.0 * n).sqrt(), "{sigma}");
        assert!(
            (tail - 0.0455).abs() < 5.0 * (0.0455_f64 * 0.9545 / n).sqrt(),
            "{tail}"
        );
        assert!(correlation.abs() < 5.0 / n.sqrt(), "{correlation}");
    }

    #[test]
    fn neighbouring_places_seeds_and_streams_are_not_alike() {
        let first = |seed, stream, place| Draws::new(seed, stream, place).normal();
        let n = 4000_u32;
        let cases = [
            (0, Stream::Range, 1),
            (1, Stream::Range, 0),
            (1, Stream::Range, 1),
            (0, Stream::Dropout, 0),
            (0, Stream::Slip, 0),
        ];
        for (seed_step, stream, step) in cases {
            let product: f64 = (0..u64::from(n))
                .map(|i| {
                    first(i, Stream::Range, 7 * i) * first(i + seed_step, stream, 7 * i + step)
                })
                .sum::<f64>()
                / f64::from(n);
            assert!(
                product.abs() < 5.0 / f64::from(n).sqrt(),
                "{seed_step} {stream:?} {step}: {product}"
            );
        }
    }

    #[test]
    fn the_first_numbers_of_the_places_of_a_seed_do_not_lean_to_one_side() {
        let (n_seeds, n_places) = (200_u32, 400_u32);
        let mut squares = [0.0; 2];
        for seed in 0..u64::from(n_seeds) {
            let mut sums = [0.0; 2];
            for place in 1..=u64::from(n_places) {
                let mut draws = Draws::new(seed, Stream::Odometry, place * 20_000_000);
                for sum in &mut sums {
                    *sum += draws.normal();
                }
            }
            for (square, sum) in squares.iter_mut().zip(sums) {
                *square += sum * sum / f64::from(n_seeds * n_places);
            }
        }
        // Variance of a sum of independent numbers; five standard errors.
        for square in squares {
            assert!(
                (square - 1.0).abs() < 5.0 * (2.0 / 200.0_f64).sqrt(),
                "{squares:?}"
            );
        }
    }

    #[test]
    fn draws_are_the_same_on_every_machine() {
        // Bits, not roundings of them, of another program that follows the same definition.
        let mut draws = Draws::new(7, Stream::Edge, 3);
        let found = [draws.uniform(), draws.normal(), draws.normal()].map(f64::to_bits);
        assert_eq!(found, GOLDEN, "{found:#x?}");
    }

    const GOLDEN: [u64; 3] = [
        0x3fe1_8b9b_5e4e_9ee8,
        0x3fd1_6c20_ebed_b34e,
        0xbff0_735b_29b3_64dc,
    ];
}
