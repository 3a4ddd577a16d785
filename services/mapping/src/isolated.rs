//! Isolated returns: one beam in a thousand comes back from dust, rain or between two edges.

use crate::beams::Beam;
use nalgebra::Point2;

/// How far apart the ends of neighbouring beams on one obstacle may lie, besides [`SAME_SPREADS`]. [m]
const SAME_M: f64 = 0.1;

/// The same in distances between the beams at that range, for surfaces seen at a slant.
const SAME_SPREADS: f64 = 3.0;

/// Largest angle between neighbouring beams; the last and the first beam are neighbours only when
/// the lidar sees all around. [rad]
const NEIGHBOURS_SPREAD_MAX: f64 = 0.3;

/// True when beam `n` was returned and neither of its neighbours ended near its end.
pub(crate) fn is_isolated(beams: &[Beam], n: usize) -> bool {
    let Some((beam, point)) = beams.get(n).and_then(|beam| Some((beam, beam.point()?))) else {
        return false;
    };
    let range_m = (point - beam.origin).norm();
    let sees_it = |other: usize| {
        let other = &beams[other];
        let spread = (other.direction - beam.direction).norm();
        let gap_m = SAME_M + SAME_SPREADS * spread * range_m;
        let near = |end: Point2<f64>| (end - point).norm() <= gap_m;
        spread < NEIGHBOURS_SPREAD_MAX && other.point().is_some_and(near)
    };
    let last = beams.len() - 1;
    let before = if n == 0 { last } else { n - 1 };
    let after = if n == last { 0 } else { n + 1 };
    !sees_it(before) && !sees_it(after)
}
