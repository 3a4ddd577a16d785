//! How a robot whose centre is too close to an obstacle leaves the inflation. Pure.
//!
//! It fits where it is, so it is led over cells with as much clearance
//! ([`MapView::least_clearance_mm`]) to the free ones near by: a gap that is too narrow for the robot is
//! none because the robot stands right before it. The stock planner leads it so, and launch takes or refuses
//! goals by it.

use crate::grid::Cell;
use crate::map::{MapCell, MapView};
use crate::window::{Window, cells_in};

/// How far the robot is led along either axis, unless a planner is told otherwise. [m]
pub const ESCAPE_M: f64 = 0.6;

/// What a cell is to the robot's centre.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Standing {
    /// It may be there.
    Free,
    /// Too close to an obstacle: it must not enter, but may leave over it.
    Inflated,
    /// It must not be there, whatever it comes from.
    Obstacle,
}

/// Offsets `(x, y)` of the steps: straight ones first, so that ways of equal steps are the shorter ones.
const STEPS: [(i32, i32); 8] = [
    (1, 0),
    (0, 1),
    (-1, 0),
    (0, -1),
    (1, 1),
    (-1, 1),
    (-1, -1),
    (1, -1),
];

const UNSEEN: u8 = 255;
const ROOT: u8 = 8;

/// The ways out of the inflation. Its memory is reused.
#[derive(Debug, Default)]
pub struct Escape {
    window: Window,
    /// Step that led to each cell of the window, `UNSEEN` or `ROOT`.
    seen: Vec<u8>,
    entered: Vec<Cell>,
    exits: Vec<Cell>,
}

impl Escape {
    /// Finds the free cells that a robot in `start` is led to, over cells with at least `least_mm` of
    /// clearance, at most `escape_m` from `start` along either axis; `start` itself where that is free.
    /// `standing` says what a cell is, `diagonal` whether a diagonal step from one cell to another is
    /// legal. False when the robot is in an obstacle or off the map.
    pub fn flood(
        &mut self,
        map: &MapView<'_>,
        start: Cell,
        (escape_m, least_mm): (f64, u16),
        standing: impl Fn(MapCell) -> Standing,
        diagonal: impl Fn(Cell, Cell) -> bool,
    ) -> bool {
        self.exits.clear();
        self.entered.clear();
        let reach = match map.get(start).map(&standing) {
            None | Some(Standing::Obstacle) => return false,
            Some(Standing::Inflated) => cells_in(escape_m, map.geometry.resolution_m),
            Some(Standing::Free) => 0,
        };
        let window = Window::around(start, reach);
        self.window = window;
        self.seen.clear();
        self.seen.resize(window.len(), UNSEEN);
        if let Some(index) = window.index_of(start) {
            self.seen[index] = ROOT;
        }
        self.entered.push(start);
        let has_room = |cell| {
            map.get(cell).is_some_and(|cell| {
                standing(cell) != Standing::Obstacle && cell.clearance_mm >= least_mm
            })
        };
        let mut next = 0;
        while let Some(&from) = self.entered.get(next) {
            next += 1;
            if map.get(from).map(&standing) == Some(Standing::Free) {
                self.exits.push(from);
                continue;
            }
            for (n, (dx, dy)) in (0_u8..).zip(STEPS) {
                let to = Cell::new(from.x + dx, from.y + dy);
                let Some(index) = window.index_of(to) else {
                    continue;
                };
                let is_straight = dx == 0 || dy == 0;
                if self.seen[index] == UNSEEN && has_room(to) && (is_straight || diagonal(from, to))
                {
                    self.seen[index] = n;
                    self.entered.push(to);
                }
            }
        }
        true
    }

    /// The free cells that were found, nearest first, in steps.
    #[must_use]
    pub fn exits(&self) -> &[Cell] {
        &self.exits
    }

    /// All cells that were entered on the way, the start and the exits among them.
    #[must_use]
    pub fn entered(&self) -> &[Cell] {
        &self.entered
    }

    /// Forgets the exits of which `tried` holds, and writes the cells from the start to the nearest other
    /// one, both included. `None` when there is none; then `way` is as it was.
    pub fn turn_to_next(
        &mut self,
        mut tried: impl FnMut(Cell) -> bool,
        way: &mut Vec<Cell>,
    ) -> Option<Cell> {
        self.exits.retain(|exit| !tried(*exit));
        let exit = self.exits.first().copied()?;
        way.clear();
        let mut cell = exit;
        loop {
            way.push(cell);
            let step = self.window.index_of(cell).map_or(ROOT, |n| self.seen[n]);
            let Some((dx, dy)) = STEPS.get(usize::from(step)) else {
                break;
            };
            cell = Cell::new(cell.x - dx, cell.y - dy);
        }
        way.reverse();
        Some(exit)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::GridGeometry;
    use crate::map::{COST_INSCRIBED, COST_LETHAL};

    /// What is reached from a cell of a room of 5 x 2 cells of 10 cm, by their costs and clearances [mm].
    fn exits(room: &[[(u8, u16); 5]; 2], start: Cell, diagonal: bool) -> (bool, Vec<Cell>) {
        let geometry = GridGeometry {
            resolution_m: 0.1,
            width: 5,
            height: 2,
            ..GridGeometry::default()
        };
        let cell = |(cost, clearance_mm): &(u8, u16)| MapCell {
            cost: *cost,
            flags: 0,
            clearance_mm: *clearance_mm,
        };
        let cells: Vec<MapCell> = room.iter().flatten().map(cell).collect();
        let map = MapView {
            geometry: &geometry,
            cells: &cells,
        };
        let standing = |cell: MapCell| match cell.cost {
            COST_LETHAL => Standing::Obstacle,
            COST_INSCRIBED => Standing::Inflated,
            _ => Standing::Free,
        };
        let mut escape = Escape::default();
        let least_mm = map.get(start).map_or(0, |own| map.least_clearance_mm(own));
        let found = escape.flood(&map, start, (0.3, least_mm), standing, |_, _| diagonal);
        let mut way = Vec::new();
        let mut tried = Vec::new();
        while let Some(exit) = escape.turn_to_next(|exit| tried.contains(&exit), &mut way) {
            assert_eq!((way.first(), way.last()), (Some(&start), Some(&exit)));
            let steps = way.windows(2).map(|step| {
                let (x, y) = (step[1].x - step[0].x, step[1].y - step[0].y);
                x.abs() + y.abs()
            });
            let longest = if diagonal { 2 } else { 1 };
            assert!(steps.clone().all(|n| (1..=longest).contains(&n)), "{way:?}");
            tried.push(exit);
        }
        (found, tried)
    }

    #[test]
    fn a_robot_is_led_where_it_has_as_much_room_and_no_farther_than_told() {
        let (close, wall) = (COST_INSCRIBED, COST_LETHAL);
        let mut room = [
            [(close, 250), (close, 240), (close, 230), (0, 400), (0, 400)],
            [(wall, 0), (wall, 0), (close, 120), (0, 400), (0, 400)],
        ];
        let start = Cell::new(0, 0);
        assert_eq!(exits(&room, start, false), (true, vec![Cell::new(3, 0)]));
        // Over the corner of the cell that is too tight.
        let both = vec![Cell::new(3, 0), Cell::new(3, 1)];
        assert_eq!(exits(&room, start, true), (true, both));
        // A free cell is its own exit.
        let free = Cell::new(4, 1);
        assert_eq!(exits(&room, free, false), (true, vec![free]));
        // Half a cell's diagonal less is as much room.
        room[0][2].1 = 179;
        assert_eq!(exits(&room, start, false), (true, vec![Cell::new(3, 0)]));
        room[0][2].1 = 178;
        assert_eq!(exits(&room, start, false), (true, vec![]));
        room[0][2] = (wall, 300);
        assert_eq!(exits(&room, start, false), (true, vec![]));
        // Beyond the reach.
        room[0][2] = (close, 250);
        (room[0][3], room[1][3]) = ((close, 250), (close, 250));
        assert_eq!(exits(&room, start, true), (true, vec![]));
        // In an obstacle, and off the map.
        assert_eq!(exits(&room, Cell::new(1, 1), true), (false, vec![]));
        assert_eq!(exits(&room, Cell::new(5, 0), true), (false, vec![]));
    }
}
