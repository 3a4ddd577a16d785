//! Dynamic obstacles on a reader's copy of the map, for readers that do not predict them.
//!
//! The map holds what is static. A planner that takes tracked obstacles for static discs writes them
//! onto its replica with [`MapReplica::stamp`](crate::replica::MapReplica::stamp), by the cost model
//! that came with the map.

use crate::grid::{Cell, CellRect, GridGeometry};
use crate::map::{COST_INSCRIBED, COST_UNKNOWN, MapCell, MapInfo, clearance_mm};
use crate::obstacles::Obstacle;
use nalgebra::{Point2, Vector2};

/// What was written over the map, and what was there.
#[derive(Debug, Default)]
pub(crate) struct Stamp {
    /// Index and value of the cells before, in the order in which they were written.
    before: Vec<(usize, MapCell)>,
    /// Where cells were written.
    windows: Vec<CellRect>,
}

impl Stamp {
    /// Puts back the cells as they were. Adds the rectangles that were written to `changed`.
    pub(crate) fn lift(&mut self, cells: &mut [MapCell], changed: &mut Vec<CellRect>) {
        for (index, cell) in self.before.drain(..).rev() {
            cells[index] = cell;
        }
        changed.append(&mut self.windows);
    }

    /// Forgets what was written: the cells have been replaced.
    pub(crate) fn clear(&mut self) {
        self.before.clear();
        self.windows.clear();
    }

    /// Writes `obstacles` over the cells. Adds the rectangles that were written to `changed`.
    pub(crate) fn put(
        &mut self,
        obstacles: &[Obstacle],
        info: &MapInfo,
        cells: &mut [MapCell],
        changed: &mut Vec<CellRect>,
    ) {
        for obstacle in obstacles {
            let window = self.put_disc(obstacle, info, cells);
            self.windows.push(window);
        }
        changed.extend_from_slice(&self.windows);
    }

    /// Lowers clearance and raises cost around one disc; returns the rectangle that it reaches.
    fn put_disc(&mut self, obstacle: &Obstacle, info: &MapInfo, cells: &mut [MapCell]) -> CellRect {
        let geometry = &info.geometry;
        let limit_mm = u16::try_from(info.clearance_limit_mm).unwrap_or(u16::MAX);
        let centre = Point2::new(obstacle.x_m, obstacle.y_m);
        let own_cell = geometry.unbounded_cell_at(centre);
        let reach_m = obstacle.radius_m + f64::from(limit_mm) / 1000.0;
        let window = square_around(geometry, centre, reach_m);
        for y in window.min.y..window.max.y {
            for x in window.min.x..window.max.x {
                let cell = Cell::new(x, y);
                let Some(index) = geometry.index_of(cell) else {
                    continue;
                };
                let distance_m = (geometry.centre_of(cell) - centre).norm();
                // A disc smaller than a cell is an obstacle, too.
                let clearance_m = if cell == own_cell {
                    0.0
                } else {
                    (distance_m - obstacle.radius_m).max(0.0)
                };
                let old = cells[index];
                let clearance_mm = clearance_mm(clearance_m, limit_mm);
                if clearance_mm >= old.clearance_mm {
                    continue;
                }
                let cost = match (info.cost_model.cost(clearance_m), old.cost) {
                    (cost, COST_UNKNOWN) if cost < COST_INSCRIBED => COST_UNKNOWN,
                    (cost, COST_UNKNOWN) => cost,
                    (cost, old) => cost.max(old),
                };
                self.before.push((index, old));
                cells[index] = MapCell {
                    cost,
                    clearance_mm,
                    ..old
                };
            }
        }
        window
    }
}

/// Cells of the grid within the square of half side `reach_m` around a point of the map.
fn square_around(geometry: &GridGeometry, centre: Point2<f64>, reach_m: f64) -> CellRect {
    let reach = Vector2::repeat(reach_m);
    let (width, height) = geometry.size();
    let low = geometry.unbounded_cell_at(centre - reach);
    let high = geometry.unbounded_cell_at(centre + reach);
    CellRect {
        min: Cell::new(low.x.clamp(0, width), low.y.clamp(0, height)),
        max: Cell::new(
            high.x.saturating_add(1).clamp(0, width),
            high.y.saturating_add(1).clamp(0, height),
        ),
    }
}
