//! Returns that dust or rain gives: what one beam says, and the scans before deny.
//!
//! A thing that stands, and is at least as wide as beams lie apart, has stopped a beam of every scan
//! that looked to where it stands. A hit is dust when the beams beside it did not end near it, fewer than half of the scans
//! shortly before showed anything there, nor the last two, on its way here, what moves evenly, and the beams of
//! the last one went on behind it. Whatever was not looked at (hidden, out of the field of view, no
//! answer) proves nothing, and nothing is dust then.
//!
//! So whatever every scan shows is left out of one when it has just appeared, with more than ten scans per second
//! of two; of two as well when it moves by more than what it is found again by, or odometry is off by as much.

use core::f64::consts::TAU;
use nalgebra::{Isometry2, Point2, Vector2};
use zeronav_casts::Cast;
use zeronav_motion::Twist;
use zeronav_msgs::scan::{BEAMS_MAX, Scan};
use zeronav_msgs::time::seconds;

/// [m] between neighbouring beams at a hit up to which it can be dust: where they lie farther apart a leg
/// may stop a single one.
const APART_M_MAX: f64 = 0.03;

/// [m] within which the ranges of neighbouring beams are of one thing, or of two scans: noise of two ranges and
/// what odometry is off by in two scans.
const SAME_M: f64 = 0.03;

/// What comes to it between neighbouring beams in distances between beams, for surfaces met at an angle.
const BESIDE_BEAMS: f64 = 3.0;

/// [m] to either side of a hit within which at least half of the beams end near it if it is more than a drop, one
/// beam to either side at least and [`SIDE_MAX`] at most.
const SIDE_M: f64 = 0.005;
const SIDE_MAX: i32 = 32;

/// [m] across its beam within which another scan shows the same thing, and what comes to it in distances between
/// beams: so wide is at most what a single beam meets.
const ASIDE_M: f64 = 0.01;
const ASIDE_BEAMS: f64 = 2.0;

/// [s] before a scan in which half of the scans have to show what is there. At least the last two are asked, and
/// at most [`BEFORE_MAX`].
const SHORTLY_S: f64 = 0.22;
pub(crate) const BEFORE_MAX: usize = 8;

/// Speed over ground, by odometry, up to which a thing is found on its even way through three scans: people
/// run, and wheels slip, at less. [m/s]
const FAST_MPS: f64 = 2.0;

/// Hits of the last scan from which one may have come; among more it counts.
const CAME_FROM_MAX: usize = 32;

/// [m] by which a beam has to go on behind a place to have looked through it.
const BEHIND_M: f64 = 0.1;

/// [m] from the lidar within which nobody can tell which beam looked: it passes by too fast.
const NEAR_M: f64 = 0.1;

/// Beams to either side of the one that looked at a place which are asked, too, whether they went on behind it,
/// and how many have to: one may have ended at a drop of its own.
const ASKED_BESIDE: i32 = 1;
const THROUGH_MIN: usize = 2;

/// Looks for the beam that looked somewhere at most, and the change in the last one, in beams, with which it is
/// found. Each look takes the robot's way within one beam for what it is in angles between beams.
const LOOKS: usize = 40;
const SETTLED: f64 = 1.0e-6;

/// Hits of one scan that are compared with all of the scans before; of more, the rest counts.
const COMPARED_MAX: usize = 256;

/// Where the lidar was, and how it turned.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Stance {
    /// At the capture, the time of the last beam.
    pub(crate) odom_from_base: Isometry2<f64>,
    pub(crate) base_from_laser: Isometry2<f64>,
    /// [ns] run time of the capture.
    pub(crate) run_ns: u64,
    /// The robot's while the lidar turned.
    pub(crate) twist: Twist,
}

/// Where another scan shows the same thing, in `odom`.
#[derive(Debug, Clone, Copy)]
struct Same {
    at: Point2<f64>,
    /// Direction of the beam.
    along: Vector2<f64>,
    /// [m] to either side of the beam.
    aside_m: f64,
}

impl Same {
    fn holds(&self, end: &Point2<f64>) -> bool {
        let off = end - self.at;
        off.dot(&self.along).abs() <= SAME_M && off.perp(&self.along).abs() <= self.aside_m
    }
}

/// A scan as it was: what all of its beams say.
#[derive(Debug, Clone, Default)]
pub(crate) struct Looked {
    /// The lidar and its place; `None` = no scan.
    of: Option<(Scan, Stance)>,
    /// As they came, by beam. [m]
    ranges: Vec<f32>,
    /// In `odom`, by beam; not a number where nothing was hit. [m]
    ends: Vec<Point2<f64>>,
    /// Whether the beams to either side of one ended near it, by beam; as [`Self::is_near`].
    beside: Vec<[Option<bool>; 2]>,
    /// Those beside which a beam ended elsewhere: what is thin, and edges.
    thin: Vec<Point2<f64>>,
    /// Angle between beams. [rad]
    step_rad: f64,
    /// The first beam is beside the last one.
    is_round: bool,
}

impl Looked {
    /// Room for any scan.
    pub(crate) fn with_capacity() -> Self {
        Self {
            ranges: Vec::with_capacity(BEAMS_MAX),
            ends: Vec::with_capacity(BEAMS_MAX),
            beside: Vec::with_capacity(BEAMS_MAX),
            thin: Vec::with_capacity(BEAMS_MAX),
            ..Self::default()
        }
    }

    /// Nothing was looked at.
    pub(crate) fn clear(&mut self) {
        self.of = None;
        self.ranges.clear();
        self.ends.clear();
        self.beside.clear();
        self.thin.clear();
    }

    /// From now on tells nothing of what other scans show.
    pub(crate) fn distrust(&mut self) {
        self.of = None;
    }

    /// Begins with a scan; the beams' ends follow with [`Self::push`], in their order, then [`Self::end`].
    pub(crate) fn begin(&mut self, scan: &Scan, ranges: &[f32], stance: Stance) {
        self.clear();
        self.of = Some((*scan, stance));
        self.step_rad = f64::from(scan.angle_increment_rad).abs();
        self.ranges
            .extend_from_slice(&ranges[..ranges.len().min(BEAMS_MAX)]);
    }

    /// Where the next beam ended in `odom`; `None` = it hit nothing.
    pub(crate) fn push(&mut self, end: Option<Point2<f64>>) {
        let nowhere = Point2::new(f64::NAN, f64::NAN);
        self.ends.push(end.unwrap_or(nowhere));
    }

    /// All beams are there.
    pub(crate) fn end(&mut self) {
        let beams_rad = self.ends.len().to_f64() * self.step_rad;
        self.is_round = (beams_rad - TAU).abs() < self.step_rad;
        let n = self.ends.len();
        // Neighbouring beams are compared once. Not a number = one of them hit nothing.
        let apart = |one: usize, other: usize| (self.ends[other] - self.ends[one]).norm_squared();
        let wraps = self.is_round && n > 1;
        let ends_meet = if wraps { apart(n - 1, 0) } else { f64::NAN };
        let mut squared_before = ends_meet;
        for beam in 0..n {
            let is_last = beam + 1 == n;
            let squared_after = if is_last {
                ends_meet
            } else {
                apart(beam, beam + 1)
            };
            let answered = |is_outside: bool, other: usize| {
                (!is_outside || wraps) && self.ranges.get(other).is_some_and(|m| !m.is_nan())
            };
            let within_m = SAME_M + BESIDE_BEAMS * self.apart_m(beam);
            let is_near = |squared: f64| squared <= within_m * within_m;
            let (before, after) = ((beam + n - 1) % n, (beam + 1) % n);
            let beside = [
                answered(beam == 0, before).then(|| is_near(squared_before)),
                answered(is_last, after).then(|| is_near(squared_after)),
            ];
            self.beside.push(beside);
            if beside != [Some(true); 2] && self.ends[beam].x.is_finite() {
                self.thin.push(self.ends[beam]);
            }
            squared_before = squared_after;
        }
    }

    /// Where a beam ended in `odom`, if it hit anything. [m]
    pub(crate) fn hit(&self, beam: usize) -> Option<Point2<f64>> {
        let end = self.ends.get(beam).copied()?;
        end.x.is_finite().then_some(end)
    }

    /// True when the hit of this beam is dust to the scans before, the last one first. `compared` counts the hits
    /// of this scan that took long.
    pub(crate) fn is_dust(
        &self,
        beam: usize,
        before: &[&Self; BEFORE_MAX],
        compared: &mut usize,
    ) -> bool {
        let [last, earlier, ..] = *before;
        let Some(at) = self.hit(beam) else {
            return false;
        };
        let apart_m = self.apart_m(beam);
        if apart_m > APART_M_MAX
            || !self.is_alone(beam, apart_m)
            || earlier.of.is_none()
            || !last.looked_through(at)
            || *compared >= COMPARED_MAX
        {
            return false;
        }
        *compared += 1;
        let Some(same) = self.same_as(at, apart_m) else {
            return false;
        };
        let is_shortly = |other: &&Self| (self.after_s(other)).is_some_and(|s| s <= SHORTLY_S);
        let asked = before.iter().copied().take_while(is_shortly).count().max(2);
        let shown = before[..asked].iter().filter(|other| other.shows(&same));
        2 * shown.count() < asked && !self.came_evenly(&same, (last, earlier))
    }

    /// Where another scan shows the same thing as the beam that ended here.
    fn same_as(&self, at: Point2<f64>, apart_m: f64) -> Option<Same> {
        let (_, stance) = self.of.as_ref()?;
        let laser = stance.odom_from_base * stance.base_from_laser * Point2::origin();
        let along = (at - laser).try_normalize(0.0)?;
        let aside_m = ASIDE_M + ASIDE_BEAMS * apart_m;
        Some(Same { at, along, aside_m })
    }

    /// Distance between neighbouring beams at the range of this one. [m]
    fn apart_m(&self, beam: usize) -> f64 {
        f64::from(self.ranges.get(beam).copied().unwrap_or(f32::NAN)) * self.step_rad
    }

    /// True when fewer than half of the beams close beside this one ended near it.
    fn is_alone(&self, beam: usize, apart_m: f64) -> bool {
        // Mostly it is one to either side.
        if SIDE_M < 2.0 * apart_m {
            return self.beside[beam] == [Some(false); 2];
        }
        let side = rounded((SIDE_M / apart_m).floor()).clamp(1, SIDE_MAX);
        let beside = (1..=side).flat_map(|offset| [-offset, offset]);
        // No answer proves nothing.
        let near = beside.filter(|offset| self.is_near(beam, *offset) != Some(false));
        i32::try_from(near.count()).is_ok_and(|near| near < side)
    }

    /// Whether the beam so many beside this one ended near it; `None` = no answer.
    fn is_near(&self, beam: usize, offset: i32) -> Option<bool> {
        let other = self.index(i32::try_from(beam).ok()?.checked_add(offset)?)?;
        let within_m = SAME_M + BESIDE_BEAMS * self.apart_m(beam);
        let answered = !self.ranges.get(other)?.is_nan();
        // Not a number = it hit nothing.
        answered.then(|| (self.ends[other] - self.ends[beam]).norm_squared() <= within_m * within_m)
    }

    /// True when beams that looked to a place in `odom` went on behind it.
    fn looked_through(&self, place: Point2<f64>) -> bool {
        let (Some((scan, stance)), Some((beam, range_m))) = (&self.of, self.seen_from(place))
        else {
            return false;
        };
        if range_m < NEAR_M.max(f64::from(scan.range_m_min)) {
            return false;
        }
        let nearest = rounded(beam);
        let asked = nearest - ASKED_BESIDE..=nearest + ASKED_BESIDE;
        // Where a lidar that turns with the robot ends its turn it has not begun it.
        let n_beams = i32::try_from(self.ends.len()).unwrap_or(0);
        let is_whole = *asked.start() >= 0 && *asked.end() < n_beams;
        if !is_whole && stance.twist != Twist::REST && scan.time_increment_s > 0.0 {
            return false;
        }
        let through = asked.filter(|beam| {
            let index = self.index(*beam);
            index.is_some_and(|index| f64::from(self.ranges[index]) > range_m + BEHIND_M)
        });
        through.count() >= THROUGH_MIN
    }

    /// True when the scans before show what moves evenly, and is here now: its velocity may have changed by
    /// 0.3 m/s from scan to scan, with ten scans per second.
    fn came_evenly(&self, here: &Same, (last, earlier): (&Self, &Self)) -> bool {
        let (Some(since_s), Some(before_s)) = (self.after_s(last), last.after_s(earlier)) else {
            return true;
        };
        let within_m = FAST_MPS * since_s + SAME_M;
        let within = |was: &&Point2<f64>| (here.at - **was).norm_squared() <= within_m * within_m;
        let came_from = last.thin.iter().filter(within);
        came_from.enumerate().any(|(n, was)| {
            let first = was - (here.at - was) * (before_s / since_s);
            let there = Same { at: first, ..*here };
            n >= CAME_FROM_MAX || earlier.thin.iter().any(|end| there.holds(end))
        })
    }

    /// Time since another scan [s]; `None` when that is none.
    fn after_s(&self, other: &Self) -> Option<f64> {
        let captured_ns = |of: &Self| of.of.map(|(_, stance)| stance.run_ns);
        let since_ns = captured_ns(self)?.checked_sub(captured_ns(other)?)?;
        (since_ns > 0).then(|| seconds(since_ns))
    }

    /// True when a beam ended at the same place.
    fn shows(&self, same: &Same) -> bool {
        self.ends.iter().any(|end| same.holds(end))
    }

    /// The beam, counted in parts, that looked towards a place in `odom`, and its distance from there. [m]
    /// `None` when that cannot be told.
    fn seen_from(&self, place: Point2<f64>) -> Option<(f64, f64)> {
        let (scan, stance) = self.of.as_ref()?;
        let step_rad = f64::from(scan.angle_increment_rad);
        let last = f64::from(scan.n_beams.saturating_sub(1));
        let beam_s = f64::from(scan.time_increment_s);
        let mut beam = last;
        // The lidar turns with the robot: which beam it was tells when, and when tells which.
        for _ in 0..LOOKS {
            let moved = stance.twist.arc((beam - last) * beam_s).isometry();
            let odom_from_laser = stance.odom_from_base * moved * stance.base_from_laser;
            let in_laser = odom_from_laser.inverse_transform_point(&place);
            let angle_rad = in_laser.y.atan2(in_laser.x) - f64::from(scan.angle_min_rad);
            let turns = if step_rad < 0.0 {
                -angle_rad
            } else {
                angle_rad
            };
            let next = turns.rem_euclid(TAU) / step_rad.abs();
            if (next - beam).abs() < SETTLED {
                return Some((next, in_laser.coords.norm()));
            }
            beam = next;
        }
        None
    }

    /// The beam of this number; around the circle where the lidar sees all around.
    fn index(&self, beam: i32) -> Option<usize> {
        let n = i32::try_from(self.ends.len()).ok()?;
        let is_beside = !(0..n).contains(&beam);
        let beam = if is_beside && self.is_round && n > 0 {
            beam.rem_euclid(n)
        } else {
            beam
        };
        usize::try_from(beam).ok().filter(|_| beam < n)
    }
}

/// Beams of any scan and a few beside.
fn rounded(beam: f64) -> i32 {
    beam.round().clamp(-1.0e6, 1.0e6).to_i32()
}
