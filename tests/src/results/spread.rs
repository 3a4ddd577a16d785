//! Estimates with their spread: quartiles, intervals of rates and of means.

use serde::{Deserialize, Serialize};
use zeronav_casts::Cast;
use zeronav_observe::statistics::{percentile, quartiles};

/// Two-sided 95 % of the normal distribution.
const Z: f64 = 1.959_963_984_540_054;

/// A figure and the interval that belongs to it. `None` where nothing can be said.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Figure {
    /// The estimate.
    pub value: Option<f64>,
    /// Lower end of its interval.
    pub low: Option<f64>,
    /// Upper end of its interval.
    pub high: Option<f64>,
}

impl Figure {
    /// A figure without spread: a count, or one percentile of a distribution.
    #[must_use]
    pub fn plain(value: Option<f64>) -> Self {
        Self {
            value,
            ..Self::default()
        }
    }

    /// A percentile of samples, without spread.
    #[must_use]
    pub fn percentile(samples: &[f64], share: f64) -> Self {
        Self::plain(percentile(&mut samples.to_vec(), share))
    }

    /// Median with the quartiles.
    #[must_use]
    pub fn median(values: &[f64]) -> Self {
        let quartiles = quartiles(values.iter().copied());
        let [low, value, high] = quartiles.map_or([None; 3], |quartiles| quartiles.map(Some));
        Self { value, low, high }
    }

    /// Rate of `k` in `n` with the 95 % interval of Wilson (1927).
    #[must_use]
    pub fn rate(k: usize, n: usize) -> Self {
        if n == 0 {
            return Self::default();
        }
        let (k, n) = (number(k), number(n));
        let p = k / n;
        let z2 = Z * Z;
        let centre = (p + z2 / (2.0 * n)) / (1.0 + z2 / n);
        let half = Z / (1.0 + z2 / n) * (p * (1.0 - p) / n + z2 / (4.0 * n * n)).sqrt();
        Self {
            value: Some(p),
            low: Some((centre - half).max(0.0)),
            high: Some((centre + half).min(1.0)),
        }
    }

    /// Mean with the 95 % interval of the normal approximation.
    #[must_use]
    pub fn mean(values: &[f64]) -> Self {
        let n = number(values.len());
        if values.is_empty() {
            return Self::default();
        }
        let mean = values.iter().sum::<f64>() / n;
        if values.len() == 1 {
            return Self::plain(Some(mean));
        }
        let square = |value: &f64| (value - mean) * (value - mean);
        let variance = values.iter().map(square).sum::<f64>() / (n - 1.0);
        let half = Z * (variance / n).sqrt();
        Self {
            value: Some(mean),
            low: Some(mean - half),
            high: Some(mean + half),
        }
    }
}

fn number(n: usize) -> f64 {
    n.to_f64()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn near(figure: Figure, [value, low, high]: [f64; 3]) {
        let all = [figure.value, figure.low, figure.high];
        for (actual, expected) in all.into_iter().zip([value, low, high]) {
            let actual = actual.expect("a figure");
            assert!((actual - expected).abs() < 5e-5, "{actual}, not {expected}");
        }
    }

    /// Wilson's interval against the values of R's `prop.test(correct = FALSE)`.
    #[test]
    fn rates_have_the_interval_of_wilson() {
        near(Figure::rate(81, 263), [0.30798, 0.25529, 0.36618]);
        near(Figure::rate(15, 148), [0.10135, 0.06239, 0.16050]);
        near(Figure::rate(10, 10), [1.0, 0.72247, 1.0]);
        assert_eq!(Figure::rate(0, 0), Figure::default());
    }

    #[test]
    fn medians_have_quartiles_and_means_an_interval() {
        near(Figure::median(&[4.0, 1.0, 3.0, 2.0]), [2.5, 1.75, 3.25]);
        assert_eq!(Figure::median(&[]), Figure::default());
        // Standard deviation 1, n = 3: 1.96 / sqrt(3) = 1.13159.
        near(Figure::mean(&[1.0, 2.0, 3.0]), [2.0, 0.86841, 3.13159]);
        assert_eq!(Figure::mean(&[7.0]), Figure::plain(Some(7.0)));
    }
}
