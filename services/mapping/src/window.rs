//! Where the map lies when the robot comes to its edge.

use nalgebra::Point2;
use zeronav_casts::Cast;
use zeronav_msgs::grid::SIDE_CELLS_MAX;
use zeronav_msgs::map::{GROWING_TILES_MAX, TILE_CELLS, TILES_PER_KEYFRAME_MAX, tiles_of};
use zeronav_msgs::{Cell, GridGeometry};
use zeronav_params::{choices, parameters};

choices! {
    /// What happens at the edge.
    pub enum WindowMode {
        /// Nothing; beams end at the edge.
        #[default]
        Fixed = "fixed",
        /// The map moves along and forgets what it leaves behind.
        Rolling = "rolling",
        /// The map becomes larger, as long as there is room, and then stays.
        Growing = "growing",
    }
}

parameters! {
    /// Configuration of the window.
    #[derive(Copy)]
    pub struct WindowConfig {
        /// What happens when the robot comes to the edge of the map.
        mode: WindowMode = WindowMode::Fixed;
        /// Distance from the edge within which the robot counts as there.
        margin_m: f64 = 3.0, [0.0, 1.0e3] "m";
        /// Most tiles of 32 x 32 cells of a growing map; they decide how much memory its keyframes
        /// take.
        tiles_max: usize = GROWING_TILES_MAX, [1, TILES_PER_KEYFRAME_MAX];
    }
}

impl WindowConfig {
    /// Most tiles that a map that begins as `geometry` will ever have.
    #[must_use]
    pub fn most_tiles(&self, geometry: &GridGeometry) -> usize {
        let (columns, rows) = tiles_of(geometry);
        let tiles = columns as usize * rows as usize;
        match self.mode {
            WindowMode::Fixed | WindowMode::Rolling => tiles,
            WindowMode::Growing => tiles.max(self.tiles_max),
        }
    }

    /// The grid for a robot at `robot`, and how far its origin lies from that of `geometry`; `None`
    /// when it is well where it is. Grids move and grow by whole tiles.
    #[must_use]
    pub fn follow(
        &self,
        geometry: &GridGeometry,
        robot: Point2<f64>,
    ) -> Option<(GridGeometry, Cell)> {
        let cell = geometry.unbounded_cell_at(robot);
        let margin = (self.margin_m / geometry.resolution_m).ceil().to_i32();
        let (width, height) = geometry.size();
        let x = Side::of(cell.x, width, margin);
        let y = Side::of(cell.y, height, margin);
        let (x, y) = match self.mode {
            WindowMode::Fixed => return None,
            WindowMode::Rolling => (x.rolled(width), y.rolled(height)),
            WindowMode::Growing => (x.grown(width), y.grown(height)),
        };
        if x == (0, width) && y == (0, height) {
            return None;
        }
        let next = GridGeometry {
            origin_x_m: geometry.origin_x_m + f64::from(x.0) * geometry.resolution_m,
            origin_y_m: geometry.origin_y_m + f64::from(y.0) * geometry.resolution_m,
            width: u32::try_from(x.1).ok()?,
            height: u32::try_from(y.1).ok()?,
            ..*geometry
        };
        let (columns, rows) = tiles_of(&next);
        let fits = next.check().is_ok()
            && columns as usize * rows as usize <= self.most_tiles(geometry)
            && next.width.max(next.height) <= SIDE_CELLS_MAX;
        fits.then_some((next, Cell::new(x.0, y.0)))
    }
}

/// Where a coordinate lies along a side of the map.
#[derive(Debug, Clone, Copy)]
struct Side {
    at: i32,
    /// Cells that are missing below and above it.
    below: i32,
    above: i32,
}

impl Side {
    fn of(at: i32, length: i32, margin: i32) -> Self {
        Self {
            at,
            below: margin.saturating_sub(at).max(0),
            above: at.saturating_add(margin + 1).saturating_sub(length).max(0),
        }
    }

    /// Shift of the origin and length, so that the coordinate lies in the middle, when it is at
    /// the edge.
    fn rolled(self, length: i32) -> (i32, i32) {
        if self.below == 0 && self.above == 0 {
            return (0, length);
        }
        let shift = self.at.saturating_sub(length / 2);
        (tiles_down(shift), length)
    }

    /// Shift of the origin and length, so that nothing is missing, and a tile more.
    fn grown(self, length: i32) -> (i32, i32) {
        let more = |missing: i32| {
            if missing == 0 {
                0
            } else {
                tiles_down(missing.saturating_add(2 * TILE - 1))
            }
        };
        let (below, above) = (more(self.below), more(self.above));
        (-below, length.saturating_add(below).saturating_add(above))
    }
}

#[allow(
    clippy::cast_possible_truncation,
    clippy::cast_possible_wrap,
    reason = "32"
)]
const TILE: i32 = TILE_CELLS as i32;

/// The largest multiple of a tile that is not above `cells`.
fn tiles_down(cells: i32) -> i32 {
    cells.div_euclid(TILE).saturating_mul(TILE)
}

#[cfg(test)]
mod tests {
    use super::*;

    const GRID: GridGeometry = GridGeometry {
        origin_x_m: -1.0,
        origin_y_m: 2.0,
        resolution_m: 0.1,
        width: 200,
        height: 100,
    };

    fn follow(mode: WindowMode, x_m: f64, y_m: f64) -> Option<(GridGeometry, Cell)> {
        let config = WindowConfig {
            mode,
            margin_m: 1.0,
            tiles_max: 60,
        };
        config.follow(&GRID, Point2::new(x_m, y_m))
    }

    #[test]
    fn well_inside_nothing_happens() {
        for mode in [WindowMode::Fixed, WindowMode::Rolling, WindowMode::Growing] {
            assert_eq!(follow(mode, 9.0, 7.0), None);
            assert_eq!(follow(mode, 0.05, 3.05), None);
        }
        assert_eq!(follow(WindowMode::Fixed, 50.0, 7.0), None);
    }

    #[test]
    fn a_rolling_map_keeps_its_size_and_has_the_robot_in_its_middle() {
        let (grid, shift) = follow(WindowMode::Rolling, 18.5, 7.0).expect("a move");
        assert_eq!((grid.width, grid.height), (200, 100));
        assert_eq!(shift, Cell::new(64, 0));
        assert!((grid.origin_x_m - 5.4).abs() < 1e-9);
        let at = grid.cell_at(Point2::new(18.5, 7.0)).expect("inside");
        assert!((100 - 32..=100 + 32).contains(&at.x), "{at:?}");
        // Far outside is found again, too.
        let (grid, _) = follow(WindowMode::Rolling, -80.0, 7.0).expect("a move");
        assert!(grid.cell_at(Point2::new(-80.0, 7.0)).is_some());
    }

    #[test]
    fn a_growing_map_keeps_what_it_has_and_stops_when_it_is_full() {
        let (grid, shift) = follow(WindowMode::Growing, -1.2, 7.0).expect("growth");
        assert_eq!(shift, Cell::new(-64, 0));
        assert_eq!((grid.width, grid.height), (264, 100));
        assert!((grid.origin_x_m - -7.4).abs() < 1e-9);
        let (grid, shift) = follow(WindowMode::Growing, 3.0, 13.0).expect("growth");
        assert_eq!((shift, grid.height), (Cell::new(0, 0), 164));
        assert_eq!(follow(WindowMode::Growing, 80.0, 7.0), None);
    }
}
