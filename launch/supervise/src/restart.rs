//! What becomes of a seat whose process ended. A pure decision; killing and starting happen elsewhere.
//!
//! 1. The robot is not restarted unless the scenario says so: nothing else can stop the wheels, and a new simulator would be
//!    another robot.
//! 2. Bad configuration (exit code 2) and a contract mismatch (3) are not restarted: the next
//!    start would end the same way.
//! 3. A seat has a budget, and the stack has one for all seats together. Restarts count for a window
//!    of time, so that a stack that stays up for weeks does not use them up.
//! 4. The first restart of a seat comes at once. When the successor ends soon as well, the next one
//!    waits, twice as long every time, up to a limit.
//!
//! All times are run time, so that restarts in lockstep are the same in every run.

use core::time::Duration;
use std::collections::{HashMap, VecDeque};
use zeronav_msgs::role::Role;
use zeronav_msgs::time::nanoseconds;
use zeronav_scenario::restart::RestartSpec;

/// Wait before the second restart of a seat in a row.
const BACKOFF: Duration = Duration::from_millis(100);

/// Longest wait before a restart.
const BACKOFF_MAX: Duration = Duration::from_secs(2);

/// A process that has run for this long is not a failed restart: its successor comes at once. [ns]
const STABLE_NS: u64 = 5_000_000_000;

/// What to do about an ended process.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Decision {
    /// Start a successor after this time.
    Restart(Duration),
    /// End the run, for this reason.
    GiveUp(&'static str),
}

/// The restarts of one seat.
#[derive(Debug, Clone, Default)]
struct Seat {
    /// All of them.
    n: u32,
    /// Those since a process of the seat was stable.
    in_a_row: u32,
    /// When the newest process was to be started. [ns]
    started_ns: u64,
}

/// The restarts so far.
#[derive(Debug, Clone, Default)]
pub struct Restarts {
    seats: HashMap<Role, Seat>,
    /// Role and run time of those that count for the budgets, oldest first. [ns]
    recent: VecDeque<(Role, u64)>,
}

impl Restarts {
    /// Decides about `role`, whose process ended with `code` (`None` = by a signal) at the run time
    /// `run_ns`, and counts.
    pub fn decide(
        &mut self,
        spec: &RestartSpec,
        role: Role,
        code: Option<i32>,
        run_ns: u64,
    ) -> Decision {
        if role == Role::Robot && !spec.robot {
            return Decision::GiveUp("the robot is not restarted");
        }
        match code {
            Some(2) => {
                return Decision::GiveUp(
                    "it does not accept its configuration, its arguments or its seat",
                );
            }
            Some(3) => return Decision::GiveUp("it was built from another contract"),
            _ => {}
        }
        let window_ns = nanoseconds(spec.window_s);
        (self.recent).retain(|(_, at_ns)| run_ns.saturating_sub(*at_ns) < window_ns);
        let within = |budget: u32, n: usize| n < usize::try_from(budget).unwrap_or(usize::MAX);
        let of_role = self.recent.iter().filter(|(of, _)| *of == role).count();
        if !within(spec.per_service, of_role) {
            return Decision::GiveUp("its restart budget is used up");
        }
        if !within(spec.per_run, self.recent.len()) {
            return Decision::GiveUp("the run's restart budget is used up");
        }
        self.recent.push_back((role, run_ns));
        let seat = self.seats.entry(role).or_default();
        if run_ns.saturating_sub(seat.started_ns) >= STABLE_NS {
            seat.in_a_row = 0;
        }
        let wait = match seat.in_a_row.checked_sub(1) {
            None => Duration::ZERO,
            Some(doublings) => BACKOFF
                .saturating_mul(1 << doublings.min(10))
                .min(BACKOFF_MAX),
        };
        seat.n += 1;
        seat.in_a_row += 1;
        seat.started_ns = run_ns + nanoseconds(wait.as_secs_f64());
        Decision::Restart(wait)
    }

    /// Restarts of `role` so far.
    #[must_use]
    pub fn of(&self, role: Role) -> u32 {
        self.seats.get(&role).map_or(0, |seat| seat.n)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// [ms] Wait of each restart of mapping, at the run times `at_s`.
    fn waits_ms(at_s: &[u64]) -> Vec<u128> {
        let mut restarts = Restarts::default();
        let spec = RestartSpec::default();
        let decide = |at_s: &u64| restarts.decide(&spec, Role::Mapping, None, at_s * 1_000_000_000);
        let wait_ms = |decision| match decision {
            Decision::Restart(wait) => wait.as_millis(),
            Decision::GiveUp(why) => panic!("{why}"),
        };
        at_s.iter().map(decide).map(wait_ms).collect()
    }

    #[test]
    fn the_first_comes_at_once_and_later_ones_wait_longer() {
        let waits = [0, 100, 200, 400, 800, 1600, 2000, 2000];
        assert_eq!(waits_ms(&[7; 8]), waits);
        let mut restarts = Restarts::default();
        let spec = RestartSpec::default();
        for role in [Role::Mapping, Role::LocalPlanner] {
            assert_eq!(
                restarts.decide(&spec, role, Some(101), 0),
                Decision::Restart(Duration::ZERO),
                "every seat has a backoff of its own"
            );
        }
    }

    #[test]
    fn after_a_stable_process_the_next_comes_at_once() {
        assert_eq!(waits_ms(&[1, 2, 3, 8, 14, 17]), [0, 100, 200, 400, 0, 100]);
    }

    #[test]
    fn budgets_end_and_count_for_a_window_of_time() {
        let spec = RestartSpec {
            per_service: 2,
            per_run: 3,
            window_s: 10.0,
            ..RestartSpec::default()
        };
        let mut restarts = Restarts::default();
        let mut restarted = |role, at_s: u64| {
            let decision = restarts.decide(&spec, role, None, at_s * 1_000_000_000);
            matches!(decision, Decision::Restart(_))
        };
        assert!(restarted(Role::Mapping, 0) && restarted(Role::Mapping, 1));
        assert!(!restarted(Role::Mapping, 2), "the seat's budget");
        assert!(restarted(Role::GlobalPlanner, 3));
        assert!(!restarted(Role::GlobalPlanner, 9), "the run's budget");
        assert!(restarted(Role::Mapping, 10), "the first counts no more");
        assert!(!restarted(Role::Mapping, 10));
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
                restarts.decide(&spec, role, code, 0),
                Decision::GiveUp(_)
            ));
        }
        assert_eq!(restarts.of(Role::Mapping), 0);
    }
    /// Restarts at these run times [ns]; the wait of each, `None` for one that is not made.
    fn decide_at(spec: &RestartSpec, at_ns: &[u64]) -> Vec<Option<Duration>> {
        let mut restarts = Restarts::default();
        let decide = |at_ns: &u64| match restarts.decide(spec, Role::Mapping, None, *at_ns) {
            Decision::Restart(wait) => Some(wait),
            Decision::GiveUp(_) => None,
        };
        at_ns.iter().map(decide).collect()
    }

    /// It is stable 5 s after its start, which is after the wait.
    #[test]
    fn a_process_is_stable_from_five_seconds_after_its_start_on() {
        let spec = RestartSpec::default();
        let (first, wait) = (3_000_000_000, Duration::from_millis(100));
        let second = first + 1_000_000_000;
        let started = second + 100_000_000;
        for (third, waits) in [
            (started + STABLE_NS - 1, Duration::from_millis(200)),
            (started + STABLE_NS, Duration::ZERO),
        ] {
            let found = decide_at(&spec, &[first, second, third]);
            assert_eq!(found, [Some(Duration::ZERO), Some(wait), Some(waits)]);
        }
        // Before the first restart it has run since the beginning.
        assert_eq!(decide_at(&spec, &[0]), [Some(Duration::ZERO)]);
    }

    #[test]
    fn a_restart_counts_until_its_window_is_over_and_not_a_nanosecond_longer() {
        let spec = RestartSpec {
            per_service: 1,
            per_run: 9,
            window_s: 2.0,
            ..RestartSpec::default()
        };
        let made = |at_ns: u64| decide_at(&spec, &[7, at_ns])[1].is_some();
        assert!(!made(7 + 1_999_999_999));
        assert!(made(7 + 2_000_000_000));
        // Run time does not go backwards, but who asks may be late.
        assert!(!made(0));
    }

    #[test]
    fn each_budget_is_the_number_of_restarts_and_says_which_it_is() {
        for (per_service, per_run, why) in [
            (3, 9, "its restart budget is used up"),
            (9, 3, "the run's restart budget is used up"),
            (3, 3, "its restart budget is used up"),
        ] {
            let spec = RestartSpec {
                per_service,
                per_run,
                ..RestartSpec::default()
            };
            let mut restarts = Restarts::default();
            for n in 0..3 {
                assert_eq!(restarts.of(Role::Mapping), n);
                let decision = restarts.decide(&spec, Role::Mapping, Some(1), 5);
                assert!(matches!(decision, Decision::Restart(_)), "{decision:?}");
            }
            let decision = restarts.decide(&spec, Role::Mapping, Some(1), 5);
            assert_eq!(decision, Decision::GiveUp(why));
            assert_eq!(
                restarts.of(Role::Mapping),
                3,
                "what is not made does not count"
            );
            assert_eq!(restarts.of(Role::LocalPlanner), 0);
        }
    }

    #[test]
    fn the_seats_count_alone_for_their_budget_and_together_for_that_of_the_run() {
        let spec = RestartSpec {
            per_service: 1,
            per_run: 2,
            ..RestartSpec::default()
        };
        let mut restarts = Restarts::default();
        let mut made = |role| {
            let decision = restarts.decide(&spec, role, None, 0);
            matches!(decision, Decision::Restart(_))
        };
        assert!(made(Role::Mapping) && made(Role::GlobalPlanner));
        assert!(!made(Role::CollisionGuard));
    }

    #[test]
    fn every_end_but_a_wrong_configuration_or_contract_is_restarted() {
        let spec = RestartSpec::default();
        let decide = |code| Restarts::default().decide(&spec, Role::Mapping, code, 0);
        for code in [None, Some(0), Some(1), Some(4), Some(101)] {
            assert_eq!(decide(code), Decision::Restart(Duration::ZERO), "{code:?}");
        }
        let why = "it does not accept its configuration, its arguments or its seat";
        assert_eq!(decide(Some(2)), Decision::GiveUp(why));
        let why = "it was built from another contract";
        assert_eq!(decide(Some(3)), Decision::GiveUp(why));
        let robot = Restarts::default().decide(&spec, Role::Robot, Some(4), 0);
        assert_eq!(robot, Decision::GiveUp("the robot is not restarted"));
        let spec = RestartSpec {
            robot: true,
            ..spec
        };
        let bridge = Restarts::default().decide(&spec, Role::Robot, None, 0);
        assert_eq!(bridge, Decision::Restart(Duration::ZERO));
    }
}
