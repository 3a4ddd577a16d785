//! `LWX-LSQ`: least-squares fit of a path.
//!
//! The printed fit `y(x)` is impossible for vertical or returning paths and misses both ends. Here
//! `x(s)` and `y(s)` over the normalised arc length `s` in [-1, 1] are sums of Chebyshev
//! polynomials, solved by QR; the ends are exact because the chord between them is fitted around by
//! `(1 - s^2)` times the rest.

use nalgebra::{DMatrix, DVector, Point2};

/// Highest degree.
pub const DEGREE_MAX: usize = 15;

/// Points of a fitted curve.
const SAMPLES: u16 = 100;

/// Why there is no fit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum FitError {
    /// Fewer than two different points.
    #[error("a fit needs two different points")]
    TooFew,
    /// `x` does not grow or does not fall all along, so `y` is no function of it.
    #[error("y(x) needs x to grow or to fall all along")]
    NotMonotone,
}

/// Arc lengths normalised to [-1, 1].
fn parameters(points: &[Point2<f64>]) -> Option<Vec<f64>> {
    let mut arcs = vec![0.0];
    for pair in points.windows(2) {
        arcs.push(arcs[arcs.len() - 1] + (pair[1] - pair[0]).norm());
    }
    let length = *arcs.last()?;
    (length > 1.0e-9).then(|| arcs.iter().map(|arc| 2.0 * arc / length - 1.0).collect())
}

/// Chebyshev polynomial `T_k(s)`.
fn chebyshev(k: usize, s: f64) -> f64 {
    let (mut before, mut here) = (1.0, s);
    if k == 0 {
        return 1.0;
    }
    for _ in 1..k {
        (before, here) = (here, 2.0 * s * here - before);
    }
    here
}

/// One coordinate: the chord from end to end plus `(1 - s^2) sum c_k T_k(s)`.
struct Coordinate {
    ends: (f64, f64),
    coefficients: DVector<f64>,
}

impl Coordinate {
    fn fit(parameters: &[f64], values: &[f64], degree: usize) -> Option<Self> {
        let ends = (*values.first()?, *values.last()?);
        let n = degree.saturating_sub(1).max(1);
        let chord = |s: f64| 0.5 * (ends.0 * (1.0 - s) + ends.1 * (1.0 + s));
        let matrix = DMatrix::from_fn(parameters.len(), n, |row, k| {
            let s = parameters[row];
            (1.0 - s * s) * chebyshev(k, s)
        });
        let rest = DVector::from_fn(parameters.len(), |row, _| {
            values[row] - chord(parameters[row])
        });
        let qr = matrix.qr();
        let right = qr.q().transpose() * rest;
        let upper = qr.r();
        let coefficients = upper.solve_upper_triangular(&right)?;
        Some(Self { ends, coefficients })
    }

    fn at(&self, s: f64) -> f64 {
        let chord = 0.5 * (self.ends.0 * (1.0 - s) + self.ends.1 * (1.0 + s));
        let bend: f64 = self
            .coefficients
            .iter()
            .enumerate()
            .map(|(k, c)| c * chebyshev(k, s))
            .sum();
        chord + (1.0 - s * s) * bend
    }
}

/// Fits `x(s), y(s)` of a degree and samples the curve at 101 points; both ends are exact.
///
/// # Errors
/// [`FitError::TooFew`].
pub fn fit(points: &[Point2<f64>], degree: usize) -> Result<Vec<Point2<f64>>, FitError> {
    let parameters = parameters(points).ok_or(FitError::TooFew)?;
    let degree = degree.clamp(1, DEGREE_MAX).min(points.len() - 1);
    let xs: Vec<f64> = points.iter().map(|point| point.x).collect();
    let ys: Vec<f64> = points.iter().map(|point| point.y).collect();
    let x = Coordinate::fit(&parameters, &xs, degree).ok_or(FitError::TooFew)?;
    let y = Coordinate::fit(&parameters, &ys, degree).ok_or(FitError::TooFew)?;
    Ok((0..=SAMPLES)
        .map(|i| {
            let s = 2.0 * f64::from(i) / f64::from(SAMPLES) - 1.0;
            Point2::new(x.at(s), y.at(s))
        })
        .collect())
}

/// The printed fit `y(x)` of a degree at the points' own `x`.
///
/// # Errors
/// [`FitError::NotMonotone`] for vertical and returning paths, [`FitError::TooFew`].
pub fn fit_literal(points: &[Point2<f64>], degree: usize) -> Result<Vec<Point2<f64>>, FitError> {
    if points.len() < 2 {
        return Err(FitError::TooFew);
    }
    let grows = points
        .windows(2)
        .all(|pair| pair[1].x > pair[0].x + 1.0e-12);
    let falls = points
        .windows(2)
        .all(|pair| pair[1].x < pair[0].x - 1.0e-12);
    if !grows && !falls {
        return Err(FitError::NotMonotone);
    }
    let (low, high) = (points[0].x, points[points.len() - 1].x);
    let scaled = |x: f64| 2.0 * (x - low) / (high - low) - 1.0;
    let n = degree.clamp(1, DEGREE_MAX).min(points.len() - 1) + 1;
    let matrix = DMatrix::from_fn(points.len(), n, |row, k| {
        chebyshev(k, scaled(points[row].x))
    });
    let right = DVector::from_fn(points.len(), |row, _| points[row].y);
    let qr = matrix.qr();
    let coefficients = qr
        .r()
        .solve_upper_triangular(&(qr.q().transpose() * right))
        .ok_or(FitError::TooFew)?;
    let value = |x: f64| -> f64 {
        let terms = coefficients.iter().enumerate();
        terms.map(|(k, c)| c * chebyshev(k, scaled(x))).sum()
    };
    Ok(points
        .iter()
        .map(|point| Point2::new(point.x, value(point.x)))
        .collect())
}

/// The fit of the lowest degree that is free, from `min(7, points / 4)` to 15; `None` when none
/// is: the unfitted path stays. `is_free` judges a segment.
#[must_use]
pub fn free_fit(
    points: &[Point2<f64>],
    is_free: impl Fn(Point2<f64>, Point2<f64>) -> bool,
) -> Option<Vec<Point2<f64>>> {
    let lowest = (points.len() / 4).clamp(3, 7);
    (lowest..=DEGREE_MAX).find_map(|degree| {
        let curve = fit(points, degree).ok()?;
        let free = curve.windows(2).all(|pair| is_free(pair[0], pair[1]));
        free.then_some(curve)
    })
}
