//! The static world as a grid: free, occupied or unknown.

use crate::parry_pose::parry_pose;
use nalgebra::Point2;
use parry2d::bounding_volume::Aabb;
use parry2d::math::Vec2;
use zeronav_casts::Cast;
use zeronav_msgs::map::{COST_LETHAL, FLAG_UNKNOWN, ObstacleSource};
use zeronav_msgs::pose::wrap_angle;
use zeronav_msgs::{Cell, GridGeometry, MapCell, MapView, Pose};

/// What a static map says about a cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum Occupancy {
    /// Free.
    Free = 0,
    /// Occupied by something solid.
    Occupied = 1,
    /// The map does not say.
    Unknown = 2,
}

/// A static map in the map frame.
#[derive(Debug, Clone, PartialEq)]
pub struct StaticMap {
    /// Where the cells lie.
    pub geometry: GridGeometry,
    /// `geometry.len()` cells, row-major from the lower left.
    pub cells: Vec<Occupancy>,
}

impl StaticMap {
    /// A map without anything on it.
    #[must_use]
    pub fn free(geometry: GridGeometry) -> Self {
        Self {
            cells: vec![Occupancy::Free; geometry.len()],
            geometry,
        }
    }

    /// A map as mapping publishes it, in the form of a map file: what is lethal is occupied, what is
    /// marked unknown is unknown, the rest is free.
    ///
    /// Costs are not kept: they follow from the obstacles by the cost model.
    #[must_use]
    pub fn of(view: &MapView<'_>) -> Self {
        let is_zone_alone = |cell: &MapCell| cell.source() == ObstacleSource::Keepout;
        let occupancy = |cell: &MapCell| match cell {
            cell if cell.cost == COST_LETHAL && !is_zone_alone(cell) => Occupancy::Occupied,
            cell if cell.flags & FLAG_UNKNOWN != 0 => Occupancy::Unknown,
            _ => Occupancy::Free,
        };
        Self {
            geometry: *view.geometry,
            cells: view.cells.iter().map(occupancy).collect(),
        }
    }

    /// What the map says about `cell`; `None` outside.
    #[must_use]
    pub fn get(&self, cell: Cell) -> Option<Occupancy> {
        let index = self.geometry.index_of(cell)?;
        self.cells.get(index).copied()
    }

    /// What the map says about the cell that holds a point of the map frame; `None` outside.
    #[must_use]
    pub fn at(&self, point_in_map: Point2<f64>) -> Option<Occupancy> {
        self.get(self.geometry.cell_at(point_in_map)?)
    }

    /// How many cells are as `wanted`.
    #[must_use]
    pub fn count(&self, wanted: Occupancy) -> usize {
        self.cells.iter().filter(|cell| **cell == wanted).count()
    }
}

/// Turns smaller than this move no corner of the largest map by a hundredth of a cell. [rad]
const YAW_NEGLIGIBLE_RAD: f64 = 1.0e-6;

/// Geometry of the upright grid that covers a grid of `width` x `height` cells whose lower left
/// corner lies at `corner`, turned by its yaw; `None` when a side leaves the numbers of a grid.
#[must_use]
pub fn covering_geometry(
    corner: &Pose,
    resolution_m: f64,
    (width, height): (u32, u32),
) -> Option<GridGeometry> {
    if is_upright(corner) {
        return Some(GridGeometry {
            origin_x_m: corner.x_m,
            origin_y_m: corner.y_m,
            resolution_m,
            width,
            height,
        });
    }
    let (w, h) = (
        f64::from(width) * resolution_m,
        f64::from(height) * resolution_m,
    );
    let own = Aabb::new(Vec2::ZERO, Vec2::new(w, h));
    let bounds = own.transform_by(&parry_pose(corner));
    Some(GridGeometry {
        origin_x_m: bounds.mins.x,
        origin_y_m: bounds.mins.y,
        resolution_m,
        width: cells_along(bounds.extents().x, resolution_m)?,
        height: cells_along(bounds.extents().y, resolution_m)?,
    })
}

/// Cells of `resolution_m` that cover `length_m`, a sliver of a millionth of a cell left out.
#[must_use]
pub fn cells_along(length_m: f64, resolution_m: f64) -> Option<u32> {
    let n = (length_m / resolution_m - 1.0e-6).ceil().max(1.0);
    (n <= f64::from(u32::MAX)).then_some(n.to_u32())
}

fn is_upright(corner: &Pose) -> bool {
    wrap_angle(corner.yaw_rad).abs() < YAW_NEGLIGIBLE_RAD
}

/// Lays a grid whose lower left corner lies at `corner`, turned by its yaw, onto `geometry`: each
/// upright cell takes what the turned grid says at its centre, and is unknown beside it.
#[must_use]
pub fn upright(
    geometry: GridGeometry,
    corner: &Pose,
    (width, height): (u32, u32),
    cells: Vec<Occupancy>,
) -> StaticMap {
    if is_upright(corner) {
        return StaticMap { geometry, cells };
    }
    let own = GridGeometry {
        origin_x_m: 0.0,
        origin_y_m: 0.0,
        resolution_m: geometry.resolution_m,
        width,
        height,
    };
    let (sin, cos) = corner.yaw_rad.sin_cos();
    let (columns, rows) = geometry.size();
    let mut turned = Vec::with_capacity(geometry.len());
    for y in 0..rows {
        for x in 0..columns {
            let from_corner = geometry.centre_of(Cell::new(x, y)) - corner.point();
            let point = Point2::new(
                cos * from_corner.x + sin * from_corner.y,
                cos * from_corner.y - sin * from_corner.x,
            );
            let source = own.cell_at(point).and_then(|cell| own.index_of(cell));
            turned.push(source.map_or(Occupancy::Unknown, |index| cells[index]));
        }
    }
    StaticMap {
        geometry,
        cells: turned,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use Occupancy::{Free, Occupied, Unknown};
    use core::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

    fn laid(corner: &Pose, size: (u32, u32), cells: &[Occupancy]) -> StaticMap {
        let geometry = covering_geometry(corner, 1.0, size).unwrap();
        upright(geometry, corner, size, cells.to_vec())
    }

    #[test]
    fn without_a_turn_nothing_changes() {
        let cells = [Free, Occupied, Unknown, Free, Free, Free];
        let map = laid(&Pose::new(-2.0, 3.0, 0.0), (3, 2), &cells);
        assert_eq!(map.cells, cells);
        assert_eq!((map.geometry.width, map.geometry.height), (3, 2));
        assert_eq!(map.at(Point2::new(0.5, 3.5)), Some(Unknown));
        assert_eq!(map.get(Cell::new(3, 0)), None);
    }

    #[test]
    fn a_quarter_turn_makes_columns_of_rows() {
        // Lower left corner at the origin, turned left: covers x -2..0, y 0..3.
        let cells = [Free, Occupied, Unknown, Free, Free, Free];
        let map = laid(&Pose::new(0.0, 0.0, FRAC_PI_2), (3, 2), &cells);
        assert_eq!((map.geometry.width, map.geometry.height), (2, 3));
        assert!((map.geometry.origin_x_m + 2.0).abs() < 1e-9);
        assert!(map.geometry.origin_y_m.abs() < 1e-9);
        assert_eq!(map.cells, [Free, Free, Free, Occupied, Free, Unknown]);
    }

    #[test]
    fn a_half_turn_reverses_the_cells() {
        let cells = [Free, Occupied, Unknown, Free, Free, Free];
        let map = laid(&Pose::new(5.0, 5.0, PI), (3, 2), &cells);
        let mut reversed = cells;
        reversed.reverse();
        assert_eq!(map.cells, reversed);
        assert!((map.geometry.origin_x_m - 2.0).abs() < 1e-9);
        assert!((map.geometry.origin_y_m - 3.0).abs() < 1e-9);
    }

    #[test]
    fn an_eighth_turn_is_unknown_in_the_corners_and_keeps_the_area() {
        let size = (100, 100);
        let map = laid(&Pose::new(0.0, 0.0, FRAC_PI_4), size, &[Occupied; 10_000]);
        assert_eq!((map.geometry.width, map.geometry.height), (142, 142));
        assert_eq!(map.get(Cell::new(0, 0)), Some(Unknown));
        assert_eq!(map.get(Cell::new(71, 71)), Some(Occupied));
        let occupied = map.count(Occupied);
        assert!((9_800..=10_200).contains(&occupied), "{occupied}");
    }

    #[test]
    fn a_sliver_makes_no_cell() {
        assert_eq!(cells_along(0.1 + 0.2, 0.1), Some(3));
        assert_eq!(cells_along(0.31, 0.1), Some(4));
        assert_eq!(cells_along(1.0e30, 0.1), None);
    }
}
