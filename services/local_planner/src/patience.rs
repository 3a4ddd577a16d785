//! How long a task waits for what blocks its way and may go.

use zeronav_msgs::time::seconds;

/// The time spent waiting since the robot last came closer to its goal.
///
/// It is a sum: a way that opens for a moment and closes again before the robot has got on begins
/// nothing anew, so a goal is waited for at most so long without coming closer.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Patience {
    waited_ns: u64,
    /// The last period of a wait that goes on.
    last_ns: Option<u64>,
}

impl Patience {
    /// A period of waiting; how long it has waited. [s]
    pub(crate) fn wait(&mut self, run_ns: u64) -> f64 {
        let last_ns = self.last_ns.replace(run_ns).unwrap_or(run_ns);
        self.waited_ns += run_ns.saturating_sub(last_ns);
        seconds(self.waited_ns)
    }

    /// A period without: the time stands still. True when it has waited until now.
    pub(crate) fn pause(&mut self) -> bool {
        self.last_ns.take().is_some()
    }

    /// The robot has come closer.
    pub(crate) fn renew(&mut self) {
        self.waited_ns = 0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const S: u64 = 1_000_000_000;

    #[test]
    fn waits_add_up_until_the_robot_comes_closer() {
        let mut patience = Patience::default();
        let waited = |patience: &mut Patience, from_s: u64, to_s: u64| {
            (from_s..=to_s)
                .map(|at_s| patience.wait(at_s * S))
                .last()
                .unwrap_or(0.0)
        };
        assert!((waited(&mut patience, 3, 8) - 5.0).abs() < 1e-9);
        assert!(patience.pause() && !patience.pause());
        assert!((waited(&mut patience, 20, 22) - 7.0).abs() < 1e-9);
        patience.pause();
        patience.renew();
        assert!((waited(&mut patience, 30, 31) - 1.0).abs() < 1e-9);
    }
}
