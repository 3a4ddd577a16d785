//! The obstacles that a scan shows, as the potential fields count them: one for each convex piece.

use nalgebra::{Point2, Vector2};
use zeronav_casts::Cast;

/// Between neighbouring hits of two obstacles. [m]
const GAP_M: f64 = 0.3;

/// How far a hit lies behind a convex outline before it is one of another piece: more than the noise
/// of a lidar. [m]
const HOLLOW_M: f64 = 0.06;

/// Calls `found` with the hits of every convex piece, in the scan's order. `hits` are in `base`,
/// neighbours in the scan beside each other.
///
/// Hits without a gap between them belong together; where they form a hollow towards the robot, such
/// as the corner of a room, they are split at its deepest hit, which belongs to both sides. So a
/// straight wall, a pillar and the corner of a box that points at the robot are one piece each.
pub(super) fn convex_pieces<'a>(
    hits: &'a [Point2<f64>],
    hull: &mut Vec<usize>,
    found: &mut dyn FnMut(&'a [Point2<f64>]),
) {
    let mut first = 0;
    for end in 1..=hits.len() {
        let gap = |at: usize| (hits[at] - hits[at - 1]).norm() >= GAP_M;
        if end == hits.len() || gap(end) {
            split(&hits[first..end], hull, found);
            first = end;
        }
    }
}

fn split<'a>(
    mut chain: &'a [Point2<f64>],
    hull: &mut Vec<usize>,
    found: &mut dyn FnMut(&'a [Point2<f64>]),
) {
    while let Some(at) = deepest(chain, hull) {
        split(&chain[..=at], hull, found);
        chain = &chain[at..];
    }
    if !chain.is_empty() {
        found(chain);
    }
}

/// The hit that lies deepest behind the outline towards the robot, when that is a hollow.
fn deepest(chain: &[Point2<f64>], hull: &mut Vec<usize>) -> Option<usize> {
    // Beams may go either way round.
    let swept = chain
        .windows(2)
        .map(|pair| pair[0].coords.perp(&pair[1].coords));
    let way = swept.sum::<f64>().signum();
    let turn = |a: usize, b: usize, c: usize| {
        let (one, other) = (chain[b] - chain[a], chain[c] - chain[b]);
        one.perp(&other) * way
    };
    // The outline of a convex piece turns away from the robot all along.
    hull.clear();
    for at in 0..chain.len() {
        while let [.., a, b] = hull[..]
            && turn(a, b, at) > 0.0
        {
            hull.pop();
        }
        hull.push(at);
    }
    let mut hollow = (HOLLOW_M, None);
    for edge in hull.windows(2) {
        let (from, along) = (chain[edge[0]], chain[edge[1]] - chain[edge[0]]);
        let behind = (edge[0] + 1..edge[1]).zip(&chain[edge[0] + 1..edge[1]]);
        for (at, hit) in behind {
            let depth_m = along.perp(&(hit - from)).abs() / along.norm().max(1.0e-9);
            // Of a wall that is as deep all along, its end.
            if depth_m > hollow.0 + 1.0e-6 {
                hollow = (depth_m, Some(at));
            }
        }
    }
    hollow.1
}

/// The point of a piece that is nearest to the robot. [m]
pub(super) fn nearest(piece: &[Point2<f64>]) -> Point2<f64> {
    let on_edge = piece.windows(2).map(|ends| {
        let along = ends[1] - ends[0];
        let share = -ends[0].coords.dot(&along) / along.norm_squared().max(1.0e-12);
        ends[0] + along * share.clamp(0.0, 1.0)
    });
    on_edge
        .chain(piece.first().copied())
        .min_by(|a, b| a.coords.norm().total_cmp(&b.coords.norm()))
        .unwrap_or_default()
}

/// The middle of a piece's hits. [m]
pub(super) fn middle(piece: &[Point2<f64>]) -> Point2<f64> {
    let sum = piece
        .iter()
        .fold(Vector2::zeros(), |sum, hit| sum + hit.coords);
    Point2::from(sum / piece.len().max(1).to_f64())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Hits every degree on walls between two corners each, the nearest along each beam.
    fn scan(walls: &[[(f64, f64); 2]], from_deg: i32, to_deg: i32) -> Vec<Point2<f64>> {
        (from_deg..=to_deg)
            .filter_map(|deg| {
                let (sin, cos) = f64::from(deg).to_radians().sin_cos();
                let ranges = walls.iter().filter_map(|[(ax, ay), (bx, by)]| {
                    let (wx, wy) = (bx - ax, by - ay);
                    let crossed = cos * wy - sin * wx;
                    let range = (ax * wy - ay * wx) / crossed;
                    let share = (ax * sin - ay * cos) / crossed;
                    (range > 0.0 && (0.0..=1.0).contains(&share)).then_some(range)
                });
                let range = ranges.fold(f64::INFINITY, f64::min);
                range
                    .is_finite()
                    .then(|| Point2::new(range * cos, range * sin))
            })
            .collect()
    }

    fn count(hits: &[Point2<f64>]) -> usize {
        let mut n = 0;
        convex_pieces(hits, &mut Vec::new(), &mut |_| n += 1);
        n
    }

    #[test]
    fn a_straight_wall_is_one_piece_and_the_corner_of_a_room_two() {
        let wall = [[(2.0, -3.0), (2.0, 3.0)]];
        assert_eq!(count(&scan(&wall, -50, 50)), 1);
        let corner = [[(2.0, -3.0), (2.0, 2.0)], [(2.0, 2.0), (-3.0, 2.0)]];
        let mut hits = scan(&corner, -40, 120);
        assert_eq!(count(&hits), 2);
        hits.reverse();
        assert_eq!(count(&hits), 2, "the other way round");
        let u = [
            [(2.0, -1.0), (2.0, 1.0)],
            [(2.0, 1.0), (-1.0, 1.0)],
            [(-1.0, -1.0), (2.0, -1.0)],
        ];
        assert_eq!(count(&scan(&u, -100, 100)), 3);
    }

    #[test]
    fn a_box_and_a_pillar_are_one_piece_each() {
        // A corner that points at the robot.
        let cube = [[(2.0, 0.0), (3.0, 1.0)], [(2.0, 0.0), (3.0, -1.0)]];
        assert_eq!(count(&scan(&cube, -30, 30)), 1);
        let pillar: Vec<Point2<f64>> = (-20..=20)
            .map(|deg| {
                let (sin, cos) = (180.0 + 4.0 * f64::from(-deg)).to_radians().sin_cos();
                Point2::new(2.0 + 0.4 * cos, 0.4 * sin)
            })
            .collect();
        assert_eq!(count(&pillar), 1);
        // Two of them are two.
        let far: Vec<_> = pillar
            .iter()
            .map(|at| Point2::new(at.x, at.y + 2.0))
            .collect();
        assert_eq!(count(&[pillar, far].concat()), 2);
        assert_eq!(count(&[]), 0);
    }

    #[test]
    fn noise_makes_no_pieces() {
        let wall = [[(2.0, -3.0), (2.0, 3.0)]];
        let mut hits = scan(&wall, -50, 50);
        for (i, hit) in hits.iter_mut().enumerate() {
            hit.x += if i % 3 == 0 { 0.02 } else { -0.01 };
        }
        assert_eq!(count(&hits), 1);
    }

    #[test]
    fn the_nearest_point_lies_between_hits_too() {
        let near = nearest(&[Point2::new(2.0, -0.5), Point2::new(2.0, 1.0)]);
        assert!((near - Point2::new(2.0, 0.0)).norm() < 1e-12, "{near}");
        let only = nearest(&[Point2::new(1.0, 1.0)]);
        assert!((only - Point2::new(1.0, 1.0)).norm() < 1e-12);
    }
}
