//! A scan whose pose on the map is known, and its beams over the grid.

use crate::beams::{Beam, End};
use crate::ray::Ray;
use nalgebra::{Point2, Vector2};
use zeronav_msgs::{GridGeometry, Pose};

/// A beam in cells, how it ended, and whether on a dynamic obstacle.
pub(crate) type GridRay = (Ray, End, bool);

/// Beams with the pose of their frame.
#[derive(Debug, Clone, Copy)]
pub struct LocatedScan<'a> {
    /// Where the frame of the beams lies in the map.
    pub map_from_frame: Pose,
    /// The beams.
    pub beams: &'a [Beam],
    /// True for beams that ended on a dynamic obstacle; empty without any.
    pub moving: &'a [bool],
    /// Run time of the capture. [ns]
    pub run_ns: u64,
}

impl LocatedScan<'_> {
    /// Writes the beams as rays over the cells of a grid into `rays`, which it clears first. False
    /// when the pose is not finite.
    pub fn cast_on(&self, geometry: &GridGeometry, rays: &mut Vec<GridRay>) -> bool {
        let Pose { x_m, y_m, yaw_rad } = self.map_from_frame;
        if !(x_m + y_m + yaw_rad).is_finite() {
            return false;
        }
        let (sin, cos) = yaw_rad.sin_cos();
        let per_m = 1.0 / geometry.resolution_m;
        let shift = Vector2::new(x_m - geometry.origin_x_m, y_m - geometry.origin_y_m);
        let turned = |v: Vector2<f64>| Vector2::new(cos * v.x - sin * v.y, sin * v.x + cos * v.y);
        rays.clear();
        rays.extend(self.beams.iter().enumerate().map(|(n, beam)| {
            let ray = Ray {
                origin: Point2::from((turned(beam.origin.coords) + shift) * per_m),
                direction: turned(beam.direction),
            };
            let moving = self.moving.get(n).copied().unwrap_or(false);
            (ray, beam.end, moving)
        }));
        true
    }
}

/// Where points of `base` lie in the map.
pub(crate) fn placed_at(map_from_base: &Pose) -> impl Fn(&Point2<f64>) -> Point2<f64> + use<> {
    let (sin, cos) = map_from_base.yaw_rad.sin_cos();
    let (x_m, y_m) = (map_from_base.x_m, map_from_base.y_m);
    move |at| Point2::new(x_m + cos * at.x - sin * at.y, y_m + sin * at.x + cos * at.y)
}
