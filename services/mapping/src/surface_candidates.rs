//! Cells that may become surfaces: obstacles that are not yet known to be static.
//!
//! A scan matched against a pedestrian is carried along with him, and the end of a wall that is coming
//! into view holds the pose back, so a cell counts as a surface only after it has been an obstacle
//! without interruption for [`CONFIRM_NS`].

use crate::flips::Flips;
use crate::scan_match::Surfaces;
use std::collections::{HashMap, VecDeque};

/// How long a cell must have been an obstacle: dynamic obstacles are tracked by then; longer, and a
/// robot that drives fast among small obstacles has too few surfaces. [ns]
const CONFIRM_NS: u64 = 250_000_000;

/// The candidates, in the order in which they became obstacles.
#[derive(Debug, Default)]
pub(crate) struct SurfaceCandidates {
    queue: VecDeque<(usize, u64)>,
    since_ns: HashMap<usize, u64>,
}

impl SurfaceCandidates {
    /// Takes in which cells became obstacles and which are none any more at `run_ns`, and brings the
    /// surfaces up to date.
    pub(crate) fn follow(&mut self, flips: &Flips, run_ns: u64, surfaces: &mut Surfaces) {
        for index in &flips.cleared {
            surfaces.set(*index, false);
            self.remove(*index);
        }
        for index in &flips.cleared {
            surfaces.forget(*index);
        }
        for index in &flips.marked {
            if !surfaces.is_surface(*index) {
                self.add(*index, run_ns);
            }
        }
        while let Some(index) = self.take_confirmed(run_ns) {
            surfaces.set(index, true);
        }
    }

    /// Adds the cell at `index`, an obstacle since `run_ns`, unless it is a candidate already.
    pub(crate) fn add(&mut self, index: usize, run_ns: u64) {
        self.since_ns.entry(index).or_insert_with(|| {
            self.queue.push_back((index, run_ns));
            run_ns
        });
    }

    /// Removes the cell at `index`, if it is a candidate.
    fn remove(&mut self, index: usize) {
        self.since_ns.remove(&index);
    }

    /// Removes and returns a candidate that has been an obstacle for long enough at `run_ns`.
    fn take_confirmed(&mut self, run_ns: u64) -> Option<usize> {
        while let Some((index, since_ns)) = self.queue.front().copied() {
            if since_ns.saturating_add(CONFIRM_NS) > run_ns {
                return None;
            }
            self.queue.pop_front();
            if self.since_ns.get(&index) == Some(&since_ns) {
                self.since_ns.remove(&index);
                return Some(index);
            }
        }
        None
    }

    /// True when there are none.
    pub(crate) fn is_empty(&self) -> bool {
        self.since_ns.is_empty()
    }

    /// True when the cell at `index` is a candidate.
    pub(crate) fn contains(&self, index: usize) -> bool {
        self.since_ns.contains_key(&index)
    }

    /// The candidates, each with the run time [ns] since which it is an obstacle, oldest first.
    pub(crate) fn iter(&self) -> impl Iterator<Item = (usize, u64)> {
        let waits = |(index, since_ns): &(usize, u64)| self.since_ns.get(index) == Some(since_ns);
        self.queue.iter().copied().filter(waits)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_confirmed_candidate_is_taken_once() {
        let mut candidates = SurfaceCandidates::default();
        candidates.add(7, 100);
        candidates.add(7, 200);
        assert_eq!(candidates.take_confirmed(100 + CONFIRM_NS - 1), None);
        assert_eq!(candidates.take_confirmed(100 + CONFIRM_NS), Some(7));
        assert_eq!(candidates.take_confirmed(u64::MAX), None);
    }

    #[test]
    fn a_candidate_that_disappears_starts_over() {
        let mut candidates = SurfaceCandidates::default();
        candidates.add(7, 100);
        candidates.add(8, 100);
        candidates.remove(7);
        candidates.add(7, 300);
        assert_eq!(candidates.iter().collect::<Vec<_>>(), [(8, 100), (7, 300)]);
        assert_eq!(candidates.take_confirmed(100 + CONFIRM_NS), Some(8));
        assert_eq!(candidates.take_confirmed(100 + CONFIRM_NS), None);
        assert_eq!(candidates.take_confirmed(300 + CONFIRM_NS), Some(7));
    }
}
