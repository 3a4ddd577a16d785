//! Which cells are obstacles, by the static map and by scans, in layers.
//!
//! The *static* layer is the static map and never changes. The *sensed* layer is log-odds, changed
//! at most once per cell and scan; hits on dynamic obstacles do not enter it, so that these leave no
//! trail. Unknown is a state of its own. A cell is an obstacle when either layer says so.
//!
//! The rules are those of Nav2's obstacle layer: a scan clears along all its beams first and marks
//! then; a beam without a return clears, an invalid one does nothing; the robot's footprint clears.
//! What is added against flicker:
//!
//! - Cells that a scan marks are not cleared by another beam of the same scan.
//! - A beam clears only cells that it has left again before it was returned.
//! - A hit counts half a cell behind its measured end, so that noise around the face of an obstacle
//!   falls into the obstacle's own cell: an obstacle marks the cells whose centre it covers.
//! - A cell that touches an obstacle is marked with the second hit only: mostly it is noise, and the
//!   robot's centre cannot be there anyway.
//! - A free cell with a return of fewer than three beams beside each other is marked when every scan of 0.2 s has had
//!   one there, and three at least; more mark a cell in the open at once.
//! - Returns from where beams lie too far apart to tell a surface from an edge mark nothing
//!   (`isolated.rs`).

use crate::beams::End;
use crate::config::MappingConfig;
use crate::flips::Flips;
use crate::free_blocks::FreeBlocks;
use crate::hit_means::BeamEnd;
use crate::isolated::{Evidence, evidence, isolated_hit};
use crate::located_scan::{GridRay, LocatedScan};
use crate::log_odds::LogOdds;
use crate::ray::{Passing, Ray};
use crate::rows_around::rows_around;
use nalgebra::{Point2, Vector2};
use zeronav_msgs::map::{FLAG_SENSED, FLAG_UNKNOWN};
use zeronav_msgs::time::seconds;
use zeronav_msgs::{Cell, GridGeometry, MapCell};
use zeronav_world::{Occupancy, StaticMap};

/// No beam has been here, and the static map does not know the cell.
const UNKNOWN: i16 = i16::MIN;

/// Bit: occupied by the static map.
const STATIC: u8 = 1;
/// Bit: touches an obstacle of the static map.
const BESIDE_STATIC: u8 = 1 << 1;
/// Bit: hit by the current scan.
const HIT: u8 = 1 << 2;
/// Bit: passed by a beam of the current scan.
const PASSED: u8 = 1 << 3;
/// Bit: an obstacle, as told by [`Flips`].
const OBSTACLE: u8 = 1 << 4;
/// Bit: so near to an obstacle of the static map that points there belong to it.
const NEAR_STATIC: u8 = 1 << 5;

/// How far behind its measured end a hit counts. [cells]
const HIT_BEHIND: f64 = 0.5;

/// Slack of the rule that a beam clears only cells it has left, for ranges in `f32`. [cells]
const PASSED_SLACK: f64 = 1.0e-3;

/// Belief in every cell of the map.
#[derive(Debug)]
pub(crate) struct Belief {
    geometry: GridGeometry,
    log_odds: LogOdds,
    obstacle_range_m: f64,
    raytrace_range_m: f64,
    /// The robot's centre cannot be in cells that touch an obstacle.
    blocks_beside: bool,
    odds: Vec<i16>,
    bits: Vec<u8>,
    free_blocks: FreeBlocks,
    /// Scratch: the beams of the scan.
    rays: Vec<GridRay>,
    hits: Vec<usize>,
    /// Of the cells hit, those that are no obstacles and need further hits to become one, beside what is one
    /// already or of few beams.
    beside: Vec<usize>,
    isolated: Vec<usize>,
    /// [ns] run time of the newest scan.
    run_ns: Option<u64>,
    passed: Vec<usize>,
    /// Cells whose layers may have changed.
    touched: Vec<usize>,
    /// Where beams of the last scan ended on what the static map does not hold. [cells]
    ended: Vec<BeamEnd>,
}

impl Belief {
    /// What is known before the first scan. `inscribed_radius_m` is the robot's.
    ///
    /// Hits in cells that touch an obstacle of the static map are taken for hits of that
    /// obstacle, as long as the robot's centre cannot be in such cells anyway: walls that are
    /// mapped would otherwise fill the map with news of half a cell.
    #[must_use]
    pub(crate) fn new(
        geometry: &GridGeometry,
        static_map: Option<&StaticMap>,
        config: &MappingConfig,
        inscribed_radius_m: f64,
    ) -> Self {
        let mut belief = Self {
            obstacle_range_m: config.obstacle_range_m,
            raytrace_range_m: config.raytrace_range_m,
            blocks_beside: inscribed_radius_m
                >= core::f64::consts::FRAC_1_SQRT_2 * geometry.resolution_m,
            ..Self::blank(geometry, config.log_odds)
        };
        for (index, occupancy) in static_map
            .iter()
            .flat_map(|map| map.cells.iter().enumerate())
        {
            if *occupancy != Occupancy::Unknown {
                belief.odds[index] = config.log_odds.min;
            }
            if *occupancy == Occupancy::Occupied {
                belief.bits[index] |= STATIC | OBSTACLE;
                if belief.blocks_beside {
                    belief.mark_beside(index);
                }
            }
        }
        belief.count_open();
        belief
    }

    /// Nothing is known, and beams reach nowhere.
    fn blank(geometry: &GridGeometry, log_odds: LogOdds) -> Self {
        Self {
            geometry: *geometry,
            log_odds,
            obstacle_range_m: 0.0,
            raytrace_range_m: 0.0,
            blocks_beside: false,
            odds: vec![UNKNOWN; geometry.len()],
            bits: vec![0; geometry.len()],
            free_blocks: FreeBlocks::new(geometry),
            rays: Vec::new(),
            hits: Vec::new(),
            beside: Vec::new(),
            isolated: Vec::new(),
            run_ns: None,
            passed: Vec::new(),
            touched: Vec::new(),
            ended: Vec::new(),
        }
    }

    /// The same belief on another grid of the same resolution, `shift` cells from this one's
    /// origin to the other's: what lies on both is kept, the rest of the new one is unknown.
    #[must_use]
    pub(crate) fn moved(&self, geometry: &GridGeometry, shift: Cell) -> Self {
        let mut moved = Self {
            obstacle_range_m: self.obstacle_range_m,
            raytrace_range_m: self.raytrace_range_m,
            blocks_beside: self.blocks_beside,
            run_ns: self.run_ns,
            ..Self::blank(geometry, self.log_odds)
        };
        let (old_width, old_height) = self.geometry.size();
        let (width, height) = geometry.size();
        let columns = shift.x.max(0)..(shift.x + width).min(old_width);
        for y in shift.y.max(0)..(shift.y + height).min(old_height) {
            let (Some(from), Some(to)) = (
                self.geometry.index_of(Cell::new(columns.start, y)),
                geometry.index_of(Cell::new(columns.start - shift.x, y - shift.y)),
            ) else {
                continue;
            };
            let n = columns.len();
            moved.odds[to..to + n].copy_from_slice(&self.odds[from..from + n]);
            for (new, old) in moved.bits[to..].iter_mut().zip(&self.bits[from..from + n]) {
                *new = old & (STATIC | BESIDE_STATIC | NEAR_STATIC);
            }
        }
        for index in 0..moved.bits.len() {
            if moved.bits[index] & STATIC != 0 || moved.is_sensed(index) {
                moved.bits[index] |= OBSTACLE;
            }
        }
        moved.count_open();
        moved
    }

    /// What another mapping has learnt: its cells, on the same grid. Cells that the lidar saw
    /// occupied are believed as much as can be, free ones are free, and unknown ones stay as they are.
    pub(crate) fn learn(&mut self, cells: &[MapCell]) {
        for (index, cell) in cells.iter().enumerate().take(self.odds.len()) {
            if cell.flags & FLAG_SENSED != 0 {
                self.odds[index] = self.log_odds.max;
                self.bits[index] |= OBSTACLE;
            } else if cell.flags & FLAG_UNKNOWN == 0 {
                self.odds[index] = self.log_odds.min;
                if self.bits[index] & STATIC == 0 {
                    self.bits[index] &= !OBSTACLE;
                }
            }
        }
        self.free_blocks = FreeBlocks::new(&self.geometry);
        self.count_open();
    }

    fn count_open(&mut self) {
        for (index, odds) in self.odds.iter().enumerate() {
            if *odds != self.log_odds.min {
                self.free_blocks.add_uncertain(index);
            }
        }
    }

    fn mark_beside(&mut self, index: usize) {
        let width = self.geometry.width as usize;
        for (row, columns) in rows_around(&self.geometry, index) {
            for bits in &mut self.bits[row * width..][columns] {
                *bits |= BESIDE_STATIC;
            }
        }
    }

    /// True when a cell around `index` is an obstacle that scans have put there.
    fn touches_sensed(&self, index: usize) -> bool {
        let width = self.geometry.width as usize;
        rows_around(&self.geometry, index).any(|(row, columns)| {
            let odds = &self.odds[row * width..][columns];
            odds.iter().any(|odds| *odds > self.log_odds.occupied_above)
        })
    }

    /// True when some layer has an obstacle at `index`.
    #[must_use]
    #[inline]
    pub(crate) fn is_obstacle(&self, index: usize) -> bool {
        self.bits[index] & OBSTACLE != 0
    }

    /// True when the static map has an obstacle at `index`.
    #[must_use]
    #[inline]
    pub(crate) fn is_static(&self, index: usize) -> bool {
        self.bits[index] & STATIC != 0
    }

    /// True when scans have put an obstacle at `index`.
    #[must_use]
    #[inline]
    pub(crate) fn is_sensed(&self, index: usize) -> bool {
        self.odds[index] > self.log_odds.occupied_above
    }

    /// Marks `index` as so near to the static map's obstacles that points there belong to them.
    pub(crate) fn set_near_static(&mut self, index: usize) {
        self.bits[index] |= NEAR_STATIC;
    }

    /// True when points at `index` belong to an obstacle of the static map.
    #[must_use]
    pub(crate) fn is_near_static(&self, index: usize) -> bool {
        self.bits[index] & NEAR_STATIC != 0
    }

    /// True when neither the static map nor a scan has said anything about the cell at `index`.
    #[must_use]
    #[inline]
    pub(crate) fn is_unknown(&self, index: usize) -> bool {
        self.odds[index] == UNKNOWN
    }

    /// Takes in a scan and adds what flipped. Nothing when the pose is not finite. `under_robot`
    /// are the cells under the robot, which are free.
    pub(crate) fn integrate(
        &mut self,
        scan: &LocatedScan<'_>,
        under_robot: &[usize],
        flips: &mut Flips,
    ) {
        self.ended.clear();
        let mut rays = core::mem::take(&mut self.rays);
        if !scan.cast_on(&self.geometry, &mut rays) {
            self.rays = rays;
            return;
        }
        for (n, (ray, end, moving)) in rays.iter().enumerate() {
            if let (End::Hit(range_m), false) = (end, *moving) {
                self.note_hit(ray, *range_m, || evidence(scan.beams, n));
            }
        }
        let resolution_m = self.geometry.resolution_m;
        let (width, height) = self.geometry.size();
        for (ray, end, _) in &rays {
            let (End::Hit(until_m) | End::NoReturn(until_m)) = end else {
                continue;
            };
            let until = until_m.min(self.raytrace_range_m) / resolution_m + PASSED_SLACK;
            let mut clearing = Clearing {
                belief: self,
                flips,
            };
            ray.left_cells(width, height, until, &mut clearing);
        }
        self.rays = rays;
        for index in under_robot {
            Clearing {
                belief: self,
                flips,
            }
            .passed(*index);
        }
        let before_ns = self.run_ns.replace(scan.run_ns);
        let since_s = before_ns.map_or(0.0, |ns| seconds(scan.run_ns.saturating_sub(ns)));
        self.mark(since_s, flips);
        self.tell(flips);
        let lists = [
            &mut self.hits,
            &mut self.beside,
            &mut self.isolated,
            &mut self.passed,
        ];
        for index in lists.into_iter().flat_map(|list| list.drain(..)) {
            self.bits[index] &= !(HIT | PASSED);
        }
    }

    /// Forgets the obstacles that scans have put within `radius_m` of a point of the map: the trail
    /// of an obstacle that turned out to move. Adds what flipped.
    pub(crate) fn forget(&mut self, centre: Point2<f64>, radius_m: f64, flips: &mut Flips) {
        let reach = Vector2::new(radius_m, radius_m);
        let (width, height) = self.geometry.size();
        let min = self.geometry.unbounded_cell_at(centre - reach);
        let max = self.geometry.unbounded_cell_at(centre + reach);
        for y in min.y.max(0)..=max.y.min(height - 1) {
            for x in min.x.max(0)..=max.x.min(width - 1) {
                let cell = Cell::new(x, y);
                let near = (self.geometry.centre_of(cell) - centre).norm() <= radius_m;
                if let (Some(index), true) = (self.geometry.index_of(cell), near)
                    && self.is_sensed(index)
                {
                    self.set_odds(index, self.log_odds.min);
                    self.touched.push(index);
                }
            }
        }
        self.tell(flips);
    }

    /// Remembers the cell that a beam was returned from.
    fn note_hit(&mut self, ray: &Ray, range_m: f64, evidence: impl Fn() -> Evidence) {
        if range_m > self.obstacle_range_m {
            return;
        }
        let cells = range_m / self.geometry.resolution_m + HIT_BEHIND;
        let Some(index) = self.geometry.index_of(ray.cell_at(cells)) else {
            return;
        };
        if self.bits[index] & (BESIDE_STATIC | STATIC) != 0 {
            return;
        }
        let end = (ray.at(range_m / self.geometry.resolution_m), -ray.direction);
        if self.bits[index] & HIT != 0 {
            self.note_end(index, end);
            return;
        }
        // An obstacle that is known needs no proof; an unknown cell was never seen to be free.
        let list = if self.is_sensed(index) {
            &mut self.hits
        } else {
            match evidence() {
                Evidence::None => return,
                Evidence::Isolated if self.odds[index] != UNKNOWN => &mut self.isolated,
                _ if self.blocks_beside && self.touches_sensed(index) => &mut self.beside,
                _ => &mut self.hits,
            }
        };
        list.push(index);
        self.bits[index] |= HIT;
        self.note_end(index, end);
    }

    /// Remembers where exactly a beam ended, unless that belongs to the static map.
    fn note_end(&mut self, index: usize, end: BeamEnd) {
        if !self.is_near_static(index) {
            self.ended.push(end);
        }
    }

    /// Where beams of the last scan ended on what the static map does not hold. [cells]
    pub(crate) fn ended(&self) -> &[BeamEnd] {
        &self.ended
    }

    /// Changes a belief, and whether the cell counts as free for its block.
    fn set_odds(&mut self, index: usize, odds: i16) {
        let old = core::mem::replace(&mut self.odds[index], odds);
        let free = self.log_odds.min;
        if old == free && odds != free {
            self.free_blocks.add_uncertain(index);
        } else if old != free && odds == free {
            self.free_blocks.remove_uncertain(index);
        }
    }

    /// Raises the belief in the cells that were hit, `since_s` after the scan before. [s]
    fn mark(&mut self, since_s: f64, flips: &mut Flips) {
        let LogOdds {
            hit,
            min,
            max,
            occupied_above,
            ..
        } = self.log_odds;
        let (hits, beside) = (self.hits.len(), self.hits.len() + self.beside.len());
        let isolated = isolated_hit(occupied_above - min, since_s);
        for n in 0..beside + self.isolated.len() {
            // As far as a doubtful hit leads by itself; it leads to the threshold, and the next one beyond.
            let (index, doubtful) = if n < hits {
                (self.hits[n], None)
            } else if n < beside {
                (self.beside[n - hits], Some(occupied_above - min))
            } else {
                (self.isolated[n - beside], Some(isolated))
            };
            let old = self.odds[index];
            if old == UNKNOWN {
                flips.revealed.push(index);
            }
            let new = match doubtful {
                Some(by) if old < occupied_above => {
                    old.max(min).saturating_add(by).min(occupied_above)
                }
                _ => old.max(min).saturating_add(hit).min(max),
            };
            self.set_odds(index, new);
            if old <= occupied_above && new > occupied_above {
                self.touched.push(index);
            }
        }
    }

    /// Says of the cells that were touched which became obstacles and which are none any more.
    fn tell(&mut self, flips: &mut Flips) {
        for n in 0..self.touched.len() {
            let index = self.touched[n];
            let was = self.is_obstacle(index);
            let is = self.is_static(index) || self.is_sensed(index);
            if is && !was {
                self.bits[index] |= OBSTACLE;
                flips.marked.push(index);
            } else if was && !is {
                self.bits[index] &= !OBSTACLE;
                flips.cleared.push(index);
            }
        }
        self.touched.clear();
    }
}

/// Lowers the belief in the cells that a beam has passed.
struct Clearing<'a> {
    belief: &'a mut Belief,
    flips: &'a mut Flips,
}

impl Passing for Clearing<'_> {
    #[inline]
    fn leaps(&self, x: i32, y: i32) -> bool {
        self.belief.free_blocks.is_free(x, y)
    }

    #[inline]
    fn passed(&mut self, index: usize) {
        let belief = &mut *self.belief;
        let LogOdds { miss, min, .. } = belief.log_odds;
        let old = belief.odds[index];
        // Nearly always: free space that is known to be free.
        if old == min {
            return;
        }
        if belief.bits[index] & (HIT | PASSED) != 0 {
            return;
        }
        belief.bits[index] |= PASSED;
        belief.passed.push(index);
        if old == UNKNOWN {
            belief.set_odds(index, min);
            self.flips.revealed.push(index);
            return;
        }
        let new = old.saturating_add(miss).max(min);
        belief.set_odds(index, new);
        let above = belief.log_odds.occupied_above;
        if old > above && new <= above {
            belief.touched.push(index);
        }
    }
}
