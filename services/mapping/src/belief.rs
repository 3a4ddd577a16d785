//! What scans say about the cells: log-odds, changed at most once per cell and scan.
//!
//! The rules are those of Nav2's obstacle layer where they are sound: a scan clears along all its
//! beams first and marks then; a beam without a return clears, an invalid one does nothing. Where
//! they flicker, they are sharpened: what a scan marks no other beam of the same scan clears; a
//! beam clears only cells that it has left again before it was returned; a hit counts half a cell
//! behind where it was measured, so that noise around the face of an obstacle falls into the
//! obstacle's own cell, and an obstacle marks the cells whose centre it covers; and a cell that
//! touches an obstacle becomes one only with the second hit, because the robot's centre cannot be
//! there anyway and it is mostly noise. What appears in the open is marked at once.

use crate::config::{LogOdds, MappingConfig};
use crate::ray::Ray;
use nalgebra::Vector2;
use zeronav_msgs::scan::Scan;
use zeronav_msgs::{GridGeometry, Pose};
use zeronav_world::{Occupancy, StaticMap};

/// No beam has been here, and the static map does not know the cell.
const UNKNOWN: i16 = i16::MIN;

/// Bit: occupied by the static map.
const STATIC: u8 = 1;
/// Bit: touches an obstacle of the static map.
const BESIDE_STATIC: u8 = 1 << 1;
/// Bit: hit by the scan at hand.
const HIT: u8 = 1 << 2;
/// Bit: passed by a beam of the scan at hand.
const PASSED: u8 = 1 << 3;

/// How far behind its measured end a hit counts. [cells]
const HIT_BEHIND: f64 = 0.5;

/// How much earlier than it left a cell a beam may have been returned and still clear it, against
/// ranges rounded to single precision. [cells]
const PASSED_SLACK: f64 = 1.0e-3;

/// What a scan changed. Row-major indices; reused.
#[derive(Debug, Default)]
pub struct Flips {
    /// Cells that became obstacles.
    pub marked: Vec<usize>,
    /// Cells that are obstacles no longer.
    pub cleared: Vec<usize>,
    /// Cells seen for the first time.
    pub revealed: Vec<usize>,
}

/// Belief in every cell of the map.
#[derive(Debug)]
pub struct Belief {
    geometry: GridGeometry,
    log_odds: LogOdds,
    obstacle_range_m: f64,
    raytrace_range_m: f64,
    /// The robot's centre cannot be in cells that touch an obstacle.
    blocks_beside: bool,
    odds: Vec<i16>,
    bits: Vec<u8>,
    hits: Vec<usize>,
    /// Of the cells hit, those that touch an obstacle of earlier scans and are none.
    doubtful: Vec<usize>,
    passed: Vec<usize>,
}

impl Belief {
    /// What is known before the first scan. `inscribed_radius_m` is the robot's.
    ///
    /// Hits in cells that touch an obstacle of the static map are taken for hits of that
    /// obstacle, as long as the robot's centre cannot be in such cells anyway: walls that are
    /// mapped would otherwise fill the map with news of half a cell.
    #[must_use]
    pub fn new(
        geometry: &GridGeometry,
        static_map: Option<&StaticMap>,
        config: &MappingConfig,
        inscribed_radius_m: f64,
    ) -> Self {
        let mut belief = Self {
            geometry: *geometry,
            log_odds: config.log_odds,
            obstacle_range_m: config.obstacle_range_m,
            raytrace_range_m: config.raytrace_range_m,
            odds: vec![UNKNOWN; geometry.len()],
            bits: vec![0; geometry.len()],
            blocks_beside: inscribed_radius_m
                >= core::f64::consts::FRAC_1_SQRT_2 * geometry.resolution_m,
            hits: Vec::new(),
            doubtful: Vec::new(),
            passed: Vec::new(),
        };
        for (index, occupancy) in static_map
            .iter()
            .flat_map(|map| map.cells.iter().enumerate())
        {
            if *occupancy != Occupancy::Unknown {
                belief.odds[index] = config.log_odds.min;
            }
            if *occupancy == Occupancy::Occupied {
                belief.bits[index] |= STATIC;
                if belief.blocks_beside {
                    belief.mark_beside(index);
                }
            }
        }
        belief
    }

    fn mark_beside(&mut self, index: usize) {
        let width = self.geometry.width as usize;
        for (row, columns) in around(&self.geometry, index) {
            for bits in &mut self.bits[row * width..][columns] {
                *bits |= BESIDE_STATIC;
            }
        }
    }

    /// True when a cell around `index` is an obstacle that scans have put there.
    fn touches_sensed(&self, index: usize) -> bool {
        let width = self.geometry.width as usize;
        around(&self.geometry, index).any(|(row, columns)| {
            let odds = &self.odds[row * width..][columns];
            odds.iter().any(|odds| *odds > self.log_odds.occupied_above)
        })
    }

    /// True when the static map has an obstacle at `index`.
    #[must_use]
    pub fn is_static(&self, index: usize) -> bool {
        self.bits[index] & STATIC != 0
    }

    /// True when scans have put an obstacle at `index`.
    #[must_use]
    pub fn is_sensed(&self, index: usize) -> bool {
        self.odds[index] > self.log_odds.occupied_above
    }

    /// True when neither the static map nor a scan has said anything about the cell at `index`.
    #[must_use]
    pub fn is_unknown(&self, index: usize) -> bool {
        self.odds[index] == UNKNOWN
    }

    /// Takes in a scan and writes what flipped. Nothing when the pose is not finite.
    pub fn integrate(
        &mut self,
        map_from_laser: &Pose,
        scan: &Scan,
        ranges: &[f32],
        flips: &mut Flips,
    ) {
        flips.marked.clear();
        flips.cleared.clear();
        flips.revealed.clear();
        let resolution_m = self.geometry.resolution_m;
        let origin = nalgebra::Point2::new(
            (map_from_laser.x_m - self.geometry.origin_x_m) / resolution_m,
            (map_from_laser.y_m - self.geometry.origin_y_m) / resolution_m,
        );
        if !(origin.x + origin.y + map_from_laser.yaw_rad).is_finite() {
            return;
        }
        let beams = || {
            ranges.iter().enumerate().filter_map(|(n, range_m)| {
                let end = End::of(scan, *range_m)?;
                let (sin, cos) = (map_from_laser.yaw_rad + scan.angle_of(n)).sin_cos();
                let direction = Vector2::new(cos, sin);
                Some((Ray { origin, direction }, end))
            })
        };
        for (ray, end) in beams() {
            self.note_hit(&ray, end);
        }
        for (ray, end) in beams() {
            let until_m = end.until_m(scan).min(self.raytrace_range_m);
            self.pass(&ray, until_m / resolution_m + PASSED_SLACK, flips);
        }
        self.mark(flips);
        let lists = [&mut self.hits, &mut self.doubtful, &mut self.passed];
        for index in lists.into_iter().flat_map(|list| list.drain(..)) {
            self.bits[index] &= !(HIT | PASSED);
        }
    }

    /// Remembers the cell that a beam was returned from.
    fn note_hit(&mut self, ray: &Ray, end: End) {
        let End::Hit(range_m) = end else {
            return;
        };
        if range_m > self.obstacle_range_m {
            return;
        }
        let cells = range_m / self.geometry.resolution_m + HIT_BEHIND;
        let Some(index) = self.index_at(ray, cells) else {
            return;
        };
        if self.bits[index] & (HIT | BESIDE_STATIC | STATIC) != 0 {
            return;
        }
        self.bits[index] |= HIT;
        if self.blocks_beside && !self.is_sensed(index) && self.touches_sensed(index) {
            self.doubtful.push(index);
        } else {
            self.hits.push(index);
        }
    }

    #[allow(
        clippy::cast_possible_truncation,
        reason = "float to int saturates, far outside is outside"
    )]
    fn index_at(&self, ray: &Ray, cells: f64) -> Option<usize> {
        let at = ray.origin + ray.direction * cells;
        let cell = zeronav_msgs::Cell::new(at.x.floor() as i32, at.y.floor() as i32);
        self.geometry.index_of(cell)
    }

    /// Lowers the belief in the cells that a beam has passed.
    fn pass(&mut self, ray: &Ray, until: f64, flips: &mut Flips) {
        let LogOdds {
            miss,
            min,
            occupied_above,
            ..
        } = self.log_odds;
        let (width, height) = self.geometry.size();
        let (odds, bits, passed) = (&mut self.odds, &mut self.bits, &mut self.passed);
        ray.left_cells(width, height, until, |index| {
            let old = odds[index];
            // Nearly always: free space that is known to be free.
            if old == min || bits[index] & (HIT | PASSED) != 0 {
                return;
            }
            bits[index] |= PASSED;
            passed.push(index);
            if old == UNKNOWN {
                odds[index] = min;
                flips.revealed.push(index);
                return;
            }
            let new = old.saturating_add(miss).max(min);
            odds[index] = new;
            if old > occupied_above && new <= occupied_above {
                flips.cleared.push(index);
            }
        });
    }

    /// Raises the belief in the cells that were hit.
    fn mark(&mut self, flips: &mut Flips) {
        let LogOdds {
            hit,
            min,
            max,
            occupied_above,
            ..
        } = self.log_odds;
        let doubtful = self.doubtful.iter().map(|index| (*index, true));
        for (index, doubt) in self.hits.iter().map(|n| (*n, false)).chain(doubtful) {
            let old = self.odds[index];
            if old == UNKNOWN {
                flips.revealed.push(index);
            }
            let new = if doubt && old <= min {
                occupied_above
            } else {
                old.max(min).saturating_add(hit).min(max)
            };
            self.odds[index] = new;
            if old <= occupied_above && new > occupied_above {
                flips.marked.push(index);
            }
        }
    }
}

/// The rows around a cell, itself included, each with its columns, cut to the map.
fn around(
    geometry: &GridGeometry,
    index: usize,
) -> impl Iterator<Item = (usize, core::ops::Range<usize>)> + use<> {
    let (width, height) = (geometry.width as usize, geometry.height as usize);
    let (x, y) = (index % width, index / width);
    let columns = x.saturating_sub(1)..(x + 2).min(width);
    (y.saturating_sub(1)..(y + 2).min(height)).map(move |row| (row, columns.clone()))
}

/// How a beam ended.
#[derive(Debug, Clone, Copy)]
enum End {
    /// Returned from here. [m]
    Hit(f64),
    /// Nothing within the sensor's range.
    NoReturn,
}

impl End {
    /// `None` for beams that say nothing: NaN, and numbers outside the sensor's range.
    fn of(scan: &Scan, range_m: f32) -> Option<Self> {
        if range_m == f32::INFINITY {
            Some(Self::NoReturn)
        } else {
            scan.is_hit(range_m).then(|| Self::Hit(f64::from(range_m)))
        }
    }

    fn until_m(self, scan: &Scan) -> f64 {
        match self {
            Self::Hit(range_m) => range_m,
            Self::NoReturn => f64::from(scan.range_m_max),
        }
    }
}
