//! Whether a run that does not tick has to end. Pure.
//!
//! It ends because it is silent when nobody does anything: no process runs or waits for a processor. As long
//! as one waits, the machine is busy, and the answer may still come. What is beyond any machine ends by
//! the wall clock. Either way the run ends with its reason; it never goes on in another way.

use std::time::{Duration, Instant};
use zeronav_scenario::restart::RestartSpec;

/// How long a run may go on without the robot's next tick while nobody does anything.
const SILENCE_LIMIT: Duration = Duration::from_secs(10);

/// How long it may take in any case, and the start of its services.
pub(super) const WALL_LIMIT: Duration = Duration::from_secs(300);

/// From when on the processes are looked at.
const LOOK_FROM: Duration = Duration::from_millis(200);

/// Longest time between two looks that counts: beyond it launch itself was kept waiting.
const LOOK_MAX: Duration = Duration::from_millis(50);

/// The same of the wall clock: launch may have been stopped.
const WALL_LOOK_MAX: Duration = Duration::from_secs(1);

/// Who holds the robot.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Held {
    /// Nobody.
    Not,
    /// Launch, until a swap or a fault has come further; they have limits of their own.
    ByLaunch,
    /// A client, for as long as it likes.
    ByClient,
}

/// Why a run has to end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Standing {
    /// Nobody did anything.
    Silent,
    /// The wall clock.
    TooLong,
}

/// See the module's description.
#[derive(Debug)]
pub(super) struct Standstill {
    tick: u64,
    looked: Instant,
    quiet: Duration,
    wall: Duration,
    wall_limit: Duration,
}

impl Standstill {
    /// From now on. A hang of a scenario takes its time, several times that on a busy machine.
    pub(super) fn new(spec: &RestartSpec) -> Self {
        Self {
            tick: 0,
            looked: Instant::now(),
            quiet: Duration::ZERO,
            wall: Duration::ZERO,
            wall_limit: WALL_LIMIT.saturating_add(spec.hang_after().saturating_mul(10)),
        }
    }

    /// One look: the robot's tick, and whether no process of the stack runs or waits for a processor.
    pub(super) fn look(
        &mut self,
        tick: u64,
        held: Held,
        is_quiet: impl FnOnce() -> bool,
    ) -> Option<Standing> {
        let since = self.looked.elapsed();
        self.looked = Instant::now();
        self.step(since, tick, held, is_quiet)
    }

    fn step(
        &mut self,
        since: Duration,
        tick: u64,
        held: Held,
        is_quiet: impl FnOnce() -> bool,
    ) -> Option<Standing> {
        if tick != self.tick || held == Held::ByClient {
            (self.tick, self.quiet, self.wall) = (tick, Duration::ZERO, Duration::ZERO);
            return None;
        }
        self.wall += since.min(WALL_LOOK_MAX);
        if self.wall > self.wall_limit {
            return Some(Standing::TooLong);
        }
        if held == Held::Not && self.wall > LOOK_FROM && is_quiet() {
            self.quiet += since.min(LOOK_MAX);
        }
        (self.quiet > SILENCE_LIMIT).then_some(Standing::Silent)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// How many seconds it takes, looked at every 10 ms, until the run ends.
    fn ends_after(held: Held, is_quiet: impl Fn(u32) -> bool) -> Option<(u32, Standing)> {
        let mut standstill = Standstill::new(&RestartSpec::default());
        (0..40_000).find_map(|look| {
            let since = Duration::from_millis(10);
            let ending = standstill.step(since, 7, held, || is_quiet(look));
            ending.map(|why| (look / 100, why))
        })
    }

    #[test]
    fn a_run_is_silent_when_nobody_does_anything() {
        let silent = ends_after(Held::Not, |_| true);
        assert_eq!(silent, Some((10, Standing::Silent)));
        // Every other look somebody waits for a processor.
        let slower = ends_after(Held::Not, |look| look % 2 == 0);
        assert_eq!(slower, Some((20, Standing::Silent)));
    }

    #[test]
    fn a_busy_machine_ends_it_by_the_wall_clock_alone() {
        for held in [Held::Not, Held::ByLaunch] {
            let ending = ends_after(held, |_| held == Held::ByLaunch);
            assert_eq!(ending, Some((305, Standing::TooLong)), "{held:?}");
        }
        assert_eq!(ends_after(Held::ByClient, |_| true), None);
    }

    #[test]
    fn every_tick_begins_anew_and_a_launch_that_was_stopped_has_seen_nothing() {
        let mut standstill = Standstill::new(&RestartSpec::default());
        for tick in 1..10 {
            for _ in 0..100 {
                let since = Duration::from_secs(3_600);
                let ending = standstill.step(since, tick, Held::Not, || true);
                assert_eq!(ending, None);
            }
        }
    }
}
