//! BAO-SPL: a cubic uniform B-spline along a path of cells.
//!
//! \[BAO\] eqs. (9) to (12), with the row vector that eq. (12) lacks in print. Every cell of the
//! path is a control point: the curve then stays within 0.24 cells of the path's corners and, on
//! a path that cuts no corner, at least 0.465 cells from every cell that is not known to be free.

use crate::planner::PlanQuery;
use crate::remarks::Remarks;
use nalgebra::{Point2, Vector2};
use zeronav_msgs::Cell;
use zeronav_msgs::path::WAYPOINTS_MAX;
use zeronav_params::choices;

/// Most samples between two control points.
pub(crate) const SAMPLES_MAX: u32 = 100;

/// How a path is rounded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Spline {
    /// How the curve meets its ends.
    pub ends: SplineEnds,
    /// Samples between two control points, at least 1, where the curve is not straight.
    pub samples: u32,
}

impl Spline {
    /// The cells' centres are the path.
    pub(crate) const OFF: Self = Self {
        ends: SplineEnds::Off,
        samples: 1,
    };
}

choices! {
    /// `bao_iaa`, `bao_dij`: how the cubic B-spline meets its first and last control point.
    pub enum SplineEnds {
        /// A mirrored point beyond each end: exact ends, along the path.
        #[default]
        Phantom = "phantom",
        /// The end points three times: exact ends, straight first piece.
        Triple = "triple",
        /// No curve: the cells' centres are the path.
        Off = "off",
    }
}

/// A point of the curve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct CurvePoint {
    /// Where.
    pub at: Point2<f64>,
    /// First derivative by the parameter, which grows by 1 from control point to control point.
    pub tangent: Vector2<f64>,
    /// \[1/unit of `at`\] Curvature, left positive; 0 where the curve does not advance.
    pub curvature: f64,
}

/// The curve between the second and the third of four control points, at `t` from 0 to 1.
/// [BAO] eqs. (9) to (11).
#[must_use]
pub(crate) fn point_on(control: &[Point2<f64>; 4], t: f64) -> CurvePoint {
    let sum = |weights: [f64; 4]| {
        control
            .iter()
            .zip(weights)
            .fold(Vector2::zeros(), |sum, (point, weight)| {
                sum + weight * point.coords
            })
    };
    let (t2, t3) = (t * t, t * t * t);
    let at = sum([
        (1.0 - t).powi(3) / 6.0,
        (3.0 * t3 - 6.0 * t2 + 4.0) / 6.0,
        (-3.0 * t3 + 3.0 * t2 + 3.0 * t + 1.0) / 6.0,
        t3 / 6.0,
    ]);
    let tangent = sum([
        -(1.0 - t).powi(2) / 2.0,
        (9.0 * t2 - 12.0 * t) / 6.0,
        (-9.0 * t2 + 6.0 * t + 3.0) / 6.0,
        t2 / 2.0,
    ]);
    let second = sum([1.0 - t, 3.0 * t - 2.0, 1.0 - 3.0 * t, t]);
    let speed = tangent.norm();
    let curvature = if speed > 1e-9 {
        tangent.perp(&second) / speed.powi(3)
    } else {
        0.0
    };
    CurvePoint {
        at: at.into(),
        tangent,
        curvature,
    }
}

/// The control points of every piece of the curve along `points`, one piece between two points
/// with [`SplineEnds::Phantom`], two more with [`SplineEnds::Triple`]. None for fewer than two
/// points and for [`SplineEnds::Off`].
pub(crate) fn segments(
    points: &[Point2<f64>],
    ends: SplineEnds,
) -> impl Iterator<Item = [Point2<f64>; 4]> + '_ {
    let pair = match points {
        [first, second, ..] => Some((*first, *second)),
        _ => None,
    };
    let tail = match points {
        [.., before, last] => Some((*before, *last)),
        _ => None,
    };
    let (head, foot) = match (ends, pair, tail) {
        (SplineEnds::Phantom, Some((first, second)), Some((before, last))) => {
            (vec![first + (first - second)], vec![last + (last - before)])
        }
        (SplineEnds::Triple, Some((first, _)), Some((_, last))) => (vec![first; 2], vec![last; 2]),
        _ => (Vec::new(), Vec::new()),
    };
    let has_curve = !head.is_empty();
    let n = if has_curve {
        head.len() + points.len() + foot.len()
    } else {
        0
    };
    let control = move |n: usize| {
        if let Some(point) = head.get(n) {
            *point
        } else {
            let n = n - head.len();
            points
                .get(n)
                .copied()
                .unwrap_or_else(|| foot[(n - points.len()).min(foot.len() - 1)])
        }
    };
    (0..n.saturating_sub(3)).map(move |first| [0, 1, 2, 3].map(|k| control(first + k)))
}

/// Writes the curve along a path of cells in the `map` frame [m], straight between the points;
/// empty when there is none or when it would leave the free cells of the path's surroundings, which
/// the remarks say, as they say how sharply it turns.
///
/// Control points are the cells' centres, and the goal itself in place of its cell's centre. A
/// curve of more points than a message holds is sampled half as densely, again and again.
pub(crate) fn curve_of(
    query: &PlanQuery<'_>,
    cells: &[Cell],
    spline: Spline,
    remarks: &mut Remarks,
    curve: &mut Vec<Point2<f64>>,
) {
    curve.clear();
    if spline.ends == SplineEnds::Off || cells.len() < 2 {
        return;
    }
    let geometry = query.map.geometry;
    let mut points: Vec<_> = cells.iter().map(|cell| geometry.centre_of(*cell)).collect();
    if let (Some(cell), Some(point)) = (cells.last(), points.last_mut())
        && geometry.cell_at(query.goal.point()) == Some(*cell)
    {
        *point = query.goal.point();
    }
    let mut samples = spline.samples.clamp(1, SAMPLES_MAX);
    loop {
        curve.clear();
        curve.push(points[0]);
        let mut sharpest = 0.0_f64;
        for control in segments(&points, spline.ends) {
            let pieces = if is_straight(&control) { 1 } else { samples };
            for piece in 1..=pieces {
                let point = point_on(&control, f64::from(piece) / f64::from(pieces));
                sharpest = sharpest.max(point.curvature.abs());
                curve.push(point.at);
            }
        }
        remarks.curvature_max_1pm = sharpest;
        if curve.len() <= WAYPOINTS_MAX || samples == 1 {
            break;
        }
        samples /= 2;
    }
    let is_legal = |point: &Point2<f64>| {
        geometry.cell_at(*point).is_some_and(|cell| {
            let free = query
                .map
                .get(cell)
                .is_some_and(|c| !query.unknown.blocks(c));
            free || cells.contains(&cell)
        })
    };
    if !curve.iter().all(is_legal) {
        curve.clear();
        remarks.curve_dropped = true;
        remarks.curvature_max_1pm = 0.0;
    }
}

fn is_straight(control: &[Point2<f64>; 4]) -> bool {
    let along = control[3] - control[0];
    let aside = |point: &Point2<f64>| along.perp(&(point - control[0])).abs();
    aside(&control[1]) + aside(&control[2]) <= 1e-9 * along.norm_squared()
}
