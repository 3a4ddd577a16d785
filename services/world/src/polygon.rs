//! Corners as people write them, checked and put in order. parry takes convex corners on faith.

use crate::error::{SpecError, number};
use nalgebra::{Point2, Vector2};
use parry2d::mass_properties::details::convex_polygon_area_and_center_of_mass;
use parry2d::math::Vec2;
use zeronav_msgs::message::COORDINATE_M_MAX;

/// Most corners of a polygon.
pub const POLYGON_CORNERS_MAX: usize = 256;

/// Closest that two neighbouring corners may be: below, a corner is a slip of the pen. [m]
const CORNER_DISTANCE_M_MIN: f64 = 1.0e-3;

/// Sine of the turn below which a corner lies on a straight edge.
const STRAIGHT_SINE: f64 = 1.0e-9;

/// Which way around corners were written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Order {
    CounterClockwise,
    Clockwise,
}

/// The corners of a convex polygon, counter-clockwise and without those on straight edges, and
/// how they were written.
///
/// # Errors
/// Fewer than three corners, numbers that are not finite, corners on one spot, and outlines that
/// are not convex. The field is `[index]` or empty.
pub(crate) fn convex_corners(written: &[[f64; 2]]) -> Result<(Vec<Point2<f64>>, Order), SpecError> {
    let n = written.len();
    if !(3..=POLYGON_CORNERS_MAX).contains(&n) {
        let why = format!("needs 3 to {POLYGON_CORNERS_MAX} corners, not {n}");
        return Err(SpecError::new("", why));
    }
    for (index, corner) in written.iter().enumerate() {
        for value in corner {
            let limit_m = COORDINATE_M_MAX;
            number(*value, -limit_m, limit_m, &format!("[{index}]"))?;
        }
    }
    let points: Vec<Point2<f64>> = written.iter().map(|at| Point2::from(*at)).collect();
    let edge = |index: usize| points[(index + 1) % n] - points[index % n];
    let mut turn_rad = 0.0;
    let mut sides = [false; 2];
    let mut corners = Vec::with_capacity(n);
    for (index, at) in points.iter().enumerate() {
        let (before, after): (Vector2<f64>, Vector2<f64>) = (edge(index + n - 1), edge(index));
        let lengths = before.norm() * after.norm();
        if after.norm() < CORNER_DISTANCE_M_MIN {
            let next = (index + 1) % n;
            let why = format!("is the same point as [{next}]");
            return Err(SpecError::new(format!("[{index}]"), why));
        }
        turn_rad += before.perp(&after).atan2(before.dot(&after));
        let sine = before.perp(&after) / lengths;
        if sine.abs() > STRAIGHT_SINE {
            sides[usize::from(sine > 0.0)] = true;
            corners.push(*at);
        } else if before.dot(&after) < 0.0 {
            return Err(SpecError::new(
                format!("[{index}]"),
                "is a spike without area",
            ));
        }
    }
    // A star turns one way too, but more than once around.
    if sides[0] == sides[1] || (turn_rad.abs() - core::f64::consts::TAU).abs() > 1.0 {
        return Err(SpecError::new(
            "",
            "is not convex: all corners must turn the same way, once around",
        ));
    }
    if sides[0] {
        corners.reverse();
        return Ok((corners, Order::Clockwise));
    }
    Ok((corners, Order::CounterClockwise))
}

/// Centroid of the area of a polygon. [m]
pub(crate) fn centroid(corners: &[Point2<f64>]) -> Point2<f64> {
    // About the first corner: far from the origin the products of coordinates would cancel.
    let first = corners.first().copied().unwrap_or_else(Point2::origin);
    let from_first: Vec<Vec2> = corners.iter().map(|at| (at - first).into()).collect();
    let (_, centre) = convex_polygon_area_and_center_of_mass(&from_first);
    first + Vector2::from(centre)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refused(written: &[[f64; 2]]) -> String {
        convex_corners(written).unwrap_err().to_string()
    }

    #[test]
    fn corners_come_out_counter_clockwise_and_needed() {
        let clockwise = [[0.0, 0.0], [0.0, 1.0], [0.5, 1.0], [1.0, 1.0], [1.0, 0.0]];
        let (corners, order) = convex_corners(&clockwise).unwrap();
        assert_eq!(order, Order::Clockwise);
        let expected = [[1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [0.0, 0.0]].map(Point2::from);
        assert_eq!(corners, expected);
        let centre = centroid(&corners);
        assert!((centre - Point2::new(0.5, 0.5)).norm() < 1e-12);
    }

    #[test]
    fn the_centroid_of_a_triangle_is_the_mean_of_its_corners() {
        let (corners, _) = convex_corners(&[[0.0, 0.0], [3.0, 0.0], [0.0, 6.0]]).unwrap();
        assert!((centroid(&corners) - Point2::new(1.0, 2.0)).norm() < 1e-12);
    }

    #[test]
    fn outlines_that_cannot_be_are_refused() {
        assert!(refused(&[[0.0, 0.0], [1.0, 0.0]]).contains("needs 3 to 256 corners, not 2"));
        let dent = [[0.0, 0.0], [2.0, 0.0], [1.0, 0.5], [1.0, 2.0]];
        assert!(refused(&dent).contains("not convex"));
        let line = [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]];
        assert!(refused(&line).contains("spike"));
        let twice = [[0.0, 0.0], [1.0, 0.0], [1.0, 0.0], [0.0, 1.0]];
        assert_eq!(refused(&twice), "[1]: is the same point as [2]");
        let nan = [[0.0, 0.0], [1.0, f64::NAN], [0.0, 1.0]];
        assert!(refused(&nan).starts_with("[1]: must be a number"));
        // A pentagram turns one way at every corner.
        let star = [0, 2, 4, 1, 3].map(|k| {
            let angle = core::f64::consts::TAU * f64::from(k) / 5.0;
            [angle.cos(), angle.sin()]
        });
        assert!(refused(&star).contains("once around"));
    }
}
