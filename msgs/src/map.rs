//! `map/update` and `map/keyframe`: the map, tile by tile.

use crate::grid::{Cell, CellRect, GridGeometry};
use crate::message::{Refusal, ZeroCopySend, ensure, number};
use crate::pose::Pose;
use crate::way_out::WayOut;
use crate::{codes, message};
use zeronav_casts::Cast;

/// Side of a tile. [cells]
pub const TILE_CELLS: usize = 32;

/// Most tiles of one update message; a larger revision comes in several parts.
pub const TILES_PER_UPDATE_MAX: usize = 60;

/// Most tiles of a growing map, unless the configuration of mapping says otherwise; launch reserves
/// shared memory for as many.
pub const GROWING_TILES_MAX: usize = 1024;

/// Most tiles of a keyframe: a map of 4096 x 4096 cells.
pub const TILES_PER_KEYFRAME_MAX: usize = 128 * 128;

/// Cost of a cell without any reason to avoid it.
pub const COST_FREE: u8 = 0;
/// Highest cost of a cell in which the centre of the robot may stand.
pub const COST_CIRCUMSCRIBED_MAX: u8 = 252;
/// Cost of a cell closer to an obstacle than the inscribed radius.
pub const COST_INSCRIBED: u8 = 253;
/// Cost of an obstacle.
pub const COST_LETHAL: u8 = 254;
/// Cost of a cell about which nothing is known.
pub const COST_UNKNOWN: u8 = 255;

/// Flag: occupied by the static map.
pub const FLAG_STATIC: u8 = 1;
/// Flag: occupied by what the lidar saw.
pub const FLAG_SENSED: u8 = 1 << 1;
/// Flag: a virtual obstacle.
pub const FLAG_VIRTUAL: u8 = 1 << 2;
/// Flag: filled by obstacle regularisation.
pub const FLAG_REGULARISED: u8 = 1 << 3;
/// Flag: nothing is known about the cell, whatever its cost says.
pub const FLAG_UNKNOWN: u8 = 1 << 4;

/// Flag: inside a keepout zone, whatever is there.
pub const FLAG_KEEPOUT: u8 = 1 << 5;

const FLAGS_ALL: u8 = (1 << 6) - 1;

codes! {
    /// Where an obstacle comes from, as far as the map tells.
    pub enum ObstacleSource: u16 {
        /// Not told.
        None = 0 => "none",
        /// It is part of the static map.
        StaticMap = 1 => "static_map",
        /// The lidar saw it, and the static map does not have it.
        Lidar = 2 => "lidar",
        /// It is a tracked obstacle.
        Tracked = 3 => "tracked",
        /// It is none: nothing is known of the cell, and unknown cells count as obstacles.
        Unknown = 4 => "unknown",
        /// It is none: the cell lies in a keepout zone.
        Keepout = 5 => "keepout",
    }
}

message! {
    /// One cell. `cost` and `clearance_mm` come from obstacles that are static, by the static map or
    /// by what the lidar saw; those that move are on `map/obstacles` alone.
    pub struct MapCell = "zeronav.MapCell.v2" {
        /// [number] As in Nav2: 0 free, 253 inscribed, 254 lethal, 255 unknown.
        pub cost: u8,
        /// [bits] Sum of the `FLAG_` bits.
        pub flags: u8,
        /// [mm] from the cell's centre to the nearest obstacle square, rounded down, saturated at
        /// the map's limit; 0 inside an obstacle.
        pub clearance_mm: u16,
    }
}

impl MapCell {
    /// A cell about which nothing is known.
    #[must_use]
    pub const fn unknown(clearance_mm: u16) -> Self {
        Self {
            cost: COST_UNKNOWN,
            flags: FLAG_UNKNOWN,
            clearance_mm,
        }
    }

    /// True when the centre of the robot cannot be here: an obstacle is within the inscribed
    /// radius. Unknown cells are not blocked by this rule.
    #[must_use]
    pub const fn blocks_centre(self) -> bool {
        self.cost == COST_INSCRIBED || self.cost == COST_LETHAL
    }

    /// Where the obstacle in this cell comes from. On a reader's copy a lethal cell that neither the
    /// static map nor the lidar holds is a tracked obstacle, stamped on it.
    #[must_use]
    pub const fn source(self) -> ObstacleSource {
        if self.flags & FLAG_STATIC != 0 {
            ObstacleSource::StaticMap
        } else if self.flags & FLAG_SENSED != 0 {
            ObstacleSource::Lidar
        } else if self.flags & FLAG_KEEPOUT != 0 {
            ObstacleSource::Keepout
        } else if self.cost == COST_LETHAL {
            ObstacleSource::Tracked
        } else if self.flags & FLAG_UNKNOWN != 0 {
            ObstacleSource::Unknown
        } else {
            ObstacleSource::None
        }
    }

    /// Clearance in metres.
    #[must_use]
    pub fn clearance_m(self) -> f64 {
        f64::from(self.clearance_mm) / 1000.0
    }
}

message! {
    /// 32 x 32 cells, row-major. Cells beyond the map's edge are unknown and ignored.
    pub struct MapTile = "zeronav.MapTile.v2" {
        /// [number] Column of tiles, from 0.
        pub tile_x: u32,
        /// [number] Row of tiles, from 0.
        pub tile_y: u32,
        /// The cells.
        pub cells: [MapCell; 1024],
    }
}

message! {
    /// How the cost of a known cell follows from its clearance, see [`CostModel::cost`].
    pub struct CostModel = "zeronav.CostModel.v1" {
        /// [m] of the robot's inscribed circle, >= 0.
        pub inscribed_radius_m: f64,
        /// [m] added to the inscribed radius, >= 0.
        pub padding_m: f64,
        /// [m] of clearance beyond which a cell is free, >= 0.
        pub inflation_radius_m: f64,
        /// [1/m] by which the cost falls, >= 0.
        pub scaling_per_m: f64,
    }
}

message! {
    /// Fixed fields of map messages. The slice holds tiles.
    pub struct MapInfo = "zeronav.MapInfo.v3" {
        /// Where the grid lies.
        pub geometry: GridGeometry,
        /// [id] Revision that the map has after this message: the id of the update's last part.
        pub revision: u64,
        /// `map_from_odom`.
        pub map_from_odom: Pose,
        /// Covariance of the pose of `base` in the map, against where that began, upper triangle by rows. [m, m, rad] Its
        /// deviations also say how far the pose is known ([`MapInfo::certainty`]).
        pub covariance: [f64; 6],
        /// [number] Which part of the revision this is, from 0.
        pub part: u16,
        /// [count] Parts of the revision, at least 1; 1 in a keyframe.
        pub parts: u16,
        /// [count] Tiles in the slice.
        pub n_tiles: u32,
        /// [mm] at which clearance is saturated.
        pub clearance_limit_mm: u32,
        /// [flag] 1 when scans keep coming, 0 when the map is not current.
        pub current: u32,
        /// How the cost of a cell follows from its clearance.
        pub cost_model: CostModel,
        /// The way out of a keepout zone, whose cells are open.
        pub way_out: WayOut,
    }
}

/// Columns and rows of tiles that cover `geometry`.
#[must_use]
pub fn tiles_of(geometry: &GridGeometry) -> (u32, u32) {
    let side = u32::try_from(TILE_CELLS).unwrap_or(1);
    (
        geometry.width.div_ceil(side),
        geometry.height.div_ceil(side),
    )
}

impl MapTile {
    /// The cells of this tile that lie on the map.
    #[must_use]
    pub fn rect(&self, geometry: &GridGeometry) -> CellRect {
        let side = 32;
        let min = Cell::new(
            self.tile_x.cast_signed().saturating_mul(side),
            self.tile_y.cast_signed().saturating_mul(side),
        );
        let (width, height) = geometry.size();
        CellRect {
            min,
            max: Cell::new(
                min.x.saturating_add(side).min(width),
                min.y.saturating_add(side).min(height),
            ),
        }
    }

    /// Fills the tile from a row-major grid of the same geometry.
    ///
    /// # Panics
    /// When `cells` is not as long as the geometry says.
    pub fn fill_from(&mut self, geometry: &GridGeometry, cells: &[MapCell]) {
        assert_eq!(cells.len(), geometry.len(), "grid and geometry differ");
        let rect = self.rect(geometry);
        self.cells = [MapCell::unknown(0); 1024];
        for y in rect.min.y..rect.max.y {
            let (Some(from), row) = (
                geometry.index_of(Cell::new(rect.min.x, y)),
                (y - rect.min.y).cast_unsigned() as usize * TILE_CELLS,
            ) else {
                continue;
            };
            let n = (rect.max.x - rect.min.x).cast_unsigned() as usize;
            self.cells[row..row + n].copy_from_slice(&cells[from..from + n]);
        }
    }

    /// Copies the tile into a row-major grid of the same geometry. Returns the smallest rectangle
    /// around the cells that are others now; `None` when all are as they were.
    ///
    /// # Panics
    /// When `cells` is not as long as the geometry says.
    pub fn copy_to(&self, geometry: &GridGeometry, cells: &mut [MapCell]) -> Option<CellRect> {
        assert_eq!(cells.len(), geometry.len(), "grid and geometry differ");
        let rect = self.rect(geometry);
        let n = (rect.max.x - rect.min.x).max(0).cast_unsigned() as usize;
        let mut changed: Option<CellRect> = None;
        for y in rect.min.y..rect.max.y {
            let (Some(to), row) = (
                geometry.index_of(Cell::new(rect.min.x, y)),
                (y - rect.min.y).cast_unsigned() as usize * TILE_CELLS,
            ) else {
                continue;
            };
            let (old, new) = (&mut cells[to..to + n], &self.cells[row..row + n]);
            let is_other = |(old, new): (&MapCell, &MapCell)| old != new;
            let Some(first) = old.iter().zip(new).position(is_other) else {
                continue;
            };
            let last = old.iter().zip(new).rposition(is_other).unwrap_or(first);
            old[first..=last].copy_from_slice(&new[first..=last]);
            let (min_x, max_x) = (rect.min.x + first.to_i32(), rect.min.x + last.to_i32() + 1);
            let so_far = changed.get_or_insert(CellRect {
                min: Cell::new(min_x, y),
                max: Cell::new(max_x, y),
            });
            so_far.min.x = so_far.min.x.min(min_x);
            so_far.max.x = so_far.max.x.max(max_x);
            so_far.max.y = y + 1;
        }
        changed
    }
}

/// What is lost in floating point must not cost a millimetre. [mm]
const ROUNDING_MM: f64 = 1.0e-6;

impl CostModel {
    /// Cost of a known cell whose centre is `clearance_m` from the nearest obstacle.
    ///
    /// As in Nav2's inflation layer: 254 in obstacles, 253 where the clearance is at most the
    /// inscribed radius or less than that and the padding, then
    /// `252 exp(-k (clearance - inscribed - padding))` rounded down, 0 beyond the inflation radius.
    /// Nav2 measures from the obstacle's centre, we from its edge, so that costs reach half a cell
    /// further.
    #[must_use]
    pub fn cost(&self, clearance_m: f64) -> u8 {
        let beyond_m = clearance_m - self.inscribed_radius_m;
        let spare_m = beyond_m - self.padding_m;
        if clearance_m * 1000.0 <= ROUNDING_MM {
            COST_LETHAL
        } else if beyond_m * 1000.0 <= ROUNDING_MM || spare_m * 1000.0 < -ROUNDING_MM {
            COST_INSCRIBED
        } else if clearance_m * 1000.0 <= self.inflation_radius_m * 1000.0 + ROUNDING_MM {
            let fall = (-self.scaling_per_m * spare_m).exp();
            (f64::from(COST_CIRCUMSCRIBED_MAX) * fall).to_u8()
        } else {
            COST_FREE
        }
    }

    fn check(&self) -> Result<(), Refusal> {
        number(self.inscribed_radius_m, 0.0, 100.0, "inscribed_radius_m")?;
        number(self.padding_m, 0.0, 100.0, "padding_m")?;
        number(self.inflation_radius_m, 0.0, 100.0, "inflation_radius_m")?;
        number(self.scaling_per_m, 0.0, 1.0e6, "scaling_per_m")
    }
}

/// A clearance as a cell holds it: rounded down, at most `limit_mm`. [mm]
#[must_use]
pub fn clearance_mm(clearance_m: f64, limit_mm: u16) -> u16 {
    (clearance_m * 1000.0 + ROUNDING_MM)
        .clamp(0.0, f64::from(u16::MAX))
        .to_u16()
        .min(limit_mm)
}

impl MapInfo {
    /// True when the revision is complete with this message.
    #[must_use]
    pub const fn is_last_part(&self) -> bool {
        self.part + 1 == self.parts
    }

    /// Accepts map messages whose tiles lie on the map.
    ///
    /// # Errors
    /// The first field that is wrong.
    pub fn check(&self, tiles: &[MapTile], tiles_max: usize) -> Result<(), Refusal> {
        self.geometry.check()?;
        self.map_from_odom.check("map_from_odom")?;
        for value in self.covariance {
            number(value, -1.0e12, 1.0e12, "covariance")?;
        }
        ensure(self.revision != 0, Refusal::Identity)?;
        ensure(
            self.parts >= 1 && self.part < self.parts,
            Refusal::OutOfRange("part"),
        )?;
        ensure(
            (1..=u32::from(u16::MAX)).contains(&self.clearance_limit_mm),
            Refusal::OutOfRange("clearance_limit_mm"),
        )?;
        ensure(self.current <= 1, Refusal::Code("current"))?;
        self.cost_model.check()?;
        self.way_out.check()?;
        ensure(
            tiles.len() == self.n_tiles as usize && tiles.len() <= tiles_max,
            Refusal::Length("tiles"),
        )?;
        let (columns, rows) = tiles_of(&self.geometry);
        for tile in tiles {
            ensure(
                tile.tile_x < columns && tile.tile_y < rows,
                Refusal::OutOfRange("tile"),
            )?;
            let right = |cell: &MapCell| {
                u32::from(cell.clearance_mm) <= self.clearance_limit_mm
                    && cell.flags & !FLAGS_ALL == 0
            };
            let wrong = !tile.cells.iter().all(right);
            ensure(!wrong, Refusal::OutOfRange("cell"))?;
        }
        Ok(())
    }
}

/// A whole map as planners see it: row-major cells of a geometry.
#[derive(Debug, Clone, Copy)]
pub struct MapView<'a> {
    /// Where the cells lie.
    pub geometry: &'a GridGeometry,
    /// `geometry.len()` cells, row-major.
    pub cells: &'a [MapCell],
}

impl MapView<'_> {
    /// The cell; `None` outside the map.
    #[must_use]
    pub fn get(&self, cell: Cell) -> Option<MapCell> {
        self.geometry
            .index_of(cell)
            .and_then(|index| self.cells.get(index))
            .copied()
    }

    /// Clearance that a robot whose centre is in `start`, too close to an obstacle, has at least wherever
    /// it is led out of there. [mm]
    ///
    /// It fits where it is, so it fits where there is as much room; half a cell's diagonal less counts as
    /// much, because the robot is anywhere in its cell.
    #[must_use]
    pub fn least_clearance_mm(&self, start: MapCell) -> u16 {
        let half_diagonal_m = self.geometry.resolution_m * core::f64::consts::FRAC_1_SQRT_2;
        (f64::from(start.clearance_mm) - 1000.0 * half_diagonal_m)
            .max(0.0)
            .to_u16()
    }

    /// Where the obstacle comes from that blocks `cell`: the nearest one, no farther than the cell's
    /// clearance says, of two equally near the one in the lower row, then column. An unknown cell that
    /// no obstacle blocks is its own reason.
    #[must_use]
    pub fn source_at(&self, cell: Cell) -> ObstacleSource {
        let Some(own) = self.get(cell) else {
            return ObstacleSource::None;
        };
        if own.cost == COST_UNKNOWN {
            return own.source();
        }
        // Clearance is to the edge of the obstacle's cell.
        let clearance_cells = (own.clearance_m() / self.geometry.resolution_m).floor();
        let reach = clearance_cells.clamp(0.0, SOURCE_CELLS_MAX).to_i32() + 1;
        let mut nearest: Option<(i32, MapCell)> = None;
        for y in -reach..=reach {
            for x in -reach..=reach {
                let away = x * x + y * y;
                let at = Cell::new(cell.x.saturating_add(x), cell.y.saturating_add(y));
                if nearest.is_none_or(|(nearest, _)| away < nearest)
                    && let Some(obstacle) = self.get(at).filter(|at| at.cost == COST_LETHAL)
                {
                    nearest = Some((away, obstacle));
                }
            }
        }
        nearest.map_or(own, |(_, obstacle)| obstacle).source()
    }
}

/// Farthest that the obstacle which blocks a cell is looked for. [cells]
const SOURCE_CELLS_MAX: f64 = 64.0;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_obstacle_says_where_it_comes_from() {
        use ObstacleSource::{Lidar, None, StaticMap, Tracked, Unknown};
        let geometry = GridGeometry {
            resolution_m: 0.05,
            width: 9,
            height: 1,
            ..GridGeometry::default()
        };
        let near = |clearance_mm| MapCell {
            cost: COST_INSCRIBED,
            flags: 0,
            clearance_mm,
        };
        let obstacle = |flags| MapCell {
            cost: COST_LETHAL,
            flags,
            clearance_mm: 0,
        };
        let cells = [
            obstacle(FLAG_STATIC | FLAG_SENSED),
            near(25),
            near(75),
            near(25),
            obstacle(FLAG_SENSED),
            near(25),
            MapCell::unknown(75),
            near(25),
            // Stamped on a reader's copy.
            obstacle(0),
        ];
        let map = MapView {
            geometry: &geometry,
            cells: &cells,
        };
        let sources = [-1, 0, 1, 2, 3, 4, 5, 6, 7, 8].map(|x| map.source_at(Cell::new(x, 0)));
        // In the middle between two: the lower one.
        let expected = [
            None, StaticMap, StaticMap, StaticMap, Lidar, Lidar, Lidar, Unknown, Tracked, Tracked,
        ];
        assert_eq!(sources, expected);
    }
}
