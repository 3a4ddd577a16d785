//! The robot's outline: exact distances for points, covering discs for the clearance field.

use nalgebra::{Point2, Vector2};
use zeronav_msgs::description::{Corner, Description};

/// Share of a polygon's extent by which a covering disc may stand out over its edges.
const OVERHANG_SHARE: f64 = 0.04;

/// The same for the rough covering; its discs are then made smaller by half of that, so that it is
/// right to within half of that either way.
const ROUGH_SHARE: f64 = 0.12;

/// Cells of the sampling lattice along a polygon's extent.
const LATTICE: i32 = 40;

/// Most covering discs.
pub(crate) const DISCS_MAX: usize = 64;

/// A disc of a covering.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Disc {
    /// Its centre in `base`. [m]
    pub(crate) centre: Point2<f64>,
    /// [m]
    pub(crate) radius_m: f64,
}

/// The outline prepared for queries.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Footprint {
    corners: Vec<Point2<f64>>,
    /// [m] a disc around the origin inside the outline.
    pub(crate) inscribed_m: f64,
    /// [m] a disc around the origin that holds the outline.
    pub(crate) circumscribed_m: f64,
    /// Discs whose union holds the outline; a disc robot is one.
    pub(crate) discs: Vec<Disc>,
    /// A few discs whose union is the outline give or take 6 % of its extent, for what is checked
    /// again before it counts.
    pub(crate) rough: Vec<Disc>,
}

impl Footprint {
    /// The outline of `robot`; no corners = a disc of its circumscribed radius.
    pub(crate) fn new(robot: &Description, corners: &[Corner]) -> Self {
        let corners: Vec<Point2<f64>> = corners
            .iter()
            .map(|corner| Point2::new(corner.x_m, corner.y_m))
            .collect();
        if corners.len() < 3 {
            let radius_m = robot.circumscribed_radius_m;
            let disc = Disc {
                centre: Point2::origin(),
                radius_m,
            };
            return Self {
                corners: Vec::new(),
                inscribed_m: radius_m,
                circumscribed_m: radius_m,
                discs: vec![disc],
                rough: vec![disc],
            };
        }
        let reach_m = corners.iter().map(|c| c.coords.norm()).fold(0.0, f64::max);
        let inside_m = -polygon_distance_m(&corners, Point2::origin());
        Self {
            discs: cover(&corners, OVERHANG_SHARE),
            rough: rough(&corners),
            corners,
            // The outline decides; the description may say less, never more.
            inscribed_m: inside_m.clamp(0.0, robot.inscribed_radius_m),
            circumscribed_m: reach_m.max(robot.circumscribed_radius_m),
        }
    }

    /// True for a disc, which can always turn on the spot.
    pub(crate) fn is_disc(&self) -> bool {
        self.corners.is_empty()
    }

    /// Signed distance of a point in `base` from the outline: negative inside. [m]
    pub(crate) fn distance_m(&self, point: Point2<f64>) -> f64 {
        if self.is_disc() {
            point.coords.norm() - self.circumscribed_m
        } else {
            polygon_distance_m(&self.corners, point)
        }
    }

    /// Signed distance of a square from the outline: its centre in `base` [m], the direction of one of
    /// its sides, and half of a side [m]. Negative where they overlap.
    pub(crate) fn square_distance_m(
        &self,
        centre: Point2<f64>,
        side: Vector2<f64>,
        half_m: f64,
    ) -> f64 {
        let across = Vector2::new(-side.y, side.x);
        let outside_m = |point: Point2<f64>| {
            let offset = point - centre;
            let over = Vector2::new(offset.dot(&side).abs(), offset.dot(&across).abs())
                - Vector2::repeat(half_m);
            over.sup(&Vector2::zeros()).norm() + over.max().min(0.0)
        };
        if self.is_disc() {
            return outside_m(Point2::origin()) - self.circumscribed_m;
        }
        // Two convex shapes are nearest at a corner of one of them.
        let (a, b) = (side * half_m, across * half_m);
        let corners = [
            centre + a + b,
            centre + a - b,
            centre - a + b,
            centre - a - b,
        ];
        let of_square = corners.map(|corner| polygon_distance_m(&self.corners, corner));
        let of_outline = self.corners.iter().map(|corner| outside_m(*corner));
        of_square
            .into_iter()
            .chain(of_outline)
            .fold(f64::INFINITY, f64::min)
    }

    /// The lowest and the highest corner of a box around the outline along the axes of `base`. [m]
    pub(crate) fn bounds(&self) -> (Point2<f64>, Point2<f64>) {
        if self.is_disc() {
            let reach = Vector2::repeat(self.circumscribed_m);
            return (Point2::from(-reach), Point2::from(reach));
        }
        let first = self.corners[0];
        self.corners
            .iter()
            .fold((first, first), |(low, high), corner| {
                (low.inf(corner), high.sup(corner))
            })
    }
}

/// Signed distance of `point` from a convex, counter-clockwise polygon. [m]
fn polygon_distance_m(corners: &[Point2<f64>], point: Point2<f64>) -> f64 {
    let mut inside_m = f64::NEG_INFINITY;
    let mut outside_m = f64::INFINITY;
    for (i, &from) in corners.iter().enumerate() {
        let to = corners[(i + 1) % corners.len()];
        let edge = to - from;
        let length_m = edge.norm();
        if length_m <= 0.0 {
            continue;
        }
        let along = edge / length_m;
        let offset = point - from;
        inside_m = inside_m.max(offset.dot(&Vector2::new(along.y, -along.x)));
        let nearest = from + along * offset.dot(&along).clamp(0.0, length_m);
        outside_m = outside_m.min((point - nearest).norm());
    }
    if inside_m <= 0.0 { inside_m } else { outside_m }
}

/// Largest extent of a polygon along the axes of `base`. [m]
fn extent(corners: &[Point2<f64>]) -> (Point2<f64>, f64) {
    let (mut low, mut high) = (corners[0], corners[0]);
    for corner in corners {
        low = low.inf(corner);
        high = high.sup(corner);
    }
    (low, (high - low).max())
}

/// Few discs whose union is nearly the polygon.
fn rough(corners: &[Point2<f64>]) -> Vec<Disc> {
    let mut discs = cover(corners, ROUGH_SHARE);
    let less_m = 0.5 * ROUGH_SHARE * extent(corners).1;
    for disc in &mut discs {
        disc.radius_m -= less_m;
    }
    discs
}

/// Discs whose union holds the polygon, none standing out by more than a share of its extent.
///
/// Greedy set cover over a lattice of the inside and points on the edges. Every point of the
/// polygon is within 0.87 pitches of a sample, and a disc covers a sample only together with
/// that surrounding, so nothing between the samples is missed.
fn cover(corners: &[Point2<f64>], overhang_share: f64) -> Vec<Disc> {
    let (low, extent_m) = extent(corners);
    let pitch_m = extent_m / f64::from(LATTICE);
    let around_m = 0.87 * pitch_m;
    let overhang_m = overhang_share * extent_m;
    let mut samples: Vec<Point2<f64>> = Vec::new();
    let mut candidates: Vec<Disc> = Vec::new();
    for row in 0..=LATTICE {
        for column in 0..=LATTICE {
            let at = low + Vector2::new(f64::from(column), f64::from(row)) * pitch_m;
            let depth_m = -polygon_distance_m(corners, at);
            if depth_m < 0.0 {
                continue;
            }
            samples.push(at);
            if row % 2 == 0 && column % 2 == 0 {
                candidates.push(Disc {
                    centre: at,
                    radius_m: depth_m + overhang_m,
                });
            }
        }
    }
    for (i, &from) in corners.iter().enumerate() {
        let to = corners[(i + 1) % corners.len()];
        for share in 0..LATTICE {
            samples.push(from + (to - from) * (f64::from(share) / f64::from(LATTICE)));
        }
    }
    // The middle and what lies just inside the corners are worth having whatever the lattice.
    let centroid = corners.iter().map(|c| c.coords).sum::<Vector2<f64>>()
        / f64::from(u32::try_from(corners.len()).unwrap_or(1));
    for corner in corners {
        for share in 0..=24 {
            let at = Point2::from(corner.coords.lerp(&centroid, f64::from(share) / 48.0));
            candidates.push(Disc {
                centre: at,
                radius_m: overhang_m - polygon_distance_m(corners, at),
            });
        }
    }
    let mut discs = Vec::new();
    while !samples.is_empty() && discs.len() < DISCS_MAX {
        let covers =
            |disc: &Disc, at: &Point2<f64>| (at - disc.centre).norm() + around_m <= disc.radius_m;
        let mut best: Option<(usize, Disc)> = None;
        for disc in &candidates {
            let n = samples.iter().filter(|at| covers(disc, at)).count();
            if n > best.map_or(0, |(most, _)| most) {
                best = Some((n, *disc));
            }
        }
        let Some((_, disc)) = best else {
            break;
        };
        samples.retain(|at| !covers(&disc, at));
        discs.push(disc);
    }
    if !samples.is_empty() {
        // A shape too thin for the lattice: one disc around everything is always right.
        discs.clear();
        discs.push(Disc {
            centre: Point2::origin(),
            radius_m: corners.iter().map(|c| c.coords.norm()).fold(0.0, f64::max),
        });
    }
    discs
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg32;

    fn corners(points: &[(f64, f64)]) -> Vec<Corner> {
        let corner = |&(x_m, y_m): &(f64, f64)| Corner { x_m, y_m };
        points.iter().map(corner).collect()
    }

    fn jackal() -> (Description, Vec<Corner>) {
        let robot = Description {
            inscribed_radius_m: 0.215,
            circumscribed_radius_m: 0.333,
            ..Description::default()
        };
        let outline = [
            (0.254, 0.215),
            (-0.254, 0.215),
            (-0.254, -0.215),
            (0.254, -0.215),
        ];
        (robot, corners(&outline))
    }

    #[test]
    fn distances_of_a_rectangle_are_exact() {
        let (robot, corners) = jackal();
        let footprint = Footprint::new(&robot, &corners);
        let check = |x: f64, y: f64, expected: f64| {
            let found = footprint.distance_m(Point2::new(x, y));
            assert!((found - expected).abs() < 1e-12, "{found} at {x}, {y}");
        };
        check(0.0, 0.0, -0.215);
        check(0.354, 0.0, 0.1);
        check(0.254, 0.0, 0.0);
        check(0.254 + 0.3, 0.215 + 0.4, 0.5);
        assert!((footprint.inscribed_m - 0.215).abs() < 1e-12);
    }

    #[test]
    fn distances_of_squares_are_exact() {
        let (robot, corners) = jackal();
        let footprint = Footprint::new(&robot, &corners);
        let along = Vector2::new(1.0, 0.0);
        let slanted = Vector2::new(0.5_f64.sqrt(), 0.5_f64.sqrt());
        let half_diagonal_m = 0.025 * 2.0_f64.sqrt();
        for (x, y, side, expected) in [
            // Side to side, corner to side, corner to corner, and the outline's corner to a side.
            (0.354, 0.0, along, 0.075),
            (0.0, 0.415, slanted, 0.2 - half_diagonal_m),
            (0.254 + 0.325, 0.215 + 0.425, along, 0.5),
            (
                0.254 + 0.1,
                0.215 + 0.1,
                slanted,
                0.1 * 2.0_f64.sqrt() - 0.025,
            ),
            // Into it by a centimetre.
            (0.254 + 0.015, 0.0, along, -0.01),
        ] {
            let found = footprint.square_distance_m(Point2::new(x, y), side, 0.025);
            assert!((found - expected).abs() < 1e-12, "{found} at {x}, {y}");
        }
        let disc = Footprint::new(&robot, &[]);
        let found = disc.square_distance_m(Point2::new(0.433, 0.0), along, 0.025);
        assert!((found - 0.075).abs() < 1e-12, "{found}");
    }

    #[test]
    fn discs_cover_the_outline_and_little_more() {
        let (robot, rectangle) = jackal();
        let wedge = corners(&[(0.4, 0.0), (-0.2, 0.3), (-0.3, 0.0), (-0.2, -0.3)]);
        let long = corners(&[(0.8, 0.25), (-0.4, 0.25), (-0.4, -0.25), (0.8, -0.25)]);
        for outline in [rectangle, wedge, long] {
            let robot = Description {
                inscribed_radius_m: 0.2,
                circumscribed_radius_m: 0.3,
                ..robot
            };
            let footprint = Footprint::new(&robot, &outline);
            assert!(footprint.discs.len() <= 40);
            assert!(footprint.rough.len() <= 12, "{}", footprint.rough.len());
            let overhang_m = OVERHANG_SHARE * extent(&footprint.corners).1;
            let rough_m = 0.5 * ROUGH_SHARE * extent(&footprint.corners).1 + 1e-9;
            let mut random = Pcg32::seed_from_u64(3);
            for _ in 0..20_000 {
                let at = Point2::new(
                    random.random_range(-1.0..1.0),
                    random.random_range(-0.5..0.5),
                );
                let covered = footprint
                    .discs
                    .iter()
                    .any(|disc| (at - disc.centre).norm() <= disc.radius_m);
                let distance_m = footprint.distance_m(at);
                let rough = footprint.rough.iter();
                let about_m = rough
                    .map(|disc| (at - disc.centre).norm() - disc.radius_m)
                    .fold(f64::INFINITY, f64::min);
                assert!(distance_m > 0.0 || about_m <= rough_m, "{at} is inside");
                assert!(about_m > 0.0 || distance_m <= rough_m, "{at} is outside");
                assert!(covered || distance_m > 0.0, "{at} is inside, not covered");
                assert!(
                    !covered || distance_m <= overhang_m + 1e-9,
                    "{at} sticks out"
                );
            }
        }
    }
}
