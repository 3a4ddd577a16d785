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

impl Records {
    /// Forgets all but the newest, at least a minute and a half of a stack in real time.
    pub fn keep_newest(&mut self) {
        keep(&mut self.spans, 20_000);
        keep(&mut self.paths, 200);
        keep(&mut self.sightings, 100);
    }
}

/// Shortens a list that has grown to twice `n` to its newest `n`: seldom, because the others move.
fn keep<T>(list: &mut Vec<T>, n: usize) {
    if list.len() >= 2 * n {
        list.drain(..list.len() - n);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_newest_of_a_long_list_are_kept() {
        let mut list = Vec::new();
        for n in 0..1000 {
            list.push(n);
            keep(&mut list, 8);
            assert!(list.len() < 16 && list.last() == Some(&n));
        }
        assert!(list.len() >= 8);
        assert!(list.windows(2).all(|pair| pair[1] == pair[0] + 1));
    }
}
