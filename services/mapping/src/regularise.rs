//! Obstacle regularisation (TN-REG): obstacle groups on the way become their bounding rectangle,
//! so that planners stay out of their pockets.
//!
//! The straight line from the robot to its goal is followed cell by cell; where it meets an
//! obstacle, the obstacle's 8-connected group is flooded, and the free cells of its bounding box
//! are virtual. Groups off the line stay as they are, and so does a group whose rectangle would
//! hold the robot or the goal, or is too large. Nothing but the list of rectangles is made: what
//! is an obstacle stays the business of the other layers.

use crate::rows_around::cell_at;
use zeronav_casts::Cast;
use zeronav_msgs::{Cell, CellRect, GridGeometry};
use zeronav_params::parameters;

parameters! {
    /// Whether and how far obstacles are regularised.
    #[derive(Copy)]
    pub struct RegularisationConfig {
        /// Whether obstacle groups on the straight line to the goal become rectangles.
        enabled: bool = false;
        /// Most groups along the line; the next is done when the line is examined again.
        groups_max: usize = 1, [0, 1000];
        /// Largest rectangle, as a share of the map's area.
        area_share_max: f64 = 0.25, [f64::MIN_POSITIVE, 1.0];
    }
}

/// A flooded group.
#[derive(Debug, Clone, Copy)]
struct Group {
    /// What its cells are marked with.
    mark: u32,
    bounds: CellRect,
    too_large: bool,
}

/// Rectangles, and the memory they are found with.
#[derive(Debug)]
pub struct Regulariser {
    geometry: GridGeometry,
    groups_max: usize,
    area_max: i64,
    /// Mark of the group that each cell was last found in, 0 = none.
    marks: Vec<u32>,
    last_mark: u32,
    groups: Vec<Group>,
    stack: Vec<Cell>,
    /// Marks of the groups that the current line has met.
    met: Vec<u32>,
    rectangles: Vec<CellRect>,
    skipped: usize,
}

impl Regulariser {
    /// Nothing found yet.
    #[must_use]
    pub fn new(geometry: &GridGeometry, config: &RegularisationConfig) -> Self {
        Self {
            geometry: *geometry,
            groups_max: config.groups_max,
            area_max: (geometry.len().to_f64() * config.area_share_max).to_i64(),
            marks: vec![0; geometry.len()],
            last_mark: 0,
            groups: Vec::new(),
            stack: Vec::new(),
            met: Vec::new(),
            rectangles: Vec::new(),
            skipped: 0,
        }
    }

    /// Obstacles have come or gone at these row-major indices: the groups that they may belong to
    /// are found again when the line meets them.
    pub fn changed(&mut self, came: &[usize], went: &[usize]) {
        let (geometry, marks) = (&self.geometry, &self.marks);
        self.groups.retain(|group| {
            if group.too_large {
                // What comes makes it no smaller.
                return !went.iter().any(|index| marks[*index] == group.mark);
            }
            let near = group.bounds.grown(1, geometry);
            let mut all = came.iter().chain(went);
            !all.any(|index| near.contains(cell_at(geometry, *index)))
        });
    }

    /// Finds the rectangles on the line between two cells of the map.
    pub fn look_along(&mut self, from: Cell, to: Cell, is_obstacle: impl Fn(usize) -> bool) {
        self.rectangles.clear();
        self.skipped = 0;
        self.met.clear();
        supercover(from, to, |cell| {
            let Some(index) = self
                .geometry
                .index_of(cell)
                .filter(|index| is_obstacle(*index))
            else {
                return true;
            };
            let mark = self.marks[index];
            let known = self.groups.iter().find(|group| group.mark == mark).copied();
            let group = known.unwrap_or_else(|| self.flood(cell, &is_obstacle));
            if self.met.contains(&group.mark) {
                return true;
            }
            self.met.push(group.mark);
            let holds = |cell| group.bounds.contains(cell);
            if group.too_large || holds(from) || holds(to) {
                self.skipped += 1;
            } else {
                self.rectangles.push(group.bounds);
            }
            self.met.len() < self.groups_max
        });
    }

    /// There is no line any more.
    pub fn forget_line(&mut self) {
        self.rectangles.clear();
        self.skipped = 0;
    }

    /// What was found. Their free cells are virtual obstacles.
    #[must_use]
    pub fn rectangles(&self) -> &[CellRect] {
        &self.rectangles
    }

    /// Groups on the line whose rectangle would hold the robot or the goal, or is too large.
    #[must_use]
    pub fn skipped(&self) -> usize {
        self.skipped
    }

    /// Marks the group around `seed` and remembers it.
    fn flood(&mut self, seed: Cell, is_obstacle: &impl Fn(usize) -> bool) -> Group {
        self.last_mark += 1;
        let mark = self.last_mark;
        let mut bounds = CellRect {
            min: seed,
            max: Cell::new(seed.x + 1, seed.y + 1),
        };
        let mut joins_too_large = false;
        self.stack.clear();
        if let Some(index) = self.geometry.index_of(seed) {
            self.marks[index] = mark;
            self.stack.push(seed);
        }
        while let Some(at) = self.stack.pop() {
            bounds.min = Cell::new(bounds.min.x.min(at.x), bounds.min.y.min(at.y));
            bounds.max = Cell::new(bounds.max.x.max(at.x + 1), bounds.max.y.max(at.y + 1));
            for y in at.y - 1..=at.y + 1 {
                for x in at.x - 1..=at.x + 1 {
                    let next = Cell::new(x, y);
                    let Some(index) = self.geometry.index_of(next) else {
                        continue;
                    };
                    if self.marks[index] == mark || !is_obstacle(index) {
                        continue;
                    }
                    let other = self.marks[index];
                    let mut large = self.groups.iter().filter(|group| group.too_large);
                    if large.any(|group| group.mark == other) {
                        // It is part of what is known to be too large, and need not be flooded.
                        joins_too_large = true;
                        continue;
                    }
                    self.marks[index] = mark;
                    self.stack.push(next);
                }
            }
        }
        let size = |low: i32, high: i32| i64::from(high) - i64::from(low);
        let area = size(bounds.min.x, bounds.max.x) * size(bounds.min.y, bounds.max.y);
        let group = Group {
            mark,
            bounds,
            too_large: joins_too_large || area > self.area_max,
        };
        self.groups.push(group);
        group
    }
}

/// Shows `see` every cell that the line between two cells' centres touches, in order, both cells
/// beside a corner that it passes through, until `see` returns false. In whole numbers: the next
/// border along x is at `(2 nx + 1) / 2 dx` of the line, along y at `(2 ny + 1) / 2 dy`.
fn supercover(from: Cell, to: Cell, mut see: impl FnMut(Cell) -> bool) {
    let (dx, dy) = (
        i64::from(to.x) - i64::from(from.x),
        i64::from(to.y) - i64::from(from.y),
    );
    let (step_x, step_y) = (if dx < 0 { -1 } else { 1 }, if dy < 0 { -1 } else { 1 });
    let (dx, dy) = (dx.abs(), dy.abs());
    let (mut nx, mut ny) = (0, 0);
    let mut at = from;
    if !see(at) {
        return;
    }
    while nx < dx || ny < dy {
        let (x_border, y_border) = ((2 * nx + 1) * dy, (2 * ny + 1) * dx);
        if x_border == y_border
            && !(see(Cell::new(at.x + step_x, at.y)) && see(Cell::new(at.x, at.y + step_y)))
        {
            return;
        }
        if x_border <= y_border {
            at.x += step_x;
            nx += 1;
        }
        if y_border <= x_border {
            at.y += step_y;
            ny += 1;
        }
        if !see(at) {
            return;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(from: (i32, i32), to: (i32, i32)) -> Vec<(i32, i32)> {
        let mut cells = Vec::new();
        supercover(Cell::new(from.0, from.1), Cell::new(to.0, to.1), |cell| {
            cells.push((cell.x, cell.y));
            true
        });
        cells
    }

    #[test]
    fn lines_touch_what_they_touch() {
        assert_eq!(line((2, 3), (2, 3)), [(2, 3)]);
        assert_eq!(line((0, 0), (3, 0)), [(0, 0), (1, 0), (2, 0), (3, 0)]);
        assert_eq!(line((0, 2), (0, 0)), [(0, 2), (0, 1), (0, 0)]);
        // Through corners: both sides.
        assert_eq!(
            line((0, 0), (-2, 2)),
            [(0, 0), (-1, 0), (0, 1), (-1, 1), (-2, 1), (-1, 2), (-2, 2)]
        );
        assert_eq!(line((0, 0), (2, 1)), [(0, 0), (1, 0), (1, 1), (2, 1)]);
    }
}
