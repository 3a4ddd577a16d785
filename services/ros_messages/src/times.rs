//! What the times of a recording are.

use zeronav_msgs::run::{RunClock, RunMode};

/// From run time to the times of the file.
///
/// In real time those are the system's, [ns] since 1970, as `use_sim_time:=false` expects: run time 0
/// plus run time. In lockstep, where a second of run time takes a hundredth of one, they are run time.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct TimeBase {
    /// The file's time of run time 0. [ns]
    base_ns: u64,
    /// `CLOCK_MONOTONIC` at run time 0; `None` in lockstep, where it says nothing. [ns]
    zero_ns: Option<u64>,
}

impl TimeBase {
    /// Of a run with this clock, at a moment that is `now_unix_ns` since 1970 and `now_ns` of
    /// `CLOCK_MONOTONIC`.
    #[must_use]
    pub fn new(clock: &RunClock, now_unix_ns: u64, now_ns: u64) -> Self {
        if clock.mode() != Some(RunMode::RealTime) {
            return Self::default();
        }
        let age_ns = now_ns.saturating_sub(clock.zero_ns);
        Self {
            base_ns: now_unix_ns.saturating_sub(age_ns),
            zero_ns: Some(clock.zero_ns),
        }
    }

    /// The file's time of run time 0. [ns]
    #[must_use]
    pub fn base_ns(&self) -> u64 {
        self.base_ns
    }

    /// True when the file's times are those of the system.
    #[must_use]
    pub fn is_real_time(&self) -> bool {
        self.zero_ns.is_some()
    }

    /// The file's time at `run_ns`. [ns]
    #[must_use]
    pub fn at_run(&self, run_ns: u64) -> u64 {
        self.base_ns.saturating_add(run_ns)
    }

    /// The file's time at `monotonic_ns` of `CLOCK_MONOTONIC`; `None` in lockstep, and of no moment
    /// of the run. [ns]
    #[must_use]
    pub fn at_monotonic(&self, monotonic_ns: u64) -> Option<u64> {
        let run_ns = monotonic_ns.checked_sub(self.zero_ns?)?;
        Some(self.at_run(run_ns))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn clock(mode: RunMode) -> RunClock {
        RunClock {
            mode: mode.code(),
            zero_ns: 4_000,
            ..RunClock::default()
        }
    }

    #[test]
    fn real_time_has_the_times_of_the_system() {
        let times = TimeBase::new(&clock(RunMode::RealTime), 1_000_000, 5_000);
        assert_eq!(times.base_ns(), 999_000);
        assert_eq!(times.at_run(50), 999_050);
        assert_eq!(times.at_monotonic(4_050), Some(999_050));
        assert_eq!(times.at_monotonic(3_999), None, "before the run");
    }

    #[test]
    fn lockstep_has_run_time() {
        let times = TimeBase::new(&clock(RunMode::Lockstep), 1_000_000, 5_000);
        assert_eq!((times.at_run(50), times.at_monotonic(4_050)), (50, None));
    }
}
