//! The synthetic world of the tests: a room with a block in its middle, and a box that appears on the
//! straight way to the goal.

use nalgebra::{Point2, Vector2};
use zeronav_msgs::grid::{Cell, GridGeometry};
use zeronav_msgs::map::{
    CostModel, FLAG_SENSED, FLAG_STATIC, MapCell, MapTile, TILE_CELLS, clearance_mm, tiles_of,
};
use zeronav_msgs::pose::Pose;

/// Tick at which the box is there.
pub(crate) const BOX_TICK: u64 = 60;

/// Clearance at which the map is saturated. [mm]
pub(crate) const CLEARANCE_LIMIT_MM: u16 = 2000;

/// Radius of the robot. [m]
pub(crate) const ROBOT_RADIUS_M: f64 = 0.2;

/// Where the robot starts.
pub(crate) const START: Pose = Pose::new(1.0, 1.0, 0.0);

/// Where it is sent.
pub(crate) const GOAL: Pose = Pose::new(6.5, 1.0, 0.0);

/// Corners of the free way around the box, as the kit's own planner sends it. [m]
pub(crate) const DETOUR_M: [[f64; 2]; 3] = [[2.6, 2.0], [4.6, 2.0], [6.5, 1.0]];

/// An upright rectangle: lower and upper corner. [m]
type Rectangle = [[f64; 2]; 2];

/// Walls and block.
const STATIC: [Rectangle; 5] = [
    [[-0.2, -0.2], [8.2, 0.0]],
    [[-0.2, 6.0], [8.2, 6.2]],
    [[-0.2, 0.0], [0.0, 6.0]],
    [[8.0, 0.0], [8.2, 6.0]],
    [[2.5, 2.6], [5.5, 3.4]],
];

/// The box.
const BOX: Rectangle = [[3.4, 0.0], [3.9, 1.4]];

/// The room at one tick.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Room {
    with_box: bool,
}

impl Room {
    /// The room at `tick`.
    pub(crate) fn at(tick: u64) -> Self {
        Self {
            with_box: tick >= BOX_TICK,
        }
    }

    fn rectangles(self) -> impl Iterator<Item = &'static Rectangle> {
        STATIC.iter().chain(self.with_box.then_some(&BOX))
    }

    /// Distance from a point to the nearest obstacle; 0 inside. [m]
    pub(crate) fn distance_m(self, point: Point2<f64>) -> f64 {
        let distances = self
            .rectangles()
            .map(|rectangle| distance_m(rectangle, point));
        distances.fold(f64::INFINITY, f64::min)
    }

    /// Distance to the first obstacle in a direction; infinite when there is none. [m]
    pub(crate) fn range_m(self, from: Point2<f64>, angle_rad: f64) -> f64 {
        let direction = Vector2::new(angle_rad.cos(), angle_rad.sin());
        let hits = self
            .rectangles()
            .filter_map(|rectangle| hit_m(rectangle, from, direction));
        hits.fold(f64::INFINITY, f64::min)
    }

    /// The cell of the map.
    pub(crate) fn cell(self, cell: Cell) -> MapCell {
        let centre = geometry().centre_of(cell);
        let clearance_m = self.distance_m(centre);
        let mut flags = 0;
        if clearance_m <= 0.0 {
            let is_static = STATIC.iter().any(|wall| distance_m(wall, centre) <= 0.0);
            flags = if is_static { FLAG_STATIC } else { FLAG_SENSED };
        }
        MapCell {
            cost: COST_MODEL.cost(clearance_m),
            flags,
            clearance_mm: clearance_mm(clearance_m, CLEARANCE_LIMIT_MM),
        }
    }

    /// All tiles of the map.
    pub(crate) fn tiles(self) -> Vec<MapTile> {
        let (columns, rows) = tiles_of(&geometry());
        let places = (0..rows).flat_map(|row| (0..columns).map(move |column| (column, row)));
        places
            .map(|(tile_x, tile_y)| self.tile(tile_x, tile_y))
            .collect()
    }

    fn tile(self, tile_x: u32, tile_y: u32) -> MapTile {
        let mut tile = MapTile {
            tile_x,
            tile_y,
            cells: [MapCell::unknown(0); 1024],
        };
        let rect = tile.rect(&geometry());
        for y in rect.min.y..rect.max.y {
            for x in rect.min.x..rect.max.x {
                let column = (x - rect.min.x).cast_unsigned() as usize;
                let row = (y - rect.min.y).cast_unsigned() as usize;
                tile.cells[row * TILE_CELLS + column] = self.cell(Cell::new(x, y));
            }
        }
        tile
    }
}

/// How costs follow from clearance, for the robot of the tests.
pub(crate) const COST_MODEL: CostModel = CostModel {
    inscribed_radius_m: ROBOT_RADIUS_M,
    padding_m: 0.05,
    inflation_radius_m: 0.8,
    scaling_per_m: 5.0,
};

/// What launch writes into the configuration of mapping for a map without a file: area and resolution.
pub(crate) fn mapping_config() -> String {
    let GridGeometry {
        origin_x_m,
        origin_y_m,
        resolution_m,
        width,
        height,
    } = geometry();
    let far = |from_m: f64, cells: u32| from_m + f64::from(cells) * resolution_m;
    let (far_x_m, far_y_m) = (far(origin_x_m, width), far(origin_y_m, height));
    format!(
        "area_m = [[{origin_x_m:?}, {origin_y_m:?}], [{far_x_m:?}, {far_y_m:?}]]\n\
         resolution_m = {resolution_m:?}\n"
    )
}

/// Where the map lies.
pub(crate) fn geometry() -> GridGeometry {
    GridGeometry {
        origin_x_m: -0.2,
        origin_y_m: -0.2,
        resolution_m: 0.05,
        width: 168,
        height: 128,
    }
}

fn distance_m([low, high]: &Rectangle, point: Point2<f64>) -> f64 {
    let beyond = |axis: usize| {
        (low[axis] - point[axis])
            .max(point[axis] - high[axis])
            .max(0.0)
    };
    beyond(0).hypot(beyond(1))
}

/// Distance along a ray to a rectangle, by the slab method.
fn hit_m(rectangle: &Rectangle, from: Point2<f64>, direction: Vector2<f64>) -> Option<f64> {
    let [low, high] = rectangle;
    let (mut enter, mut leave) = (0.0_f64, f64::INFINITY);
    for axis in 0..2 {
        if direction[axis].abs() < 1.0e-12 {
            if from[axis] < low[axis] || from[axis] > high[axis] {
                return None;
            }
            continue;
        }
        let a = (low[axis] - from[axis]) / direction[axis];
        let b = (high[axis] - from[axis]) / direction[axis];
        enter = enter.max(a.min(b));
        leave = leave.min(a.max(b));
    }
    (enter <= leave).then_some(enter)
}

#[cfg(test)]
mod tests {
    use super::*;
    use zeronav_msgs::map::COST_LETHAL;

    #[test]
    fn the_box_blocks_the_straight_way_and_the_detour_stays_free() {
        let (before, after) = (Room::at(BOX_TICK - 1), Room::at(BOX_TICK));
        let ahead = START.point();
        assert!((before.range_m(ahead, 0.0) - 7.0).abs() < 1.0e-9);
        assert!((after.range_m(ahead, 0.0) - 2.4).abs() < 1.0e-9);
        let mut from = Point2::new(2.0, 1.0);
        for corner in DETOUR_M {
            let to = Point2::from(corner);
            for step in 0..=100 {
                let at = from + (to - from) * (f64::from(step) / 100.0);
                assert!(after.distance_m(at) > 0.3, "{at}");
            }
            from = to;
        }
    }

    #[test]
    fn the_map_shows_the_box_as_sensed_and_the_walls_as_static() {
        let cell = |x_m, y_m| {
            geometry()
                .cell_at(Point2::new(x_m, y_m))
                .expect("on the map")
        };
        let room = Room::at(BOX_TICK);
        let in_box = room.cell(cell(3.6, 0.7));
        assert_eq!((in_box.cost, in_box.flags), (COST_LETHAL, FLAG_SENSED));
        let wall = room.cell(cell(-0.1, 3.0));
        assert_eq!((wall.cost, wall.flags), (COST_LETHAL, FLAG_STATIC));
        assert_eq!(Room::at(0).cell(cell(3.6, 0.7)).flags, 0);
    }
}
