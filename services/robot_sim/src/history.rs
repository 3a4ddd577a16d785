//! Where the robot was while the lidar turned.

use crate::drive::Motion;
use std::collections::VecDeque;
use zeronav_msgs::Pose;
use zeronav_msgs::time::seconds;

/// The motion of one tick.
#[derive(Debug, Clone)]
pub struct Stretch {
    /// [ns] run time at which it begins.
    pub from_run_ns: u64,
    /// [ns] run time at which it ends.
    pub to_run_ns: u64,
    /// The motion, if nothing was in the way.
    pub motion: Motion,
    /// When, in seconds after its beginning, and where a contact ended it.
    pub stopped: Option<(f64, Pose)>,
}

/// The last ticks.
#[derive(Debug, Clone)]
pub struct History {
    /// Where it was before the first of them.
    before: Pose,
    stretches: VecDeque<Stretch>,
    memory_ns: u64,
}

impl History {
    /// A robot that has stood at `start` so far; `memory_ns` is remembered beside the newest tick.
    #[must_use]
    pub fn new(start: Pose, memory_ns: u64) -> Self {
        Self {
            before: start,
            stretches: VecDeque::new(),
            memory_ns,
        }
    }

    /// Adds a tick behind the others.
    pub fn push(&mut self, stretch: Stretch) {
        let old_ns = stretch.from_run_ns.saturating_sub(self.memory_ns);
        self.stretches.push_back(stretch);
        while let Some(oldest) = self.stretches.front()
            && oldest.to_run_ns < old_ns
        {
            self.before = oldest.at(oldest.to_run_ns);
            self.stretches.pop_front();
        }
    }

    /// `map_from_base` at `run_ns`, within the last ticks.
    #[must_use]
    pub fn at(&self, run_ns: u64) -> Pose {
        let next = self
            .stretches
            .partition_point(|it| it.from_run_ns <= run_ns);
        let stretch = next
            .checked_sub(1)
            .and_then(|last| self.stretches.get(last));
        stretch.map_or(self.before, |stretch| stretch.at(run_ns))
    }
}

impl Stretch {
    fn at(&self, run_ns: u64) -> Pose {
        let into_s = seconds(run_ns.saturating_sub(self.from_run_ns));
        match self.stopped {
            Some((at_s, pose)) if into_s >= at_s => pose,
            _ => self.motion.at(into_s).pose,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::drive::DriveLimits;
    use crate::drive_state::DriveState;
    use zeronav_motion::Twist;

    const TICK_NS: u64 = 20_000_000;

    const LIMITS: DriveLimits = DriveLimits {
        v_mps_max: 1.0,
        v_mps_min: 0.0,
        w_radps_max: 1.0,
        speed_up_mps2: 1.0,
        slow_down_mps2: 1.0,
        alpha_radps2: 1.0,
    };

    /// Ticks at 1 m/s along x; the last is stopped half way.
    fn drive(ticks: u64, memory_ns: u64) -> History {
        let mut history = History::new(Pose::default(), memory_ns);
        let twist = Twist {
            v_mps: 1.0,
            w_radps: 0.0,
        };
        let mut pose = Pose::default();
        for tick in 0..ticks {
            let motion = Motion::towards(DriveState { pose, twist }, twist, &LIMITS, 0.02);
            let stopped = (tick + 1 == ticks).then(|| (0.01, motion.at(0.01).pose));
            pose = motion.at(0.02).pose;
            history.push(Stretch {
                from_run_ns: tick * TICK_NS,
                to_run_ns: (tick + 1) * TICK_NS,
                motion,
                stopped,
            });
        }
        history
    }

    #[track_caller]
    fn check(history: &History, run_ns: u64, x_m: f64) {
        let at = history.at(run_ns);
        assert!((at.x_m - x_m).abs() < 1e-12, "{at:?}, not {x_m}");
    }

    #[test]
    fn every_moment_of_the_memory_is_known() {
        let history = drive(20, 10 * TICK_NS);
        // The newest tick began at 380 ms, so from 180 ms on.
        check(&history, 180_000_000, 0.18);
        check(&history, 275_500_000, 0.2755);
        check(&history, 390_000_000, 0.39);
        check(&history, 399_000_000, 0.39);
        assert!(history.stretches.len() <= 13, "{}", history.stretches.len());
        // What is forgotten is where it was last remembered.
        check(&history, 0, 0.16);
    }

    #[test]
    fn before_the_first_tick_it_stood_at_the_start() {
        check(&History::new(Pose::new(3.0, 0.0, 0.0), 0), 5, 3.0);
        let history = drive(2, 0);
        check(&history, 0, 0.0);
        check(&history, 30_000_000, 0.03);
    }
}
