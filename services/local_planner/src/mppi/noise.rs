//! Noise for the samples: drawn once, paired differently in every cycle.
//!
//! Drawing 2000 x 56 x 2 normal numbers takes longer than all the rest of a cycle. The rows of the
//! pool are drawn at the start; a cycle pairs a row of speeds with another row of yaw rates and
//! turns signs, so it still sees sequences that it has not seen before. Every row is a first-order
//! autoregressive process over knots that lie some steps apart: with white noise the samples stay
//! near their mean, and what is left of it shakes the wheels (Vlahov, Gibson, Fan, Spieler, Agha,
//! Theodorou, "Low Frequency Sampling in Model Predictive Path Integral Control", RA-L 2024).
//!
//! A normal number is a sum of twelve uniform ones: no function of the platform's mathematics takes
//! part, so all machines draw the same, and none is beyond six standard deviations.

use super::batch::{LANES, Lanes};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg32;
use zeronav_casts::Cast;

/// Steps from knot to knot.
pub(crate) const KNOT_STEPS: usize = 4;

/// Correlation of neighbouring knots.
const CORRELATION: f32 = 0.7;

/// The pool: rows of [`LANES`] samples.
#[derive(Debug, Clone)]
pub(crate) struct Noise {
    random: Pcg32,
    /// Rows x knots, with mean 0 and variance 1.
    speeds: Vec<Lanes>,
    yaw_rates: Vec<Lanes>,
    knots: usize,
    rows: usize,
    /// How this cycle pairs the rows.
    shift: usize,
    signs: (f32, f32),
}

impl Noise {
    /// Draws a pool of `rows x LANES` sequences of `steps`.
    pub(crate) fn new(seed: u64, rows: usize, steps: usize) -> Self {
        let mut random = Pcg32::seed_from_u64(seed);
        let (rows, knots) = (rows.max(1), steps / KNOT_STEPS + 2);
        let speeds = draw(&mut random, rows, knots);
        let yaw_rates = draw(&mut random, rows, knots);
        Self {
            random,
            speeds,
            yaw_rates,
            knots,
            rows,
            shift: 0,
            signs: (1.0, 1.0),
        }
    }

    /// Rows of samples.
    pub(crate) const fn rows(&self) -> usize {
        self.rows
    }

    /// Another pairing.
    pub(crate) fn shuffle(&mut self) {
        self.shift = self.random.random_range(0..self.rows);
        let mut sign = || {
            if self.random.random::<bool>() {
                1.0
            } else {
                -1.0
            }
        };
        self.signs = (sign(), sign());
    }

    /// Noise of the speeds and the yaw rates of a row at a step, between its knots.
    pub(crate) fn at(&self, row: usize, step: usize, speeds: &mut Lanes, yaw_rates: &mut Lanes) {
        let (knot, into) = (step / KNOT_STEPS, step % KNOT_STEPS);
        let share = into.to_f32() / KNOT_STEPS.to_f32();
        let other = (row + self.shift) % self.rows;
        blend(
            &self.speeds[row * self.knots + knot..],
            share,
            self.signs.0,
            speeds,
        );
        blend(
            &self.yaw_rates[other * self.knots + knot..],
            share,
            self.signs.1,
            yaw_rates,
        );
    }
}

/// Between two knots, times a sign.
fn blend(knots: &[Lanes], share: f32, sign: f32, to: &mut Lanes) {
    for ((to, from), next) in to.iter_mut().zip(&knots[0]).zip(&knots[1]) {
        *to = sign * (from + (next - from) * share);
    }
}

fn draw(random: &mut Pcg32, rows: usize, knots: usize) -> Vec<Lanes> {
    let fresh = (1.0 - CORRELATION * CORRELATION).sqrt();
    let mut pool = vec![[0.0; LANES]; rows * knots];
    for row in pool.chunks_exact_mut(knots) {
        let mut last = [0.0; LANES];
        for (knot, lanes) in row.iter_mut().enumerate() {
            for (lane, last) in lanes.iter_mut().zip(&mut last) {
                *lane = if knot == 0 {
                    normal(random)
                } else {
                    CORRELATION * *last + fresh * normal(random)
                };
                *last = *lane;
            }
        }
    }
    pool
}

/// A number with mean 0 and variance 1.
fn normal(random: &mut Pcg32) -> f32 {
    (0..12).map(|_| random.random::<f32>()).sum::<f32>() - 6.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_pool_is_normal_and_the_same_every_time() {
        let noise = Noise::new(3, 50, 56);
        let all: Vec<f64> = noise
            .speeds
            .iter()
            .flatten()
            .map(|n| f64::from(*n))
            .collect();
        let count = f64::from(u32::try_from(all.len()).expect("few"));
        let mean = all.iter().sum::<f64>() / count;
        let variance = all.iter().map(|n| n * n).sum::<f64>() / count;
        assert!(mean.abs() < 0.05, "{mean}");
        assert!((variance - 1.0).abs() < 0.05, "{variance}");
        assert_eq!(Noise::new(3, 50, 56).yaw_rates, noise.yaw_rates);
        assert_ne!(Noise::new(4, 50, 56).yaw_rates, noise.yaw_rates);
    }

    #[test]
    fn neighbouring_knots_are_alike_and_steps_lie_between_them() {
        let mut noise = Noise::new(5, 20, 56);
        noise.shuffle();
        let (mut now, mut next) = ([0.0; LANES], [0.0; LANES]);
        let mut unused = [0.0; LANES];
        let (mut product, mut square) = (0.0, 0.0);
        for row in 0..noise.rows() {
            noise.at(row, 0, &mut now, &mut unused);
            noise.at(row, KNOT_STEPS, &mut next, &mut unused);
            let mut half = [0.0; LANES];
            noise.at(row, KNOT_STEPS / 2, &mut half, &mut unused);
            for lane in 0..LANES {
                product += now[lane] * next[lane];
                square += now[lane] * now[lane];
                assert!((half[lane] - 0.5 * (now[lane] + next[lane])).abs() < 1e-6);
            }
        }
        assert!(
            (product / square - CORRELATION).abs() < 0.1,
            "{}",
            product / square
        );
    }

    #[test]
    fn cycles_pair_differently() {
        let mut noise = Noise::new(7, 50, 56);
        let mut seen = std::collections::BTreeSet::new();
        for _ in 0..100 {
            noise.shuffle();
            seen.insert((noise.shift, noise.signs.0 > 0.0, noise.signs.1 > 0.0));
        }
        assert!(seen.len() > 50, "{}", seen.len());
    }
}
