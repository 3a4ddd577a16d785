//! The zones on a grid: which cells the robot must keep out of, and what others cost at least.

use crate::zone_set::ZoneSet;
use crate::zone_shape::Part;
use crate::zones::ZoneKind;
use crate::{CellRect, GridGeometry};
use nalgebra::Point2;
use zeronav_casts::Cast;

/// Mark of a cell that a keepout zone reaches into; other marks are the least cost of a cell, 0 = no zone asks for one.
pub const MARK_KEEPOUT: u8 = u8::MAX;

/// How far an edge must reach into a cell: one that lies on the line between two is in neither. [cells]
const INTO_CELLS: f64 = 1.0e-6;

impl ZoneSet {
    /// Marks of the cells of a rectangle, row by row from `rect.min`: [`MARK_KEEPOUT`] of a cell that a keepout zone
    /// reaches into, otherwise the least cost that zones of cost and lanes ask for at its centre. Each zone costs the
    /// cells of its own rows and columns alone, lanes one pass over all.
    #[must_use]
    pub fn marks(&self, geometry: &GridGeometry, rect: &CellRect) -> Vec<u8> {
        let beside = self.largest(ZoneKind::Lane).map_or(0, cost);
        let mut marks = Marks::new(geometry, rect, beside);
        for lane in self.of_kind(ZoneKind::Lane) {
            marks.fill(lane, |mark| *mark = 0);
        }
        for part in self.of_kind(ZoneKind::Cost) {
            let least = cost(part.message.value);
            marks.fill(part, |mark| *mark = (*mark).max(least));
        }
        for part in self.of_kind(ZoneKind::Keepout) {
            marks.fill(part, |mark| *mark = MARK_KEEPOUT);
            marks.close_edges(part);
        }
        marks.values
    }
}

#[allow(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "1 to 252, as the check of the message has made sure"
)]
const fn cost(value: f64) -> u8 {
    value as u8
}

/// The whole part of a coordinate. [cells]
fn whole(cells: f64) -> i32 {
    cells.to_i32()
}

struct Marks<'a> {
    geometry: &'a GridGeometry,
    rect: &'a CellRect,
    values: Vec<u8>,
}

impl<'a> Marks<'a> {
    fn new(geometry: &'a GridGeometry, rect: &'a CellRect, mark: u8) -> Self {
        let along = |from: i32, to: i32| usize::try_from(to.saturating_sub(from)).unwrap_or(0);
        let n = along(rect.min.x, rect.max.x) * along(rect.min.y, rect.max.y);
        Self {
            geometry,
            rect,
            values: vec![mark; n],
        }
    }

    /// A point of the map frame on the grid. [cells]
    fn cells(&self, at: Point2<f64>) -> Point2<f64> {
        let origin = Point2::new(self.geometry.origin_x_m, self.geometry.origin_y_m);
        Point2::from((at - origin) / self.geometry.resolution_m)
    }

    /// The marks of `first <= x < end` in a row, as far as they are in the rectangle.
    fn row(&mut self, y: i32, first: i32, end: i32) -> &mut [u8] {
        let CellRect { min, max } = self.rect;
        let (first, end) = (first.max(min.x), end.min(max.x));
        let index = |x: i32| {
            let [x, y, width] = [x - min.x, y - min.y, max.x - min.x].map(i64::from);
            usize::try_from(y * width + x).unwrap_or(usize::MAX)
        };
        if first >= end || y < min.y || y >= max.y {
            return &mut [];
        }
        self.values
            .get_mut(index(first)..index(end))
            .unwrap_or_default()
    }

    /// Rows of the rectangle from one coordinate to another. [cells]
    fn rows(&self, from: f64, to: f64) -> core::ops::Range<i32> {
        whole(from).max(self.rect.min.y)..whole(to).min(self.rect.max.y)
    }

    /// Changes the marks of the cells whose centre lies in a part.
    fn fill(&mut self, part: &Part, change: impl Fn(&mut u8)) {
        let edges = self.edges(part);
        let (low, high) = (self.cells(part.min).y, self.cells(part.max).y);
        let mut crossings = Vec::new();
        for y in self.rows(low.floor(), high.ceil()) {
            let middle = f64::from(y) + 0.5;
            crossings.clear();
            let crossing = edges
                .iter()
                .filter(|[from, to]| (from.y > middle) != (to.y > middle));
            crossings.extend(
                crossing.map(|[from, to]| {
                    from.x + (middle - from.y) / (to.y - from.y) * (to.x - from.x)
                }),
            );
            crossings.sort_by(f64::total_cmp);
            for pair in crossings.chunks_exact(2) {
                let [first, end] = [pair[0], pair[1]].map(|x| whole((x - 0.5).ceil()));
                self.row(y, first, end).iter_mut().for_each(&change);
            }
        }
    }

    /// Closes the cells that the edges of a part lie in.
    fn close_edges(&mut self, part: &Part) {
        for [from, to] in self.edges(part) {
            let (low, high) = (from.inf(&to), from.sup(&to));
            let along = to - from;
            let rows = (low.y + INTO_CELLS).floor()..(high.y - INTO_CELLS).ceil();
            for y in self.rows(rows.start, rows.end) {
                // What of the edge lies in the row.
                let within = [f64::from(y), f64::from(y) + 1.0].map(|at| {
                    let share = (at - from.y) / along.y;
                    let x = from.x + along.x * share.clamp(0.0, 1.0);
                    if x.is_nan() { [low.x, high.x] } else { [x, x] }
                });
                let [[a, b], [c, d]] = within;
                let first = (a.min(c) + INTO_CELLS).floor();
                let end = (b.max(d) - INTO_CELLS).ceil();
                self.row(y, whole(first), whole(end)).fill(MARK_KEEPOUT);
            }
        }
    }

    /// The edges of a part. [cells]
    fn edges(&self, part: &Part) -> Vec<[Point2<f64>; 2]> {
        part.edges()
            .map(|(from, to)| [self.cells(from), self.cells(to)])
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Cell;
    use crate::zone_set::tests::{rect, set};
    use crate::zones::ZonePart;

    fn grid() -> (GridGeometry, CellRect) {
        let geometry = GridGeometry {
            origin_x_m: -1.0,
            origin_y_m: -0.5,
            resolution_m: 0.1,
            width: 70,
            height: 60,
        };
        let rect = CellRect {
            min: Cell::new(0, 0),
            max: Cell::new(70, 60),
        };
        (geometry, rect)
    }

    #[test]
    fn a_zone_without_right_angles_closes_the_cells_that_it_reaches_into() {
        let (geometry, rect) = grid();
        let wedge = [[0.03, 0.04], [4.03, 1.07], [3.02, 4.03], [1.9, 1.2]];
        let clockwise = [[-2.0, 0.53], [-2.0, 1.52], [2.52, 1.52], [2.52, 0.53]];
        let zones = set(&[
            ZonePart::new("wedge", ZoneKind::Keepout, 0.0, &wedge),
            ZonePart::new("bar", ZoneKind::Keepout, 0.0, &clockwise),
        ]);
        let marks = zones.marks(&geometry, &rect);
        let half_m = 0.5 * geometry.resolution_m;
        for (index, mark) in marks.iter().enumerate() {
            let n = i32::try_from(index).unwrap();
            let centre = geometry.centre_of(Cell::new(n % 70, n / 70));
            let grid = (-10..=10).flat_map(|x| (-10..=10).map(move |y| (x, y)));
            let touches = grid.into_iter().any(|(x, y)| {
                let aside = |n: i32| 0.0999 * f64::from(n) * half_m;
                let at = Point2::new(centre.x + aside(x), centre.y + aside(y));
                zones.keepout_at(at).is_some()
            });
            let margin_m = zones.keepout_margin_m(centre);
            if touches {
                assert_eq!(*mark, MARK_KEEPOUT, "{centre}");
            } else if margin_m > 1.5 * half_m {
                assert_eq!(*mark, 0, "{centre}");
            }
        }
        // A part of the grid has the same marks.
        let part = CellRect {
            min: Cell::new(8, 3),
            max: Cell::new(41, 50),
        };
        let of_part = zones.marks(&geometry, &part);
        let rows = (3..50).flat_map(|y| marks[y * 70 + 8..y * 70 + 41].iter().copied());
        assert!(rows.eq(of_part));
        let none = CellRect {
            min: part.max,
            max: part.min,
        };
        assert!(zones.marks(&geometry, &none).is_empty());
    }

    #[test]
    fn what_lies_on_the_lines_of_the_grid_closes_no_cell_beside_it() {
        let (geometry, whole) = grid();
        let square = rect("square", ZoneKind::Keepout, 0.0, [0.0, 0.0, 0.2, 0.2]);
        let marks = set(&[square]).marks(&geometry, &whole);
        let closed: Vec<_> = (0..70 * 60_usize)
            .filter(|n| marks[*n] != 0)
            .map(|n| (n % 70, n / 70))
            .collect();
        let expected: Vec<_> = (5..7).flat_map(|y| (10..12).map(move |x| (x, y))).collect();
        assert_eq!(closed, expected);
    }

    #[test]
    fn lanes_raise_the_cost_beside_them_and_costs_that_inside() {
        let (geometry, whole) = grid();
        let zones = set(&[
            rect("lane", ZoneKind::Lane, 80.0, [0.0, 0.0, 5.5, 1.0]),
            rect("wet", ZoneKind::Cost, 200.0, [4.0, 0.0, 5.0, 3.0]),
        ]);
        let marks = zones.marks(&geometry, &whole);
        let at = |x_m: f64, y_m: f64| {
            let cell = geometry.cell_at(Point2::new(x_m, y_m)).unwrap();
            marks[geometry.index_of(cell).unwrap()]
        };
        assert_eq!(
            [at(1.0, 0.5), at(1.0, 2.0), at(4.5, 0.5), at(4.5, 2.0)],
            [0, 80, 200, 200]
        );
    }
}
