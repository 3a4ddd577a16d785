//! How fast a lockstep stack goes. Pure.

use std::time::{Duration, Instant};
use zeronav_casts::Cast;

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
    pub(super) fn granted(&mut self, robot_tick: u64, now: Instant) -> u64 {
        let (tick, since) = self.from;
        let elapsed_s = now.saturating_duration_since(since).as_secs_f64();
        let granted = tick + (elapsed_s * self.factor / self.tick.as_secs_f64()).to_u64();
        if granted > robot_tick + BEHIND_MAX {
            self.restart(robot_tick + BEHIND_MAX, now);
        }
        granted.min(robot_tick + BEHIND_MAX)
    }
}

/// How fast a lockstep stack goes: as was asked, otherwise as fast as it can while it has a goal, and in
/// real time while it has none.
#[derive(Debug, Default)]
pub(super) struct Speed {
    asked: Option<Pace>,
    idle: Option<Pace>,
}

impl Speed {
    /// From now on at this pace; `None` = as described above.
    pub(super) fn ask(&mut self, pace: Option<Pace>) {
        self.asked = pace;
    }

    /// The factor that was asked for.
    pub(super) fn factor(&self) -> Option<f64> {
        self.asked.map(|pace| pace.factor)
    }

    /// From this tick and moment on.
    pub(super) fn restart(&mut self, robot_tick: u64, now: Instant) {
        self.idle = None;
        if let Some(pace) = &mut self.asked {
            pace.restart(robot_tick, now);
        }
    }

    /// The tick up to which the robot may go now, with ticks of this length; `u64::MAX` = any.
    pub(super) fn granted(
        &mut self,
        is_idle: bool,
        tick: Duration,
        robot_tick: u64,
        now: Instant,
    ) -> u64 {
        if let Some(pace) = &mut self.asked {
            return pace.granted(robot_tick, now);
        }
        if !is_idle {
            self.idle = None;
            return u64::MAX;
        }
        let real_time = || Pace::new(1.0, tick, robot_tick, now);
        let pace = self.idle.get_or_insert_with(real_time);
        pace.granted(robot_tick, now)
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

    #[test]
    fn without_a_goal_run_time_is_real_time_and_with_one_there_is_no_limit() {
        let began = Instant::now();
        let mut speed = Speed::default();
        assert_eq!(speed.granted(false, TICK, 7, began), u64::MAX);
        assert_eq!(speed.granted(true, TICK, 7, began), 7);
        assert_eq!(speed.granted(true, TICK, 7, began + 2 * TICK), 9);
        assert_eq!(speed.granted(false, TICK, 9, began + 2 * TICK), u64::MAX);
        let later = began + 50 * TICK;
        assert_eq!(speed.granted(true, TICK, 900, later), 900, "no arrears");
        speed.ask(Some(Pace::new(4.0, TICK, 900, later)));
        assert_eq!(speed.granted(true, TICK, 900, later + TICK), 904);
    }
}
