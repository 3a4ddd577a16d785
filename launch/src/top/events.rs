//! What happened, the newest last, in bounded memory.

use super::view::EventLine;
use std::collections::VecDeque;
use zeronav_msgs::time::seconds;

/// Events that are kept; the oldest go first.
const EVENTS_MAX: usize = 200;

/// The same words within this time are said once. [ns]
const AGAIN_NS: u64 = 1_000_000_000;

/// What happened.
#[derive(Debug, Default)]
pub(super) struct Events {
    lines: VecDeque<EventLine>,
    /// What the guard did last, and when. [ns]
    guard: Option<(&'static str, u64)>,
}

impl Events {
    /// Notes an event at this run time. [s]
    pub(super) fn add_at(&mut self, time_s: f64, kind: &'static str, text: String) {
        if self.lines.len() == EVENTS_MAX {
            self.lines.pop_front();
        }
        // What the stack tells late is put where it belongs.
        let later = self.lines.iter().rev();
        let later = later.take_while(|line| line.time_s > time_s).count();
        let at = self.lines.len() - later;
        self.lines.insert(at, EventLine { time_s, kind, text });
    }

    /// Notes an event at this run time. [ns]
    pub(super) fn add(&mut self, run_ns: u64, kind: &'static str, text: String) {
        self.add_at(seconds(run_ns), kind, text);
    }

    /// The guard does this to a request. An intervention that goes on, or comes again at once, is one.
    pub(super) fn guard(&mut self, run_ns: u64, does: &'static str) {
        let before = self.guard.replace((does, run_ns));
        let again = before.is_some_and(|(before, at_ns)| {
            before == does && run_ns.saturating_sub(at_ns) < AGAIN_NS
        });
        if !again {
            self.add(run_ns, "guard", does.to_owned());
        }
    }

    /// All of them.
    pub(super) fn lines(&self) -> Vec<EventLine> {
        self.lines.iter().cloned().collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_intervention_that_goes_on_is_one_event() {
        let mut events = Events::default();
        let ms = 1_000_000;
        for at in [0, 20, 40, 900, 1800, 3000] {
            events.guard(at * ms, "slowed");
        }
        events.guard(3020 * ms, "stopped_short");
        let said: Vec<(f64, String)> = (events.lines().into_iter())
            .map(|line| (line.time_s, line.text))
            .collect();
        let expected = [(0.0, "slowed"), (3.0, "slowed"), (3.02, "stopped_short")];
        assert_eq!(
            said,
            expected.map(|(time_s, text)| (time_s, text.to_owned()))
        );
    }

    #[test]
    fn events_are_bounded_and_in_order() {
        let mut events = Events::default();
        for n in 0..300 {
            events.add(n * 1_000_000_000, "path", n.to_string());
        }
        events.add_at(298.5, "restart", "late".to_owned());
        let lines = events.lines();
        assert_eq!(lines.len(), EVENTS_MAX);
        assert_eq!(lines[lines.len() - 2].text, "late");
        assert!(
            lines
                .windows(2)
                .all(|pair| pair[0].time_s <= pair[1].time_s)
        );
    }
}
