//! Where rays meet a shape, by parry, and which rays can.

use nalgebra::{Point2, Vector2};
use parry2d::math::Vec2;
use parry2d::query::Ray;
use zeronav_world::Convex;

/// Distance from `origin` along the unit vector `direction` to `form`, all in one frame; 0 inside,
/// `None` when the ray misses. [m]
#[must_use]
pub fn cast(form: &Convex, origin: Point2<f64>, direction: Vector2<f64>) -> Option<f64> {
    Caster::new(form, origin).cast(direction, f64::MAX)
}

/// Rays from one point to one shape.
pub(crate) struct Caster<'a> {
    form: &'a Convex,
    /// In the frame of parry's form.
    origin: Vec2,
}

impl<'a> Caster<'a> {
    pub(crate) fn new(form: &'a Convex, origin: Point2<f64>) -> Self {
        Self {
            form,
            origin: form.pose().inverse_transform_point(origin.coords.into()),
        }
    }

    /// See [`cast`]; `None` beyond `limit_m` too.
    pub(crate) fn cast(&self, direction: Vector2<f64>, limit_m: f64) -> Option<f64> {
        let direction = self.form.pose().rotation.inverse() * Vec2::from(direction);
        let ray = Ray::new(self.origin, direction);
        self.form.form().cast_local_ray(&ray, limit_m, true)
    }
}

/// Smallest and largest direction in which anything within `slack_m` >= 0 of `form` is seen from
/// `origin`, the difference less than pi; `None` from inside, where it is seen all around. [rad]
#[must_use]
pub fn covered_angle(form: &Convex, origin: Point2<f64>, slack_m: f64) -> Option<(f64, f64)> {
    if let Some(ball) = form.form().as_ball() {
        let way = form.pose().translation - Vec2::from(origin.coords);
        let sine = (ball.radius + slack_m) / way.length();
        if sine >= 1.0 || sine.is_nan() {
            return None;
        }
        let middle_rad = way.y.atan2(way.x);
        let half_rad = sine.asin();
        return Some((middle_rad - half_rad, middle_rad + half_rad));
    }
    if form.distance_to_point_m(origin) <= slack_m {
        return None;
    }
    // The hull of discs of the slack around the corners.
    let widened_rad = |way: Vector2<f64>| {
        if slack_m > 0.0 {
            (slack_m / way.norm()).min(1.0).asin()
        } else {
            0.0
        }
    };
    let mut ways = form.corners().map(|corner| corner - origin);
    let reference = ways.next()?;
    let first_rad = widened_rad(reference);
    let (mut low_rad, mut high_rad) = (-first_rad, first_rad);
    for way in ways {
        let turn_rad = reference.perp(&way).atan2(reference.dot(&way));
        let widened_rad = widened_rad(way);
        low_rad = low_rad.min(turn_rad - widened_rad);
        high_rad = high_rad.max(turn_rad + widened_rad);
    }
    let middle_rad = reference.y.atan2(reference.x);
    Some((middle_rad + low_rad, middle_rad + high_rad))
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f64::consts::{FRAC_PI_4, SQRT_2, TAU};
    use rand::RngExt as _;
    use rand::SeedableRng as _;
    use rand_pcg::Pcg64Mcg;
    use zeronav_world::{Shape, ShapeSpec};

    fn shape(spec: &ShapeSpec) -> Shape {
        Shape::new(spec).expect("a shape")
    }

    fn direction(angle_rad: f64) -> Vector2<f64> {
        Vector2::new(angle_rad.cos(), angle_rad.sin())
    }

    #[track_caller]
    fn close(found: Option<f64>, expected: f64) {
        let found = found.expect("a hit");
        assert!((found - expected).abs() < 1e-12, "{found}, not {expected}");
    }

    #[test]
    fn hand_computed_ranges() {
        let disc = shape(&ShapeSpec::Disc {
            centre_m: [3.0, 1.0],
            radius_m: 0.5,
        });
        let from = Point2::new(0.0, 1.0);
        close(cast(disc.placed(), from, Vector2::x()), 2.5);
        // 0.3 beside the middle: half the chord is 0.4.
        close(
            cast(disc.placed(), Point2::new(0.0, 1.3), Vector2::x()),
            2.6,
        );
        assert_eq!(cast(disc.placed(), from, -Vector2::x()), None);
        close(
            cast(disc.placed(), Point2::new(3.1, 0.9), Vector2::x()),
            0.0,
        );
        // Grazing: a hair inside and a hair outside.
        let graze = |y: f64| cast(disc.placed(), Point2::new(0.0, y), Vector2::x());
        assert!(graze(1.5 - 1e-9).is_some_and(|range| (range - 3.0).abs() < 1e-4));
        assert_eq!(graze(1.5 + 1e-9), None);

        // A square on its corner: the near one is at x = 3 - sqrt 2.
        let diamond = shape(&ShapeSpec::Box {
            centre_m: [3.0, 1.0],
            size_m: [2.0, 2.0],
            yaw_rad: FRAC_PI_4,
        });
        close(cast(diamond.placed(), from, Vector2::x()), 3.0 - SQRT_2);
        close(
            cast(diamond.placed(), Point2::new(0.0, 1.5), Vector2::x()),
            3.5 - SQRT_2,
        );
        let graze = |y: f64| cast(diamond.placed(), Point2::new(0.0, y), Vector2::x());
        close(graze(1.0 + SQRT_2 - 1e-9), 3.0 - 1e-9);
        assert_eq!(graze(1.0 + SQRT_2 + 1e-9), None);
        close(
            cast(diamond.placed(), Point2::new(3.0, 1.0), Vector2::y()),
            0.0,
        );
        // Along an edge of an upright square, which is closed.
        let square = shape(&ShapeSpec::Box {
            centre_m: [3.0, 1.0],
            size_m: [2.0, 2.0],
            yaw_rad: 0.0,
        });
        close(
            cast(square.placed(), Point2::new(0.0, 2.0), Vector2::x()),
            2.0,
        );
        assert_eq!(
            cast(square.placed(), Point2::new(0.0, 2.001), Vector2::x()),
            None
        );
    }

    /// Reference for a disc, by the foot of the perpendicular.
    fn brute_disc(radius_m: f64, way: Vector2<f64>, direction: Vector2<f64>) -> Option<f64> {
        let square = radius_m * radius_m;
        if way.norm_squared() <= square {
            return Some(0.0);
        }
        let foot_m = way.dot(&direction);
        let half_chord_squared = square - direction.perp(&way).powi(2);
        (foot_m > 0.0 && half_chord_squared >= 0.0).then(|| foot_m - half_chord_squared.sqrt())
    }

    /// Reference for a polygon: clips the ray with the half plane of every edge (Cyrus and Beck,
    /// "Generalized two- and three-dimensional clipping", 1978).
    fn brute_polygon(
        corners: &[Point2<f64>],
        origin: Point2<f64>,
        direction: Vector2<f64>,
    ) -> Option<f64> {
        let (mut t_in, mut t_out) = (0.0_f64, f64::INFINITY);
        for (from, to) in corners.iter().zip(corners.iter().cycle().skip(1)) {
            let edge = to - from;
            // Both positive on the outer side of the counter-clockwise edge.
            let outside = (origin - from).perp(&edge);
            let outwards = direction.perp(&edge);
            if outwards < 0.0 {
                t_in = t_in.max(-outside / outwards);
            } else if outwards > 0.0 {
                t_out = t_out.min(-outside / outwards);
            } else if outside > 0.0 {
                return None;
            }
        }
        (t_in <= t_out).then_some(t_in)
    }

    #[test]
    fn rays_agree_with_brute_force() {
        let seed = 3;
        eprintln!("seed {seed}");
        let mut rng = Pcg64Mcg::seed_from_u64(seed);
        let (mut hits, mut grazes) = (0, 0);
        for case in 0..200_000 {
            let centre_m = [rng.random_range(-4.0..4.0), rng.random_range(-4.0..4.0)];
            let spec = match case % 4 {
                0 => ShapeSpec::Disc {
                    centre_m,
                    radius_m: rng.random_range(0.002..2.0),
                },
                1 => ShapeSpec::Box {
                    centre_m,
                    size_m: [rng.random_range(0.001..3.0), rng.random_range(0.001..30.0)],
                    yaw_rad: rng.random_range(-3.0..3.0),
                },
                kind => ShapeSpec::Polygon {
                    corners_m: {
                        let n = if kind == 2 { 5 } else { 100 };
                        let turned_rad = rng.random_range(0.0..TAU);
                        let flat = rng.random_range(0.1..1.0);
                        (0..n)
                            .map(|corner| {
                                let turn = TAU * f64::from(corner) / f64::from(n);
                                let along = direction(turned_rad + turn);
                                [centre_m[0] + along.x, centre_m[1] + flat * along.y]
                            })
                            .collect()
                    },
                },
            };
            let shape = shape(&spec);
            let form = shape.placed();
            let origin = Point2::new(rng.random_range(-9.0..9.0), rng.random_range(-9.0..9.0));
            let along = direction(rng.random_range(0.0..TAU));
            let found = cast(form, origin, along);
            let expected = match &spec {
                ShapeSpec::Disc { radius_m, .. } => {
                    brute_disc(*radius_m, Point2::from(centre_m) - origin, along)
                }
                _ => brute_polygon(&form.corners().collect::<Vec<_>>(), origin, along),
            };
            match (found, expected) {
                (Some(a), Some(b)) => {
                    hits += 1;
                    assert!((a - b).abs() < 1e-7, "case {case}: {a}, not {b}: {spec:?}");
                }
                (None, None) => {}
                // Decided by rounding: a ray along the very edge.
                _ => grazes += 1,
            }
        }
        assert!(hits > 20_000 && grazes < 10, "{hits} hits, {grazes} grazes");
    }
}
