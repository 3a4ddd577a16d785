//! Obstacles that were found a moment ago and are not yet known to stand.
//!
//! A scan laid on what walks is carried along with it, and the end of a wall that is coming into view
//! holds the robot back, so a cell counts as a surface only after it has been an obstacle without a
//! break for a moment.

use std::collections::{HashMap, VecDeque};

/// How long a cell must have been an obstacle: what moves is known as such by then; longer, and a
/// robot that drives fast among small things has little to hold on to. [ns]
const STANDS_NS: u64 = 250_000_000;

/// Cells that wait, in the order in which they became obstacles.
#[derive(Debug, Default)]
pub(crate) struct Settling {
    queue: VecDeque<(usize, u64)>,
    since_ns: HashMap<usize, u64>,
}

impl Settling {
    /// The cell at `index` is an obstacle from `run_ns` on, if it was none.
    pub(crate) fn begin(&mut self, index: usize, run_ns: u64) {
        self.since_ns.entry(index).or_insert_with(|| {
            self.queue.push_back((index, run_ns));
            run_ns
        });
    }

    /// The cell at `index` is none any longer.
    pub(crate) fn end(&mut self, index: usize) {
        self.since_ns.remove(&index);
    }

    /// A cell that has stood for long enough at `run_ns`; it waits no longer.
    pub(crate) fn take(&mut self, run_ns: u64) -> Option<usize> {
        while let Some((index, since_ns)) = self.queue.front().copied() {
            if since_ns.saturating_add(STANDS_NS) > run_ns {
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

    /// True when the cell at `index` waits.
    pub(crate) fn waits(&self, index: usize) -> bool {
        self.since_ns.contains_key(&index)
    }

    /// The cells that wait, each with the run time since which it is an obstacle, oldest first.
    pub(crate) fn waiting(&self) -> impl Iterator<Item = (usize, u64)> {
        let waits = |(index, since_ns): &(usize, u64)| self.since_ns.get(index) == Some(since_ns);
        self.queue.iter().copied().filter(waits)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_stands_for_a_second_is_taken_once() {
        let mut settling = Settling::default();
        settling.begin(7, 100);
        settling.begin(7, 200);
        assert_eq!(settling.take(100 + STANDS_NS - 1), None);
        assert_eq!(settling.take(100 + STANDS_NS), Some(7));
        assert_eq!(settling.take(u64::MAX), None);
    }

    #[test]
    fn what_goes_and_comes_back_begins_anew() {
        let mut settling = Settling::default();
        settling.begin(7, 100);
        settling.begin(8, 100);
        settling.end(7);
        settling.begin(7, 300);
        assert_eq!(settling.waiting().collect::<Vec<_>>(), [(8, 100), (7, 300)]);
        assert_eq!(settling.take(100 + STANDS_NS), Some(8));
        assert_eq!(settling.take(100 + STANDS_NS), None);
        assert_eq!(settling.take(300 + STANDS_NS), Some(7));
    }
}
