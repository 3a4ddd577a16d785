//! What becomes of a seat whose process ended. A pure decision; killing and starting happen elsewhere.
//!
//! 1. The robot is not restarted: nothing else can stop the wheels, and a new simulator would be
//!    another robot.
//! 2. Bad configuration (exit code 2) and a contract mismatch (3) are not restarted: the next
//!    start would end the same way.
//! 3. A seat has a budget, and the run has one for all seats together.
//! 4. The first restart of a seat comes at once. From the second on it waits, twice as long every
//!    time, up to a limit.

use core::time::Duration;
use std::collections::HashMap;
use zeronav_msgs::role::Role;
use zeronav_params::parameters;

/// Wait before the second restart of a seat.
const BACKOFF: Duration = Duration::from_millis(100);

/// Longest wait before a restart.
const BACKOFF_MAX: Duration = Duration::from_secs(2);

parameters! {
    /// Budgets and the hang limit, `[restart]` of a scenario.
    pub struct RestartSpec {
        /// Most restarts of one service.
        per_service: u32 = 10, [0, 10_000];
        /// Most restarts of all services together.
        per_run: u32 = 30, [0, 10_000];
        /// Time without progress after which a service counts as hung. A service without work beats
        /// every 50 ms, so that a limit below 0.1 s would kill healthy ones.
        hang_after_s: f64 = 0.5, [0.1, 3600.0] "s";
        /// Ticks for which a restarted seat stays empty, lockstep only.
        absent_ticks: u64 = 20, [0, 1_000_000];
    }
}

impl RestartSpec {
    /// Time without progress after which a service counts as hung; the longest there is for a number
    /// of seconds that is none.
    #[must_use]
    pub fn hang_after(&self) -> Duration {
        Duration::try_from_secs_f64(self.hang_after_s).unwrap_or(Duration::MAX)
    }
}

/// What to do about an ended process.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Decision {
    /// Start a successor after this time.
    Restart(Duration),
    /// End the run, for this reason.
    GiveUp(&'static str),
}

/// The restarts so far.
#[derive(Debug, Clone, Default)]
pub(crate) struct Restarts {
    of: HashMap<Role, u32>,
    all: u32,
}

impl Restarts {
    /// Decides about `role`, whose process ended with `code` (`None` = by a signal), and counts.
    pub(crate) fn decide(&mut self, spec: &RestartSpec, role: Role, code: Option<i32>) -> Decision {
        if role == Role::Robot {
            return Decision::GiveUp("the robot is not restarted");
        }
        match code {
            Some(2) => return Decision::GiveUp("its configuration is wrong"),
            Some(3) => return Decision::GiveUp("it was built from another contract"),
            _ => {}
        }
        let before = self.of.entry(role).or_default();
        if *before >= spec.per_service {
            return Decision::GiveUp("its restart budget is used up");
        }
        if self.all >= spec.per_run {
            return Decision::GiveUp("the run's restart budget is used up");
        }
        let wait = match before.checked_sub(1) {
            None => Duration::ZERO,
            Some(doublings) => BACKOFF
                .saturating_mul(1 << doublings.min(10))
                .min(BACKOFF_MAX),
        };
        *before += 1;
        self.all += 1;
        Decision::Restart(wait)
    }

    /// Restarts of `role` so far.
    #[must_use]
    pub(crate) fn of(&self, role: Role) -> u32 {
        self.of.get(&role).copied().unwrap_or(0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_comes_at_once_and_later_ones_wait_longer() {
        let mut restarts = Restarts::default();
        let spec = RestartSpec::default();
        let waits: Vec<u128> = (0..8)
            .map(|_| match restarts.decide(&spec, Role::Mapping, None) {
                Decision::Restart(wait) => wait.as_millis(),
                Decision::GiveUp(why) => panic!("{why}"),
            })
            .collect();
        assert_eq!(waits, [0, 100, 200, 400, 800, 1600, 2000, 2000]);
        assert_eq!(
            restarts.decide(&spec, Role::LocalPlanner, Some(101)),
            Decision::Restart(Duration::ZERO),
            "every seat has a backoff of its own"
        );
    }

    #[test]
    fn budgets_end() {
        let spec = RestartSpec {
            per_service: 2,
            per_run: 3,
            ..RestartSpec::default()
        };
        let mut restarts = Restarts::default();
        let mut restarted =
            |role| matches!(restarts.decide(&spec, role, None), Decision::Restart(_));
        assert!(restarted(Role::Mapping) && restarted(Role::Mapping));
        assert!(!restarted(Role::Mapping), "the seat's budget");
        assert!(restarted(Role::GlobalPlanner));
        assert!(!restarted(Role::GlobalPlanner), "the run's budget");
    }

    #[test]
    fn what_cannot_help_is_not_tried() {
        let mut restarts = Restarts::default();
        let spec = RestartSpec::default();
        for (role, code) in [
            (Role::Robot, None),
            (Role::Mapping, Some(2)),
            (Role::Mapping, Some(3)),
        ] {
            assert!(matches!(
                restarts.decide(&spec, role, code),
                Decision::GiveUp(_)
            ));
        }
        assert_eq!(restarts.of(Role::Mapping), 0);
    }
}
