//! How fast a lockstep stack goes. Pure.

use std::time::{Duration, Instant};

/// Speeds that can be asked for, in parts of real time.
pub(super) const SPEEDS: [f64; 2] = [0.01, 100.0];

/// Ticks that a stack may be behind and makes up for.
const BEHIND_MAX: u64 = 5;

/// Grants ticks as wall time passes.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pace {
    /// Run time per wall time.
    pub factor: f64,
    tick: Duration,
    /// The tick that was granted at this moment.
    from: (u64, Instant),
}

impl Pace {
    /// From this tick and moment on, with ticks of this length.
    pub(super) fn new(factor: f64, tick: Duration, robot_tick: u64, now: Instant) -> Self {
        Self {
            factor,
            tick,
            from: (robot_tick, now),
        }
    }

    /// From this tick and moment on.
    pub(super) fn restart(&mut self, robot_tick: u64, now: Instant) {
        self.from = (robot_tick, now);
    }

    /// The tick up to which the robot may go now, [`BEHIND_MAX`] after its own at most: what a slow
    /// stack is behind by more is not made up for.
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "not negative, and a run is shorter than 2^63 ticks"
    )]
    pub(super) fn granted(&mut self, robot_tick: u64, now: Instant) -> u64 {
        let (tick, since) = self.from;
        let elapsed_s = now.saturating_duration_since(since).as_secs_f64();
        let granted = tick + (elapsed_s * self.factor / self.tick.as_secs_f64()) as u64;
        if granted > robot_tick + BEHIND_MAX {
            self.restart(robot_tick + BEHIND_MAX, now);
        }
        granted.min(robot_tick + BEHIND_MAX)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TICK: Duration = Duration::from_millis(20);

    #[test]
    fn ticks_come_as_fast_as_was_asked() {
        for (factor, after_1_s) in [(0.25, 12), (1.0, 50), (4.0, 200)] {
            let began = Instant::now();
            let mut pace = Pace::new(factor, TICK, 1000, began);
            let mut robot_tick = 1000;
            for ms in 0..=1001 {
                let now = began + Duration::from_millis(ms);
                let granted = pace.granted(robot_tick, now);
                assert!(granted >= robot_tick, "never back");
                robot_tick = granted;
            }
            assert_eq!(robot_tick, 1000 + after_1_s);
        }
    }

    #[test]
    fn a_stack_that_stands_still_is_never_held_and_makes_up_for_little() {
        let began = Instant::now();
        let mut pace = Pace::new(1.0, TICK, 5, began);
        let later = began + Duration::from_secs(60);
        for n in 0..3 {
            assert_eq!(pace.granted(5, later + n * TICK), 5 + BEHIND_MAX);
        }
        assert_eq!(
            pace.granted(5 + BEHIND_MAX, later + 3 * TICK),
            6 + BEHIND_MAX
        );
        pace.restart(100, later);
        assert_eq!(pace.granted(100, later + TICK), 101);
    }
}
