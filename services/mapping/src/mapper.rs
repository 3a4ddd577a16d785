//! From scans to the map: belief, clearance, cost, tiles.

mod other_grid;
mod zones;

use crate::beams::{Beams, Sweep};
use crate::belief::Belief;
use crate::cell_value::{ValueTable, cost_model};
use crate::clearance::ClearanceField;
use crate::config::MappingConfig;
use crate::error::MappingError;
use crate::flips::{Flips, Integrated};
use crate::located_scan::LocatedScan;
use crate::regularise::Regulariser;
use crate::rows_around::cell_at;
use crate::scan_match::Surfaces;
use crate::surface_candidates::SurfaceCandidates;
use crate::tiles::{TileBoxes, TileIndex};
use crate::virtual_obstacles::VirtualConfig;
use crate::zone_paint::ZonePaint;
use nalgebra::Point2;
use zeronav_msgs::description::Description;
use zeronav_msgs::map::{
    COST_INSCRIBED, COST_LETHAL, COST_UNKNOWN, CostModel, FLAG_KEEPOUT, FLAG_REGULARISED,
    FLAG_SENSED, FLAG_STATIC, FLAG_UNKNOWN, FLAG_VIRTUAL, MapTile, clearance_mm,
};
use zeronav_msgs::scan::Scan;
use zeronav_msgs::stages::{Stage, StageTimer};
use zeronav_msgs::zone_marks::MARK_KEEPOUT;
use zeronav_msgs::{Cell, CellRect, GridGeometry, MapCell, MapView, Pose};
use zeronav_world::StaticMap;

/// The map, and what is needed to keep it right. Time follows what a scan changed, not the size
/// of the map; nothing is allocated once scans repeat themselves.
#[derive(Debug)]
pub struct Mapper {
    geometry: GridGeometry,
    belief: Belief,
    clearance: ClearanceField,
    cost_model: CostModel,
    values: ValueTable,
    clearance_limit_mm: u16,
    cells: Vec<MapCell>,
    zones: ZonePaint,
    beams: Beams,
    flips: Flips,
    /// Obstacles that came or went.
    flipped: TileBoxes,
    /// Obstacles that went.
    cleared: TileBoxes,
    /// Cells that differ from what was taken last.
    dirty: TileBoxes,
    virtuals: VirtualConfig,
    n_virtual: usize,
    regulariser: Option<Regulariser>,
    /// Rectangles of the line that was last looked along.
    rectangles: Vec<CellRect>,
    /// Scratch: those of the line before it.
    rectangles_before: Vec<CellRect>,
    /// What scans are laid on, made at the first request.
    surfaces: Option<Surfaces>,
    candidates: SurfaceCandidates,
    /// Of the last scan. [ns]
    run_ns: u64,
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
        let belief = Belief::new(&geometry, static_map, config, inscribed_m);
        let cost_model = cost_model(config, inscribed_m);
        let mut mapper = Self::around(
            &geometry,
            belief,
            (cost_model, &ZonePaint::default()),
            config,
        );
        // So far there are static obstacles alone.
        let margin = (2.0 * config.tracking.static_margin_m / geometry.resolution_m).powi(2);
        for index in 0..expected {
            if f64::from(mapper.clearance.squares()[index]) <= margin {
                mapper.belief.set_near_static(index);
            }
        }
        mapper.dirty.clear();
        Ok(mapper)
    }

    /// The map that a belief makes. Every tile is dirty.
    fn around(
        geometry: &GridGeometry,
        belief: Belief,
        (cost_model, zones): (CostModel, &ZonePaint),
        config: &MappingConfig,
    ) -> Self {
        let clearance_limit_mm = clearance_mm(config.clearance_limit_m, u16::MAX);
        let limit_cells = config.clearance_limit_m / geometry.resolution_m;
        let regulariser = config
            .regularisation
            .enabled
            .then(|| Regulariser::new(geometry, &config.regularisation));
        let mut mapper = Self {
            geometry: *geometry,
            belief,
            clearance: ClearanceField::new(geometry, limit_cells),
            cost_model,
            values: ValueTable::new(&cost_model, clearance_limit_mm, geometry.resolution_m),
            clearance_limit_mm,
            cells: vec![MapCell::default(); geometry.len()],
            zones: zones.on(geometry),
            beams: Beams::default(),
            flips: Flips::default(),
            flipped: TileBoxes::new(geometry),
            cleared: TileBoxes::new(geometry),
            dirty: TileBoxes::new(geometry),
            virtuals: config.virtual_obstacles,
            n_virtual: 0,
            regulariser,
            rectangles: Vec::new(),
            rectangles_before: Vec::new(),
            surfaces: None,
            candidates: SurfaceCandidates::default(),
            run_ns: 0,
        };
        for index in 0..geometry.len() {
            let obstacle = mapper.is_closed(index);
            mapper.clearance.set(index, obstacle);
        }
        mapper.clearance.recompute_all();
        let (width, height) = geometry.size();
        mapper.refresh(&CellRect {
            min: Cell::new(0, 0),
            max: Cell::new(width, height),
        });
        mapper
    }

    /// Takes in a scan that was checked against [`Scan::check`], seen from `map_from_laser`, all
    /// beams at once and nothing in it moving.
    pub fn integrate(&mut self, map_from_laser: &Pose, scan: &Scan, ranges: &[f32]) -> Integrated {
        let mut beams = core::mem::take(&mut self.beams);
        beams.cast(scan, ranges, &Sweep::still(Pose::default()));
        let sight = LocatedScan {
            map_from_frame: *map_from_laser,
            beams: beams.as_slice(),
            moving: &[],
            run_ns: 0,
        };
        let integrated = self.take_in(&sight, &[], &mut StageTimer::default());
        self.beams = beams;
        integrated
    }

    /// Takes in a scan. `under_robot` are the row-major indices of the cells under the robot.
    pub fn take_in(
        &mut self,
        sight: &LocatedScan<'_>,
        under_robot: &[usize],
        timer: &mut StageTimer,
    ) -> Integrated {
        let mut flips = core::mem::take(&mut self.flips);
        self.belief.integrate(sight, under_robot, &mut flips);
        self.run_ns = sight.run_ns;
        timer.mark(Stage::Integrate);
        if let Some(surfaces) = &mut self.surfaces {
            surfaces.take_in(self.belief.ended());
        }
        self.follow(&flips);
        let integrated = flips.count();
        flips.clear();
        self.flips = flips;
        integrated
    }

    /// Forgets the obstacles that scans have put within `radius_m` of a point of the map; the next
    /// scan puts back those that are still there.
    pub fn forget(&mut self, centre: Point2<f64>, radius_m: f64) {
        let mut flips = core::mem::take(&mut self.flips);
        self.belief.forget(centre, radius_m, &mut flips);
        self.follow(&flips);
        flips.clear();
        self.flips = flips;
    }

    /// Forgets all obstacles that scans have put.
    pub fn forget_sensed(&mut self) {
        let (width, height) = self.geometry.size();
        let middle = self.geometry.centre_of(Cell::new(width / 2, height / 2));
        let reach_m = f64::from(width).hypot(f64::from(height)) * self.geometry.resolution_m;
        self.forget(middle, reach_m);
        if let Some(surfaces) = &mut self.surfaces {
            surfaces.forget_hits();
        }
    }

    /// Finds the obstacle groups on the line from the robot to its goal, or none without a line,
    /// and flags what they are filled up with. Does nothing unless regularisation is on.
    pub fn regularise(&mut self, line: Option<(Point2<f64>, Point2<f64>)>) {
        let Some(regulariser) = &mut self.regulariser else {
            return;
        };
        let clearance = &self.clearance;
        match line {
            Some((from, to)) => regulariser.look_along(
                self.geometry.unbounded_cell_at(from),
                self.geometry.unbounded_cell_at(to),
                |index| clearance.is_obstacle(index),
            ),
            None => regulariser.forget_line(),
        }
        if self.rectangles == regulariser.rectangles() {
            return;
        }
        core::mem::swap(&mut self.rectangles, &mut self.rectangles_before);
        self.rectangles.clear();
        self.rectangles.extend_from_slice(regulariser.rectangles());
        for n in 0..self.rectangles_before.len() {
            let rect = self.rectangles_before[n];
            self.refresh(&rect);
        }
        for n in 0..self.rectangles.len() {
            let rect = self.rectangles[n];
            self.refresh(&rect);
        }
    }

    /// Rectangles that obstacle groups on the way were filled up to.
    #[must_use]
    pub fn rectangles(&self) -> &[CellRect] {
        &self.rectangles
    }

    /// Number of virtual cells on the map: `virtual_total`.
    #[must_use]
    pub fn n_virtual(&self) -> usize {
        self.n_virtual
    }

    /// What scans can be laid on, once it was made.
    #[must_use]
    pub fn surfaces(&self) -> Option<&Surfaces> {
        self.surfaces.as_ref()
    }

    /// Makes what scans can be laid on, at the first call; it is kept up from then on. Where obstacles are from
    /// before, beside the static map, scans are laid on their cells' centres, and soon on where they end.
    pub fn make_surfaces(&mut self) {
        let belief = &self.belief;
        self.surfaces.get_or_insert_with(|| {
            let mut made = Surfaces::new(&self.geometry, |index| belief.is_obstacle(index));
            made.add_cells(|index| !belief.is_near_static(index));
            made
        });
    }

    /// True when something is known of a point of the map: by the static map or a scan.
    #[must_use]
    pub fn is_known(&self, point_in_map: Point2<f64>) -> bool {
        let cell = self.geometry.unbounded_cell_at(point_in_map);
        let index = self.geometry.index_of(cell);
        index.is_some_and(|index| !self.belief.is_unknown(index))
    }

    /// True when a point of the map may be matched against the surfaces: no cell around it is a
    /// candidate. A point on a wall of which only the other end is a surface yet would be pulled
    /// towards that end.
    #[must_use]
    pub fn is_matchable(&self, point_in_map: Point2<f64>) -> bool {
        if self.candidates.is_empty() {
            return true;
        }
        let cell = self.geometry.unbounded_cell_at(point_in_map);
        (-1..=1).all(|dy| {
            (-1..=1).all(|dx| {
                let beside = Cell::new(cell.x.saturating_add(dx), cell.y.saturating_add(dy));
                let index = self.geometry.index_of(beside);
                !index.is_some_and(|index| self.candidates.contains(index))
            })
        })
    }

    /// True when what is seen at a point of the map is an obstacle of the static map.
    #[must_use]
    pub fn is_near_static(&self, point_in_map: Point2<f64>) -> bool {
        let cell = self.geometry.unbounded_cell_at(point_in_map);
        let index = self.geometry.index_of(cell);
        index.is_some_and(|index| self.belief.is_near_static(index))
    }

    /// True for a point in an obstacle of the static map.
    #[must_use]
    pub(crate) fn is_in_static(&self, point_in_map: Point2<f64>) -> bool {
        let cell = self.geometry.unbounded_cell_at(point_in_map);
        let index = self.geometry.index_of(cell);
        index.is_some_and(|index| self.belief.is_static(index))
    }

    /// Brings clearance and cells up to date with the belief.
    fn follow(&mut self, flips: &Flips) {
        for index in &flips.cleared {
            let cell = cell_at(&self.geometry, *index);
            let is_closed = self.zones.closes(*index, &self.geometry);
            self.clearance.set(*index, is_closed);
            self.flipped.add(cell);
            self.cleared.add(cell);
        }
        for index in &flips.marked {
            let cell = cell_at(&self.geometry, *index);
            self.clearance.set(*index, true);
            self.flipped.add(cell);
        }
        if let Some(regulariser) = &mut self.regulariser {
            regulariser.changed(&flips.marked, &flips.cleared);
        }
        self.follow_clearance(&flips.marked);
        for index in &flips.revealed {
            self.refresh_cell(*index, cell_at(&self.geometry, *index));
        }
        if let Some(surfaces) = &mut self.surfaces {
            self.candidates.follow(flips, self.run_ns, surfaces);
        }
    }

    /// Brings clearance and cells up to date where obstacles flipped; `marked` came one by one.
    fn follow_clearance(&mut self, marked: &[usize]) {
        let clear = self.clearance.reach();
        // Where obstacles went first: it looks at obstacles alone, old and new.
        for n in 0..self.cleared.len() {
            let gone = self.cleared.get(n).grown(clear, &self.geometry);
            self.clearance.recompute(&gone);
        }
        for index in marked {
            self.clearance.add(cell_at(&self.geometry, *index));
        }
        let reach = clear.max(self.virtuals.reach());
        for n in 0..self.flipped.len() {
            let changed = self.flipped.get(n).grown(reach, &self.geometry);
            self.refresh(&changed);
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
        let value = self.value_of(index, cell);
        let old = self.cells[index];
        if old != value {
            self.n_virtual += usize::from(value.flags & FLAG_VIRTUAL != 0);
            self.n_virtual -= usize::from(old.flags & FLAG_VIRTUAL != 0);
            self.cells[index] = value;
            self.dirty.add(cell);
        }
    }

    /// Layers are combined by their maximum: what the static map holds stays, whatever scans say.
    #[inline]
    fn value_of(&self, index: usize, cell: Cell) -> MapCell {
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
        let is_obstacle = |index: usize| self.clearance.is_obstacle(index);
        if self.virtuals.is_virtual(&self.geometry, cell, is_obstacle) {
            flags |= FLAG_VIRTUAL;
        }
        if !self.rectangles.is_empty()
            && !is_obstacle(index)
            && self.rectangles.iter().any(|rect| rect.contains(cell))
        {
            flags |= FLAG_REGULARISED;
        }
        let least_cost = match self.zones.mark_of(index) {
            MARK_KEEPOUT => {
                flags |= FLAG_KEEPOUT;
                0
            }
            cost => cost,
        };
        let cost = match known_cost {
            blocked @ (COST_LETHAL | COST_INSCRIBED) => blocked,
            _ if unknown => COST_UNKNOWN,
            cost => cost.max(least_cost),
        };
        MapCell {
            cost,
            flags,
            clearance_mm,
        }
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

    /// The map as a map file holds it: obstacles, free cells, unknown ones.
    #[must_use]
    pub fn as_static_map(&self) -> StaticMap {
        StaticMap::of(&self.view())
    }

    /// How the cost of a cell follows from its clearance.
    #[must_use]
    pub fn cost_model(&self) -> CostModel {
        self.cost_model
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
