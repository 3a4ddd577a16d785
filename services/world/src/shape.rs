//! Shapes of a scenario, ready to be asked.

use crate::convex::Convex;
use crate::error::{SpecError, number};
use crate::polygon::{centroid, convex_corners};
use crate::spec::ShapeSpec;
use nalgebra::Point2;
use zeronav_msgs::Pose;
use zeronav_msgs::message::COORDINATE_M_MAX;

/// Smallest side or radius of a shape. [m]
pub const SHAPE_SIZE_M_MIN: f64 = 1.0e-3;

/// Largest yaw of a box, either way round. [rad]
pub const SHAPE_YAW_RAD_MAX: f64 = 62.8;

/// A solid thing: its form in its own frame and where the scenario puts it.
///
/// Boxes and discs have their frame in their middle, turned with the box. A polygon has it in the
/// centroid of its area, not turned.
#[derive(Debug, Clone)]
pub struct Shape {
    pose: Pose,
    form: Convex,
    placed: Convex,
}

impl Shape {
    /// The shape that `spec` describes.
    ///
    /// # Errors
    /// The field that is not finite, too small, or not convex.
    pub fn new(spec: &ShapeSpec) -> Result<Self, SpecError> {
        let (pose, form) = match spec {
            ShapeSpec::Box {
                centre_m,
                size_m,
                yaw_rad,
            } => {
                point(*centre_m, "centre_m")?;
                size(size_m[0], "size_m[0]")?;
                size(size_m[1], "size_m[1]")?;
                number(*yaw_rad, -SHAPE_YAW_RAD_MAX, SHAPE_YAW_RAD_MAX, "yaw_rad")?;
                let pose = Pose::new(centre_m[0], centre_m[1], *yaw_rad);
                (pose, Convex::rectangle(*size_m))
            }
            ShapeSpec::Disc { centre_m, radius_m } => {
                point(*centre_m, "centre_m")?;
                size(*radius_m, "radius_m")?;
                let pose = Pose::new(centre_m[0], centre_m[1], 0.0);
                (pose, Convex::disc(Point2::origin(), *radius_m))
            }
            ShapeSpec::Polygon { corners_m } => {
                let field = "corners_m";
                let (corners, _) =
                    convex_corners(corners_m).map_err(|error| error.within(field))?;
                let centre = centroid(&corners);
                let corners: Vec<_> = corners.iter().map(|at| Point2::from(at - centre)).collect();
                let form = Convex::polygon(&corners)
                    .ok_or_else(|| SpecError::new(field, "has two corners on one spot"))?;
                (Pose::new(centre.x, centre.y, 0.0), form)
            }
        };
        Ok(Self {
            placed: form.placed(&pose),
            pose,
            form,
        })
    }

    /// Where the scenario puts it: `map_from_shape`. An obstacle that moves starts here.
    #[must_use]
    pub const fn pose(&self) -> Pose {
        self.pose
    }

    /// Its form in its own frame.
    #[must_use]
    pub const fn form(&self) -> &Convex {
        &self.form
    }

    /// Its form in the map frame, where the scenario puts it.
    #[must_use]
    pub const fn placed(&self) -> &Convex {
        &self.placed
    }

    /// Its form in the map frame when it is at `map_from_shape`. No allocation.
    #[must_use]
    pub fn placed_at(&self, map_from_shape: &Pose) -> Convex {
        self.form.placed(map_from_shape)
    }

    /// Its edge in the map frame for drawing, where the scenario puts it: a closed chain, the
    /// first point not repeated.
    #[must_use]
    pub fn outline(&self) -> Vec<Point2<f64>> {
        self.placed.outline()
    }

    /// Distance between the shape, standing at `map_from_shape`, and a chain of straight lines, 0
    /// when they touch: a robot of radius r that drives along `polyline` with its centre stays
    /// clear of it when this is more than r. A single point counts as a chain; infinite for none.
    /// [m]
    #[must_use]
    pub fn polyline_clearance_m(&self, map_from_shape: &Pose, polyline: &[Point2<f64>]) -> f64 {
        self.placed_at(map_from_shape)
            .distance_to_polyline_m(polyline)
    }
}

pub(crate) fn point(at: [f64; 2], field: &str) -> Result<(), SpecError> {
    for (axis, value) in at.into_iter().enumerate() {
        let limit_m = COORDINATE_M_MAX;
        number(value, -limit_m, limit_m, &format!("{field}[{axis}]"))?;
    }
    Ok(())
}

fn size(value_m: f64, field: &str) -> Result<(), SpecError> {
    number(value_m, SHAPE_SIZE_M_MIN, COORDINATE_M_MAX, field)
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f64::consts::FRAC_PI_2;
    use parry2d::math::Vec2;
    use parry2d::query::Ray;

    fn a_box(size_m: [f64; 2], yaw_rad: f64) -> ShapeSpec {
        ShapeSpec::Box {
            centre_m: [2.0, 1.0],
            size_m,
            yaw_rad,
        }
    }

    #[test]
    fn a_turned_box_lies_across() {
        let shape = Shape::new(&a_box([4.0, 1.0], FRAC_PI_2)).unwrap();
        let bounds = shape.placed().bounds();
        assert!(bounds.mins.distance(Vec2::new(1.5, -1.0)) < 1e-12);
        assert!(bounds.maxs.distance(Vec2::new(2.5, 3.0)) < 1e-12);
        assert_eq!(shape.outline().len(), 4);
    }

    #[test]
    fn a_polygon_turns_about_its_centroid() {
        let shape = Shape::new(&ShapeSpec::Polygon {
            corners_m: vec![[10.0, 0.0], [13.0, 0.0], [10.0, 6.0]],
        })
        .unwrap();
        assert_eq!(shape.pose(), Pose::new(11.0, 2.0, 0.0));
        let far = shape.placed_at(&Pose::new(0.0, 0.0, FRAC_PI_2));
        // The corner (10, 6) is (-1, 4) in its frame, so (-4, -1) after a quarter turn.
        assert!((far.distance_to_point_m(Point2::new(-5.0, -1.0)) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn rays_of_parry_meet_the_same_surfaces() {
        let triangle = ShapeSpec::Polygon {
            corners_m: vec![[1.0, -1.0], [3.0, -1.0], [3.0, 1.0], [1.0, 1.0]],
        };
        let disc = ShapeSpec::Disc {
            centre_m: [2.0, 0.0],
            radius_m: 1.0,
        };
        for spec in [triangle, disc] {
            let shape = Shape::new(&spec).unwrap();
            let ray = Ray::new(Vec2::new(-2.0, 0.0), Vec2::new(1.0, 0.0));
            let placed = shape.placed();
            let hit = placed.form().cast_ray(placed.pose(), &ray, 10.0, true);
            assert!((hit.unwrap() - 3.0).abs() < 1e-12, "{spec:?}: {hit:?}");
        }
    }

    #[test]
    fn clearance_of_a_path_counts_to_the_edge() {
        let shape = Shape::new(&a_box([4.0, 1.0], 0.0)).unwrap();
        let path = [Point2::new(-9.0, 3.0), Point2::new(9.0, 3.0)];
        let clearance_m = shape.polyline_clearance_m(&shape.pose(), &path);
        assert!((clearance_m - 1.5).abs() < 1e-12);
        let moved = Pose::new(2.0, 3.2, 0.0);
        assert!(shape.polyline_clearance_m(&moved, &path).abs() < 1e-12);
    }

    #[test]
    fn sizes_and_places_must_be_numbers() {
        let refused = |spec: &ShapeSpec| Shape::new(spec).unwrap_err().field;
        assert_eq!(refused(&a_box([0.0, 1.0], 0.0)), "size_m[0]");
        assert_eq!(refused(&a_box([1.0, -2.0], 0.0)), "size_m[1]");
        assert_eq!(refused(&a_box([1.0, 1.0], f64::INFINITY)), "yaw_rad");
        let disc = |x, radius_m| ShapeSpec::Disc {
            centre_m: [0.0, x],
            radius_m,
        };
        assert_eq!(refused(&disc(f64::NAN, 1.0)), "centre_m[1]");
        assert_eq!(refused(&disc(0.0, -1.0)), "radius_m");
        let corners_m = vec![[0.0, 0.0], [1.0, 0.0]];
        assert_eq!(refused(&ShapeSpec::Polygon { corners_m }), "corners_m");
    }
}
