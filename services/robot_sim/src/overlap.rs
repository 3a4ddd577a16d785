//! How deep two convex sets are in each other.
//!
//! Only scripted obstacles can be inside the robot: they appear on it or walk into it. It may then
//! leave but not go deeper, so the depth must be known, not only that the distance is 0.
//!
//! Not parry's `contact`: its expanding polytope (EPA) now and then stops on the wrong face, with
//! depths of round polygons wrong by up to 0.2 m in f64, and it allocates. For two overlapping
//! convex polygons the shortest of all shifts is along a face normal of one, and those are few.

use nalgebra::Point2;
use parry2d::math::Vec2;
use zeronav_world::Convex;

/// Distance between the two, or, when they overlap, minus the shortest shift that parts them. [m]
#[must_use]
pub fn signed_distance_m(a: &Convex, b: &Convex) -> f64 {
    let distance_m = a.distance_m(b);
    if distance_m > 0.0 {
        distance_m
    } else {
        -depth_m(a, b).max(0.0)
    }
}

/// The shortest shift that parts two overlapping sets. [m]
fn depth_m(a: &Convex, b: &Convex) -> f64 {
    match (a.form().as_ball(), b.form().as_ball()) {
        (Some(one), Some(other)) => {
            let apart_m = a.pose().translation.distance(b.pose().translation);
            one.radius + other.radius - apart_m
        }
        (Some(ball), None) => ball_depth_m(b, a, ball.radius),
        (None, Some(ball)) => ball_depth_m(a, b, ball.radius),
        (None, None) => out_of_m(a, b).min(out_of_m(b, a)),
    }
}

fn ball_depth_m(polygon: &Convex, disc: &Convex, radius_m: f64) -> f64 {
    let centre = disc.pose().translation;
    let outside_m = polygon.distance_to_point_m(Point2::new(centre.x, centre.y));
    if outside_m > 0.0 {
        radius_m - outside_m
    } else {
        out_of_m(polygon, disc)
    }
}

/// The shortest shift along a face normal of box or polygon `from` that takes `other` out of it.
/// [m]
fn out_of_m(from: &Convex, other: &Convex) -> f64 {
    let Some(support) = other.form().as_support_map() else {
        return f64::INFINITY;
    };
    let from_other = from.pose().inv_mul(other.pose());
    let shift_m = |(on_face, normal): (Vec2, Vec2)| {
        (on_face - support.support_point_toward(&from_other, -normal)).dot(normal)
    };
    let cuboid = from.form().as_cuboid().map(|cuboid| {
        let half = cuboid.half_extents;
        [Vec2::X, Vec2::Y, -Vec2::X, -Vec2::Y].map(|normal| (half * normal, normal))
    });
    let polygon = from.form().as_convex_polygon().map(|polygon| {
        let points = polygon.points().iter().copied();
        points.zip(polygon.normals().iter().copied())
    });
    let faces = cuboid.into_iter().flatten();
    faces
        .chain(polygon.into_iter().flatten())
        .map(shift_m)
        .fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f64::consts::{FRAC_PI_4, PI, SQRT_2, TAU};
    use nalgebra::Vector2;
    use rand::{RngExt as _, SeedableRng as _};
    use rand_pcg::Pcg64Mcg;
    use zeronav_world::{Shape, ShapeSpec};

    fn disc(x: f64, y: f64, radius_m: f64) -> Convex {
        Convex::disc(Point2::new(x, y), radius_m)
    }

    fn square(x: f64, y: f64, yaw_rad: f64) -> Convex {
        Shape::new(&ShapeSpec::Box {
            centre_m: [x, y],
            size_m: [2.0, 2.0],
            yaw_rad,
        })
        .expect("a shape")
        .placed()
        .clone()
    }

    #[track_caller]
    fn check(a: &Convex, b: &Convex, expected: f64) {
        for (a, b) in [(a, b), (b, a)] {
            let found = signed_distance_m(a, b);
            assert!((found - expected).abs() < 1e-12, "{found}, not {expected}");
        }
    }

    #[test]
    fn depth_goes_on_where_distance_ends() {
        check(&disc(0.0, 0.0, 1.0), &disc(3.0, 0.0, 1.5), 0.5);
        check(&disc(0.0, 0.0, 1.0), &disc(2.0, 0.0, 1.5), -0.5);
        // Centre outside the square, inside it, in its middle.
        check(&disc(1.5, 0.0, 0.7), &square(0.0, 0.0, 0.0), -0.2);
        check(&disc(0.75, 0.0, 0.7), &square(0.0, 0.0, 0.0), -0.95);
        check(&disc(0.0, 0.0, 0.7), &square(0.0, 0.0, 0.0), -1.7);
        // Squares: side in side, corner in side, one in the other.
        check(&square(0.0, 0.0, 0.0), &square(1.9, 0.3, 0.0), -0.1);
        check(&square(0.0, 0.0, 0.0), &square(2.25, 0.3, 0.0), 0.25);
        check(
            &square(0.0, 0.0, 0.0),
            &square(0.9 + SQRT_2, 0.1, FRAC_PI_4),
            -0.1,
        );
        check(&square(0.0, 0.0, 0.0), &square(0.0, 0.0, 0.0), -2.0);
    }

    /// How far `form` reaches along a unit vector. [m]
    fn reach_m(form: &Convex, along: Vector2<f64>) -> f64 {
        match form.form().as_ball() {
            Some(ball) => form.bounds().center().dot(Vec2::new(along.x, along.y)) + ball.radius,
            None => form
                .corners()
                .map(|corner| corner.coords.dot(&along))
                .fold(f64::NEG_INFINITY, f64::max),
        }
    }

    /// The shortest shift in any of many directions.
    fn brute_depth_m(a: &Convex, b: &Convex) -> f64 {
        (0..3600)
            .map(|tenth| {
                let (sin, cos) = (f64::from(tenth) * TAU / 3600.0).sin_cos();
                let along = Vector2::new(cos, sin);
                reach_m(a, along) + reach_m(b, -along)
            })
            .fold(f64::INFINITY, f64::min)
    }

    #[test]
    fn depths_agree_with_brute_force() {
        let seed = 5;
        eprintln!("seed {seed}");
        let mut rng = Pcg64Mcg::seed_from_u64(seed);
        let mut form = |kind: u32| {
            let centre_m = [rng.random_range(-1.0..1.0), rng.random_range(-1.0..1.0)];
            let spec = match kind {
                0 => ShapeSpec::Disc {
                    centre_m,
                    radius_m: rng.random_range(0.01..2.0),
                },
                1 => ShapeSpec::Box {
                    centre_m,
                    size_m: [rng.random_range(0.01..3.0), rng.random_range(0.01..3.0)],
                    yaw_rad: rng.random_range(-3.0..3.0),
                },
                kind => ShapeSpec::Polygon {
                    corners_m: {
                        let n = if kind == 2 { 5 } else { 40 };
                        let (wide, high) = (rng.random_range(0.1..1.0), rng.random_range(0.1..1.0));
                        (0..n)
                            .map(|corner| {
                                let (sin, cos) = (TAU * f64::from(corner) / f64::from(n)).sin_cos();
                                [centre_m[0] + wide * cos, centre_m[1] + high * sin]
                            })
                            .collect()
                    },
                },
            };
            Shape::new(&spec).expect("a shape").placed().clone()
        };
        let mut overlaps = 0;
        for case in 0..2_000 {
            let (a, b) = (form(case % 4), form(case / 4 % 4));
            let found = signed_distance_m(&a, &b);
            let sampled_m = brute_depth_m(&a, &b);
            assert!(
                (found > 0.0) == (sampled_m < 0.0),
                "case {case}: {found} {sampled_m}"
            );
            if found <= 0.0 {
                overlaps += 1;
                // The best direction lies within half a sample, and nothing is wider than 9 m.
                let too_deep_m = sampled_m + found;
                assert!(
                    (-1e-9..9.0 * PI / 3600.0).contains(&too_deep_m),
                    "case {case}: {found}, not {}: {a:?} {b:?}",
                    -sampled_m
                );
            }
        }
        assert!(overlaps > 800, "{overlaps}");
    }
}
