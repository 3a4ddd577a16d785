//! `[restart]` of a scenario: how often a seat is filled again, and what counts as hung.

use core::time::Duration;
use zeronav_params::parameters;

parameters! {
    /// Budgets and the hang limit, `[restart]` of a scenario.
    pub struct RestartSpec {
        /// Most restarts of one service within `window_s`.
        per_service: u32 = 10, [0, 10_000];
        /// Most restarts of all services together within `window_s`.
        per_run: u32 = 30, [0, 10_000];
        /// Run time after which a restart counts no more.
        window_s: f64 = 3600.0, [1.0, 1.0e6] "s";
        /// Time without progress after which a service counts as hung. A service without work beats
        /// every 50 ms, so that a limit below 0.1 s would kill healthy ones.
        hang_after_s: f64 = 0.5, [0.1, 3600.0] "s";
        /// Ticks for which a restarted seat stays empty, lockstep only.
        absent_ticks: u64 = 20, [0, 1_000_000];
        /// The program in the robot's seat is restarted, too, in real time: the bridge to a robot that goes on by
        /// itself. A simulated robot is not: its world would be lost.
        robot: bool = false;
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
