//! Obstacle cells of the map near the robot as the squares that they are, for exact distances.
//!
//! A cell may be larger than what is in it by most of its side. Where the current scan measures the
//! surface, or one before it did that the lidar has turned away from since, its hits tell where that is: a
//! cell that a beam ends in or within [`ALONG_M`] of is left to them.

use crate::lanes::data::Sheet;
use crate::past_hits::{ALONG_M, Hit};
use nalgebra::{Point2, Vector2};
use zeronav_casts::Cast;

/// Places on a beam at which its cells are marked.
const PLACES: i32 = 2;

/// Obstacle cells and what it takes to find them.
#[derive(Debug, Clone, Default)]
pub(crate) struct Squares {
    /// Centres, relative to the robot along the axes of the map. [m]
    pub(crate) centres: Vec<Point2<f64>>,
    /// Half of a side. [m]
    pub(crate) half_m: f64,
    /// Cells that the scan measures, of the window that was looked at.
    measured: Vec<bool>,
}

impl Squares {
    /// Looks at the cells within `reach_m` of the robot along either axis. Hits are
    /// relative to the robot along the axes of the map. Cells inside an obstacle are left out.
    pub(crate) fn fill(
        &mut self,
        sheet: &Sheet<'_>,
        reach_m: f64,
        hits: impl Iterator<Item = Hit>,
    ) {
        self.centres.clear();
        let resolution_m = f64::from(sheet.resolution_m);
        self.half_m = 0.5 * resolution_m;
        let (centre_x, centre_y) = (f64::from(sheet.centre.0), f64::from(sheet.centre.1));
        let last = f64::from(sheet.side - 1);
        let clamped = |at: f64| at.clamp(0.0, last).to_usize();
        let reach = reach_m / resolution_m;
        let (from_x, to_x) = (clamped(centre_x - reach), clamped(centre_x + reach));
        let (from_y, to_y) = (clamped(centre_y - reach), clamped(centre_y + reach));
        let (width, side) = (to_x - from_x + 1, sheet.side.to_usize());
        self.measured.clear();
        self.measured.resize(width * (to_y - from_y + 1), false);
        for Hit { at: point, along } in hits {
            for place in -PLACES..=PLACES {
                let at: Point2<f64> =
                    point + along * (ALONG_M * f64::from(place) / f64::from(PLACES));
                let x = (at.x / resolution_m + centre_x).round();
                let y = (at.y / resolution_m + centre_y).round();
                let inside = x >= from_x.to_f64() && x <= to_x.to_f64();
                if inside && y >= from_y.to_f64() && y <= to_y.to_f64() {
                    self.measured[(y.to_usize() - from_y) * width + x.to_usize() - from_x] = true;
                }
            }
        }
        let is_obstacle = |x: usize, y: usize| sheet.cells[y * side + x] <= 0.0;
        for y in from_y..=to_y {
            for x in from_x..=to_x {
                let is_measured =
                    |x: usize, y: usize| self.measured[(y - from_y) * width + x - from_x];
                if !is_obstacle(x, y) || is_measured(x, y) {
                    continue;
                }
                let inner = x > from_x && x < to_x && y > from_y && y < to_y;
                let hidden = inner
                    && [(x - 1, y), (x + 1, y), (x, y - 1), (x, y + 1)]
                        .iter()
                        .all(|&(x, y)| is_obstacle(x, y) && !is_measured(x, y));
                if !hidden {
                    let at = Vector2::new(x.to_f64() - centre_x, y.to_f64() - centre_y);
                    self.centres.push(Point2::from(at * resolution_m));
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Cells of 0.1 m around a robot at the centre of cell (10, 10); obstacles at `obstacles`.
    fn found(obstacles: &[(usize, usize)], points: &[(f64, f64)]) -> Vec<(usize, usize)> {
        let mut cells = vec![1.0_f32; 21 * 21];
        for &(x, y) in obstacles {
            cells[y * 21 + x] = 0.0;
        }
        let sheet = Sheet {
            cells: &cells,
            side: 21,
            centre: (10.0, 10.0),
            resolution_m: 0.1,
            inverse: 10.0,
        };
        let mut squares = Squares::default();
        let points = points.iter().map(|&(x, y)| Point2::new(x, y));
        let hits = points.map(|at| Hit::of(Point2::origin(), at));
        squares.fill(&sheet, 0.8, hits);
        let cell = |at: f64| (at / 0.1 + 10.0).round().to_usize();
        let cells = squares.centres.iter();
        cells.map(|at| (cell(at.x), cell(at.y))).collect()
    }

    #[test]
    fn what_the_scan_measures_is_left_to_its_points() {
        let wall = [(14, 9), (14, 10), (14, 11)];
        assert_eq!(found(&wall, &[]), wall);
        // Hits in the middle of the wall, and before it by as much as noise.
        assert_eq!(found(&wall, &[(0.4, 0.0)]), [(14, 9), (14, 11)]);
        assert_eq!(found(&wall, &[(0.32, 0.0)]), [(14, 9), (14, 11)]);
        // Somewhere before it: something else.
        assert_eq!(found(&wall, &[(0.25, 0.0)]), wall);
    }

    #[test]
    fn cells_inside_an_obstacle_and_far_away_are_left_out() {
        let block: Vec<_> = (12..15)
            .flat_map(|x| (12..15).map(move |y| (x, y)))
            .chain([(20, 10)])
            .collect();
        let found = found(&block, &[]);
        assert_eq!(found.len(), 8);
        assert!(!found.contains(&(13, 13)) && !found.contains(&(20, 10)));
    }
}
