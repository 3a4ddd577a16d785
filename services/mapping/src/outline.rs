//! The robot's outline, and the cells under it.

use nalgebra::Point2;
use zeronav_msgs::description::{Corner, Description};
use zeronav_msgs::{Cell, GridGeometry, Pose};

/// A convex outline in `base`, or a disc around its origin.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Outline {
    /// Counter-clockwise; empty for a disc. [m]
    corners: Vec<Point2<f64>>,
    /// Of the smallest disc around the origin that holds it. [m]
    radius_m: f64,
}

impl Outline {
    /// The outline of a described robot.
    #[must_use]
    pub(crate) fn new(description: &Description, corners: &[Corner]) -> Self {
        Self {
            corners: corners
                .iter()
                .map(|corner| Point2::new(corner.x_m, corner.y_m))
                .collect(),
            radius_m: description.circumscribed_radius_m,
        }
    }

    /// Of the smallest disc around the origin that holds it. [m]
    pub(crate) const fn radius_m(&self) -> f64 {
        self.radius_m
    }

    /// True when a point of `base` lies inside or on the outline.
    #[must_use]
    pub(crate) fn contains(&self, point_in_base: Point2<f64>) -> bool {
        if self.corners.is_empty() {
            return point_in_base.coords.norm() <= self.radius_m;
        }
        let next = self.corners.iter().cycle().skip(1);
        self.corners.iter().zip(next).all(|(from, to)| {
            let (edge, at) = (to - from, point_in_base - from);
            edge.x * at.y - edge.y * at.x >= 0.0
        })
    }

    /// Calls `visit` with the row-major index of every cell whose centre lies under the robot.
    pub(crate) fn cells_under(
        &self,
        geometry: &GridGeometry,
        map_from_base: &Pose,
        mut visit: impl FnMut(usize),
    ) {
        let (sin, cos) = map_from_base.yaw_rad.sin_cos();
        let corner = |sign: f64| {
            geometry.unbounded_cell_at(Point2::new(
                map_from_base.x_m + sign * self.radius_m,
                map_from_base.y_m + sign * self.radius_m,
            ))
        };
        let (width, height) = geometry.size();
        let (min, max) = (corner(-1.0), corner(1.0));
        for y in min.y.max(0)..=max.y.min(height - 1) {
            for x in min.x.max(0)..=max.x.min(width - 1) {
                let cell = Cell::new(x, y);
                let offset = geometry.centre_of(cell) - map_from_base.point();
                let in_base = Point2::new(
                    cos * offset.x + sin * offset.y,
                    cos * offset.y - sin * offset.x,
                );
                if self.contains(in_base)
                    && let Some(index) = geometry.index_of(cell)
                {
                    visit(index);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn count(outline: &Outline, pose: Pose) -> usize {
        let geometry = GridGeometry {
            origin_x_m: -5.0,
            origin_y_m: -5.0,
            resolution_m: 0.05,
            width: 200,
            height: 200,
        };
        let mut n = 0;
        outline.cells_under(&geometry, &pose, |_| n += 1);
        n
    }

    #[test]
    fn a_box_covers_its_area_wherever_it_looks() {
        let description = Description {
            circumscribed_radius_m: 0.51,
            ..Description::default()
        };
        let corners = [(-0.4, -0.3), (0.4, -0.3), (0.4, 0.3), (-0.4, 0.3)]
            .map(|(x_m, y_m)| Corner { x_m, y_m });
        let outline = Outline::new(&description, &corners);
        assert_eq!(count(&outline, Pose::new(0.0, 0.0, 0.0)), 16 * 12);
        for yaw in [0.3, 0.8, 1.5, -2.0] {
            // 0.48 m^2 are 192 cells, less or more by what lies on the border.
            let n = count(&outline, Pose::new(0.3, 1.2, yaw));
            assert!((180..=204).contains(&n), "{n} cells at {yaw} rad");
        }
        assert_eq!(count(&outline, Pose::new(30.0, 0.0, 0.0)), 0);
        let half = count(&outline, Pose::new(-5.0, 0.0, 0.0));
        assert_eq!(half, 8 * 12);
    }

    #[test]
    fn a_disc_is_a_disc() {
        let description = Description {
            circumscribed_radius_m: 0.25,
            ..Description::default()
        };
        let outline = Outline::new(&description, &[]);
        // Pi 0.25^2 are 78.5 cells.
        assert!((70..=88).contains(&count(&outline, Pose::new(0.01, 0.02, 0.0))));
        assert!(outline.contains(Point2::new(0.0, 0.25)));
        assert!(!outline.contains(Point2::new(0.18, 0.18)));
    }
}
