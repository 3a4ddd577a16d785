//! Discs that go straight and bounce off everything static and off the edge of the map.

use nalgebra::{Point2, Vector2};
use std::collections::VecDeque;
use zeronav_world::{Convex, World};

/// Distance at which it bounces. [m]
const TOUCH_M: f64 = 1.0e-4;

/// Shortest step towards something. [m]
const STEP_M_MIN: f64 = 1.0e-4;

/// How far the normal of a surface is felt for. [m] The disc is moved back first, so that what is
/// felt is outside.
const FEEL_M: f64 = 1.0e-3;

/// Most legs that are looked ahead at once: one that is wedged in stops.
const LEGS_AHEAD_MAX: usize = 64;

/// How long what was is remembered: as long as the slowest lidar turns, and a second. [s]
const MEMORY_S: f64 = 11.0;

/// How far ahead of what is asked for it is looked. [s]
const AHEAD_S: f64 = 0.5;

/// The way of one disc.
#[derive(Debug, Clone)]
pub struct Bounce {
    radius_m: f64,
    speed_mps: f64,
    /// Straight stretches; the last goes on until [`Self::known_s`].
    legs: VecDeque<Leg>,
    known_s: f64,
}

#[derive(Debug, Clone, Copy)]
struct Leg {
    from_s: f64,
    from: Point2<f64>,
    velocity_mps: Vector2<f64>,
}

impl Leg {
    fn at(&self, t_s: f64) -> Point2<f64> {
        self.from + self.velocity_mps * (t_s - self.from_s).max(0.0)
    }
}

impl Bounce {
    /// A disc of `radius_m` that sets out at `from` with `velocity_mps`.
    #[must_use]
    pub fn new(from: Point2<f64>, velocity_mps: Vector2<f64>, radius_m: f64) -> Self {
        Self {
            radius_m,
            speed_mps: velocity_mps.norm(),
            legs: VecDeque::from([Leg {
                from_s: 0.0,
                from,
                velocity_mps,
            }]),
            known_s: 0.0,
        }
    }

    /// [m/s]
    #[must_use]
    pub const fn speed_mps(&self) -> f64 {
        self.speed_mps
    }

    /// Where it is `t_s` after it set out; as far as it was looked ahead, and 11 s back from
    /// there.
    #[must_use]
    pub fn at(&self, t_s: f64) -> Point2<f64> {
        let leg = self.legs.iter().rev().find(|leg| leg.from_s <= t_s);
        leg.or(self.legs.front())
            .map_or_else(Point2::origin, |leg| leg.at(t_s.min(self.known_s)))
    }

    /// Finds what it bounces off until `t_s` and a little longer.
    pub fn look_ahead(&mut self, world: &World, t_s: f64) {
        if t_s <= self.known_s || self.speed_mps <= 0.0 {
            return;
        }
        let until_s = t_s + AHEAD_S;
        for _ in 0..LEGS_AHEAD_MAX {
            let Some(leg) = self.legs.back().copied() else {
                break;
            };
            let Some((hit_s, normal)) = self.next_hit(world, &leg, until_s) else {
                self.known_s = until_s;
                break;
            };
            let into_mps = leg.velocity_mps.dot(&normal);
            self.known_s = hit_s;
            self.legs.push_back(Leg {
                from_s: hit_s,
                from: leg.at(hit_s),
                velocity_mps: leg.velocity_mps - normal * (2.0 * into_mps),
            });
        }
        if self.known_s < until_s {
            let from = self.at(self.known_s);
            self.legs.push_back(Leg {
                from_s: self.known_s,
                from,
                velocity_mps: Vector2::zeros(),
            });
            self.known_s = until_s;
        }
        let old_s = t_s - MEMORY_S;
        while self.legs.get(1).is_some_and(|next| next.from_s < old_s) {
            self.legs.pop_front();
        }
    }

    /// When it next meets something that it moves towards, and the normal there, until `until_s`.
    fn next_hit(&self, world: &World, leg: &Leg, until_s: f64) -> Option<(f64, Vector2<f64>)> {
        let speed_mps = leg.velocity_mps.norm();
        if speed_mps <= 0.0 {
            return None;
        }
        let way = leg.velocity_mps / speed_mps;
        let mut t_s = self.known_s.max(leg.from_s);
        while t_s < until_s {
            let at = leg.at(t_s);
            let free_m = self.free_m(world, at);
            if free_m <= TOUCH_M {
                let normal = self.normal(world, at - way * (3.0 * FEEL_M), way);
                if normal.dot(&way) < 0.0 {
                    return Some((t_s, normal));
                }
            }
            t_s += (free_m - TOUCH_M).max(STEP_M_MIN) / speed_mps;
        }
        None
    }

    /// Distance of the disc's edge from everything static and from the edge of the map. [m]
    fn free_m(&self, world: &World, at: Point2<f64>) -> f64 {
        let g = world.geometry();
        let far_x = g.origin_x_m + f64::from(g.width) * g.resolution_m;
        let far_y = g.origin_y_m + f64::from(g.height) * g.resolution_m;
        let edge_m = (at.x - g.origin_x_m)
            .min(far_x - at.x)
            .min(at.y - g.origin_y_m)
            .min(far_y - at.y);
        let limit_m = (edge_m - self.radius_m).max(0.0) + self.radius_m;
        let static_m = world.convex_distance_m(&Convex::disc(at, 0.0), limit_m);
        edge_m.min(static_m) - self.radius_m
    }

    /// Direction in which it gets free fastest; against `way` where that is unclear.
    fn normal(&self, world: &World, at: Point2<f64>, way: Vector2<f64>) -> Vector2<f64> {
        let felt = |along: Vector2<f64>| {
            self.free_m(world, at + along * FEEL_M) - self.free_m(world, at - along * FEEL_M)
        };
        Vector2::new(felt(Vector2::x()), felt(Vector2::y()))
            .try_normalize(1.0e-9)
            .unwrap_or(-way)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f64::consts::FRAC_PI_4;
    use zeronav_world::{ShapeSpec, WorldSpec};

    fn world(shapes: Vec<ShapeSpec>) -> World {
        let spec = WorldSpec {
            shapes,
            ..WorldSpec::area([0.0, 0.0], [10.0, 6.0])
        };
        World::new(&spec, None).expect("a world")
    }

    /// Where the disc is at the end of every 20 ms.
    fn walk(bounce: &mut Bounce, world: &World, ticks: u32) -> Vec<Point2<f64>> {
        (1..=ticks)
            .map(|tick| {
                let t_s = f64::from(tick) * 0.02;
                bounce.look_ahead(world, t_s);
                bounce.at(t_s)
            })
            .collect()
    }

    #[test]
    fn it_comes_back_from_the_edge_of_the_map_as_light_from_a_mirror() {
        let world = world(Vec::new());
        let mut bounce = Bounce::new(Point2::new(5.0, 3.0), Vector2::new(2.0, 0.5), 0.5);
        // The right edge after 2.25 s, the upper one after 5 s, the left one after 6.75 s.
        let at = walk(&mut bounce, &world, 400);
        let near = |tick: usize, x: f64, y: f64| {
            let found = at[tick - 1];
            assert!(
                (found - Point2::new(x, y)).norm() < 0.002,
                "{found} at {tick}"
            );
        };
        near(100, 9.0, 4.0);
        near(125, 9.0, 4.25);
        near(225, 5.0, 5.25);
        near(275, 3.0, 5.25);
        near(400, 3.0, 4.0);
    }

    #[test]
    fn a_slanted_wall_turns_it_by_twice_the_angle() {
        let wall = ShapeSpec::Box {
            centre_m: [7.0, 3.0],
            size_m: [4.0, 0.2],
            yaw_rad: FRAC_PI_4,
        };
        let world = world(vec![wall]);
        let mut bounce = Bounce::new(Point2::new(2.0, 3.0), Vector2::new(1.0, 0.0), 0.3);
        let at = walk(&mut bounce, &world, 350);
        let (before, after) = (at[99] - at[49], at[349] - at[329]);
        assert!(before.normalize().dot(&Vector2::x()) > 0.999_999);
        assert!(after.normalize().dot(&Vector2::y()) > 0.999, "{after}");
        assert!((after.norm() - 0.4).abs() < 1e-6);
    }

    #[test]
    fn it_never_enters_anything_and_never_stops() {
        let discs = (0..12).map(|i| ShapeSpec::Disc {
            centre_m: [0.8 + 0.75 * f64::from(i), 1.5 + f64::from((i * 7) % 4)],
            radius_m: 0.2,
        });
        let world = world(discs.collect());
        for case in 0..8 {
            let heading = f64::from(case) * 0.77 + 0.1;
            let velocity = Vector2::new(heading.cos(), heading.sin()) * 1.3;
            let mut bounce = Bounce::new(Point2::new(5.0, 0.5), velocity, 0.15);
            let mut last = Point2::new(5.0, 0.5);
            for at in walk(&mut bounce, &world, 3000) {
                let free_m = bounce.free_m(&world, at);
                assert!(free_m > -1.0e-3, "case {case}: {free_m} at {at}");
                assert!((at - last).norm() <= 1.3 * 0.02 + 1e-9);
                last = at;
            }
            assert!(bounce.legs.len() < 200, "{} legs", bounce.legs.len());
            let speed = bounce.legs.back().expect("a leg").velocity_mps.norm();
            assert!((speed - 1.3).abs() < 1e-9, "case {case}: {speed}");
        }
    }
}
