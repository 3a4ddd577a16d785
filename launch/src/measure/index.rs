//! The records of a run.

use zeronav_msgs::path::{PathCause, PathStatus};
use zeronav_msgs::span::Span;

/// A path as it was published, without repeats of an unchanged one.
#[derive(Debug, Clone, PartialEq)]
pub struct PathRecord {
    /// Id on `plan/path`.
    pub id: u64,
    /// Map revision it was checked with.
    pub map: u64,
    /// Run time. [ns]
    pub run_ns: u64,
    /// Its outcome.
    pub status: PathStatus,
    /// Its cause.
    pub cause: PathCause,
    /// Key of the planner.
    pub planner: String,
    /// Length. [m]
    pub length_m: f64,
    /// From its end to the goal. [m]
    pub beside_goal_m: f64,
    /// Nodes expanded.
    pub expanded: u64,
    /// Waypoints, `map` frame. [m]
    pub points_m: Vec<[f64; 2]>,
}

/// What launch saw of one scripted obstacle.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Sighting {
    /// Place in the scenario's list.
    pub index: usize,
    /// Run time at which it appeared: one obstacle may appear several times. [ns]
    pub appeared_run_ns: u64,
    /// Moment at which it appeared, [ns] monotonic.
    pub appeared_ns: u64,
    /// First scan with any beam on it.
    pub first_beam_scan: Option<u64>,
    /// First scan with at least three beams on it.
    pub first_scan: Option<u64>,
    /// First map revision, current as of that scan or later, with a sensed lethal cell at its
    /// outline.
    pub first_map: Option<u64>,
    /// What the map showed of it, in order of the revisions that changed that.
    pub sensed: Vec<Sensed>,
}

/// What a map showed of an obstacle.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Sensed {
    /// The first revision with it.
    pub map: u64,
    /// Centres of the sensed lethal cells within one cell of the outline. [m]
    pub cells_m: Vec<[f64; 2]>,
}

impl Sighting {
    /// What revision `map` showed of it. [m]
    #[must_use]
    pub fn sensed_by(&self, map: u64) -> &[[f64; 2]] {
        let until = self.sensed.partition_point(|sensed| sensed.map <= map);
        let newest = until.checked_sub(1).and_then(|at| self.sensed.get(at));
        newest.map_or(&[], |sensed| &sensed.cells_m)
    }
}

/// Adds to a list that keeps at most `max`: when it is full, the oldest quarter goes. Returns how
/// many have gone.
pub(crate) fn push_bounded<T>(list: &mut Vec<T>, value: T, max: usize) -> usize {
    let gone = if list.len() < max { 0 } else { max / 4 };
    list.drain(..gone);
    list.push(value);
    gone
}

/// Everything that launch collected.
#[derive(Debug, Clone, Default)]
pub struct Records {
    /// All spans, per process in order.
    pub spans: Vec<Span>,
    /// All paths that brought a new geometry or a new failure, in order.
    pub paths: Vec<PathRecord>,
    /// All scripted obstacles that appeared.
    pub sightings: Vec<Sighting>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_full_list_loses_its_oldest_quarter() {
        let mut list = Vec::new();
        let gone: usize = (0..1000).map(|n| push_bounded(&mut list, n, 8)).sum();
        assert!((6..=8).contains(&list.len()), "{}", list.len());
        assert_eq!(list.len() + gone, 1000);
        assert_eq!(list.last(), Some(&999));
        assert!(list.windows(2).all(|pair| pair[1] == pair[0] + 1));
    }
}
