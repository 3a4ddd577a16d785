//! When a message was captured and received, and how old it is.

use zeronav_msgs::header::Header;

/// When a message was captured and when it came in.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Received {
    /// Tick.
    pub tick: u64,
    /// Run time. [ns]
    pub run_ns: u64,
    /// Capture of the newest sensor data in it, monotonic, as its author says. [ns]
    pub capture_ns: u64,
    /// When it came in, by this process's own clock. [ns]
    pub came_ns: u64,
}

impl Received {
    /// The times of a message that came in at `came_ns`.
    #[must_use]
    pub fn of(header: &Header, came_ns: u64) -> Self {
        Self {
            tick: header.tick,
            run_ns: header.run_ns,
            capture_ns: header.capture_ns,
            came_ns,
        }
    }

    /// The same message, as old as its arrival whatever it was made from: what counts is that its
    /// author still sends.
    #[must_use]
    pub fn on_arrival(self) -> Self {
        Self {
            capture_ns: self.came_ns,
            ..self
        }
    }

    /// Its age at run time `run_ns`, which is `now_ns` by this process's own clock. [ns]
    ///
    /// Run time in lockstep. Otherwise the own clock, which bounds what a foreign stamp may claim:
    /// a capture stamped later than the arrival does not count.
    #[must_use]
    pub fn age_ns(&self, lockstep: bool, run_ns: u64, now_ns: u64) -> u64 {
        if lockstep {
            run_ns.saturating_sub(self.run_ns)
        } else {
            now_ns.saturating_sub(self.capture_ns.min(self.came_ns))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ages_are_run_time_in_lockstep_and_the_own_clock_otherwise() {
        let message = Received {
            tick: 3,
            run_ns: 60,
            capture_ns: 1_000,
            came_ns: 1_200,
        };
        assert_eq!(message.age_ns(true, 100, 9_000), 40);
        assert_eq!(message.age_ns(true, 50, 9_000), 0);
        assert_eq!(message.age_ns(false, 100, 9_000), 8_000);
        // A capture from the future is not believed.
        let ahead = Received {
            capture_ns: 5_000,
            ..message
        };
        assert_eq!(ahead.age_ns(false, 100, 9_000), 7_800);
    }
}
