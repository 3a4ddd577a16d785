//! The robot's true outline, and how far points are from it.

use nalgebra::Vector2;
use zeronav_motion::Twist;
use zeronav_msgs::description::{Corner, Description, FOOTPRINT_CORNERS_MAX};

/// An edge of the outline.
#[derive(Debug, Clone, Copy, Default)]
struct Edge {
    /// Where it begins. [m]
    from: Vector2<f64>,
    /// Unit vector along it, the outline to its left.
    along: Vector2<f64>,
    /// [m]
    length_m: f64,
    /// [m] from the origin of the frame to the edge's line, along the outward normal.
    offset_m: f64,
}

impl Edge {
    fn new(from: Vector2<f64>, along: Vector2<f64>, length_m: f64) -> Self {
        Self {
            from,
            along,
            length_m,
            offset_m: from.x * along.y - from.y * along.x,
        }
    }

    /// Signed distance from the edge's line, positive outside. [m]
    fn across_m(&self, x: f64, y: f64) -> f64 {
        x * self.along.y - y * self.along.x - self.offset_m
    }
}

/// A disc or a convex polygon. No allocation.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Outline {
    edges: [Edge; FOOTPRINT_CORNERS_MAX],
    /// 0 = a disc of the radius below.
    n_edges: usize,
    /// Where the origin of `base` is; zero for an outline in `base`.
    middle: Vector2<f64>,
    /// [m] of the smallest disc around the origin of `base` that holds the outline.
    pub(crate) radius_m: f64,
}

impl Outline {
    /// The outline of a description that passed its check; no corners = a disc.
    pub(crate) fn new(description: &Description, corners: &[Corner]) -> Self {
        let mut outline = Self {
            edges: [Edge::default(); FOOTPRINT_CORNERS_MAX],
            n_edges: 0,
            middle: Vector2::zeros(),
            radius_m: description.circumscribed_radius_m,
        };
        let at = |corner: &Corner| Vector2::new(corner.x_m, corner.y_m);
        let next = corners.iter().skip(1).chain(corners.first());
        let edges = corners
            .iter()
            .zip(next)
            .map(|(from, to)| (at(from), at(to)));
        for (from, to) in edges.take(FOOTPRINT_CORNERS_MAX) {
            outline.radius_m = outline.radius_m.max(from.norm());
            let length_m = (to - from).norm();
            if length_m > 0.0 {
                outline.edges[outline.n_edges] = Edge::new(from, (to - from) / length_m, length_m);
                outline.n_edges += 1;
            }
        }
        outline
    }

    /// True for a disc, which turns in itself.
    pub(crate) const fn is_disc(&self) -> bool {
        self.n_edges == 0
    }

    /// [m/s] of the outline's fastest point.
    pub(crate) fn speed_mps(&self, twist: Twist) -> f64 {
        let reach_m = if self.is_disc() { 0.0 } else { self.radius_m };
        twist.v_mps.abs() + twist.w_radps.abs() * reach_m
    }

    /// How far the outline reaches forwards, backwards and to the left and right when it has turned
    /// by at most `turned_rad` to either side: bounds from above. [m]
    pub(crate) fn extents(&self, turned_rad: f64) -> (f64, f64, (f64, f64)) {
        let radius_m = self.radius_m;
        if self.is_disc() {
            return (radius_m, radius_m, (radius_m, radius_m));
        }
        let sin = if turned_rad < core::f64::consts::FRAC_PI_2 {
            turned_rad.sin()
        } else {
            return (radius_m, radius_m, (radius_m, radius_m));
        };
        // Of a corner (x, y) the new x is at most max(x, 0) + |y| sin, and so on.
        let most = |of: fn(Vector2<f64>, f64) -> f64| {
            let corners = self.edges[..self.n_edges].iter();
            corners.fold(0.0, |most: f64, edge| most.max(of(edge.from, sin)))
        };
        let forward = most(|at, sin| at.x.max(0.0) + at.y.abs() * sin);
        let backward = most(|at, sin| (-at.x).max(0.0) + at.y.abs() * sin);
        let left = most(|at, sin| at.y.max(0.0) + at.x.abs() * sin);
        let right = most(|at, sin| (-at.y).max(0.0) + at.x.abs() * sin);
        (
            forward.min(radius_m),
            backward.min(radius_m),
            (left.min(radius_m), right.min(radius_m)),
        )
    }

    /// Becomes the outline of a robot at `at` with this sine and cosine of its yaw, in
    /// the frame of these; `in_base` is the one that this outline was copied from.
    pub(crate) fn place(&mut self, in_base: &Self, at: Vector2<f64>, (sin, cos): (f64, f64)) {
        let turned = |v: Vector2<f64>| Vector2::new(cos * v.x - sin * v.y, sin * v.x + cos * v.y);
        self.middle = at;
        let edges = self.edges[..self.n_edges].iter_mut();
        for (edge, from) in edges.zip(&in_base.edges) {
            *edge = Edge::new(at + turned(from.from), turned(from.along), from.length_m);
        }
    }

    /// Bounds from below on the signed distances of several points, `x` and `y` in the outline's
    /// frame; exact inside and where an edge is nearest. [m]
    pub(crate) fn at_least_m<const N: usize>(&self, x: &[f64; N], y: &[f64; N]) -> [f64; N] {
        if self.is_disc() {
            return core::array::from_fn(|i| self.circle_m(Vector2::new(x[i], y[i])));
        }
        let mut most_m = [f64::NEG_INFINITY; N];
        for edge in &self.edges[..self.n_edges] {
            for i in 0..N {
                let across_m = edge.across_m(x[i], y[i]);
                // Not `max`, whose rule for NaN costs as much as the rest.
                most_m[i] = if across_m > most_m[i] {
                    across_m
                } else {
                    most_m[i]
                };
            }
        }
        most_m
    }

    /// Signed distance from the disc that holds the outline. [m]
    pub(crate) fn circle_m(&self, point: Vector2<f64>) -> f64 {
        (point - self.middle).norm() - self.radius_m
    }

    /// Signed distance of a point in the outline's frame, negative inside. Exact when it is below
    /// `enough_m`; beyond it may be anything from `enough_m` up. [m]
    pub(crate) fn distance_m(&self, point: Vector2<f64>, enough_m: f64) -> f64 {
        let from_circle_m = self.circle_m(point);
        if self.is_disc() || from_circle_m >= enough_m {
            return from_circle_m;
        }
        // The largest distance from an edge's line is a bound from below, and exact inside.
        let [across_m] = self.at_least_m(&[point.x], &[point.y]);
        if across_m <= 0.0 || across_m >= enough_m {
            return across_m;
        }
        let edges = &self.edges[..self.n_edges];
        let squared = edges.iter().fold(f64::INFINITY, |least, edge| {
            let offset = point - edge.from;
            let share_m = offset.dot(&edge.along).clamp(0.0, edge.length_m);
            least.min((offset - edge.along * share_m).norm_squared())
        });
        squared.sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use parry2d::math::{Pose2, Vec2};
    use parry2d::query::PointQuery;
    use parry2d::shape::ConvexPolygon;
    use proptest::prelude::*;

    fn wedge() -> Vec<Corner> {
        [(0.4, 0.0), (-0.2, 0.3), (-0.3, 0.0), (-0.2, -0.3)]
            .map(|(x_m, y_m)| Corner { x_m, y_m })
            .to_vec()
    }

    proptest! {
        #[test]
        fn distances_are_those_of_parry(x in -1.0f64..1.0, y in -1.0f64..1.0) {
            let corners = wedge();
            let outline = Outline::new(&Description::default(), &corners);
            let points = corners.iter().map(|c| Vec2::new(c.x_m, c.y_m)).collect();
            let polygon = ConvexPolygon::from_convex_polyline(points).expect("a convex outline");
            let expected = polygon.distance_to_point(&Pose2::IDENTITY, Vec2::new(x, y), false);
            let found = outline.distance_m(Vector2::new(x, y), f64::INFINITY);
            prop_assert!((found - expected).abs() < 1e-6, "{} against {}", found, expected);
            let culled = outline.distance_m(Vector2::new(x, y), 0.2);
            prop_assert!((culled - found).abs() < 1e-12 || (culled >= 0.2 && found >= 0.2));
            let [bound] = outline.at_least_m(&[x], &[y]);
            prop_assert!(bound <= found + 1e-12, "{} is no bound of {}", bound, found);
        }
    }

    #[test]
    fn no_corners_are_a_disc_that_does_not_move_by_turning() {
        let description = Description {
            circumscribed_radius_m: 0.25,
            ..Description::default()
        };
        let outline = Outline::new(&description, &[]);
        let distance_m = outline.distance_m(Vector2::new(0.3, 0.4), f64::INFINITY);
        assert!((distance_m - 0.25).abs() < 1e-12);
        let turning = Twist {
            v_mps: 0.1,
            w_radps: 3.0,
        };
        assert!((outline.speed_mps(turning) - 0.1).abs() < 1e-12);
    }

    #[test]
    fn a_turned_outline_reaches_so_far_at_most() {
        let corners = [(0.4, 0.2), (-0.1, 0.2), (-0.1, -0.15), (0.4, -0.15)]
            .map(|(x_m, y_m)| Corner { x_m, y_m });
        let outline = Outline::new(&Description::default(), &corners);
        let sin = 0.1_f64.sin();
        let (forward, backward, (left, right)) = outline.extents(0.1);
        for (found, expected) in [
            (forward, 0.4 + 0.2 * sin),
            (backward, 0.1 + 0.2 * sin),
            (left, 0.2 + 0.4 * sin),
            (right, 0.15 + 0.4 * sin),
        ] {
            assert!((found - expected).abs() < 1e-12, "{found} not {expected}");
        }
        // No farther than its outermost corner, whatever the turn.
        let most = 0.4_f64.hypot(0.2);
        let most = (most, most, (most, most));
        for turned_rad in [1.5, 1.6, 9.0] {
            let found = outline.extents(turned_rad);
            let farther = found.0 > most.0 || found.1 > most.0 || found.2.0 > most.0;
            assert!(
                !farther && (turned_rad < 1.55 || found == most),
                "{found:?}"
            );
        }
        assert!((outline.speed_mps(Twist::new(-0.5, -2.0)) - 0.5 - 2.0 * most.0).abs() < 1e-12);
    }
}
