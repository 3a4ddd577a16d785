//! Shapes drawn onto a grid.

use crate::convex::Convex;
use crate::static_map::{Occupancy, StaticMap};
use nalgebra::Point2;
use zeronav_msgs::Cell;

/// A shape this near to a cell touches it, so that a wall along a cell border marks both sides
/// whatever the last digit of its coordinates is; so do lidar hits on that wall. [m]
const TOUCH_M: f64 = 1.0e-9;

/// Marks every cell whose closed square touches `convex` as occupied.
///
/// Row by row: what a row's strip cuts out of a convex set is convex, so the touched cells of the
/// row are those over its extent along x, no more and no less.
pub(crate) fn mark(map: &mut StaticMap, convex: &Convex) {
    let geometry = map.geometry;
    let bounds = convex.bounds();
    let first = geometry.unbounded_cell_at(Point2::new(bounds.mins.x, bounds.mins.y));
    let last = geometry.unbounded_cell_at(Point2::new(bounds.maxs.x, bounds.maxs.y));
    let (_, height) = geometry.size();
    // One more on either side for squares that only touch.
    for y in first.y.saturating_sub(1).max(0)..=last.y.saturating_add(1).min(height - 1) {
        let row_min = geometry.origin_y_m + f64::from(y) * geometry.resolution_m;
        let row_max = row_min + geometry.resolution_m;
        let Some((left, right)) = convex.extent_in_strip(row_min - TOUCH_M, row_max + TOUCH_M)
        else {
            continue;
        };
        mark_row(map, y, left - TOUCH_M, right + TOUCH_M);
    }
}

/// Marks the cells of row `y` whose closed squares meet `left..=right`.
fn mark_row(map: &mut StaticMap, y: i32, left: f64, right: f64) {
    let geometry = map.geometry;
    let (width, _) = geometry.size();
    let at = |x: f64| {
        geometry
            .unbounded_cell_at(Point2::new(x, geometry.origin_y_m))
            .x
    };
    let border = |x: i32| geometry.origin_x_m + f64::from(x) * geometry.resolution_m;
    let mut from = at(left).max(0);
    // The cell to the left of the one that holds the point, when the point lies on its border.
    if from > 0 && border(from) >= left {
        from -= 1;
    }
    let to = at(right).min(width - 1);
    for x in from..=to {
        if let Some(index) = geometry.index_of(Cell::new(x, y)) {
            map.cells[index] = Occupancy::Occupied;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shape::Shape;
    use crate::spec::ShapeSpec;
    use parry2d::bounding_volume::Aabb;
    use parry2d::math::Vec2;
    use zeronav_msgs::GridGeometry;

    const GRID: GridGeometry = GridGeometry {
        origin_x_m: -1.0,
        origin_y_m: -1.0,
        resolution_m: 0.05,
        width: 40,
        height: 40,
    };

    fn drawn(spec: &ShapeSpec) -> (StaticMap, Shape) {
        let shape = Shape::new(spec).unwrap();
        let mut map = StaticMap::free(GRID);
        mark(&mut map, shape.placed());
        (map, shape)
    }

    #[track_caller]
    fn check(spec: &ShapeSpec) -> usize {
        let (map, shape) = drawn(spec);
        for y in 0..40 {
            for x in 0..40 {
                let half = Vec2::splat(GRID.resolution_m / 2.0);
                let centre = GRID.centre_of(Cell::new(x, y));
                let square = Aabb::from_half_extents(Vec2::new(centre.x, centre.y), half);
                let distance_m = shape.placed().distance_to_bounds_m(&square);
                let occupied = map.get(Cell::new(x, y)) == Some(Occupancy::Occupied);
                assert_eq!(occupied, distance_m <= 1.5e-9, "cell {x} {y}: {distance_m}");
            }
        }
        map.count(Occupancy::Occupied)
    }

    #[test]
    fn cells_are_marked_exactly_when_they_touch() {
        check(&ShapeSpec::Disc {
            centre_m: [0.111, -0.222],
            radius_m: 0.33,
        });
        check(&ShapeSpec::Box {
            centre_m: [0.2, 0.3],
            size_m: [1.3, 0.02],
            yaw_rad: 0.6,
        });
        check(&ShapeSpec::Polygon {
            corners_m: vec![[-0.9, -0.83], [0.71, -0.3], [0.2, 0.97]],
        });
        // Partly beside the map.
        check(&ShapeSpec::Disc {
            centre_m: [1.0, 1.1],
            radius_m: 0.5,
        });
    }

    #[test]
    fn a_box_on_cell_borders_marks_its_neighbours_too() {
        let n = check(&ShapeSpec::Box {
            centre_m: [0.1, 0.0],
            size_m: [0.2, 0.1],
            yaw_rad: 0.0,
        });
        assert_eq!(n, 6 * 4);
    }

    #[test]
    fn a_box_inside_one_cell_marks_that_cell() {
        let n = check(&ShapeSpec::Box {
            centre_m: [0.025, 0.025],
            size_m: [0.01, 0.01],
            yaw_rad: 0.3,
        });
        assert_eq!(n, 1);
    }

    #[test]
    fn far_away_shapes_mark_nothing() {
        let n = check(&ShapeSpec::Disc {
            centre_m: [900_000.0, -900_000.0],
            radius_m: 5.0,
        });
        assert_eq!(n, 0);
    }
}
