//! Scans of the last second: what could be looked through then.

use crate::beams::Sweep;
use core::f64::consts::TAU;
use nalgebra::Point2;
use std::collections::VecDeque;
use zeronav_casts::Cast;
use zeronav_msgs::Pose;
use zeronav_msgs::scan::Scan;

/// Scans that are kept.
const SCANS_MAX: usize = 12;

/// Least time between them, but for the newest: fast lidars would fill the memory with the last
/// moment, in which no obstacle gets far. [ns]
const APART_NS: u64 = 90_000_000;

/// Beams on either side of a point that must pass it at least: a beam that slips past an edge
/// proves nothing.
const BESIDE_MIN: i64 = 1;

/// How often the beam towards a point is looked for from where the laser was at the beam of the look before:
/// a laser turns much slower than its beams do.
const LOOKS: usize = 3;

/// One scan as it was seen.
#[derive(Debug, Clone)]
pub(crate) struct PastScan {
    /// Where the laser was, in the map.
    sweep: Sweep,
    run_ns: u64,
    scan: Scan,
    ranges: Vec<f32>,
}

impl PastScan {
    /// Run time of its capture. [ns]
    #[must_use]
    pub(crate) fn run_ns(&self) -> u64 {
        self.run_ns
    }

    /// True when all its beams within `margin_m` beside a point of the map passed it by at least
    /// `margin_m`: where the pose is off by a little, static obstacles are never looked through, however
    /// thin. False when the point lay beside its field of view, and for beams that say nothing.
    #[must_use]
    pub(crate) fn sees_through(&self, point_in_map: Point2<f64>, margin_m: f64) -> bool {
        let (beam, range_m) = self.towards(point_in_map);
        let beside = self.beams_within(margin_m, range_m);
        (beam - beside..=beam + beside).all(|beam| match self.range_of(beam) {
            Some(f32::INFINITY) => range_m + margin_m <= f64::from(self.scan.range_m_max),
            Some(seen) => self.scan.is_hit(seen) && f64::from(seen) > range_m + margin_m,
            None => false,
        })
    }

    /// True when it says nothing of a point of the map: something at least `margin_m` nearer is in the
    /// way, it is out of range, or no beam looks there.
    #[must_use]
    pub(crate) fn is_hidden(&self, point_in_map: Point2<f64>, margin_m: f64) -> bool {
        let (beam, range_m) = self.towards(point_in_map);
        let nearer = |seen: f32| self.scan.is_hit(seen) && f64::from(seen) < range_m - margin_m;
        range_m > f64::from(self.scan.range_m_max) || self.range_of(beam).is_none_or(nearer)
    }

    /// True when its beam towards a point of the map ended there, by at most `margin_m` off.
    #[must_use]
    pub(crate) fn ended_at(&self, point_in_map: Point2<f64>, margin_m: f64) -> bool {
        let (beam, range_m) = self.towards(point_in_map);
        self.range_of(beam)
            .is_some_and(|seen| (f64::from(seen) - range_m).abs() <= margin_m)
    }

    /// How many beams on either side are within `margin_m` at `range_m`.
    fn beams_within(&self, margin_m: f64, range_m: f64) -> i64 {
        let spread_m = range_m * f64::from(self.scan.angle_increment_rad).abs();
        let beside = (margin_m / spread_m).ceil().to_i64();
        beside.clamp(BESIDE_MIN, self.ranges.len().to_i64())
    }

    /// The beam that looks nearest to a point of the map, perhaps none of the scan's, and how far
    /// the point is. [m]
    fn towards(&self, point_in_map: Point2<f64>) -> (i64, f64) {
        let (mut beam, mut range_m) = self.towards_from(&self.sweep.last, point_in_map);
        if self.sweep.first != self.sweep.last {
            let steps = self.ranges.len().saturating_sub(1).max(1).to_f64();
            for _ in 0..LOOKS {
                let share = (beam / steps).min(1.0);
                (beam, range_m) = self.towards_from(&self.sweep.at(share), point_in_map);
            }
        }
        (beam.to_i64(), range_m)
    }

    /// The same for a laser that stands at `map_from_laser`.
    fn towards_from(&self, map_from_laser: &Pose, point_in_map: Point2<f64>) -> (f64, f64) {
        let offset = point_in_map - map_from_laser.point();
        let increment = f64::from(self.scan.angle_increment_rad);
        let angle = offset.y.atan2(offset.x) - map_from_laser.yaw_rad;
        // Going the way the lidar turns.
        let from_first = (angle - f64::from(self.scan.angle_min_rad)) * increment.signum();
        let beam = (from_first.rem_euclid(TAU) / increment.abs()).round();
        (beam, offset.norm())
    }

    /// Range of a beam; a full turn goes on where it began. `None` beside the field of view. [m]
    fn range_of(&self, beam: i64) -> Option<f32> {
        let n_beams = self.ranges.len().to_i64();
        let per_turn = (TAU / f64::from(self.scan.angle_increment_rad).abs())
            .round()
            .to_i64();
        let beam = if n_beams >= per_turn {
            beam.rem_euclid(n_beams.max(1))
        } else {
            beam
        };
        let beam = usize::try_from(beam).ok()?;
        self.ranges.get(beam).copied()
    }
}

/// The last scans, oldest first. Memory is reused.
#[derive(Debug, Default)]
pub(crate) struct PastScans {
    scans: VecDeque<PastScan>,
}

impl PastScans {
    /// Adds a scan that was taken along `sweep` through the map at run time `run_ns`.
    pub(crate) fn push(&mut self, scan: &Scan, ranges: &[f32], sweep: &Sweep, run_ns: u64) {
        // The newest one always, in place of the one before when that followed too soon.
        let mut latest = self.scans.iter().rev().map(PastScan::run_ns);
        let too_soon = latest
            .next()
            .zip(latest.next())
            .is_some_and(|(last_ns, before_ns)| last_ns.saturating_sub(before_ns) < APART_NS);
        let spare = if too_soon {
            self.scans.pop_back()
        } else if self.scans.len() == SCANS_MAX {
            self.scans.pop_front()
        } else {
            None
        };
        let mut memory = spare.map(|past| past.ranges).unwrap_or_default();
        memory.clear();
        memory.extend_from_slice(ranges);
        self.scans.push_back(PastScan {
            sweep: *sweep,
            run_ns,
            scan: *scan,
            ranges: memory,
        });
    }

    /// True when one of them saw through a point of the map, see [`PastScan::sees_through`].
    #[must_use]
    pub(crate) fn saw_through(&self, point_in_map: Point2<f64>, margin_m: f64) -> bool {
        let mut scans = self.scans.iter();
        scans.any(|past| past.sees_through(point_in_map, margin_m))
    }

    /// The newest scan.
    #[must_use]
    pub(crate) fn newest(&self) -> Option<&PastScan> {
        self.scans.back()
    }

    /// The oldest scan that is not older than `run_ns`.
    #[must_use]
    pub(crate) fn oldest_since(&self, run_ns: u64) -> Option<&PastScan> {
        self.scans.iter().find(|past| past.run_ns >= run_ns)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn past(n_beams: u32, angle_min_rad: f32, increment_rad: f32, ranges: &[f32]) -> PastScan {
        let scan = Scan {
            n_beams,
            angle_min_rad,
            angle_increment_rad: increment_rad,
            range_m_min: 0.1,
            range_m_max: 10.0,
            ..Scan::default()
        };
        let mut scans = PastScans::default();
        scans.push(&scan, ranges, &Sweep::still(Pose::new(1.0, 2.0, 0.5)), 7);
        scans.newest().expect("a scan").clone()
    }

    #[test]
    fn through_what_is_farther_and_never_through_what_is_nearer() {
        let mut ranges = vec![5.0_f32; 360];
        ranges[90] = f32::NAN;
        ranges[200] = f32::INFINITY;
        ranges[199] = f32::INFINITY;
        ranges[201] = f32::INFINITY;
        for way in [1.0_f32, -1.0] {
            let increment = way * std::f32::consts::TAU / 360.0;
            let past = past(360, 0.3, increment, &ranges);
            let see = |beam: f64, range_m: f64| {
                let angle = 0.5 + 0.3 + f64::from(way) * beam.to_radians();
                let point = Point2::new(1.0 + range_m * angle.cos(), 2.0 + range_m * angle.sin());
                past.sees_through(point, 0.1)
            };
            assert!(see(10.0, 4.8) && see(359.0, 4.8) && see(0.0, 4.8));
            assert!(!see(10.0, 4.95) && !see(10.0, 6.0));
            // 10 cm at 1 m are six beams.
            assert!(!see(90.0, 1.0) && !see(96.0, 1.0) && see(97.0, 1.0));
            let ended = |range_m: f64| {
                let angle = 0.5 + 0.3 + f64::from(way) * 10.0_f64.to_radians();
                let point = Point2::new(1.0 + range_m * angle.cos(), 2.0 + range_m * angle.sin());
                past.ended_at(point, 0.1)
            };
            assert!(ended(5.05) && ended(4.95) && !ended(4.8) && !ended(5.2));
            assert!(see(200.0, 9.8) && !see(200.0, 9.95) && !see(199.0, 6.0));
        }
    }

    #[test]
    fn hidden_is_what_lies_behind_out_of_range_or_beside_the_view() {
        let past = past(100, -0.5, 0.01, &[5.0; 100]);
        let hidden = |angle: f64, range_m: f64| {
            let angle = 0.5 + angle;
            let at = Point2::new(1.0 + range_m * angle.cos(), 2.0 + range_m * angle.sin());
            past.is_hidden(at, 0.4)
        };
        assert!(!hidden(0.0, 4.0) && !hidden(0.0, 5.3) && hidden(0.0, 5.5));
        assert!(!hidden(0.48, 4.0) && hidden(0.6, 4.0) && hidden(3.0, 4.0));
        assert!(hidden(0.0, 10.5));
    }

    #[test]
    fn a_thin_post_is_not_looked_through_from_beside_itself() {
        // 3 m away, one beam of a quarter of a degree wide.
        let mut ranges = vec![5.0_f32; 400];
        ranges[200] = 3.0;
        let increment = 0.25_f32.to_radians();
        let past = past(400, 0.0, increment, &ranges);
        let angle = 0.5 + f64::from(increment) * 200.0;
        let beside = |off_m: f64| {
            let angle = angle + off_m / 3.0;
            Point2::new(1.0 + 3.0 * angle.cos(), 2.0 + 3.0 * angle.sin())
        };
        for off_m in [0.0, 0.05, -0.09] {
            assert!(!past.sees_through(beside(off_m), 0.1), "{off_m}");
        }
        assert!(past.sees_through(beside(0.13), 0.1));
    }

    #[test]
    fn beside_the_field_of_view_nothing_is_seen() {
        let past = past(100, -0.5, 0.01, &[5.0; 100]);
        let at = |angle: f64| Point2::new(1.0 + (0.5 + angle).cos(), 2.0 + (0.5 + angle).sin());
        assert!(past.sees_through(at(0.0), 0.1) && past.sees_through(at(0.37), 0.1));
        // What lies right beside the edge is not known to be free all around.
        assert!(!past.sees_through(at(0.45), 0.1));
        assert!(!past.sees_through(at(0.6), 0.1) && !past.sees_through(at(-0.6), 0.1));
        assert!(!past.sees_through(at(3.0), 0.1));
    }

    /// A laser that turns by 0.4 rad while it takes its scan, in front of a wall along x = 4.
    #[test]
    fn a_wall_is_not_looked_through_because_the_robot_turned_meanwhile() {
        let n_beams = 360_u16;
        let scan = Scan {
            n_beams: u32::from(n_beams),
            angle_min_rad: -std::f32::consts::PI,
            angle_increment_rad: std::f32::consts::TAU / f32::from(n_beams),
            range_m_min: 0.1,
            range_m_max: 10.0,
            ..Scan::default()
        };
        let sweep = Sweep {
            first: Pose::new(1.0, 2.0, 0.1),
            last: Pose::new(1.1, 2.0, 0.5),
        };
        let ranges: Vec<f32> = (0..n_beams)
            .map(|beam| {
                let from = sweep.at(f64::from(beam) / f64::from(n_beams - 1));
                let cos = (from.yaw_rad + scan.angle_of(usize::from(beam))).cos();
                let range_m = ((4.0 - from.x_m) / cos).to_f32();
                if cos > 0.0 && range_m < scan.range_m_max {
                    range_m
                } else {
                    f32::INFINITY
                }
            })
            .collect();
        let seen_along = |sweep: &Sweep| {
            let mut scans = PastScans::default();
            scans.push(&scan, &ranges, sweep, 7);
            scans.newest().expect("a scan").clone()
        };
        let wall = || (0..40).map(|n| Point2::new(4.0, 0.1 * f64::from(n)));
        let past = seen_along(&sweep);
        for at in wall() {
            assert!(
                !past.sees_through(at, 0.1) && past.ended_at(at, 0.05),
                "{at}"
            );
            let before = Point2::new(3.5, at.y);
            assert!(past.sees_through(before, 0.1), "{before}");
        }
        // As if all beams had been taken at once, from where the last one was.
        let at_once = seen_along(&Sweep::still(sweep.last));
        assert!(wall().any(|at| at_once.sees_through(at, 0.1)));
    }
}
