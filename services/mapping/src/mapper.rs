//! From scans to the map: belief, clearance, cost, tiles.

use crate::belief::{Belief, Flips};
use crate::cell_value::{ValueTable, clearance_limit_mm};
use crate::clearance::ClearanceField;
use crate::config::{MappingConfig, MappingError};
use crate::tiles::{TileBoxes, TileIndex};
use zeronav_msgs::description::Description;
use zeronav_msgs::map::{
    COST_INSCRIBED, COST_LETHAL, COST_UNKNOWN, FLAG_SENSED, FLAG_STATIC, FLAG_UNKNOWN, MapTile,
};
use zeronav_msgs::scan::Scan;
use zeronav_msgs::{Cell, CellRect, GridGeometry, MapCell, MapView, Pose};
use zeronav_world::StaticMap;

/// Rows that are computed together when the map is made.
const BAND_ROWS: i32 = 128;

/// What a scan did to the map. Counts of cells.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Integrated {
    /// Became obstacles.
    pub marked: usize,
    /// Are obstacles no longer.
    pub cleared: usize,
    /// Were seen for the first time.
    pub revealed: usize,
}

/// The map, and what is needed to keep it right. Time follows what a scan changed, not the size
/// of the map; nothing is allocated once scans repeat themselves.
#[derive(Debug)]
pub struct Mapper {
    geometry: GridGeometry,
    belief: Belief,
    clearance: ClearanceField,
    values: ValueTable,
    clearance_limit_mm: u16,
    cells: Vec<MapCell>,
    flips: Flips,
    /// Obstacles that came or went.
    flipped: TileBoxes,
    /// Obstacles that went.
    cleared: TileBoxes,
    /// Cells that differ from what was taken last.
    dirty: TileBoxes,
}

impl Mapper {
    /// The map before the first scan: the static map, or nothing known. No tile is dirty.
    ///
    /// `static_map` is the content of [`MappingConfig::static_map`]; the caller has read it.
    ///
    /// # Errors
    /// What is wrong with configuration or static map.
    pub fn new(
        config: &MappingConfig,
        static_map: Option<&StaticMap>,
        description: &Description,
    ) -> Result<Self, MappingError> {
        let geometry = match static_map {
            Some(map) => {
                map.geometry.check().map_err(MappingError::Geometry)?;
                map.geometry
            }
            None => config.geometry()?,
        };
        let expected = geometry.len();
        if let Some(n_cells) = static_map.map(|map| map.cells.len())
            && n_cells != expected
        {
            return Err(MappingError::StaticMap { n_cells, expected });
        }
        config.check(geometry.resolution_m)?;
        let inscribed_m = description.inscribed_radius_m;
        let limit_cells = config.clearance_limit_m / geometry.resolution_m;
        let mut mapper = Self {
            geometry,
            belief: Belief::new(&geometry, static_map, config, inscribed_m),
            clearance: ClearanceField::new(&geometry, limit_cells),
            values: ValueTable::new(config, inscribed_m, geometry.resolution_m),
            clearance_limit_mm: clearance_limit_mm(config),
            cells: vec![MapCell::default(); expected],
            flips: Flips::default(),
            flipped: TileBoxes::new(&geometry),
            cleared: TileBoxes::new(&geometry),
            dirty: TileBoxes::new(&geometry),
        };
        for index in 0..expected {
            mapper.clearance.set(index, mapper.belief.is_static(index));
        }
        let (width, height) = geometry.size();
        // In bands, so that a large map needs no large memory for it.
        for y in (0..height).step_by(BAND_ROWS.cast_unsigned() as usize) {
            let band = CellRect {
                min: Cell::new(0, y),
                max: Cell::new(width, height.min(y + BAND_ROWS)),
            };
            mapper.clearance.recompute(&band);
            mapper.refresh(&band);
        }
        mapper.dirty.clear();
        Ok(mapper)
    }

    /// Takes in a scan that was checked against [`Scan::check`], seen from `map_from_laser`.
    pub fn integrate(&mut self, map_from_laser: &Pose, scan: &Scan, ranges: &[f32]) -> Integrated {
        let mut flips = core::mem::take(&mut self.flips);
        self.belief
            .integrate(map_from_laser, scan, ranges, &mut flips);
        self.follow(&flips);
        let integrated = Integrated {
            marked: flips.marked.len(),
            cleared: flips.cleared.len(),
            revealed: flips.revealed.len(),
        };
        self.flips = flips;
        integrated
    }

    /// Brings clearance and cells up to date with the belief.
    fn follow(&mut self, flips: &Flips) {
        for index in &flips.cleared {
            let cell = self.cell_of(*index);
            self.clearance.set(*index, false);
            self.flipped.add(cell);
            self.cleared.add(cell);
        }
        for index in &flips.marked {
            let cell = self.cell_of(*index);
            self.clearance.set(*index, true);
            self.flipped.add(cell);
        }
        let reach = self.clearance.reach();
        // Where obstacles went first: it looks at obstacles alone, old and new.
        for n in 0..self.cleared.len() {
            let gone = self.cleared.get(n).grown(reach, &self.geometry);
            self.clearance.recompute(&gone);
        }
        for index in &flips.marked {
            self.clearance.add(self.cell_of(*index));
        }
        for n in 0..self.flipped.len() {
            let changed = self.flipped.get(n).grown(reach, &self.geometry);
            self.refresh(&changed);
        }
        for index in &flips.revealed {
            self.refresh_cell(*index, self.cell_of(*index));
        }
        self.flipped.clear();
        self.cleared.clear();
    }

    fn refresh(&mut self, rect: &CellRect) {
        for y in rect.min.y..rect.max.y {
            for x in rect.min.x..rect.max.x {
                let cell = Cell::new(x, y);
                if let Some(index) = self.geometry.index_of(cell) {
                    self.refresh_cell(index, cell);
                }
            }
        }
    }

    #[inline]
    fn refresh_cell(&mut self, index: usize, cell: Cell) {
        let value = self.value_of(index);
        if self.cells[index] != value {
            self.cells[index] = value;
            self.dirty.add(cell);
        }
    }

    /// Layers are combined by their maximum: what the static map holds stays, whatever scans say.
    #[inline]
    fn value_of(&self, index: usize) -> MapCell {
        let (clearance_mm, known_cost) = self.values.get(self.clearance.squares()[index]);
        let mut flags = 0;
        if self.belief.is_static(index) {
            flags |= FLAG_STATIC;
        }
        if self.belief.is_sensed(index) {
            flags |= FLAG_SENSED;
        }
        let unknown = self.belief.is_unknown(index);
        if unknown {
            flags |= FLAG_UNKNOWN;
        }
        let cost = match known_cost {
            blocked @ (COST_LETHAL | COST_INSCRIBED) => blocked,
            _ if unknown => COST_UNKNOWN,
            cost => cost,
        };
        MapCell {
            cost,
            flags,
            clearance_mm,
        }
    }

    fn cell_of(&self, index: usize) -> Cell {
        let width = self.geometry.width as usize;
        let number = |cells: usize| i32::try_from(cells).unwrap_or(i32::MAX);
        Cell::new(number(index % width), number(index / width))
    }

    /// Where the map lies.
    #[must_use]
    pub fn geometry(&self) -> &GridGeometry {
        &self.geometry
    }

    /// The cells, row-major.
    #[must_use]
    pub fn cells(&self) -> &[MapCell] {
        &self.cells
    }

    /// The map as planners see it.
    #[must_use]
    pub fn view(&self) -> MapView<'_> {
        MapView {
            geometry: &self.geometry,
            cells: &self.cells,
        }
    }

    /// Where clearance saturates. [mm]
    #[must_use]
    pub fn clearance_limit_mm(&self) -> u16 {
        self.clearance_limit_mm
    }

    /// Adds the tiles of which a cell changed since the last call to `tiles`, which is then sorted
    /// row by row and names each tile once; forgets them. Tiles that could not be sent stay in
    /// `tiles` until the caller clears it.
    pub fn take_dirty_tiles(&mut self, tiles: &mut Vec<TileIndex>) {
        self.dirty.take_tiles(tiles);
    }

    /// Fills a tile of a message in place.
    pub fn fill_tile(&self, index: TileIndex, tile: &mut MapTile) {
        index.name(tile);
        tile.fill_from(&self.geometry, &self.cells);
    }
}
