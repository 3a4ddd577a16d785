//! What a cluster of points is: part of a circle, or a segment.

use nalgebra::{Matrix2, Matrix3, Point2, Vector2, Vector3};

/// What fits best.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Fit {
    /// The near side of something round.
    Circle {
        /// [m]
        centre: Point2<f64>,
        /// [m]
        radius_m: f64,
    },
    /// Something straight, or too little of anything to tell.
    Segment {
        /// [m]
        middle: Point2<f64>,
        /// Its direction, of length 1.
        along: Vector2<f64>,
        /// Half its length. [m]
        half_m: f64,
    },
}

impl Fit {
    /// How far it reaches from its centre. [m]
    #[must_use]
    pub fn radius_m(&self) -> f64 {
        match self {
            Self::Circle { radius_m, .. } => *radius_m,
            Self::Segment { half_m, .. } => *half_m,
        }
    }
}

/// Fits a circle or a segment to points seen from `eye`; `None` without points.
///
/// A circle must fit better than a line by half, be at most `radius_m_max` large, and turn its
/// round side to the eye.
#[must_use]
pub fn fit(
    points: impl Iterator<Item = Point2<f64>> + Clone,
    eye: Point2<f64>,
    radius_m_max: f64,
) -> Option<Fit> {
    let n = points.clone().count();
    if n == 0 {
        return None;
    }
    #[allow(clippy::cast_precision_loss, reason = "at most 4096 points")]
    let count = n as f64;
    let sum = points
        .clone()
        .fold(Vector2::zeros(), |sum, point| sum + point.coords);
    let mean = Point2::from(sum / count);
    let spread = points.clone().fold(Matrix2::zeros(), |spread, point| {
        spread + (point - mean) * (point - mean).transpose()
    });
    let (along, across_variance) = main_axis(&(spread / count));
    let (low, high) = points
        .clone()
        .map(|point| (point - mean).dot(&along))
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), at| {
            (low.min(at), high.max(at))
        });
    let segment = Fit::Segment {
        middle: mean + along * (0.5 * (low + high)),
        along,
        half_m: 0.5 * (high - low),
    };
    if n < 5 {
        return Some(segment);
    }
    let circle = circle_through(points.clone(), mean).filter(|(centre, radius_m)| {
        let residual = points
            .map(|point| ((point - centre).norm() - radius_m).powi(2))
            .sum::<f64>()
            / count;
        let bulges = (centre - eye).norm() > (mean - eye).norm();
        *radius_m <= radius_m_max && bulges && residual < 0.25 * across_variance
    });
    Some(circle.map_or(segment, |(centre, radius_m)| Fit::Circle {
        centre,
        radius_m,
    }))
}

/// The centre of a circle of known radius through points on its side towards `eye`: least squares
/// by a few steps of Gauss and Newton.
#[must_use]
pub fn centre_of_radius(
    points: &(impl Iterator<Item = Point2<f64>> + Clone),
    eye: Point2<f64>,
    radius_m: f64,
) -> Option<Point2<f64>> {
    let mut n = 0.0;
    let mut sum = Vector2::zeros();
    for point in points.clone() {
        n += 1.0;
        sum += point.coords;
    }
    if n == 0.0 {
        return None;
    }
    let mean = Point2::from(sum / n);
    let away = (mean - eye).try_normalize(1.0e-9)?;
    let mut centre = mean + away * (0.8 * radius_m);
    for _ in 0..6 {
        let mut normal = Matrix2::zeros();
        let mut right = Vector2::zeros();
        for point in points.clone() {
            let offset = centre - point;
            let distance_m = offset.norm().max(1.0e-9);
            let gradient = offset / distance_m;
            normal += gradient * gradient.transpose();
            right += gradient * (distance_m - radius_m);
        }
        // A weak pull to where it is, for the few points of something far or small.
        normal += Matrix2::identity() * (0.02 * n);
        let step = normal.try_inverse()? * right;
        centre -= step;
        if step.norm() < 1.0e-5 {
            break;
        }
    }
    Some(centre)
}

/// Direction of the largest spread, and the variance across it.
fn main_axis(spread: &Matrix2<f64>) -> (Vector2<f64>, f64) {
    let (a, b, c) = (spread[(0, 0)], spread[(0, 1)], spread[(1, 1)]);
    let angle = 0.5 * (2.0 * b).atan2(a - c);
    let (sin, cos) = angle.sin_cos();
    let across = Vector2::new(-sin, cos);
    let variance = (across.transpose() * spread * across)[(0, 0)];
    (Vector2::new(cos, sin), variance)
}

/// Kasa, "A circle fitting procedure and its error analysis", 1976: the circle with the least sum
/// of squared differences of squared distances, around `mean`.
fn circle_through(
    points: impl Iterator<Item = Point2<f64>>,
    mean: Point2<f64>,
) -> Option<(Point2<f64>, f64)> {
    let mut normal = Matrix3::zeros();
    let mut right = Vector3::zeros();
    for point in points {
        let at = point - mean;
        let row = Vector3::new(at.x, at.y, 1.0);
        normal += row * row.transpose();
        right += row * at.norm_squared();
    }
    let solution = normal.try_inverse()? * right;
    let centre = Vector2::new(0.5 * solution.x, 0.5 * solution.y);
    let radius_m = (solution.z + centre.norm_squared()).max(0.0).sqrt();
    radius_m.is_finite().then_some((mean + centre, radius_m))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The near side of a disc, as a lidar at the origin sees it.
    fn near_side(centre: Point2<f64>, radius_m: f64, n: u32, noise_m: f64) -> Vec<Point2<f64>> {
        let distance_m = centre.coords.norm();
        let half = (radius_m / distance_m).asin() * 0.98;
        let towards = centre.y.atan2(centre.x);
        (0..n)
            .map(|i| {
                let off = half * (2.0 * f64::from(i) / f64::from(n - 1) - 1.0);
                let range_m = distance_m * off.cos()
                    - (radius_m.powi(2) - (distance_m * off.sin()).powi(2)).sqrt();
                let range_m = range_m + noise_m * if i % 2 == 0 { 1.0 } else { -1.0 };
                Point2::new((towards + off).cos(), (towards + off).sin()) * range_m
            })
            .collect()
    }

    #[test]
    fn round_things_are_circles() {
        for (x, y, radius_m) in [(3.0, 1.0, 0.3), (-2.0, 2.0, 0.15), (0.0, -5.0, 0.5)] {
            let centre = Point2::new(x, y);
            let points = near_side(centre, radius_m, 15, 0.0);
            let Some(Fit::Circle {
                centre: c,
                radius_m: r,
            }) = fit(points.iter().copied(), Point2::origin(), 0.6)
            else {
                panic!("no circle at {centre}");
            };
            assert!((c - centre).norm() < 1e-6 && (r - radius_m).abs() < 1e-6);
            // With noise, a known radius holds the centre.
            let noisy = near_side(centre, radius_m, 9, 0.01);
            let c = centre_of_radius(&noisy.iter().copied(), Point2::origin(), radius_m).unwrap();
            assert!((c - centre).norm() < 0.03, "{c} {centre}");
        }
    }

    #[test]
    fn straight_things_are_segments() {
        let points: Vec<Point2<f64>> = (0..20)
            .map(|i| Point2::new(2.0 + 0.05 * f64::from(i), 1.0))
            .collect();
        let Some(Fit::Segment { middle, half_m, .. }) =
            fit(points.iter().copied(), Point2::origin(), 0.6)
        else {
            panic!("no segment");
        };
        assert!((middle - Point2::new(2.475, 1.0)).norm() < 1e-9);
        assert!((half_m - 0.475).abs() < 1e-9);
        // Too few points tell nothing, and a hollow is no disc.
        let few = fit(points[..3].iter().copied(), Point2::origin(), 0.6);
        assert!(matches!(few, Some(Fit::Segment { .. })));
        let hollow: Vec<Point2<f64>> = near_side(Point2::new(3.0, 0.0), 0.4, 15, 0.0)
            .iter()
            .map(|point| Point2::new(6.0 - point.x, point.y))
            .collect();
        let fitted = fit(hollow.iter().copied(), Point2::origin(), 0.6);
        assert!(matches!(fitted, Some(Fit::Segment { .. })), "{fitted:?}");
        assert_eq!(fit(core::iter::empty(), Point2::origin(), 0.6), None);
    }
}
