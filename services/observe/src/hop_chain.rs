//! The way of a scan to the wheels, hop by hop, and what can be wrong with it.
//!
//! A boundary between two hops is one clock reading of one process, so the hops of a way telescope
//! and their sum says nothing about them. What can fail is looked at instead: a stamp that lies
//! before its predecessor, a link whose record is missing, and the robot's own time from capture to
//! application on a second clock, `CLOCK_MONOTONIC_RAW`.

use zeronav_casts::Cast;
use zeronav_msgs::span::Span;

/// Names of the hops through the map, in order. The first ends at the capture of the scan that the
/// path's map is current as of; `to_` hops are transport and waking, the others the work of a
/// process.
pub const HOPS: [&str; 11] = [
    "detect",
    "robot",
    "to_mapping",
    "mapping",
    "to_global_planner",
    "global_planner",
    "to_local_planner",
    "local_planner",
    "to_collision_guard",
    "collision_guard",
    "to_robot",
];

/// Places in [`HOPS`] of all hops from an earlier scan on.
pub const ALL: [usize; 11] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10];

/// Places in [`HOPS`] of the hops of a scan whose points the local planner checks itself.
pub const DIRECT: [usize; 6] = [1, 6, 7, 8, 9, 10];

/// Places in [`HOPS`] of the hops of a scan through map and path.
pub const THROUGH_MAP: [usize; 10] = [1, 2, 3, 4, 5, 6, 7, 8, 9, 10];

/// By how much the rates of the two clocks differ at most: the kernel slews `CLOCK_MONOTONIC` by up
/// to 500 ppm and `CLOCK_MONOTONIC_RAW` not at all.
const SLEW_PPM_MAX: u64 = 500;

/// By how much the two clocks' readings of one moment lie apart at most. [ns]
const READING_NS: u64 = 20_000;

/// One way.
#[derive(Debug, Clone, PartialEq)]
pub struct HopChain {
    /// Places of its hops in [`HOPS`].
    pub hops: &'static [usize],
    /// Their boundaries, one more than hops. [ns]
    pub boundaries_ns: Vec<u64>,
    /// The robot's own time from capture to application on the second clock, where it left one.
    /// [ns]
    pub second_ns: Option<u64>,
}

impl HopChain {
    /// By the records of a scan, of the request whose author checked its points, of the guard's command
    /// made of that, and of the robot that applied it.
    #[must_use]
    pub fn direct([scan, local, guard, applied]: [&Span; 4]) -> Self {
        let mut boundaries_ns = vec![scan.capture_ns, scan.published_ns];
        boundaries_ns.extend(control([local, guard, applied]));
        Self {
            hops: &DIRECT,
            boundaries_ns,
            second_ns: second_ns(scan, applied),
        }
    }

    /// By the records of a scan, of the map that is current as of it, of the path on that map, and of what
    /// followed the path.
    #[must_use]
    pub fn through_map([scan, mapping, global, local, guard, applied]: [&Span; 6]) -> Self {
        let mut boundaries_ns = vec![
            scan.capture_ns,
            scan.published_ns,
            mapping.started_ns,
            mapping.published_ns,
            global.started_ns,
            global.published_ns,
        ];
        boundaries_ns.extend(control([local, guard, applied]));
        Self {
            hops: &THROUGH_MAP,
            boundaries_ns,
            second_ns: second_ns(scan, applied),
        }
    }

    /// The same from the capture of an earlier scan on.
    #[must_use]
    pub fn from_earlier(start: &Span, spans: [&Span; 6]) -> Self {
        let mut way = Self::through_map(spans);
        way.boundaries_ns.insert(0, start.capture_ns);
        Self {
            hops: &ALL,
            second_ns: second_ns(start, spans[5]),
            ..way
        }
    }

    /// Lengths of the hops: place in [`HOPS`] and time. A hop whose end lies before its beginning
    /// is 0 long. [ns]
    pub fn lengths_ns(&self) -> impl Iterator<Item = (usize, u64)> + '_ {
        let pairs = self.boundaries_ns.windows(2);
        let lengths = pairs.map(|pair| pair[1].saturating_sub(pair[0]));
        self.hops.iter().copied().zip(lengths)
    }

    /// The hops with their names. [us]
    pub fn named_us(&self) -> impl Iterator<Item = (&'static str, f64)> + '_ {
        let lengths = self.lengths_ns();
        lengths.map(|(hop, length_ns)| (HOPS[hop], to_us(length_ns)))
    }

    /// The hops that end before they begin: place in [`HOPS`], beginning and end. [ns]
    pub fn out_of_order(&self) -> impl Iterator<Item = (usize, u64, u64)> + '_ {
        let pairs = self.hops.iter().zip(self.boundaries_ns.windows(2));
        let wrong = pairs.filter(|(_, pair)| pair[1] < pair[0]);
        wrong.map(|(hop, pair)| (*hop, pair[0], pair[1]))
    }

    /// Sum of the hops. [ns]
    #[must_use]
    pub fn sum_ns(&self) -> u64 {
        self.lengths_ns().map(|(_, length_ns)| length_ns).sum()
    }

    /// By how much the sum of the hops and the robot's second clock differ. [ns]
    #[must_use]
    pub fn difference_ns(&self) -> Option<u64> {
        Some(self.second_ns?.abs_diff(self.sum_ns()))
    }

    /// True when that is more than the rates of the clocks and their readings allow.
    #[must_use]
    pub fn is_beyond(&self) -> bool {
        let allowed_ns = self.sum_ns() * SLEW_PPM_MAX / 1_000_000 + 2 * READING_NS;
        self.difference_ns().is_some_and(|ns| ns > allowed_ns)
    }
}

/// The boundaries from the local planner to the wheels. [ns]
fn control([local, guard, applied]: [&Span; 3]) -> [u64; 5] {
    [
        local.started_ns,
        local.published_ns,
        guard.started_ns,
        guard.published_ns,
        applied.started_ns,
    ]
}

/// From the robot's record of a scan to its record of a command that took effect, on its second
/// clock; `None` when it left no readings there. [ns]
fn second_ns(scan: &Span, applied: &Span) -> Option<u64> {
    let both = scan.raw_ns != 0 && applied.raw_ns != 0;
    both.then(|| applied.raw_ns.saturating_sub(scan.raw_ns))
}

/// Nanoseconds as microseconds, to a tenth.
#[must_use]
pub fn to_us(time_ns: u64) -> f64 {
    (time_ns.to_f64() / 100.0).round() / 10.0
}
