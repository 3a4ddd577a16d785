//! For how long an answer has been owed.

use std::time::{Duration, Instant};

/// From when on the processes are looked at.
const LOOK_FROM: Duration = Duration::from_millis(100);

/// Longest time between two looks that counts: beyond it launch itself was kept waiting.
const LOOK_MAX: Duration = Duration::from_millis(50);

/// See the module's description.
#[derive(Debug, Clone, Copy)]
pub(super) struct Owing {
    since: Instant,
    looked: Instant,
    quiet: Duration,
}

impl Owing {
    /// From now on.
    pub(super) fn new() -> Self {
        let now = Instant::now();
        Self {
            since: now,
            looked: now,
            quiet: Duration::ZERO,
        }
    }

    /// By the wall clock.
    pub(super) fn elapsed(&self) -> Duration {
        self.since.elapsed()
    }

    /// For how long nobody did anything meanwhile: one look, at which `is_quiet` says whether no process
    /// of the stack runs or waits for a processor.
    pub(super) fn quiet(&mut self, is_quiet: impl FnOnce() -> bool) -> Duration {
        let since = self.looked.elapsed();
        self.looked = Instant::now();
        if self.elapsed() > LOOK_FROM && is_quiet() {
            self.quiet += since.min(LOOK_MAX);
        }
        self.quiet
    }
}
