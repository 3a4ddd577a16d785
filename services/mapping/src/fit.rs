//! What a cluster of points is: part of a circle, or a segment.

use nalgebra::{Matrix2, Matrix3, Point2, Vector2, Vector3};
use zeronav_casts::Cast;

/// What fits best.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Fit {
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
    pub(crate) fn radius_m(&self) -> f64 {
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
pub(crate) fn fit(
    points: impl Iterator<Item = Point2<f64>> + Clone,
    eye: Point2<f64>,
    radius_m_max: f64,
) -> Option<Fit> {
    let n = points.clone().count();
    if n == 0 {
        return None;
    }
    let count = n.to_f64();
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

/// Where a disc of known radius is, and how well that is known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Place {
    /// [m]
    pub centre: Point2<f64>,
    /// [m^2]
    pub covariance: Matrix2<f64>,
}

/// The disc of `radius_m`, known to `radius_sigma_m`, through points on its side towards `eye`, each
/// known to `point_sigma_m`: least squares by a few steps of Gauss and Newton. Of a disc that is
/// partly hidden the points tell little across the line of sight, which is what the covariance says.
#[must_use]
pub(crate) fn disc_through(
    points: &(impl Iterator<Item = Point2<f64>> + Clone),
    eye: Point2<f64>,
    (radius_m, radius_sigma_m): (f64, f64),
    point_sigma_m: f64,
) -> Option<Place> {
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
    let start = mean + away * (0.8 * radius_m);
    // No disc is farther from where it seems to be than its own size.
    let pull = (point_sigma_m / radius_m.max(point_sigma_m)).powi(2);
    let mut centre = start;
    let mut normal = Matrix2::zeros();
    let mut towards = Vector2::zeros();
    for _ in 0..6 {
        normal = Matrix2::identity() * pull;
        towards = Vector2::zeros();
        let mut right = (centre - start) * pull;
        for point in points.clone() {
            let offset = centre - point;
            let distance_m = offset.norm().max(1.0e-9);
            let gradient = offset / distance_m;
            let off_m = distance_m - radius_m;
            // What lies off the disc, between it and what is behind, says little.
            let weight = 1.0 / (1.0 + (off_m / (3.0 * point_sigma_m)).powi(2));
            normal += gradient * gradient.transpose() * weight;
            towards += gradient * weight;
            right += gradient * (off_m * weight);
        }
        let step = normal.try_inverse()? * right;
        centre -= step;
        if step.norm() < 1.0e-5 {
            break;
        }
    }
    let inverse = normal.try_inverse()?;
    let by_radius = inverse * towards * radius_sigma_m;
    Some(Place {
        centre,
        covariance: inverse * (point_sigma_m * point_sigma_m) + by_radius * by_radius.transpose(),
    })
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
            let points = noisy.iter().copied();
            let place = disc_through(&points, Point2::origin(), (radius_m, 0.0), 0.02).unwrap();
            assert!((place.centre - centre).norm() < 0.03, "{place:?} {centre}");
        }
    }

    /// What can be seen of a disc holds its centre as well as the covariance says, and a sliver of it
    /// holds it along the line of sight alone.
    #[test]
    fn a_disc_that_is_half_hidden_is_where_its_covariance_says() {
        let (centre, radius_m, sigma_m) = (Point2::new(3.0, 0.0), 0.3, 0.01);
        let whole = near_side(centre, radius_m, 40, sigma_m);
        let place = |points: &[Point2<f64>], radius: (f64, f64)| {
            disc_through(&points.iter().copied(), Point2::origin(), radius, sigma_m).unwrap()
        };
        let all = place(&whole, (radius_m, 0.0));
        let half = place(&whole[..20], (radius_m, 0.0));
        let sliver = place(&whole[18..22], (radius_m, 0.0));
        for (seen, across_m) in [(all, 0.01), (half, 0.02), (sliver, 0.3)] {
            assert!((seen.centre - centre).norm() < across_m, "{seen:?}");
            // Three standard deviations hold what is off.
            let off = seen.centre - centre;
            for axis in 0..2 {
                let sigma_m = seen.covariance[(axis, axis)].sqrt();
                assert!(off[axis].abs() < 3.0 * sigma_m + 2.0e-3, "{seen:?}");
            }
        }
        let across_m = |seen: &Place| seen.covariance[(1, 1)].sqrt();
        assert!(across_m(&all) < across_m(&half));
        assert!(across_m(&sliver) > 10.0 * across_m(&all), "{sliver:?}");
        // A radius that is not known is an error along the line of sight.
        let unsure = place(&whole, (radius_m, 0.1));
        let along_m = unsure.covariance[(0, 0)].sqrt();
        assert!((0.1..0.15).contains(&along_m), "{unsure:?}");
        assert!(across_m(&unsure) < 0.01, "{unsure:?}");
        // A point on what is behind moves it little.
        let mut with_edge = whole;
        with_edge[0] *= 1.05;
        let edged = place(&with_edge, (radius_m, 0.0));
        assert!((edged.centre - all.centre).norm() < 3.0e-3, "{edged:?}");
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
