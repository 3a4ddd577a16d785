//! The map around the robot without what moves.
//!
//! The shared map holds what moves as obstacles that last for a moment, so that planners keep away
//! from where somebody just was. Who predicts where somebody will be must not: the way behind him is
//! free. This is a window of the map whose clearances come from the obstacles that stand alone.

#![allow(
    clippy::cast_possible_truncation,
    clippy::cast_possible_wrap,
    clippy::cast_sign_loss,
    reason = "indices of a window of a few hundred cells, clamped before use"
)]

use nalgebra::Point2;
use zeronav_msgs::map::{COST_LETHAL, FLAG_MOVING};
use zeronav_msgs::{GridGeometry, MapCell, MapView};

/// Cells up to which clearances are told apart here; where the map says more, it is right.
const REACH: i16 = 16;

/// [m] by which the window is larger than asked for, on every side.
const SPARE_M: f64 = 1.0;

/// What a window was made from.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Source {
    geometry: GridGeometry,
    cells: u64,
    half: i32,
}

/// The window.
#[derive(Debug, Clone, Default)]
pub(crate) struct StaticMap {
    source: Option<Source>,
    /// Column and row of the map that are the window's first, if the map reaches that far.
    min: (i32, i32),
    geometry: GridGeometry,
    cells: Vec<MapCell>,
    /// Grows when the window is made anew.
    revision: u64,
    /// Cells to the nearest obstacle in the same column, at most [`REACH`] and one.
    along_column: Vec<i16>,
    /// Squared distances of the row at hand. [half cells^2]
    squares: Vec<i16>,
}

/// Square of the distance from a cell's centre to the square of one that is so many cells away
/// along one axis; everything beyond [`REACH`] is that far. [half cells^2]
const fn square(cells: i16) -> i16 {
    let cells = if cells > REACH { REACH + 1 } else { cells };
    let half_cells = if cells == 0 { 0 } else { 2 * cells - 1 };
    half_cells * half_cells
}

impl StaticMap {
    /// The window around `position` that reaches at least `half_m` to every side, where the map
    /// does, and the number of its state. `map_cells` grows when cells of the map change.
    pub(crate) fn view(
        &mut self,
        map: MapView<'_>,
        map_cells: u64,
        position: Point2<f64>,
        half_m: f64,
    ) -> (MapView<'_>, u64) {
        let resolution_m = map.geometry.resolution_m;
        let inner = (half_m / resolution_m).ceil() as i32 + i32::from(REACH);
        let half = inner + (SPARE_M / resolution_m).ceil() as i32;
        let source = Source {
            geometry: *map.geometry,
            cells: map_cells,
            half,
        };
        let at = map.geometry.unbounded_cell_at(position);
        let within = |min: i32, at: i32| {
            let off = min.saturating_add(half).abs_diff(at);
            off <= (half - inner).unsigned_abs()
        };
        let inside = within(self.min.0, at.x) && within(self.min.1, at.y);
        if self.source != Some(source) || !inside {
            if self.source.is_none() || !inside {
                self.min = (at.x.saturating_sub(half), at.y.saturating_sub(half));
            }
            self.source = Some(source);
            self.revision += 1;
            self.take(map, 2 * half + 1);
            self.measure();
        }
        let view = MapView {
            geometry: &self.geometry,
            cells: &self.cells,
        };
        (view, self.revision)
    }

    /// Copies the window's cells.
    fn take(&mut self, map: MapView<'_>, side: i32) {
        let (width, height) = map.geometry.size();
        let span =
            |min: i32, size: i32| min.clamp(0, size)..min.saturating_add(side).clamp(0, size);
        let (columns, rows) = (span(self.min.0, width), span(self.min.1, height));
        self.geometry = GridGeometry {
            origin_x_m: map.geometry.origin_x_m
                + f64::from(columns.start) * map.geometry.resolution_m,
            origin_y_m: map.geometry.origin_y_m + f64::from(rows.start) * map.geometry.resolution_m,
            width: columns.len() as u32,
            height: rows.len() as u32,
            ..*map.geometry
        };
        self.cells.clear();
        for row in rows {
            let row = row as usize * width as usize;
            let cells = row + columns.start as usize..row + columns.end as usize;
            self.cells
                .extend_from_slice(map.cells.get(cells).unwrap_or(&[]));
        }
        self.cells.resize(self.geometry.len(), MapCell::unknown(0));
    }

    /// Clearances from the obstacles that stand: down and up the columns, then along the rows. Never
    /// less than those of the map, which come from more obstacles.
    fn measure(&mut self) {
        let width = self.geometry.width as usize;
        let n = self.cells.len();
        let stands = |cell: &MapCell| cell.cost == COST_LETHAL && cell.flags & FLAG_MOVING == 0;
        self.along_column.clear();
        for (i, cell) in self.cells.iter().enumerate() {
            let before = i.checked_sub(width).map_or(REACH, |i| self.along_column[i]);
            let cells = if stands(cell) {
                0
            } else {
                before.min(REACH) + 1
            };
            self.along_column.push(cells);
        }
        for i in (0..n.saturating_sub(width)).rev() {
            let after = self.along_column[i + width];
            self.along_column[i] = self.along_column[i].min(after + 1);
        }
        if width == 0 {
            return;
        }
        let mm_per_half_cell = 500.0 * self.geometry.resolution_m;
        let rows = self.along_column.chunks_exact(width);
        for (columns, cells) in rows.zip(self.cells.chunks_exact_mut(width)) {
            self.squares.clear();
            self.squares.resize(width, square(REACH + 1));
            for shift in 0..=(REACH as usize).min(width - 1) {
                let along = square(shift as i16);
                for x in 0..width - shift {
                    let (left, right) = (square(columns[x]), square(columns[x + shift]));
                    self.squares[x] = self.squares[x].min(right + along);
                    self.squares[x + shift] = self.squares[x + shift].min(left + along);
                }
            }
            for (cell, square) in cells.iter_mut().zip(&self.squares) {
                let mm = (mm_per_half_cell * f64::from(*square).sqrt()) as u16;
                cell.clearance_mm = cell.clearance_mm.max(mm);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::print_stdout, reason = "the seed of a failed run")]

    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg32;
    use zeronav_msgs::Cell;
    use zeronav_msgs::map::FLAG_SENSED;

    const GEOMETRY: GridGeometry = GridGeometry {
        origin_x_m: -1.0,
        origin_y_m: 2.0,
        resolution_m: 0.05,
        width: 90,
        height: 70,
    };

    /// Exact clearance of a cell from those that `counts` says. [mm]
    fn exact_mm(obstacles: &[(Cell, bool)], at: Cell, counts: impl Fn(bool) -> bool) -> f64 {
        let counted = obstacles.iter().filter(|(_, moves)| counts(*moves));
        let axis = |cells: i32| (2 * cells.abs() - 1).max(0);
        let least = counted
            .map(|(cell, _)| axis(cell.x - at.x).pow(2) + axis(cell.y - at.y).pow(2))
            .min();
        least.map_or(1500.0, |least| (25.0 * f64::from(least).sqrt()).min(1500.0))
    }

    fn random_map(seed: u64) -> (Vec<MapCell>, Vec<(Cell, bool)>) {
        let mut dice = Pcg32::seed_from_u64(seed);
        let obstacles: Vec<(Cell, bool)> = (0..dice.random_range(0..30))
            .map(|_| {
                let at = Cell::new(dice.random_range(0..90), dice.random_range(0..70));
                (at, dice.random_bool(0.5))
            })
            .collect();
        let cells = (0..70).flat_map(|y| (0..90).map(move |x| Cell::new(x, y)));
        let cells = cells.map(|at| {
            let moves = obstacles.iter().find(|(cell, _)| *cell == at);
            let stands = obstacles.iter().any(|(cell, moves)| *cell == at && !moves);
            MapCell {
                cost: if moves.is_some() { COST_LETHAL } else { 0 },
                flags: match moves {
                    None => 0,
                    Some(_) if stands => FLAG_SENSED,
                    Some(_) => FLAG_SENSED | FLAG_MOVING,
                },
                clearance_mm: exact_mm(&obstacles, at, |_| true) as u16,
            }
        });
        (cells.collect(), obstacles)
    }

    #[test]
    fn clearances_are_those_from_what_stands() {
        for seed in 0..40 {
            println!("seed {seed}");
            let (cells, obstacles) = random_map(seed);
            let map = MapView {
                geometry: &GEOMETRY,
                cells: &cells,
            };
            let mut standing = StaticMap::default();
            let (view, _) = standing.view(map, seed, Point2::new(1.0, 3.5), 6.0);
            assert_eq!(view.geometry, &GEOMETRY);
            for (index, cell) in view.cells.iter().enumerate() {
                let at = Cell::new((index % 90) as i32, (index / 90) as i32);
                let exact = exact_mm(&obstacles, at, |moves| !moves);
                let mm = f64::from(cell.clearance_mm);
                // Beyond the reach at least as far as that.
                let told_apart = 25.0 * 31.0;
                assert!(mm <= exact + 1e-9, "{at:?}: {mm} of {exact}");
                assert!(mm + 1.0 > exact.min(told_apart), "{at:?}: {mm} of {exact}");
            }
        }
    }

    #[test]
    fn the_window_stays_while_nothing_changes_and_the_robot_is_inside() {
        let big = GridGeometry {
            width: 600,
            height: 600,
            ..GEOMETRY
        };
        let cells = vec![MapCell::default(); big.len()];
        let map = MapView {
            geometry: &big,
            cells: &cells,
        };
        let mut standing = StaticMap::default();
        let mut at = |map_cells, x| {
            let (view, revision) = standing.view(map, map_cells, Point2::new(x, 15.0), 4.0);
            let left_m = x - view.geometry.origin_x_m;
            let right_m = f64::from(view.geometry.width) * 0.05 - left_m;
            assert!(left_m >= 4.0 && right_m >= 4.0, "{left_m} {right_m}");
            revision
        };
        assert_eq!(
            [at(1, 12.0), at(1, 12.4), at(2, 12.4), at(2, 14.0)],
            [1, 1, 2, 3]
        );
    }
}
