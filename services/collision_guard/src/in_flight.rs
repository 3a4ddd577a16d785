//! What the guard has sent and the robot has not obeyed yet.
//!
//! The guard keeps this apart from `zeronav_motion`'s on purpose, as it does its arithmetic: see
//! [`crate::limits`].

use crate::sweep::Leg;
use std::collections::VecDeque;
use zeronav_motion::Twist;
use zeronav_msgs::description::ACTUATION_DELAY_NS_MAX;
use zeronav_msgs::time::seconds;

/// Most commands kept; with more on their way, the oldest are taken for obeyed.
const COMMANDS_MAX: usize = 4096;

/// [ns] for which commands are kept: until they are obeyed, as seen by odometry that is late.
const KEPT_NS: u64 = ACTUATION_DELAY_NS_MAX + 1_000_000_000;

/// The commands on their way to the wheels.
#[derive(Debug, Clone)]
pub(crate) struct InFlight {
    /// Run time at which each was sent [ns], rising.
    sent: VecDeque<(u64, Twist)>,
    /// Newest odometry. [ns]
    odometry_ns: u64,
    /// When a command of this decision is sent. [ns]
    now_ns: u64,
}

impl Default for InFlight {
    fn default() -> Self {
        Self {
            sent: VecDeque::with_capacity(COMMANDS_MAX),
            odometry_ns: 0,
            now_ns: 0,
        }
    }
}

impl InFlight {
    /// A decision begins `period_ns` after the one before. It is dated by odometry; while that is late,
    /// by the time since.
    pub(crate) fn begin(&mut self, odometry_ns: Option<u64>, period_ns: u64) {
        match odometry_ns.filter(|run_ns| *run_ns != self.odometry_ns) {
            Some(run_ns) => (self.odometry_ns, self.now_ns) = (run_ns, run_ns),
            None => self.now_ns = self.now_ns.saturating_add(period_ns),
        }
    }

    /// The command of this decision. It replaces what was sent no earlier.
    pub(crate) fn send(&mut self, command: Twist) {
        let now_ns = self.now_ns;
        while self.sent.back().is_some_and(|last| last.0 >= now_ns) {
            self.sent.pop_back();
        }
        let is_over = |next: &(u64, Twist)| next.0.saturating_add(KEPT_NS) <= now_ns;
        while self.sent.len() == COMMANDS_MAX || self.sent.get(1).is_some_and(is_over) {
            self.sent.pop_front();
        }
        self.sent.push_back((now_ns, command));
    }

    /// What the robot does from its newest odometry until a command of now takes effect, which
    /// `delay_ns` after it was sent each of them does: the commands on their way one after the other.
    /// As long as none that is known has taken effect, the robot goes on as it does.
    pub(crate) fn legs(&self, delay_ns: u64) -> impl Iterator<Item = Leg> {
        let end_ns = if delay_ns == 0 {
            self.odometry_ns
        } else {
            self.now_ns.saturating_add(delay_ns)
        };
        let effects = self.sent.iter().map(move |(sent_ns, command)| {
            let from_ns = sent_ns.saturating_add(delay_ns);
            (from_ns.min(end_ns), Some(*command))
        });
        let (mut now_ns, mut obeyed) = (self.odometry_ns, None);
        effects
            .chain([(end_ns, None)])
            .filter_map(move |(until_ns, next)| {
                let before = core::mem::replace(&mut obeyed, next);
                let lasts_s = seconds(until_ns.saturating_sub(now_ns));
                now_ns = now_ns.max(until_ns);
                let leg = before.map_or(Leg::Keep(lasts_s), |command| Leg::Obey(command, lasts_s));
                (lasts_s > 0.0).then_some(leg)
            })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: u64 = 1_000_000;

    /// (None = keeps its twist, else the speed obeyed; for how long in ms).
    fn legs(in_flight: &InFlight, delay_ns: u64) -> Vec<(Option<f64>, f64)> {
        let ms = |lasts_s: f64| (lasts_s * 1.0e3).round();
        in_flight
            .legs(delay_ns)
            .map(|leg| match leg {
                Leg::Keep(lasts_s) => (None, ms(lasts_s)),
                Leg::Obey(twist, lasts_s) => (Some(twist.v_mps), ms(lasts_s)),
                Leg::Brake => panic!("nobody brakes by itself"),
            })
            .collect()
    }

    #[test]
    fn each_command_is_obeyed_from_its_delay_on_until_the_next_one_is() {
        let mut in_flight = InFlight::default();
        for (n, v_mps) in [(1, 0.1), (2, 0.2), (3, 0.3), (4, 0.4)] {
            in_flight.begin(Some(n * 20 * MS), 20 * MS);
            in_flight.send(Twist::new(v_mps, 0.0));
        }
        in_flight.begin(Some(100 * MS), 20 * MS);
        assert_eq!(legs(&in_flight, 0), []);
        assert_eq!(
            legs(&in_flight, 50 * MS),
            [(Some(0.2), 10.0), (Some(0.3), 20.0), (Some(0.4), 20.0)]
        );
        // The oldest one known has not taken effect.
        assert_eq!(
            legs(&in_flight, 110 * MS),
            [
                (None, 30.0),
                (Some(0.1), 20.0),
                (Some(0.2), 20.0),
                (Some(0.3), 20.0),
                (Some(0.4), 20.0)
            ]
        );
        // Two periods later, still by the same odometry.
        in_flight.begin(Some(100 * MS), 20 * MS);
        in_flight.send(Twist::new(0.5, 0.0));
        in_flight.begin(Some(100 * MS), 20 * MS);
        assert_eq!(
            legs(&in_flight, 40 * MS),
            [(Some(0.3), 20.0), (Some(0.4), 40.0), (Some(0.5), 20.0)]
        );
    }

    #[test]
    fn a_command_replaces_what_was_sent_no_earlier_and_the_memory_is_bounded() {
        let mut in_flight = InFlight::default();
        in_flight.begin(Some(100), 0);
        in_flight.send(Twist::new(0.1, 0.0));
        in_flight.begin(None, 50);
        in_flight.send(Twist::new(0.2, 0.0));
        // Late odometry comes after all.
        in_flight.begin(Some(120), 20);
        in_flight.send(Twist::new(0.3, 0.0));
        let kept: Vec<(u64, f64)> = in_flight.sent.iter().map(|it| (it.0, it.1.v_mps)).collect();
        assert_eq!(kept, [(100, 0.1), (120, 0.3)]);
        for n in 0..10_000 {
            in_flight.begin(Some(1000 + n), 1);
            in_flight.send(Twist::REST);
        }
        assert_eq!(in_flight.sent.len(), COMMANDS_MAX);
        in_flight.begin(Some(10 * KEPT_NS), 1);
        in_flight.send(Twist::REST);
        assert_eq!(in_flight.sent.len(), 2);
    }
}
