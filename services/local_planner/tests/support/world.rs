//! A small exact world: boxes, and the map made from them.

use nalgebra::{Point2, Vector2};
use zeronav_casts::Cast;
use zeronav_msgs::map::{COST_INSCRIBED, COST_LETHAL};
use zeronav_msgs::{Cell, GridGeometry, MapCell, MapView};

/// An axis-aligned obstacle in the map frame. [m]
#[derive(Debug, Clone, Copy)]
pub(crate) struct Block {
    pub(crate) low: Point2<f64>,
    pub(crate) high: Point2<f64>,
}

/// A block from its corners.
pub(crate) fn block(x0: f64, y0: f64, x1: f64, y1: f64) -> Block {
    Block {
        low: Point2::new(x0, y0),
        high: Point2::new(x1, y1),
    }
}

impl Block {
    /// Distance of a point, 0 inside. [m]
    pub(crate) fn distance_m(&self, at: Point2<f64>) -> f64 {
        let nearest = at.sup(&self.low).inf(&self.high);
        (at - nearest).norm()
    }

    /// Range of a ray by the slab method. [m]
    pub(crate) fn range_m(&self, from: Point2<f64>, direction: Vector2<f64>) -> Option<f64> {
        let (mut enter, mut leave) = (0.0_f64, f64::INFINITY);
        for axis in 0..2 {
            if direction[axis].abs() < 1e-12 {
                if from[axis] < self.low[axis] || from[axis] > self.high[axis] {
                    return None;
                }
                continue;
            }
            let a = (self.low[axis] - from[axis]) / direction[axis];
            let b = (self.high[axis] - from[axis]) / direction[axis];
            enter = enter.max(a.min(b));
            leave = leave.min(a.max(b));
        }
        (enter <= leave).then_some(enter)
    }
}

/// The map of some blocks: a cell is lethal when a block overlaps it.
pub(crate) struct Map {
    pub(crate) geometry: GridGeometry,
    pub(crate) cells: Vec<MapCell>,
}

impl Map {
    pub(crate) fn view(&self) -> MapView<'_> {
        MapView {
            geometry: &self.geometry,
            cells: &self.cells,
        }
    }

    /// Rasterises blocks into `width_m x height_m` from the origin, clearance by brute force.
    pub(crate) fn of(blocks: &[Block], width_m: f64, height_m: f64, inscribed_m: f64) -> Self {
        let resolution_m = 0.05;
        let geometry = GridGeometry {
            origin_x_m: 0.0,
            origin_y_m: 0.0,
            resolution_m,
            width: (width_m / resolution_m).round().to_u32(),
            height: (height_m / resolution_m).round().to_u32(),
        };
        let (width, height) = geometry.size();
        let all = (0..height).flat_map(|y| (0..width).map(move |x| Cell::new(x, y)));
        let overlaps = |cell: Cell| {
            let centre = geometry.centre_of(cell);
            let half = Vector2::repeat(0.5 * resolution_m - 1e-9);
            let (low, high) = (centre - half, centre + half);
            blocks.iter().any(|b| {
                low.x < b.high.x && high.x > b.low.x && low.y < b.high.y && high.y > b.low.y
            })
        };
        let lethal: Vec<Cell> = all.clone().filter(|cell| overlaps(*cell)).collect();
        let grid: Vec<bool> = all.clone().map(overlaps).collect();
        // Only cells at the border of an obstacle can be nearest to a free cell.
        let at = |cell: Cell| geometry.index_of(cell).is_none_or(|index| grid[index]);
        let border: Vec<Cell> = lethal
            .into_iter()
            .filter(|c| {
                [(1, 0), (-1, 0), (0, 1), (0, -1)]
                    .iter()
                    .any(|(dx, dy)| !at(Cell::new(c.x + dx, c.y + dy)))
            })
            .collect();
        let clearance = |cell: Cell| {
            if at(cell) {
                return 0.0;
            }
            let squared = border.iter().fold(f64::INFINITY, |least, other| {
                let dx = (f64::from((cell.x - other.x).abs()) - 0.5) * resolution_m;
                let dy = (f64::from((cell.y - other.y).abs()) - 0.5) * resolution_m;
                least.min(dx.max(0.0).powi(2) + dy.max(0.0).powi(2))
            });
            squared.sqrt().min(1.5)
        };
        let cells = all
            .map(|cell| {
                let clearance_m = clearance(cell);
                MapCell {
                    cost: match clearance_m {
                        m if m <= 0.0 => COST_LETHAL,
                        m if m <= inscribed_m => COST_INSCRIBED,
                        _ => 0,
                    },
                    flags: 0,
                    clearance_mm: (clearance_m * 1000.0).floor().to_u16(),
                }
            })
            .collect();
        Self { geometry, cells }
    }
}
