//! The robot's outline.

use crate::convex::Convex;
use crate::error::{SpecError, number};
use crate::polygon::{Order, convex_corners};
use nalgebra::Point2;
use parry2d::math::Vec2;
use parry2d::query::PointQuery;
use parry2d::shape::Segment;
use zeronav_msgs::Pose;
use zeronav_msgs::description::FOOTPRINT_CORNERS_MAX;

/// What is wrong with an outline beside the origin, and by how much it would have to be moved for that to
/// be its middle.
fn beside_origin(corners: &[Point2<f64>]) -> String {
    let middle = |along: fn(&Point2<f64>) -> f64| {
        let ends = corners.iter().map(along);
        let (least, most) = ends.fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), it| {
            (least.min(it), most.max(it))
        });
        0.5 * (least + most)
    };
    format!(
        "must hold the origin of base, the point about which the robot turns: corners are relative to it; \
         with [{:.3}, {:.3}] added to each it is in the middle",
        -middle(|corner| corner.x),
        -middle(|corner| corner.y)
    )
}

/// Smallest and largest radius of a round outline. [m]
pub const RADIUS_M: [f64; 2] = [1.0e-3, 100.0];

/// A disc or a convex polygon around the origin of `base`.
#[derive(Debug, Clone)]
pub struct Footprint {
    form: Convex,
    corners: Vec<Point2<f64>>,
    inscribed_radius_m: f64,
    circumscribed_radius_m: f64,
}

impl Footprint {
    /// A round outline.
    ///
    /// # Errors
    /// Radii that are not within [`RADIUS_M`].
    pub fn disc(radius_m: f64) -> Result<Self, SpecError> {
        number(radius_m, RADIUS_M[0], RADIUS_M[1], "radius_m")?;
        Ok(Self {
            form: Convex::disc(Point2::origin(), radius_m),
            corners: Vec::new(),
            inscribed_radius_m: radius_m,
            circumscribed_radius_m: radius_m,
        })
    }

    /// A convex outline, counter-clockwise in `base`. [m]
    ///
    /// # Errors
    /// Corners that are not convex, not counter-clockwise, or do not hold the origin of `base`.
    pub fn polygon(corners_m: &[[f64; 2]]) -> Result<Self, SpecError> {
        let field = "footprint_m";
        if corners_m.len() > FOOTPRINT_CORNERS_MAX {
            let why = format!("has more than {FOOTPRINT_CORNERS_MAX} corners");
            return Err(SpecError::new(field, why));
        }
        for (index, corner) in corners_m.iter().enumerate() {
            for value in corner {
                number(*value, -100.0, 100.0, &format!("{field}[{index}]"))?;
            }
        }
        let (corners, order) = convex_corners(corners_m).map_err(|error| error.within(field))?;
        if order == Order::Clockwise {
            let why = "runs clockwise: list its corners counter-clockwise";
            return Err(SpecError::new(field, why));
        }
        let mut inscribed_radius_m = f64::INFINITY;
        for (index, a) in corners.iter().enumerate() {
            let b = corners[(index + 1) % corners.len()];
            let inside = (b - a).perp(&(Point2::origin() - a)) > 0.0;
            let edge = Segment::new(a.coords.into(), b.coords.into());
            let edge_m = edge.distance_to_local_point(Vec2::ZERO, true);
            if !inside || edge_m < 1.0e-3 {
                return Err(SpecError::new(field, beside_origin(&corners)));
            }
            inscribed_radius_m = inscribed_radius_m.min(edge_m);
        }
        let circumscribed_radius_m = corners
            .iter()
            .map(|corner| corner.coords.norm())
            .fold(0.0, f64::max);
        let form = Convex::polygon(&corners)
            .ok_or_else(|| SpecError::new(field, "has two corners on one spot"))?;
        Ok(Self {
            form,
            corners,
            inscribed_radius_m,
            circumscribed_radius_m,
        })
    }

    /// Radius of the largest disc around the origin of `base` inside the outline. [m]
    #[must_use]
    pub const fn inscribed_radius_m(&self) -> f64 {
        self.inscribed_radius_m
    }

    /// Radius of the smallest disc around the origin of `base` that holds the outline. [m]
    #[must_use]
    pub const fn circumscribed_radius_m(&self) -> f64 {
        self.circumscribed_radius_m
    }

    /// Its form in `base`.
    #[must_use]
    pub const fn form(&self) -> &Convex {
        &self.form
    }

    /// Its corners in `base`, counter-clockwise; none for a disc.
    #[must_use]
    pub fn corners(&self) -> &[Point2<f64>] {
        &self.corners
    }

    /// What the robot covers at `map_from_base`. No allocation.
    #[must_use]
    pub fn placed(&self, map_from_base: &Pose) -> Convex {
        self.form.placed(map_from_base)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn radii_of_a_rectangle_come_from_its_nearest_side_and_farthest_corner() {
        let footprint =
            Footprint::polygon(&[[-0.2, -0.3], [0.4, -0.3], [0.4, 0.3], [-0.2, 0.3]]).unwrap();
        assert!((footprint.inscribed_radius_m() - 0.2).abs() < 1e-12);
        assert!((footprint.circumscribed_radius_m() - 0.5).abs() < 1e-12);
        assert_eq!(footprint.corners().len(), 4);
        let placed = footprint.placed(&Pose::new(1.0, 0.0, core::f64::consts::PI));
        assert!(placed.distance_to_point_m(Point2::new(0.6, 0.0)).abs() < 1e-9);
        assert!((placed.distance_to_point_m(Point2::new(0.5, 0.0)) - 0.1).abs() < 1e-9);
    }

    #[test]
    fn outlines_without_the_origin_or_the_wrong_way_around_are_refused() {
        let beside = [[0.1, 0.0], [1.0, 0.0], [1.0, 1.0]];
        let error = Footprint::polygon(&beside).unwrap_err();
        for part in ["origin of base", "with [-0.550, -0.500] added"] {
            assert!(error.why.contains(part), "{error}");
        }
        let clockwise = [[-1.0, -1.0], [-1.0, 1.0], [1.0, 1.0], [1.0, -1.0]];
        let error = Footprint::polygon(&clockwise).unwrap_err();
        assert!(error.why.contains("counter-clockwise"), "{error}");
        let dent = [
            [-1.0, -1.0],
            [1.0, -1.0],
            [0.2, 0.0],
            [1.0, 1.0],
            [-1.0, 1.0],
        ];
        let error = Footprint::polygon(&dent).unwrap_err();
        assert!(error.why.contains("not convex"), "{error}");
        assert_eq!(Footprint::disc(0.0).unwrap_err().field, "radius_m");
    }
}
