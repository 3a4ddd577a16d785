//! Odometry and scans until it is known where mapping placed them, so that what is shown of a run does not depend on
//! what was heard first.

use std::collections::VecDeque;
use zeronav_casts::Cast;
use zeronav_msgs::odometry::Odometry;
use zeronav_msgs::pose::{Pose, wrap_angle};
use zeronav_msgs::scan::Scan;

/// Ticks for which odometry and scans are held back: far more than mapping can be behind the robot.
const HOLD_TICKS: u64 = 128;

/// Scans, and places, that wait for odometry at most; the oldest go first.
const WAITING_MAX: usize = 512;

/// Odometry that is kept for scans between two messages.
const RECENT_MAX: usize = 64;

/// `odom_from_base` with its speeds at a tick and its run time. [ns]
#[derive(Debug, Clone, Copy)]
pub(super) struct HeldOdometry {
    pub tick: u64,
    pub run_ns: u64,
    pub odometry: Odometry,
}

/// A scan of a tick, at its own run time. [ns]
#[derive(Debug)]
pub(super) struct HeldScan {
    tick: u64,
    pub run_ns: u64,
    pub scan: Scan,
    pub ranges_m: Vec<f32>,
}

/// See the module's description.
#[derive(Debug, Default)]
pub(super) struct Held {
    odometry: VecDeque<HeldOdometry>,
    /// What was let go of, newest last.
    recent: VecDeque<HeldOdometry>,
    scans: VecDeque<HeldScan>,
    /// Ticks, and `map_from_odom` from each on.
    places: VecDeque<(u64, Pose)>,
    newest_tick: u64,
    /// Nothing more comes.
    is_over: bool,
}

impl Held {
    /// Mapping places the odometry frame there, from this tick on.
    pub(super) fn place(&mut self, tick: u64, map_from_odom: Pose) {
        // What is said last counts.
        while self.places.back().is_some_and(|(at, _)| *at >= tick) {
            self.places.pop_back();
        }
        self.places.push_back((tick, map_from_odom));
        let many = |places: &VecDeque<_>| places.len() > WAITING_MAX;
        while self.places.len() > 1 && (many(&self.places) || self.is_settled(self.places[1].0)) {
            self.places.pop_front();
        }
    }

    /// Adds a message of odometry.
    pub(super) fn add(&mut self, odometry: HeldOdometry) {
        self.newest_tick = self.newest_tick.max(odometry.tick);
        self.odometry.push_back(odometry);
    }

    /// Adds a scan.
    pub(super) fn add_scan(&mut self, tick: u64, run_ns: u64, scan: Scan, ranges_m: Vec<f32>) {
        if self.scans.len() == WAITING_MAX {
            self.scans.pop_front();
        }
        self.scans.push_back(HeldScan {
            tick,
            run_ns,
            scan,
            ranges_m,
        });
    }

    /// Nothing more comes: nothing is held back any more.
    pub(super) fn end(&mut self) {
        self.is_over = true;
    }

    /// The oldest odometry whose place is known by now.
    pub(super) fn next(&mut self) -> Option<HeldOdometry> {
        let first = *self.odometry.front()?;
        if !self.is_settled(first.tick) {
            return None;
        }
        self.odometry.pop_front();
        if self.recent.len() == RECENT_MAX {
            self.recent.pop_front();
        }
        self.recent.push_back(first);
        Some(first)
    }

    /// The oldest scan up to this tick.
    pub(super) fn next_scan(&mut self, tick: u64) -> Option<HeldScan> {
        let is_next = self.scans.front().is_some_and(|scan| scan.tick <= tick);
        is_next.then(|| self.scans.pop_front()).flatten()
    }

    /// `map_from_odom` at a tick.
    pub(super) fn place_at(&self, tick: u64) -> Option<Pose> {
        let known = self.places.iter().rev().find(|(at, _)| *at <= tick);
        known.map(|(_, map_from_odom)| *map_from_odom)
    }

    /// `map_from_base` at the run time of a scan: at odometry, or between two messages.
    pub(super) fn place_of(&self, scan: &HeldScan) -> Option<Pose> {
        let near = self.recent.iter().chain(self.odometry.front());
        let before = near.clone().rfind(|it| it.run_ns <= scan.run_ns)?;
        let after = near.clone().find(|it| it.run_ns >= scan.run_ns)?;
        let odom_from_base = between(before, after, scan.run_ns);
        Some(self.place_at(scan.tick)?.then(&odom_from_base))
    }

    fn is_settled(&self, tick: u64) -> bool {
        self.is_over || tick.saturating_add(HOLD_TICKS) < self.newest_tick
    }
}

/// The pose at a run time between those of two messages. [ns]
fn between(before: &HeldOdometry, after: &HeldOdometry, run_ns: u64) -> Pose {
    let (from, to) = (&before.odometry.pose, &after.odometry.pose);
    let whole_ns = after.run_ns.saturating_sub(before.run_ns);
    if whole_ns == 0 {
        return *to;
    }
    let share = (run_ns - before.run_ns).to_f64() / whole_ns.to_f64();
    Pose::new(
        from.x_m + share * (to.x_m - from.x_m),
        from.y_m + share * (to.y_m - from.y_m),
        wrap_angle(from.yaw_rad + share * wrap_angle(to.yaw_rad - from.yaw_rad)),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn odometry(tick: u64) -> HeldOdometry {
        HeldOdometry {
            tick,
            run_ns: tick * 10,
            odometry: Odometry {
                pose: Pose::new(f64::from(u32::try_from(tick).expect("small")), 0.0, 0.0),
                ..Odometry::default()
            },
        }
    }

    /// What comes out, whatever came first: ticks, and where each was placed.
    fn placed(late: u64) -> Vec<(u64, Option<Pose>)> {
        let mut held = Held::default();
        let mut out = Vec::new();
        let mut settle = |held: &mut Held| {
            while let Some(next) = held.next() {
                out.push((next.tick, held.place_at(next.tick)));
            }
        };
        for tick in 1..400 {
            held.add(odometry(tick));
            if tick > late && (tick - late).is_multiple_of(5) {
                let at = tick - late;
                held.place(
                    at,
                    Pose::new(0.0, f64::from(u32::try_from(at).expect("small")), 0.0),
                );
            }
            settle(&mut held);
        }
        for at in (400 - late..400).filter(|at| at % 5 == 0) {
            held.place(
                at,
                Pose::new(0.0, f64::from(u32::try_from(at).expect("small")), 0.0),
            );
        }
        held.end();
        settle(&mut held);
        out
    }

    #[test]
    fn the_place_of_a_tick_is_that_of_its_map_however_late_it_is_heard() {
        let exact = placed(0);
        assert_eq!(exact.len(), 399);
        assert_eq!(exact[3], (4, None), "before the first map");
        let fifth = Some(Pose::new(0.0, 5.0, 0.0));
        assert_eq!([exact[4], exact[8]], [(5, fifth), (9, fifth)]);
        for late in [1, 7, 100] {
            assert_eq!(placed(late), exact, "{late} ticks late");
        }
    }

    #[test]
    fn a_scan_between_two_messages_lies_between_their_places() {
        let mut held = Held::default();
        held.place(0, Pose::new(0.0, 1.0, 0.0));
        for tick in 1..=3 {
            held.add(odometry(tick));
        }
        for (tick, run_ns) in [(2, 15), (3, 30), (3, 31)] {
            held.add_scan(tick, run_ns, Scan::default(), Vec::new());
        }
        held.end();
        let mut places = Vec::new();
        while let Some(next) = held.next() {
            while let Some(scan) = held.next_scan(next.tick) {
                places.push(held.place_of(&scan).map(|place| [place.x_m, place.y_m]));
            }
        }
        assert_eq!(
            places,
            [Some([1.5, 1.0]), Some([3.0, 1.0]), None],
            "never beyond"
        );
    }
}
