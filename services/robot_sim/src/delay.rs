//! The time between a command's arrival and its taking effect.

use std::collections::VecDeque;
use zeronav_motion::Twist;

/// Most commands on their way; with more, the oldest takes effect early.
const COMMANDS_MAX: usize = 16_384;

/// Commands on their way to the motors.
#[derive(Debug, Clone)]
pub struct Delay {
    length_ns: u64,
    /// When each takes effect, in order. [ns]
    coming: VecDeque<(u64, Option<Twist>)>,
    present: Option<Twist>,
}

impl Delay {
    /// A line of `delay_ns`, without any command yet.
    #[must_use]
    pub fn new(delay_ns: u64) -> Self {
        Self {
            length_ns: delay_ns,
            coming: VecDeque::new(),
            present: None,
        }
    }

    /// A command, or that there is none any more, arrives at `run_ns`. A later one of the same
    /// moment replaces it.
    pub fn push(&mut self, run_ns: u64, set_point: Option<Twist>) {
        let takes_effect_ns = run_ns.saturating_add(self.length_ns);
        if self
            .coming
            .back()
            .is_some_and(|last| last.0 == takes_effect_ns)
        {
            self.coming.pop_back();
        }
        if self.coming.len() == COMMANDS_MAX
            && let Some((_, oldest)) = self.coming.pop_front()
        {
            self.present = oldest;
        }
        self.coming.push_back((takes_effect_ns, set_point));
    }

    /// What the motors obey from `run_ns` on; `None` before the first command took effect.
    pub fn set_point(&mut self, run_ns: u64) -> Option<Twist> {
        while let Some((takes_effect_ns, set_point)) = self.coming.front().copied()
            && takes_effect_ns <= run_ns
        {
            self.present = set_point;
            self.coming.pop_front();
        }
        self.present
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn forward(v_mps: f64) -> Twist {
        Twist {
            v_mps,
            w_radps: 0.0,
        }
    }

    #[test]
    fn commands_take_effect_after_the_delay_and_in_order() {
        let mut line = Delay::new(50);
        line.push(0, Some(forward(1.0)));
        line.push(20, Some(forward(2.0)));
        line.push(20, Some(forward(3.0)));
        line.push(40, None);
        assert_eq!(line.set_point(49), None);
        assert_eq!(line.set_point(50), Some(forward(1.0)));
        assert_eq!(line.set_point(69), Some(forward(1.0)));
        assert_eq!(line.set_point(89), Some(forward(3.0)));
        assert_eq!(line.set_point(90), None);
    }

    #[test]
    fn without_delay_the_newest_counts_at_once() {
        let mut line = Delay::new(0);
        line.push(7, Some(forward(1.0)));
        line.push(7, Some(forward(2.0)));
        assert_eq!(line.set_point(7), Some(forward(2.0)));
    }

    #[test]
    fn too_many_commands_take_no_more_room() {
        let mut line = Delay::new(1_000_000);
        for run_ns in 0..50_000 {
            line.push(run_ns, Some(forward(1.0)));
        }
        assert_eq!(line.coming.len(), COMMANDS_MAX);
        assert_eq!(line.set_point(0), Some(forward(1.0)));
    }
}
