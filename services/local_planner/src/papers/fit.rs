//! `LWX-LSQ`: least-squares fit of a path.
//!
//! The printed fit `y(x)` is impossible for vertical or returning paths and misses both ends. Here
//! `x(s)` and `y(s)` over the normalised arc length `s` in [-1, 1] are sums of Chebyshev
//! polynomials, solved by QR; the ends are exact because the chord between them is fitted around by
//! `(1 - s^2)` times the rest.

use nalgebra::{DMatrix, DVector, Point2, Vector2};

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
    #[error("x must be monotonic")]
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

/// One coordinate: the chord from end to end plus `(1 - s^2) g(s)`, where `g` is a sum `c_k T_k(s)`.
///
/// A slope that is given at an end fixes `g` there: `g(1) = (chord' - x'(1)) / 2` and
/// `g(-1) = (x'(-1) - chord') / 2`. The sum is then multiplied by what is zero at that end.
struct Coordinate {
    ends: (f64, f64),
    /// `g` at both ends, where slopes are given.
    fixed: [Option<f64>; 2],
    coefficients: DVector<f64>,
}

/// Values that `g` is fixed to at -1 and 1, and the factor of the rest.
fn fixed_part(fixed: [Option<f64>; 2], s: f64) -> (f64, f64) {
    let (low, high) = (0.5 * (1.0 - s), 0.5 * (1.0 + s));
    match fixed {
        [None, None] => (0.0, 1.0),
        [Some(at_low), None] => (at_low * low, high),
        [None, Some(at_high)] => (at_high * high, low),
        [Some(at_low), Some(at_high)] => (at_low * low + at_high * high, low * high),
    }
}

impl Coordinate {
    /// `slopes` are those by `s` at both ends.
    fn fit(
        parameters: &[f64],
        values: &[f64],
        degree: usize,
        slopes: [Option<f64>; 2],
    ) -> Option<Self> {
        let ends = (*values.first()?, *values.last()?);
        let chord_slope = 0.5 * (ends.1 - ends.0);
        let [low, high] = slopes;
        let fixed = [
            low.map(|slope| 0.5 * (slope - chord_slope)),
            high.map(|slope| 0.5 * (chord_slope - slope)),
        ];
        let n = degree.saturating_sub(1).max(1);
        let chord = |s: f64| 0.5 * (ends.0 * (1.0 - s) + ends.1 * (1.0 + s));
        let matrix = DMatrix::from_fn(parameters.len(), n, |row, k| {
            let s = parameters[row];
            (1.0 - s * s) * fixed_part(fixed, s).1 * chebyshev(k, s)
        });
        let rest = DVector::from_fn(parameters.len(), |row, _| {
            let s = parameters[row];
            values[row] - chord(s) - (1.0 - s * s) * fixed_part(fixed, s).0
        });
        let qr = matrix.qr();
        let right = qr.q().transpose() * rest;
        let upper = qr.r();
        let coefficients = upper.solve_upper_triangular(&right)?;
        Some(Self {
            ends,
            fixed,
            coefficients,
        })
    }

    fn at(&self, s: f64) -> f64 {
        let chord = 0.5 * (self.ends.0 * (1.0 - s) + self.ends.1 * (1.0 + s));
        let terms = self.coefficients.iter().enumerate();
        let sum: f64 = terms.map(|(k, c)| c * chebyshev(k, s)).sum();
        let (value, factor) = fixed_part(self.fixed, s);
        chord + (1.0 - s * s) * (value + factor * sum)
    }
}

/// Fits `x(s), y(s)` of a degree and samples the curve at 101 points; both ends are exact.
///
/// # Errors
/// [`FitError::TooFew`].
pub fn fit(points: &[Point2<f64>], degree: usize) -> Result<Vec<Point2<f64>>, FitError> {
    fit_between(points, degree, [None; 2])
}

/// The same with given directions at the ends: unit vectors along the path.
fn fit_between(
    points: &[Point2<f64>],
    degree: usize,
    directions: [Option<Vector2<f64>>; 2],
) -> Result<Vec<Point2<f64>>, FitError> {
    let parameters = parameters(points).ok_or(FitError::TooFew)?;
    let degree = degree.clamp(1, DEGREE_MAX).min(points.len() - 1);
    let length: f64 = points
        .windows(2)
        .map(|pair| (pair[1] - pair[0]).norm())
        .sum();
    let along = |axis: usize| {
        let values: Vec<f64> = points.iter().map(|point| point[axis]).collect();
        let slopes = directions.map(|direction| Some(direction?[axis] * 0.5 * length));
        Coordinate::fit(&parameters, &values, degree, slopes).ok_or(FitError::TooFew)
    };
    let (x, y) = (along(0)?, along(1)?);
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

/// Halvings of a path that no single fit is free on: enough for the corners of a building.
const SPLITS_MAX: u32 = 6;

/// The fit of the lowest degree that is free, from `min(7, points / 4)` to 15. Where none is, the
/// path is split at its sharpest turn and the parts are fitted so that they join in the same
/// direction, each split again up to six times; `None` when that does not help either: the
/// unfitted path stays. `is_free` judges a segment.
#[must_use]
pub fn free_fit(
    points: &[Point2<f64>],
    is_free: impl Fn(Point2<f64>, Point2<f64>) -> bool,
) -> Option<Vec<Point2<f64>>> {
    free_between(points, [None; 2], SPLITS_MAX, &is_free)
}

fn free_between(
    points: &[Point2<f64>],
    directions: [Option<Vector2<f64>>; 2],
    splits: u32,
    is_free: &dyn Fn(Point2<f64>, Point2<f64>) -> bool,
) -> Option<Vec<Point2<f64>>> {
    let lowest = (points.len() / 4).clamp(3, 7);
    let whole = (lowest..=DEGREE_MAX).find_map(|degree| {
        let curve = fit_between(points, degree, directions).ok()?;
        let free = curve.windows(2).all(|pair| is_free(pair[0], pair[1]));
        free.then_some(curve)
    });
    if whole.is_some() || splits == 0 {
        return whole;
    }
    let (at, direction) = sharpest(points)?;
    let [from, to] = directions;
    let mut curve = free_between(&points[..=at], [from, Some(direction)], splits - 1, is_free)?;
    let rest = free_between(&points[at..], [Some(direction), to], splits - 1, is_free)?;
    curve.extend_from_slice(&rest[1..]);
    Some(curve)
}

/// The sharpest turn that leaves at least four points on either side, and the mean of the directions
/// before and after it; of equal ones the nearest to the middle.
fn sharpest(points: &[Point2<f64>]) -> Option<(usize, Vector2<f64>)> {
    const LEFT: usize = 4;
    let middle = points.len() / 2;
    let turn = |at: usize| {
        let before = (points[at] - points[at - 1]).try_normalize(1.0e-12)?;
        let after = (points[at + 1] - points[at]).try_normalize(1.0e-12)?;
        let mean = (before + after).try_normalize(1.0e-9)?;
        Some((before.dot(&after), at, mean))
    };
    (LEFT..points.len().saturating_sub(LEFT))
        .filter_map(turn)
        .min_by(|a, b| {
            let by_turn = (a.0 * 1.0e6).round().total_cmp(&(b.0 * 1.0e6).round());
            by_turn.then(a.1.abs_diff(middle).cmp(&b.1.abs_diff(middle)))
        })
        .map(|(_, at, mean)| (at, mean))
}
