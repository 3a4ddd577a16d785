//! What the static map explains of a scan, seen from a pose, and what it contradicts.
//!
//! A beam that ends on a surface is explained, unless a wall stands before that. One that passes a wall contradicts the
//! map: something has gone, or the pose is wrong. One that ends where nothing is on the map has met something
//! new, which says less: new things come by the dozen and stand in front of walls.

use crate::beams::{Beam, End};
use crate::mapper::Mapper;
use crate::ray::{Passing, Ray};
use nalgebra::{Point2, Vector2};
use zeronav_msgs::map::FLAG_STATIC;
use zeronav_msgs::{MapCell, Pose};

/// How far before its end a beam may have passed a wall: along walls it grazes their cells. [m]
const GRAZES_M: f64 = 0.2;

/// What a beam without a return counts that should have met a wall: lidars lose returns.
const LOST_RETURN: f64 = 0.5;

/// Beams of a scan by what the static map says of them.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Explained {
    /// Ended on a surface.
    pub(crate) on: f64,
    /// Ended where nothing is on the map.
    pub(crate) new: f64,
    /// Passed a wall.
    pub(crate) through: f64,
}

impl Explained {
    /// The share that the map explains, 0 to 1, of all that it says something of, where something new counts
    /// `new_counts`.
    pub(crate) fn share(&self, new_counts: f64) -> f64 {
        let all = self.on + self.new * new_counts + self.through;
        if all > 0.0 { self.on / all } else { 0.0 }
    }

    /// Adds what the map says of other beams.
    pub(crate) fn add(&mut self, other: &Self) {
        self.on += other.on;
        self.new += other.new;
        self.through += other.through;
    }

    /// Beams that the map says something of.
    pub(crate) fn judged(&self) -> f64 {
        self.on + self.new + self.through
    }
}

/// The walls of the static map.
#[derive(Clone, Copy)]
pub(crate) struct Walls<'a> {
    mapper: &'a Mapper,
}

impl<'a> Walls<'a> {
    pub(crate) fn of(mapper: &'a Mapper) -> Self {
        Self { mapper }
    }

    /// What the map says of beams in `base` as far as `range_m_max`, the robot at `map_from_base`; `is_on` whether a
    /// point of the map lies on a surface.
    pub(crate) fn explain<'b>(
        self,
        beams: impl Iterator<Item = &'b Beam>,
        map_from_base: &Pose,
        range_m_max: f64,
        is_on: impl Fn(Point2<f64>) -> bool,
    ) -> Explained {
        let mut sum = Explained::default();
        let (sin, cos) = map_from_base.yaw_rad.sin_cos();
        let turned = |v: Vector2<f64>| Vector2::new(cos * v.x - sin * v.y, sin * v.x + cos * v.y);
        for beam in beams {
            let origin = map_from_base.point() + turned(beam.origin.coords);
            let direction = turned(beam.direction);
            let passes = |range_m: f64| {
                let until_m = range_m.min(range_m_max) - GRAZES_M;
                self.stand_in_the_way(origin, direction, until_m)
            };
            match beam.end {
                End::NoReturn(range_m) => {
                    sum.through += LOST_RETURN * f64::from(u8::from(passes(range_m)));
                }
                End::Hit(range_m) if passes(range_m) => sum.through += 1.0,
                End::Hit(range_m) if range_m <= range_m_max => {
                    let end = origin + direction * range_m;
                    if is_on(end) {
                        sum.on += 1.0;
                    } else if self.mapper.is_known(end) {
                        sum.new += 1.0;
                    }
                }
                End::Hit(_) | End::Invalid => {}
            }
        }
        sum
    }

    fn stand_in_the_way(self, origin: Point2<f64>, direction: Vector2<f64>, until_m: f64) -> bool {
        let geometry = self.mapper.geometry();
        let per_m = 1.0 / geometry.resolution_m;
        let corner = Point2::new(geometry.origin_x_m, geometry.origin_y_m);
        let ray = Ray {
            origin: Point2::from((origin - corner) * per_m),
            direction,
        };
        let (width, height) = geometry.size();
        let mut way = PassedCells {
            cells: self.mapper.cells(),
            is_blocked: false,
        };
        ray.left_cells(width, height, until_m * per_m, &mut way);
        way.is_blocked
    }
}

/// The way of a beam.
struct PassedCells<'a> {
    cells: &'a [MapCell],
    is_blocked: bool,
}

impl Passing for PassedCells<'_> {
    fn leaps(&self, _x: i32, _y: i32) -> bool {
        self.is_blocked
    }

    fn passed(&mut self, index: usize) {
        self.is_blocked |= self.cells[index].flags & FLAG_STATIC != 0;
    }
}
