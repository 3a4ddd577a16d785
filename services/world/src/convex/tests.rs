use super::*;
use core::f64::consts::{FRAC_PI_4, PI, SQRT_2, TAU};

fn p(x: f64, y: f64) -> Point2<f64> {
    Point2::new(x, y)
}

fn square(cx: f64, cy: f64, half: f64) -> Convex {
    Convex::rectangle([2.0 * half; 2]).placed(&Pose::new(cx, cy, 0.0))
}

/// The same as a polygon.
fn polygon(form: &Convex) -> Convex {
    Convex::polygon(&form.corners().collect::<Vec<_>>()).unwrap()
}

fn disc(x: f64, y: f64, radius_m: f64) -> Convex {
    Convex::disc(p(x, y), radius_m)
}

#[track_caller]
fn check(actual: f64, expected: f64) {
    assert!(
        (actual - expected).abs() < 1e-9,
        "{actual} instead of {expected}"
    );
}

/// Both ways around, and with every box also as a polygon.
#[track_caller]
fn check_pair(a: &Convex, b: &Convex, expected: f64) {
    let both = |form: &Convex| {
        if form.is_disc() {
            vec![form.clone()]
        } else {
            vec![form.clone(), polygon(form)]
        }
    };
    for a in both(a) {
        for b in both(b) {
            check(a.distance_m(&b), expected);
            check(b.distance_m(&a), expected);
        }
    }
}

#[test]
fn distances_between_all_kinds() {
    check_pair(&disc(0.0, 0.0, 1.0), &disc(3.0, 4.0, 1.5), 2.5);
    check_pair(&disc(0.0, 0.0, 1.0), &disc(1.0, 0.0, 1.5), 0.0);
    check_pair(&disc(3.0, 0.0, 0.5), &square(0.0, 0.0, 1.0), 1.5);
    // Over the corner (1, 1): the diagonal.
    check_pair(&square(0.0, 0.0, 1.0), &disc(4.0, 5.0, 2.0), 3.0);
    check_pair(&disc(0.2, 0.1, 0.1), &square(0.0, 0.0, 1.0), 0.0);
    check_pair(&square(0.0, 0.0, 1.0), &square(5.0, 6.0, 1.0), 5.0);
    check_pair(&square(0.0, 0.0, 1.0), &square(0.0, 2.5, 1.0), 0.5);
    check_pair(&square(0.0, 0.0, 1.0), &square(0.0, 2.0, 1.0), 0.0);
    check_pair(&square(0.0, 0.0, 1.0), &square(0.1, 0.0, 0.2), 0.0);
}

#[test]
fn a_turned_square_reaches_farther_with_its_corner() {
    let turned = square(0.0, 0.0, 1.0).placed(&Pose::new(0.0, 0.0, FRAC_PI_4));
    check_pair(&turned, &square(3.0, 0.0, 1.0), 2.0 - SQRT_2);
    for form in [polygon(&turned), turned] {
        check(form.distance_to_point_m(p(SQRT_2 + 0.25, 0.0)), 0.25);
        let slab = Aabb::new(Vec2::new(2.0, -9.0), Vec2::new(2.1, 9.0));
        check(form.distance_to_bounds_m(&slab), 2.0 - SQRT_2);
    }
}

#[test]
fn crossing_rectangles_without_a_corner_inside_touch() {
    let upright = Convex::rectangle([0.2, 4.0]);
    let lying = Convex::rectangle([4.0, 0.2]);
    check_pair(&upright, &lying, 0.0);
}

#[test]
fn polylines_pass_by_touch_and_cross() {
    let chain = [p(-5.0, 3.0), p(0.0, 3.0), p(5.0, 0.5)];
    check(square(-2.0, 0.0, 1.0).distance_to_polyline_m(&chain), 2.0);
    check(disc(-2.0, 0.0, 1.0).distance_to_polyline_m(&chain), 2.0);
    check(square(0.0, 3.0, 0.5).distance_to_polyline_m(&chain), 0.0);
    // Crosses without ending inside.
    let through = [p(-5.0, 0.0), p(5.0, 0.0)];
    check(square(0.0, 0.0, 1.0).distance_to_polyline_m(&through), 0.0);
    check(
        square(0.0, 0.0, 1.0).distance_to_polyline_m(&[p(0.0, 1.75)]),
        0.75,
    );
    assert!(
        square(0.0, 0.0, 1.0)
            .distance_to_polyline_m(&[])
            .is_infinite()
    );
    // A chain whose points coincide is a point.
    check(
        disc(0.0, 0.0, 1.0).distance_to_polyline_m(&[p(2.0, 0.0), p(2.0, 0.0)]),
        1.0,
    );
}

#[test]
fn strips_cut_discs_and_polygons() {
    let (low, high) = disc(1.0, 0.0, 5.0).extent_in_strip(3.0, 4.0).unwrap();
    check(low, -3.0);
    check(high, 5.0);
    assert_eq!(disc(1.0, 0.0, 5.0).extent_in_strip(5.1, 6.0), None);
    let turned = square(0.0, 0.0, 1.0).placed(&Pose::new(0.0, 0.0, FRAC_PI_4));
    let (low, high) = turned.extent_in_strip(0.25, 0.5).unwrap();
    check(low, 0.25 - SQRT_2);
    check(high, SQRT_2 - 0.25);
    let (low, high) = turned.extent_in_strip(-9.0, 9.0).unwrap();
    check(low, -SQRT_2);
    check(high, SQRT_2);
    assert_eq!(turned.extent_in_strip(1.5, 2.0), None);
}

#[test]
fn what_is_nowhere_or_beyond_all_maps_is_no_panic() {
    let forms = [
        disc(0.0, 0.0, 1.0),
        square(0.0, 0.0, 1.0),
        polygon(&square(0.0, 0.0, 1.0)),
    ];
    let odd = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300, -1e300];
    for a in &forms {
        for b in &forms {
            for x in odd {
                for pose in [Pose::new(x, 0.0, 0.0), Pose::new(x, x, x)] {
                    let distance_m = a.distance_m(&b.placed(&pose));
                    assert!(
                        !distance_m.is_nan() && distance_m >= 0.0,
                        "{x}: {a:?} {b:?}"
                    );
                }
                for y in odd {
                    let distance_m = a.distance_to_segment_m(p(x, y), p(y, 1.0));
                    assert!(distance_m >= 0.0, "{x} {y}: {distance_m}");
                    let distance_m = a.distance_to_point_m(p(x, y));
                    assert!(distance_m >= 0.0, "{x} {y}: {distance_m}");
                }
            }
        }
    }
}

/// Numbers from a seed, the same everywhere.
struct Random(u64);

impl Random {
    /// Uniform in `low..high`.
    fn within(&mut self, low: f64, high: f64) -> f64 {
        // Knuth, MMIX.
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        let unit = f64::from(u32::try_from(self.0 >> 32).unwrap()) / f64::from(u32::MAX);
        low + (high - low) * unit
    }

    /// A form of some size and place; sizes run over orders of magnitude.
    fn form(&mut self, kind: u32, spread_m: f64) -> Convex {
        let mut length = || 10.0_f64.powf(self.within(-3.0, spread_m.log10() + 0.3));
        let size_m = [length(), length()];
        let form = match kind {
            0 => disc(0.0, 0.0, size_m[0]),
            1 => Convex::rectangle(size_m),
            _ => {
                let n = if kind == 2 { 5 } else { 60 };
                let start_rad = self.within(0.0, TAU);
                let corner = |k: u32| {
                    let angle_rad = start_rad + TAU * f64::from(k) / f64::from(n);
                    p(size_m[0] * angle_rad.cos(), size_m[1] * angle_rad.sin())
                };
                Convex::polygon(&(0..n).map(corner).collect::<Vec<_>>()).unwrap()
            }
        };
        form.placed(&Pose::new(
            self.within(-spread_m, spread_m),
            self.within(-spread_m, spread_m),
            self.within(-PI, PI),
        ))
    }
}

/// Brute force in f64 over corners and edges: the reference.
mod brute {
    use super::*;

    /// Corners of a form and how far it reaches beyond their hull.
    fn rounded(form: &Convex) -> (Vec<Point2<f64>>, f64) {
        match form.form().as_ball() {
            Some(ball) => (vec![point2(form.pose().translation)], ball.radius),
            None => (form.corners().collect(), 0.0),
        }
    }

    fn edges(corners: &[Point2<f64>]) -> impl Iterator<Item = (Point2<f64>, Point2<f64>)> + '_ {
        let next = corners.iter().cycle().skip(1);
        corners.iter().zip(next).map(|(a, b)| (*a, *b))
    }

    fn point_segment_m(point: Point2<f64>, a: Point2<f64>, b: Point2<f64>) -> f64 {
        let along = b - a;
        let square = along.norm_squared();
        let t = if square > 0.0 {
            ((point - a).dot(&along) / square).clamp(0.0, 1.0)
        } else {
            0.0
        };
        (point - (a + along * t)).norm()
    }

    /// Separating axis theorem: apart exactly when an edge of one has all of the other beyond it.
    fn is_beyond_an_edge(a: &[Point2<f64>], b: &[Point2<f64>]) -> bool {
        edges(a).any(|(from, to)| b.iter().all(|at| (to - from).perp(&(at - from)) < 0.0))
    }

    pub(super) fn hulls_m(a: &[Point2<f64>], b: &[Point2<f64>]) -> f64 {
        // A segment has no inner side; both of its edges have nothing beyond them on one side.
        if (a.len() > 2 || b.len() > 2) && !is_beyond_an_edge(a, b) && !is_beyond_an_edge(b, a) {
            return 0.0;
        }
        let one_way = |a: &[Point2<f64>], b: &[Point2<f64>]| {
            a.iter()
                .flat_map(|corner| edges(b).map(move |(c, d)| point_segment_m(*corner, c, d)))
                .fold(f64::INFINITY, f64::min)
        };
        one_way(a, b).min(one_way(b, a))
    }

    pub(super) fn distance_m(a: &Convex, b: &Convex) -> f64 {
        let ((a, a_m), (b, b_m)) = (rounded(a), rounded(b));
        (hulls_m(&a, &b) - a_m - b_m).max(0.0)
    }

    pub(super) fn to_points_m(a: &Convex, b: &[Point2<f64>]) -> f64 {
        let (a, a_m) = rounded(a);
        (hulls_m(&a, b) - a_m).max(0.0)
    }
}

#[test]
fn all_distances_agree_with_brute_force() {
    let seed = 7;
    eprintln!("seed {seed}");
    let mut random = Random(seed);
    let mut apart = 0;
    for case in 0..60_000_u32 {
        let spread_m = [2.0, 20.0, 500.0][case as usize % 3];
        let a = random.form(case / 3 % 4, spread_m);
        let b = random.form(case / 12 % 4, spread_m);
        // GJK stops within 5e-8 of the distance; rounding grows with the size.
        let close = |found: f64, expected: f64, what: &str| {
            let allowed = 1e-7 * expected + 1e-12 * spread_m;
            assert!(
                (found - expected).abs() <= allowed,
                "case {case} {what}: {found}, not {expected}: {a:?} {b:?}"
            );
        };
        let expected = brute::distance_m(&a, &b);
        apart += u32::from(expected > 0.0);
        close(a.distance_m(&b), expected, "pair");
        close(b.distance_m(&a), expected, "pair, other way around");
        let bounds = b.bounds();
        let rectangle = bounds.vertices().map(point2);
        let expected = brute::to_points_m(&a, &rectangle);
        close(a.distance_to_bounds_m(&bounds), expected, "rectangle");
        let ends = [0; 2].map(|_| {
            p(
                random.within(-spread_m, spread_m),
                random.within(-spread_m, spread_m),
            )
        });
        let expected = brute::to_points_m(&a, &ends[..1]);
        close(a.distance_to_point_m(ends[0]), expected, "point");
        let expected = brute::to_points_m(&a, &ends);
        close(
            a.distance_to_segment_m(ends[0], ends[1]),
            expected,
            "segment",
        );
    }
    assert!((30_000..58_000).contains(&apart), "{apart}");
}

#[test]
fn near_contacts_are_told_apart_to_a_hundredth_of_a_micrometre() {
    let seed = 11;
    eprintln!("seed {seed}");
    let mut random = Random(seed);
    for case in 0..20_000_u32 {
        let a = random.form(case % 4, 5.0);
        let b = random.form(case / 4 % 4, 5.0);
        // Shift b towards a until a wanted gap is left, over the map's corners too.
        let far = Vector2::new(random.within(-1e4, 1e4), random.within(-1e4, 1e4));
        let gap_m = 10.0_f64.powf(random.within(-6.0, -2.0));
        let way = point2(a.pose().translation) - point2(b.pose().translation);
        if brute::distance_m(&a, &b) < gap_m || way.norm() == 0.0 {
            continue;
        }
        let shifted = |form: &Convex, by: Vector2<f64>| form.placed(&Pose::new(by.x, by.y, 0.0));
        let (mut free, mut touching) = (0.0, 1.0);
        for _ in 0..60 {
            let middle = 0.5 * (free + touching);
            if brute::distance_m(&a, &shifted(&b, way * middle)) >= gap_m {
                free = middle;
            } else {
                touching = middle;
            }
        }
        let (a, b) = (shifted(&a, far), shifted(&b, way * free + far));
        let found = a.distance_m(&b);
        assert!(
            (found - gap_m).abs() < 1e-8,
            "case {case}: {found}, not {gap_m}: {a:?} {b:?}"
        );
    }
}
