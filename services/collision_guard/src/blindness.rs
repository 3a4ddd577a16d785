//! A lidar whose beams come back from nothing where there was something a moment ago.
//!
//! "No return" is what an open field looks like, and what a covered or broken lidar looks like. The
//! guard has no map, but it remembers what the lidar showed in its last good scan: things that are large
//! do not vanish all at once. What is taken away is smaller than [`LARGE_M`], what drives away does so
//! bit by bit, and what is left behind comes near the end of the range first. A sector in which all that
//! should be seen has vanished is blind until something returns there.
//!
//! A lidar that is blind from the beginning, or where all is beyond its range, cannot be told from one
//! that looks at nothing.

use nalgebra::{Isometry2, Point2, Vector2};
use zeronav_casts::Cast;
use zeronav_motion::Twist;
use zeronav_msgs::scan::Scan;

/// Sectors of a scan.
const SECTORS: usize = 12;

/// Beams that are looked at in each sector, at most.
const LOOKS: usize = 12;

/// The same at least: a lidar with fewer tells too little.
const LOOKS_MIN: usize = 3;

/// Hits that are kept: those of a scan, and as many that it does not show any more.
const SEEN_MAX: usize = 2 * SECTORS * LOOKS;

/// Share of the beams looked at in a sector up to which nothing returns there: dust before a covered
/// lens.
const NOTHING_SHARE: f64 = 0.1;

/// Share of the beams looked at in a sector that must have lost something for it to be blind.
const LOST_SHARE: f64 = 0.3;

/// [m] across: what is larger does not vanish at once.
const LARGE_M: f64 = 2.2;

/// Cosine of the angle beside the way up to which a sector shows where the robot drives to.
const TOWARDS: f64 = 0.5;

/// Share of the range up to which a thing must be seen: a little farther it may be out of sight already.
const SURE_SHARE: f64 = 0.9;

/// What the lidar showed, and where it shows nothing of it any more.
#[derive(Debug, Clone)]
pub(crate) struct Blindness {
    /// A few hits of the last good look at each sector. `odom` frame [m]
    seen: Vec<Point2<f64>>,
    spare: Vec<Point2<f64>>,
    /// Of the newest scan, in the order of the beams.
    blind: [bool; SECTORS],
    /// It shows nothing anywhere.
    empty: bool,
    /// Sectors that look to where the robot drives when it goes forward, and backward.
    ahead: [bool; SECTORS],
    behind: [bool; SECTORS],
}

impl Default for Blindness {
    fn default() -> Self {
        Self {
            seen: Vec::with_capacity(SEEN_MAX),
            spare: Vec::with_capacity(SEEN_MAX),
            blind: [false; SECTORS],
            empty: false,
            ahead: [false; SECTORS],
            behind: [false; SECTORS],
        }
    }
}

/// A scan from where its lidar was.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Look<'a> {
    pub(crate) scan: &'a Scan,
    pub(crate) ranges: &'a [f32],
    /// Of the beams, in the laser's frame.
    pub(crate) directions: &'a [Vector2<f64>],
    pub(crate) odom_from_laser: Isometry2<f64>,
    /// [rad] direction of the laser in `base`.
    pub(crate) laser_yaw_rad: f64,
}

impl Look<'_> {
    /// How many beams of each sector are looked at.
    fn looks(&self) -> usize {
        LOOKS.min(self.ranges.len() / SECTORS)
    }

    /// Beam in the middle of a part of a sector.
    fn beam(&self, sector: usize, part: usize) -> usize {
        let looks = self.looks();
        (2 * (sector * looks + part) + 1) * self.ranges.len() / (2 * SECTORS * looks)
    }

    /// Cosine of the angle between a sector's middle and the way ahead.
    fn ahead(&self, sector: usize) -> f64 {
        let middle = (2 * sector + 1) * self.ranges.len() / (2 * SECTORS);
        (self.scan.angle_of(middle) + self.laser_yaw_rad).cos()
    }

    fn hit(&self, beam: usize) -> Option<Point2<f64>> {
        let range_m = *self.ranges.get(beam)?;
        let direction = self.directions.get(beam)?;
        (self.scan.is_hit(range_m))
            .then(|| self.odom_from_laser * Point2::from(direction * f64::from(range_m)))
    }

    /// True when a beam or one beside it returned.
    fn returns(&self, beam: usize) -> bool {
        let beside = beam.saturating_sub(1)..self.ranges.len().min(beam + 2);
        (self.ranges[beside].iter()).any(|range_m| self.scan.is_hit(*range_m))
    }

    /// The sector of a beam.
    const fn sector(&self, beam: usize) -> usize {
        beam * SECTORS / self.ranges.len()
    }

    /// The beam that must show a point; `None` where none must.
    fn beam_of(&self, laser_from_odom: &Isometry2<f64>, point: &Point2<f64>) -> Option<usize> {
        let at = laser_from_odom * point;
        let far_m = at.coords.norm();
        let (near_m, range_m) = (
            f64::from(self.scan.range_m_min),
            f64::from(self.scan.range_m_max),
        );
        if far_m <= near_m || far_m > SURE_SHARE * range_m {
            return None;
        }
        let step_rad = f64::from(self.scan.angle_increment_rad);
        let turned_rad = at.y.atan2(at.x) - f64::from(self.scan.angle_min_rad);
        // Counted the way in which the lidar turns, half a beam before the first one belongs to it.
        let beam = (turned_rad * step_rad.signum() + 0.5 * step_rad.abs())
            .rem_euclid(core::f64::consts::TAU)
            / step_rad.abs();
        let beam = beam.to_usize();
        (beam < self.ranges.len()).then_some(beam)
    }
}

impl Blindness {
    /// Takes in a well-formed scan.
    pub(crate) fn take(&mut self, look: &Look<'_>) {
        self.blind = [false; SECTORS];
        if look.looks() < LOOKS_MIN {
            return;
        }
        let mut empty = [false; SECTORS];
        self.spare.clear();
        for (sector, empty) in empty.iter_mut().enumerate() {
            let before = self.spare.len();
            let parts = 0..look.looks();
            self.spare
                .extend(parts.filter_map(|part| look.hit(look.beam(sector, part))));
            *empty = share(self.spare.len() - before, look.looks()) <= NOTHING_SHARE;
        }
        self.empty = !empty.contains(&false);
        if empty.contains(&true) {
            self.compare(look, empty);
        }
        core::mem::swap(&mut self.seen, &mut self.spare);
    }

    /// Which of the empty sectors should show what was seen before, when that is large. What they should
    /// show stays known.
    fn compare(&mut self, look: &Look<'_>, empty: [bool; SECTORS]) {
        let laser_from_odom = look.odom_from_laser.inverse();
        let lost_at = |point: &Point2<f64>| {
            let sector = look.sector(look.beam_of(&laser_from_odom, point)?);
            empty[sector].then_some(sector)
        };
        let mut lost = [0; SECTORS];
        for sector in self.seen.iter().filter_map(lost_at) {
            lost[sector] += 1;
        }
        let blind = lost.map(|lost| share(lost, look.looks()) >= LOST_SHARE);
        let nowhere = Point2::new(f64::INFINITY, f64::INFINITY);
        let (low, high) = (self.seen.iter().filter(|point| lost_at(point).is_some()))
            .fold((nowhere, -nowhere), |(low, high), point| {
                (low.inf(point), high.sup(point))
            });
        if !blind.contains(&true) || (high - low).norm() < LARGE_M {
            return;
        }
        self.blind = blind;
        for sector in 0..SECTORS {
            let ahead = look.ahead(sector);
            self.ahead[sector] = ahead >= TOWARDS;
            self.behind[sector] = ahead <= -TOWARDS;
        }
        let room = self.spare.capacity() - self.spare.len();
        // Also what a robot that turns covers besides.
        let gone = self.seen.iter().filter(|point| {
            let beam = look.beam_of(&laser_from_odom, point);
            beam.is_some_and(|beam| !look.returns(beam))
        });
        self.spare.extend(gone.take(room));
    }

    /// Forgets what was seen: odometry has jumped, or an input went back in time. A blind lidar stays
    /// blind.
    pub(crate) fn clear(&mut self) {
        if !self.is_total() {
            self.seen.clear();
            self.blind = [false; SECTORS];
        }
    }

    /// True when the lidar shows nothing any more of what it should, or when most of it is blind.
    pub(crate) fn is_total(&self) -> bool {
        let n_blind = self.blind.iter().filter(|blind| **blind).count();
        n_blind > 0 && (self.empty || 2 * n_blind >= SECTORS)
    }

    /// True when the robot cannot see where it would drive to.
    pub(crate) fn is_towards(&self, twist: Twist) -> bool {
        let sectors = if twist.v_mps > 0.0 {
            self.ahead
        } else if twist.v_mps < 0.0 {
            self.behind
        } else {
            return false;
        };
        let mut sectors = self.blind.iter().zip(sectors);
        sectors.any(|(blind, there)| *blind && there)
    }
}

fn share(some: usize, of: usize) -> f64 {
    some.to_f64() / of.to_f64()
}
