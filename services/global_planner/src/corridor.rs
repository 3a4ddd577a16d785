//! The cells that the robot's centre passes on a path, ready to be held against every map update.
//!
//! The cells are found once, when the path is made; a check is then one pass over an array, a
//! microsecond for a path of a thousand cells, whatever the size of the map.

use crate::line::supercover;
use crate::moves::price;
use crate::planner::{CornerRule, Unknown};
use nalgebra::Point2;
use zeronav_casts::Cast;
use zeronav_msgs::map::COST_UNKNOWN;
use zeronav_msgs::{Cell, GridGeometry, MapView};

/// How far ahead of the last position on the path the robot is looked for. [m]
const PROGRESS_WINDOW_M: f64 = 3.0;

/// What blocks a path.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Legality {
    /// Policy for unknown cells.
    pub unknown: Unknown,
    /// What the cells beside a corner mean that the path passes exactly.
    pub corner_rule: CornerRule,
    /// True when only obstacles count there, not the margin around them.
    pub past_margin: bool,
}

/// A piece of the path inside one cell.
#[derive(Debug, Clone, Copy)]
struct Piece {
    /// Row-major index of the cell.
    index: u32,
    /// Cells touched at the corner where the piece begins, as differences to `index` in columns
    /// and rows; 0, 0 = none.
    corner: [i8; 2],
    /// [m] from the start of the path to the end of the piece.
    leaves_m: f32,
    /// [m] length of the piece.
    length_m: f32,
}

/// See the module's description.
#[derive(Debug, Clone)]
pub struct Corridor {
    geometry: GridGeometry,
    legality: Legality,
    pieces: Vec<Piece>,
    /// Leading pieces in which the robot was too close to an obstacle when the path was made:
    /// there only lethal cells block.
    way_out: usize,
    /// Corners of the path in the `map` frame, each with its arc length. [m]
    corners: Vec<(Point2<f64>, f64)>,
    progress_m: f64,
}

impl Default for Corridor {
    fn default() -> Self {
        Self {
            geometry: GridGeometry::default(),
            legality: Legality {
                unknown: Unknown::default(),
                corner_rule: CornerRule::default(),
                past_margin: false,
            },
            pieces: Vec::new(),
            way_out: 0,
            corners: Vec::new(),
            progress_m: 0.0,
        }
    }
}

impl Corridor {
    /// Becomes the corridor of the path that is straight between the centres of `cells`. The
    /// robot is at its start. Cells outside the map are left out.
    pub fn set(&mut self, map: &MapView<'_>, legality: Legality, cells: &[Cell]) {
        self.geometry = *map.geometry;
        self.legality = legality;
        self.pieces.clear();
        self.corners.clear();
        self.progress_m = 0.0;
        let resolution_m = map.geometry.resolution_m;
        let mut arc_m = 0.0;
        if let Some(first) = cells.first() {
            self.corners.push((map.geometry.centre_of(*first), 0.0));
            if cells.len() == 1 {
                self.add(*first, None, 0.0, 0.0);
            }
        }
        for pair in cells.windows(2) {
            let (from, to) = (pair[0], pair[1]);
            let line_m = f64::from(to.x - from.x).hypot(f64::from(to.y - from.y)) * resolution_m;
            supercover(from, to, |crossing| {
                let corner = crossing.touched.map(|_| [from.x < to.x, from.y < to.y]);
                let length_m = (crossing.leaves - crossing.enters) * line_m;
                let leaves_m = arc_m + crossing.leaves * line_m;
                self.add(crossing.cell, corner, leaves_m.to_f32(), length_m.to_f32());
            });
            arc_m += line_m;
            let corner = (map.geometry.centre_of(to), arc_m);
            match self.corners[..] {
                [.., (a, _), (b, _)] if is_straight(a, b, corner.0) => {
                    self.corners.pop();
                }
                _ => {}
            }
            self.corners.push(corner);
        }
        self.way_out = self
            .pieces
            .iter()
            .take_while(|piece| {
                map.cells
                    .get(piece.index as usize)
                    .is_some_and(|cell| legality.unknown.blocks(*cell))
            })
            .count();
    }

    /// Forgets the path.
    pub fn clear(&mut self) {
        self.pieces.clear();
        self.corners.clear();
        self.way_out = 0;
        self.progress_m = 0.0;
    }

    fn add(&mut self, cell: Cell, ascends: Option<[bool; 2]>, leaves_m: f32, length_m: f32) {
        let Some(index) = self.geometry.index_of(cell) else {
            return;
        };
        // The cells beside the corner lie one step back along either axis.
        let corner = ascends.map_or([0, 0], |ascends| ascends.map(|up| if up { -1 } else { 1 }));
        match self.pieces.last_mut() {
            // Two lines meet in the middle of a cell.
            Some(last) if last.index == index.to_u32() && corner == [0, 0] => {
                last.leaves_m = leaves_m;
                last.length_m += length_m;
            }
            _ => self.pieces.push(Piece {
                index: index.to_u32(),
                corner,
                leaves_m,
                length_m,
            }),
        }
    }

    /// True when what is left of the path leads over cells that nobody has seen.
    pub(crate) fn is_guess(&self, map: &MapView<'_>) -> bool {
        let cells = self.pieces[self.ahead()..].iter();
        cells
            .filter_map(|piece| map.cells.get(piece.index as usize))
            .any(|cell| cell.cost == COST_UNKNOWN)
    }

    /// True when the path was made on a map of this geometry.
    #[must_use]
    pub fn is_on(&self, geometry: &GridGeometry) -> bool {
        *geometry == self.geometry
    }

    /// Length of the path. [m]
    #[must_use]
    pub fn length_m(&self) -> f64 {
        self.corners.last().map_or(0.0, |(_, arc_m)| *arc_m)
    }

    /// Arc length from the start to the robot's projection. [m]
    #[must_use]
    pub fn progress_m(&self) -> f64 {
        self.progress_m
    }

    /// Moves the projection to the point nearest to `robot` (`map` frame), never back, and gives
    /// the robot's distance from it [m]; infinite without a path.
    ///
    /// Only the next metres of the path are looked at, so that a robot beside a thin wall is not
    /// taken to be on the path's other side of it.
    pub fn advance(&mut self, robot: Point2<f64>) -> f64 {
        let from_m = self.progress_m;
        let mut nearest = match self.corners[..] {
            [(only, _)] => ((robot - only).norm(), 0.0),
            _ => (f64::INFINITY, from_m),
        };
        for pair in self.corners.windows(2) {
            let ((a, a_m), (b, b_m)) = (pair[0], pair[1]);
            if b_m < from_m || a_m > from_m + PROGRESS_WINDOW_M {
                continue;
            }
            let along = (b - a).normalize();
            let arc_m = (a_m + (robot - a).dot(&along))
                .clamp(a_m.max(from_m), b_m.min(from_m + PROGRESS_WINDOW_M));
            let distance_m = (robot - (a + along * (arc_m - a_m))).norm();
            if distance_m < nearest.0 {
                nearest = (distance_m, arc_m);
            }
        }
        self.progress_m = nearest.1;
        nearest.0
    }

    /// Arc length from the robot's projection to the first cell ahead that blocks the robot's
    /// centre [m], 0 when the robot is in it; `None` when the way is free.
    ///
    /// # Panics
    /// When `map` has another geometry than the map the path was made on.
    #[must_use]
    pub fn is_cut(&self, map: &MapView<'_>) -> Option<f64> {
        assert_eq!(*map.geometry, self.geometry, "path and map differ");
        let ahead = self.ahead();
        self.pieces[ahead..]
            .iter()
            .zip(ahead..)
            .find(|(piece, n)| self.is_blocked(map, piece, *n))
            .map(|(piece, _)| {
                (f64::from(piece.leaves_m - piece.length_m) - self.progress_m).max(0.0)
            })
    }

    /// The first cell ahead on the path that blocks the robot's centre on `map`, or a corner of the
    /// path at it; and the one before it on the path.
    pub(crate) fn first_blocked(&self, map: &MapView<'_>) -> Option<[Cell; 2]> {
        let ahead = self.ahead();
        let mut pieces = self.pieces[ahead..].iter().zip(ahead..);
        let (_, n) = pieces.find(|(piece, n)| self.is_blocked(map, piece, *n))?;
        let (width, _) = self.geometry.size();
        let cell = |n: usize| {
            let index = i32::try_from(self.pieces.get(n)?.index).ok()?;
            Some(Cell::new(index % width, index / width))
        };
        Some([cell(n)?, cell(n.saturating_sub(1))?])
    }

    /// Cost of what is left of the path, in metres of free cells: length in each cell times the
    /// cell's price. Paths of one map can be compared by it whatever planner made them.
    #[must_use]
    pub fn cost_ahead_m(&self, map: &MapView<'_>, cost_weight: f64) -> f64 {
        self.pieces[self.ahead()..]
            .iter()
            .map(|piece| {
                let cost = map.cells.get(piece.index as usize).map_or(0, |c| c.cost);
                let left_m = f64::from(piece.leaves_m) - self.progress_m;
                left_m.min(f64::from(piece.length_m)) * price(cost, cost_weight)
            })
            .sum()
    }

    /// Index of the piece that holds the projection.
    fn ahead(&self) -> usize {
        self.pieces
            .partition_point(|piece| f64::from(piece.leaves_m) < self.progress_m)
            .min(self.pieces.len().saturating_sub(1))
    }

    fn is_blocked(&self, map: &MapView<'_>, piece: &Piece, n: usize) -> bool {
        let unknown = self.legality.unknown;
        let blocks = |index: Option<usize>, only_lethal: bool| {
            index
                .and_then(|index| map.cells.get(index))
                .is_some_and(|cell| {
                    if only_lethal {
                        unknown.is_lethal(*cell)
                    } else {
                        unknown.blocks(*cell)
                    }
                })
        };
        let index = piece.index as usize;
        if blocks(Some(index), n < self.way_out) {
            return true;
        }
        let [dx, dy] = piece.corner.map(isize::from);
        let enters_m = f64::from(piece.leaves_m - piece.length_m);
        if dx == 0 || enters_m < self.progress_m {
            return false;
        }
        // The last step of the way out begins beside cells that are too close to an obstacle.
        let on_way_out = self.way_out > 0 && n <= self.way_out;
        let only_lethal = on_way_out || self.legality.past_margin;
        let beside = |offset| blocks(index.checked_add_signed(offset), only_lethal);
        let row = self.geometry.width.cast_signed() as isize;
        !self
            .legality
            .corner_rule
            .permits(beside(dx), beside(dy * row))
    }
}

/// True when `b` lies on the way straight on from `a` to `c`.
fn is_straight(a: Point2<f64>, b: Point2<f64>, c: Point2<f64>) -> bool {
    let (ab, bc) = (b - a, c - b);
    ab.perp(&bc).abs() <= 1.0e-9 * ab.norm() * bc.norm() && ab.dot(&bc) > 0.0
}
