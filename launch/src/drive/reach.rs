//! Where a robot can drive to on a map. Pure.

use nalgebra::Point2;
use zeronav_msgs::MapView;
use zeronav_msgs::grid::{Cell, GridGeometry};

/// Cells that are connected with the robot's over cells that do not block its centre.
#[derive(Debug)]
pub(super) struct Reach {
    geometry: GridGeometry,
    reached: Vec<bool>,
}

impl Reach {
    /// From `start` in the map frame [m]; nothing when that is off the map. Unknown cells may be crossed,
    /// diagonal steps are not taken. O(cells).
    pub(super) fn from(map: &MapView<'_>, start: Point2<f64>) -> Self {
        let mut reach = Self {
            geometry: *map.geometry,
            reached: vec![false; map.cells.len()],
        };
        let mut open: Vec<Cell> = map.geometry.cell_at(start).into_iter().collect();
        let mut is_start = true;
        while let Some(cell) = open.pop() {
            let Some(index) = map.geometry.index_of(cell) else {
                continue;
            };
            // A robot beside a wall stands in a cell that blocks its centre.
            let blocks = !is_start && map.cells.get(index).is_none_or(|cell| cell.blocks_centre());
            is_start = false;
            if blocks || std::mem::replace(&mut reach.reached[index], true) {
                continue;
            }
            let steps = [(1, 0), (-1, 0), (0, 1), (0, -1)];
            open.extend(steps.map(|(x, y)| Cell::new(cell.x + x, cell.y + y)));
        }
        reach
    }

    /// Whether the robot can be driven to this point of the map frame. [m]
    pub(super) fn contains(&self, at: Point2<f64>) -> bool {
        let index = (self.geometry.cell_at(at)).and_then(|cell| self.geometry.index_of(cell));
        index.is_some_and(|index| self.reached.get(index) == Some(&true))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use zeronav_msgs::map::{COST_LETHAL, MapCell};

    #[test]
    fn what_lies_behind_a_wall_is_not_reached() {
        let geometry = GridGeometry {
            resolution_m: 0.5,
            width: 6,
            height: 3,
            ..GridGeometry::default()
        };
        let mut cells = vec![MapCell::unknown(500); 18];
        for row in 0..3 {
            cells[row * 6 + 3].cost = COST_LETHAL;
        }
        let view = |cells: &[MapCell], start| {
            let map = MapView {
                geometry: &geometry,
                cells,
            };
            let reach = Reach::from(&map, start);
            [0.25, 1.25, 1.75, 2.25, 9.0].map(|x| reach.contains(Point2::new(x, 0.75)))
        };
        let here = Point2::new(0.3, 0.3);
        assert_eq!(view(&cells, here), [true, true, false, false, false]);
        assert_eq!(view(&cells, Point2::new(-3.0, 0.3)), [false; 5]);
        // From within the inflation of the wall both sides may be tried.
        let inside = Point2::new(1.6, 0.8);
        assert_eq!(view(&cells, inside), [true, true, true, true, false]);
        cells[3].cost = 0;
        assert_eq!(view(&cells, here), [true, true, false, true, false]);
    }
}
