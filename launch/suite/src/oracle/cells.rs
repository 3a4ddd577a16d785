//! The places where the robot can be, as cells of a grid.

use super::reach::Reach;
use super::robot::{Disc, State};
use zeronav_casts::Cast;

/// Side of a cell. [m]
const CELL_M: f64 = 0.06;

/// Most cells along a side of the window, for robots that are faster than any here.
const SIDE_MAX: usize = 1024;

/// The cells that hold a place where the robot may be.
#[derive(Debug)]
pub(super) struct FreeSet {
    corner_m: [f64; 2],
    side: usize,
    cells: Vec<bool>,
    /// Columns and rows that may hold any: first and last.
    columns: [usize; 2],
    rows: [usize; 2],
}

impl FreeSet {
    pub(super) fn new(state: &State, reach_m: f64) -> Self {
        let half = ((reach_m / CELL_M).ceil().to_usize() + 2).min(SIDE_MAX / 2);
        let side = 2 * half + 1;
        let mut cells = vec![false; side * side];
        cells[half * side + half] = true;
        // The robot is in the middle of the middle cell.
        let to_corner_m = (half.to_f64() + 0.5) * CELL_M;
        Self {
            corner_m: [state.at_m[0] - to_corner_m, state.at_m[1] - to_corner_m],
            side,
            cells,
            columns: [half; 2],
            rows: [half; 2],
        }
    }

    /// Adds every cell with a point that is within `by_m` of a point of one that is in it.
    pub(super) fn grow(&mut self, by_m: f64) {
        let by = by_m / CELL_M;
        let whole = by.ceil().to_usize() + 1;
        // How far to either side a row that is `dy` away reaches.
        let reach: Vec<usize> = (0..=whole)
            .map(|dy| {
                let between = dy.saturating_sub(1).to_f64();
                if between > by {
                    0
                } else {
                    (by * by - between * between).sqrt().floor().to_usize() + 1
                }
            })
            .collect();
        let old = self.cells.clone();
        let (last, columns, rows) = (self.side - 1, self.columns, self.rows);
        for y in rows[0]..=rows[1] {
            for x in columns[0]..=columns[1] {
                if !old[y * self.side + x] {
                    continue;
                }
                // A cell among cells adds nothing that they do not add.
                let inner = x > 0
                    && x < last
                    && y > 0
                    && y < last
                    && old[y * self.side + x - 1]
                    && old[y * self.side + x + 1]
                    && old[(y - 1) * self.side + x]
                    && old[(y + 1) * self.side + x];
                if inner {
                    continue;
                }
                for to in y.saturating_sub(whole)..=(y + whole).min(last) {
                    let far = reach[to.abs_diff(y)];
                    if far == 0 {
                        continue;
                    }
                    let from = to * self.side;
                    let (left, right) = (x.saturating_sub(far), (x + far).min(last));
                    self.cells[from + left..=from + right].fill(true);
                }
            }
        }
        let wider =
            |range: [usize; 2]| [range[0].saturating_sub(whole), (range[1] + whole).min(last)];
        (self.columns, self.rows) = (wider(columns), wider(rows));
    }

    /// Leaves the cells with a point in the box where a disc of `radius_m` touches nothing.
    pub(super) fn retain(
        &mut self,
        within: &Reach,
        radius_m: f64,
        discs: &[Disc],
        fixed_m: &dyn Fn([f64; 2]) -> f64,
    ) {
        let slack_m = CELL_M * core::f64::consts::FRAC_1_SQRT_2;
        let mut columns = [usize::MAX, 0];
        let mut rows = [usize::MAX, 0];
        for y in self.rows[0]..=self.rows[1] {
            for x in self.columns[0]..=self.columns[1] {
                let cell = &mut self.cells[y * self.side + x];
                if !*cell {
                    continue;
                }
                let at_m = [
                    self.corner_m[0] + (x.to_f64() + 0.5) * CELL_M,
                    self.corner_m[1] + (y.to_f64() + 0.5) * CELL_M,
                ];
                // Only a cell in which every place touches something is lost.
                let is_free = |(centre, radius): &Disc| {
                    let apart_m = (centre[0] - at_m[0]).hypot(centre[1] - at_m[1]);
                    apart_m > radius + radius_m - slack_m
                };
                *cell = within.holds(at_m, slack_m)
                    && discs.iter().all(is_free)
                    && fixed_m(at_m) > radius_m - slack_m;
                if *cell {
                    columns = [columns[0].min(x), columns[1].max(x)];
                    rows = [rows[0].min(y), rows[1].max(y)];
                }
            }
        }
        if columns[0] == usize::MAX {
            // Empty: ranges with nothing in them.
            (columns, rows) = ([1, 0], [1, 0]);
        }
        (self.columns, self.rows) = (columns, rows);
    }

    pub(super) fn is_empty(&self) -> bool {
        self.rows[0] > self.rows[1]
    }
}
