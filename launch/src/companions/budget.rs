//! What becomes of a companion whose process ended. A pure decision.
//!
//! 1. A process that ended with exit code 0 has done what it wanted to do.
//! 2. Bad configuration (exit code 2) and another contract (3) are not tried again: the next start would end
//!    the same way.
//! 3. A companion has a budget for the whole run.
//! 4. The first restart waits a moment, each one after that twice as long, up to a limit; after a process
//!    that has run for long the next one comes soon again.
//!
//! All times are wall time: a companion decides nothing about the run.

use std::time::Duration;

/// Wait before the first restart.
const BACKOFF: Duration = Duration::from_millis(100);

/// Longest wait before a restart.
const BACKOFF_MAX: Duration = Duration::from_secs(5);

/// A process that has run for this long is not a failed restart.
const STABLE: Duration = Duration::from_secs(10);

/// What to do about an ended process.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Decision {
    /// Start another one after this time.
    Restart(Duration),
    /// It is lost, for this reason.
    GiveUp(&'static str),
    /// It has ended by itself.
    Done,
}

/// The restarts that are left.
#[derive(Debug)]
pub(super) struct Budget {
    left: u32,
    in_a_row: u32,
}

impl Budget {
    /// So many restarts.
    pub(super) fn new(restarts: u32) -> Self {
        Self {
            left: restarts,
            in_a_row: 0,
        }
    }

    /// Decides about a process that ended with `code` (`None` = by a signal, or was never started) after
    /// it had `lived`, and counts.
    pub(super) fn decide(&mut self, code: Option<i32>, lived: Duration) -> Decision {
        match code {
            Some(0) => return Decision::Done,
            Some(2) => {
                return Decision::GiveUp("it does not accept its configuration or its arguments");
            }
            Some(3) => return Decision::GiveUp("it was built from another contract"),
            _ => {}
        }
        let Some(left) = self.left.checked_sub(1) else {
            return Decision::GiveUp("its restarts are used up");
        };
        self.left = left;
        if lived >= STABLE {
            self.in_a_row = 0;
        }
        let wait = BACKOFF.saturating_mul(1 << self.in_a_row.min(10));
        self.in_a_row += 1;
        Decision::Restart(wait.min(BACKOFF_MAX))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn restarts_wait_longer_until_they_are_used_up() {
        let mut budget = Budget::new(8);
        let mut wait_ms = |lived_s| match budget.decide(None, Duration::from_secs(lived_s)) {
            Decision::Restart(wait) => Some(wait.as_millis()),
            Decision::GiveUp(_) | Decision::Done => None,
        };
        let waits = [0, 0, 9, 0, 0, 0, 0, 10].map(&mut wait_ms);
        let expected = [100, 200, 400, 800, 1600, 3200, 5000, 100];
        assert_eq!(waits, expected.map(Some));
        assert_eq!(wait_ms(100), None);
    }

    #[test]
    fn what_has_ended_well_or_cannot_be_cured_is_not_started_again() {
        let mut budget = Budget::new(1);
        assert_eq!(budget.decide(Some(0), Duration::ZERO), Decision::Done);
        for code in [2, 3] {
            let decision = budget.decide(Some(code), Duration::ZERO);
            assert!(matches!(decision, Decision::GiveUp(_)), "{decision:?}");
        }
        let decision = budget.decide(Some(1), Duration::ZERO);
        assert_eq!(decision, Decision::Restart(BACKOFF));
    }
}
