//! Where a robot can drive to on a map. Pure.
//!
//! The stock global planner's rules, for which launch must not depend on it: with every corner rule
//! but `allow` cells are connected over their edges. A robot that is too close to an obstacle leaves it as
//! the planner leads it ([`zeronav_msgs::escape`]). What a planner's own options forbid is not known here.

use nalgebra::Point2;
use std::collections::VecDeque;
use zeronav_msgs::escape::{ESCAPE_M, Escape, Standing};
use zeronav_msgs::grid::{Cell, GridGeometry};
use zeronav_msgs::map::{COST_LETHAL, MapCell, ObstacleSource};
use zeronav_msgs::zone_marks::MARK_KEEPOUT;
use zeronav_msgs::zones::ZoneKind;
use zeronav_msgs::{CellRect, MapView, ZoneSet};

/// Cells that the robot can drive to.
#[derive(Debug)]
pub(super) struct Reach {
    geometry: GridGeometry,
    reached: Vec<bool>,
}

impl Reach {
    /// From `start` in the map frame [m]; nothing when that is off the map. Unknown cells may be crossed,
    /// diagonal steps are not taken, nor those into a keepout zone: the map may not have the newest zones yet.
    /// O(cells).
    pub(super) fn from(map: &MapView<'_>, start: Point2<f64>, zones: &ZoneSet) -> Self {
        let (width, height) = map.geometry.size();
        let whole = CellRect {
            min: Cell::new(0, 0),
            max: Cell::new(width, height),
        };
        let marks = if zones.has(ZoneKind::Keepout) {
            zones.marks(map.geometry, &whole)
        } else {
            Vec::new()
        };
        let mut reach = Self {
            geometry: *map.geometry,
            reached: vec![false; map.cells.len()],
        };
        let mut open = reach.exits(map, start);
        while let Some(cell) = open.pop_front() {
            for next in beside(cell) {
                let Some(index) = map.geometry.index_of(next) else {
                    continue;
                };
                let is_free = (map.cells.get(index)).is_some_and(|cell| !cell.blocks_centre());
                let is_open = marks.get(index) != Some(&MARK_KEEPOUT);
                if is_free && is_open && !reach.reached[index] {
                    reach.reached[index] = true;
                    open.push_back(next);
                }
            }
        }
        reach
    }

    /// Marks the cells over which the robot leaves the inflation, and gives the free ones at their
    /// ends; its own cell alone where it is free.
    fn exits(&mut self, map: &MapView<'_>, start: Point2<f64>) -> VecDeque<Cell> {
        let here = map.geometry.cell_at(start);
        let Some((first, own)) = here.and_then(|cell| Some((cell, map.get(cell)?))) else {
            return VecDeque::new();
        };
        let standing = |cell: MapCell| match cell {
            cell if cell.cost == COST_LETHAL => Standing::Obstacle,
            cell if cell.blocks_centre() => Standing::Inflated,
            _ => Standing::Free,
        };
        let mut escape = Escape::default();
        let reach = (ESCAPE_M, map.least_clearance_mm(own));
        escape.flood(map, first, reach, standing, |_, _| false);
        let entered = escape.entered().iter();
        for index in entered.filter_map(|cell| map.geometry.index_of(*cell)) {
            self.reached[index] = true;
        }
        escape.exits().iter().copied().collect()
    }

    /// Whether the robot can be driven to this point of the map frame. [m]
    pub(super) fn contains(&self, at: Point2<f64>) -> bool {
        let index = (self.geometry.cell_at(at)).and_then(|cell| self.geometry.index_of(cell));
        index.is_some_and(|index| self.reached.get(index) == Some(&true))
    }
}

/// The cells that share an edge with one.
fn beside(cell: Cell) -> [Cell; 4] {
    [(1, 0), (-1, 0), (0, 1), (0, -1)].map(|(x, y)| Cell::new(cell.x + x, cell.y + y))
}

/// True when the centre of some cell within `tolerance_m` of a goal is free for the robot's centre, or may
/// become so, because what blocks it is not in the static map: a planner on this map may lead there.
pub(super) fn may_have_room(map: &MapView<'_>, goal: Point2<f64>, tolerance_m: f64) -> bool {
    let corner = nalgebra::Vector2::repeat(tolerance_m);
    let low = map.geometry.unbounded_cell_at(goal - corner);
    let high = map.geometry.unbounded_cell_at(goal + corner);
    let (width, height) = map.geometry.size();
    let cells = || {
        let rows = low.y.max(0)..=high.y.min(height - 1);
        let columns = low.x.max(0)..=high.x.min(width - 1);
        let all = rows.flat_map(move |y| columns.clone().map(move |x| Cell::new(x, y)));
        all.filter(|cell| {
            let own = map.geometry.cell_at(goal) == Some(*cell);
            own || (map.geometry.centre_of(*cell) - goal).norm() <= tolerance_m
        })
    };
    let is_free = |cell: Cell| map.get(cell).is_some_and(|cell| !cell.blocks_centre());
    cells().any(is_free) || cells().any(|cell| map.source_at(cell) != ObstacleSource::StaticMap)
}

#[cfg(test)]
mod tests {
    use super::*;
    use zeronav_msgs::map::{COST_INSCRIBED, FLAG_SENSED, FLAG_STATIC};
    use zeronav_msgs::zones::{ZonePart, Zones};

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
        let corners = [[1.1, 0.0], [1.4, 0.0], [1.4, 1.5], [1.1, 1.5]];
        let zone = ZonePart::new("zone", ZoneKind::Keepout, 0.0, &corners);
        let closed = ZoneSet::of(&Zones::default(), &[zone]);
        let view_of = |cells: &[MapCell], start, zones: &ZoneSet| {
            let map = MapView {
                geometry: &geometry,
                cells,
            };
            let reach = Reach::from(&map, start, zones);
            [0.25, 1.25, 1.75, 2.25, 9.0].map(|x| reach.contains(Point2::new(x, 0.75)))
        };
        let view = |cells: &[MapCell], start| view_of(cells, start, &ZoneSet::default());
        let here = Point2::new(0.3, 0.3);
        assert_eq!(view(&cells, here), [true, true, false, false, false]);
        assert_eq!(
            view_of(&cells, here, &closed),
            [true, false, false, false, false]
        );
        assert_eq!(view(&cells, Point2::new(-3.0, 0.3)), [false; 5]);
        // In an obstacle it goes nowhere.
        let inside = Point2::new(1.6, 0.8);
        assert_eq!(view(&cells, inside), [false; 5]);
        cells[3].cost = 0;
        assert_eq!(view(&cells, here), [true, true, false, true, false]);
    }

    /// A row of cells of 10 cm by cost and clearance [mm].
    fn row(cells: &[(u8, u16)]) -> (GridGeometry, Vec<MapCell>) {
        let geometry = GridGeometry {
            resolution_m: 0.1,
            width: u32::try_from(cells.len()).expect("a few"),
            height: 1,
            ..GridGeometry::default()
        };
        let cell = |(cost, clearance_mm): &(u8, u16)| MapCell {
            cost: *cost,
            flags: FLAG_STATIC,
            clearance_mm: *clearance_mm,
        };
        (geometry, cells.iter().map(cell).collect())
    }

    #[test]
    fn a_robot_leaves_the_inflation_where_it_has_as_much_room() {
        let close = COST_INSCRIBED;
        let reached = |cells: &[(u8, u16)], x_m: f64| -> Vec<bool> {
            let (geometry, cells) = row(cells);
            let map = MapView {
                geometry: &geometry,
                cells: &cells,
            };
            let reach = Reach::from(&map, Point2::new(x_m, 0.05), &ZoneSet::default());
            let all = 0..geometry.width;
            all.map(|x| reach.contains(geometry.centre_of(Cell::new(x.cast_signed(), 0))))
                .collect()
        };
        // Two cells deep in the inflation, with a gap on the right that is tighter than that.
        let room = [(0, 400), (close, 250), (close, 230), (close, 120), (0, 400)];
        assert_eq!(reached(&room, 0.25), [true, true, true, false, false]);
        // A gap as wide as where it is, which it may fit through, too.
        let room = [(0, 400), (close, 250), (close, 230), (close, 200), (0, 400)];
        assert_eq!(reached(&room, 0.25), [true; 5]);
        // Farther than it is led.
        let mut long = vec![(close, 250); 9];
        long.push((0, 400));
        assert!(!reached(&long, 0.05)[9]);
        assert!(reached(&long, 0.35)[9]);
    }

    #[test]
    fn a_goal_has_room_where_a_cell_is_free_or_may_become_so() {
        let (geometry, mut cells) = row(&[(0, 400), (COST_INSCRIBED, 150), (COST_LETHAL, 0)]);
        let goal = Point2::new(0.25, 0.05);
        let has_room = |cells: &[MapCell], tolerance_m| {
            let map = MapView {
                geometry: &geometry,
                cells,
            };
            may_have_room(&map, goal, tolerance_m)
        };
        assert!(has_room(&cells, 0.2001));
        assert!(!has_room(&cells, 0.19), "the free cell's centre is farther");
        assert!(!has_room(&cells, 0.001));
        cells[2].flags = FLAG_SENSED;
        assert!(has_room(&cells, 0.001), "it may go");
        cells[2].flags = 0;
        assert!(has_room(&cells, 0.001), "what is tracked may, too");
    }
}
