//! When the robot's ticks are due in real time.

use zeronav_shell::clock::now_ns;

/// The clock of a robot that no lease holds.
#[derive(Debug, Default)]
pub(crate) struct OwnClock {
    /// When the next tick is due. [ns]
    due_ns: u64,
    /// Real time that was lost because ticks were late. [ns]
    slipped_ns: u64,
}

impl OwnClock {
    /// The next tick is due after a whole one; returns when. [ns]
    pub(crate) fn restart(&mut self, tick_ns: u64) -> u64 {
        self.due_ns = now_ns() + tick_ns;
        self.due_ns
    }

    /// When the next step is due, and the run time of its scan when that is captured before the
    /// tick at `tick_run_ns`. [ns]
    pub(crate) fn next_due(
        &self,
        tick_run_ns: u64,
        capture_run_ns: Option<u64>,
    ) -> (u64, Option<u64>) {
        let before = capture_run_ns.filter(|capture_run_ns| *capture_run_ns < tick_run_ns);
        let early_ns = before.map_or(0, |capture_run_ns| tick_run_ns - capture_run_ns);
        (self.due_ns.saturating_sub(early_ns), before)
    }

    /// A tick is done. Late ticks are not caught up: run time slips.
    pub(crate) fn ticked(&mut self, tick_ns: u64) {
        self.due_ns += tick_ns;
        let now = now_ns();
        if self.due_ns < now {
            self.slipped_ns += now - self.due_ns;
            self.due_ns = now;
        }
    }

    /// Real time that was lost because ticks were late. [ns]
    pub(crate) const fn slipped_ns(&self) -> u64 {
        self.slipped_ns
    }
}
