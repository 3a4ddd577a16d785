//! Commands that are on their way to the wheels, and where they take the robot.
//!
//! A robot with an actuation delay obeys what was sent some time ago. Whoever chooses the next command
//! starts from where that one takes effect: the Smith predictor (Smith, "Closer control of loops with
//! dead time", 1957) as a prediction of the state, for which the commands on their way are known.

use crate::limits::reachable;
use crate::twist::Twist;
use std::collections::VecDeque;
use zeronav_msgs::Pose;
use zeronav_msgs::description::{ACTUATION_DELAY_NS_MAX, Description};
use zeronav_msgs::time::seconds;

/// Most commands kept; with more on their way, the oldest are taken for obeyed.
const COMMANDS_MAX: usize = 4096;

/// [ns] longest step of a prediction.
const STEP_NS: u64 = 20_000_000;

/// The commands of the last [`ACTUATION_DELAY_NS_MAX`], in the order in which they were sent.
#[derive(Debug, Clone)]
pub struct InFlight {
    /// Run time at which each was sent [ns], rising.
    sent: VecDeque<(u64, Twist)>,
}

/// Where the robot will be when the next command takes effect.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ahead {
    /// [s] from now.
    pub elapsed_s: f64,
    /// `base_now_from_base_then`.
    pub shift: Pose,
    /// Its twist there.
    pub twist: Twist,
}

impl Default for InFlight {
    fn default() -> Self {
        Self {
            sent: VecDeque::with_capacity(COMMANDS_MAX),
        }
    }
}

impl InFlight {
    /// Takes in a command sent at `run_ns`. One that is not sent later than one before replaces it.
    pub fn send(&mut self, run_ns: u64, command: Twist) {
        while self.sent.back().is_some_and(|last| last.0 >= run_ns) {
            self.sent.pop_back();
        }
        // What was replaced before any robot can obey it is no more needed.
        while self.sent.len() == COMMANDS_MAX
            || (self.sent.get(1))
                .is_some_and(|next| next.0.saturating_add(2 * ACTUATION_DELAY_NS_MAX) <= run_ns)
        {
            self.sent.pop_front();
        }
        self.sent.push_back((run_ns, command));
    }

    /// Where a robot that moves by `twist` at `run_ns` will be when a command sent now takes effect;
    /// `None` for a robot that obeys at once. As long as nothing is known of what it obeys, it goes on
    /// as it does.
    #[must_use]
    pub fn ahead(&self, robot: &Description, twist: Twist, run_ns: u64) -> Option<Ahead> {
        let delay_ns = robot.actuation_delay_ns;
        if delay_ns == 0 {
            return None;
        }
        let end_ns = run_ns.saturating_add(delay_ns);
        let mut ahead = Ahead {
            elapsed_s: seconds(delay_ns),
            shift: Pose::default(),
            twist,
        };
        let mut now_ns = run_ns;
        let effects = self.sent.iter().map(|(sent_ns, command)| {
            let from_ns = sent_ns.saturating_add(delay_ns);
            (from_ns.min(end_ns), Some(*command))
        });
        let mut obeyed = None;
        for (until_ns, next) in effects.chain([(end_ns, None)]) {
            while now_ns < until_ns {
                let step_ns = (until_ns - now_ns).min(STEP_NS);
                ahead.step(robot, obeyed, seconds(step_ns));
                now_ns += step_ns;
            }
            obeyed = next;
        }
        Some(ahead)
    }
}

impl Ahead {
    fn step(&mut self, robot: &Description, obeyed: Option<Twist>, step_s: f64) {
        let next = obeyed.map_or(self.twist, |command| {
            reachable(robot, self.twist, command, step_s)
        });
        self.shift = self.shift.then(&self.twist.mean(next).arc(step_s));
        self.twist = next;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TICK_NS: u64 = 20_000_000;

    fn robot(delay_ticks: u64) -> Description {
        Description {
            v_mps_max: 1.0,
            v_mps_min: -0.5,
            w_radps_max: 2.0,
            a_mps2_max: 1.0,
            brake_mps2: 2.0,
            alpha_radps2_max: 4.0,
            actuation_delay_ns: delay_ticks * TICK_NS,
            ..Description::default()
        }
    }

    /// A robot that obeys each command so many ticks late is where it was predicted to be, whatever it
    /// is told.
    #[test]
    fn the_robot_is_where_it_was_predicted_to_be() {
        let commands: Vec<Twist> = (0..120_u32)
            .map(|n| {
                let (slow, fast) = (f64::from(n) * 0.07, f64::from(n) * 0.23);
                Twist::new(0.25 + 0.6 * slow.sin(), 1.5 * fast.cos())
            })
            .collect();
        for delay_ticks in [1, 3, 15, 25] {
            let robot = robot(delay_ticks);
            let late = usize::try_from(delay_ticks).expect("a few");
            let mut in_flight = InFlight::default();
            let (mut poses, mut foretold) = (vec![(Pose::default(), Twist::REST)], Vec::new());
            for (n, command) in commands.iter().enumerate() {
                let (pose, twist) = poses[n];
                let run_ns = n as u64 * TICK_NS;
                let ahead = in_flight.ahead(&robot, twist, run_ns).expect("a delay");
                foretold.push((pose.then(&ahead.shift), ahead.twist));
                in_flight.send(run_ns, *command);
                let obeyed = n.checked_sub(late).map_or(Twist::REST, |n| commands[n]);
                let next = reachable(&robot, twist, obeyed, 0.02);
                poses.push((pose.then(&twist.mean(next).arc(0.02)), next));
            }
            for (n, (pose, twist)) in foretold.iter().enumerate().take(commands.len() - late) {
                let (there, is) = poses[n + late];
                assert!(
                    pose.distance_m(&there) < 1e-9,
                    "{delay_ticks}, {n}: {pose:?}"
                );
                assert!((pose.yaw_rad - there.yaw_rad).abs() < 1e-9, "{pose:?}");
                let off = (twist.v_mps - is.v_mps).abs() + (twist.w_radps - is.w_radps).abs();
                assert!(off < 1e-9, "{delay_ticks}, {n}: {twist:?} not {is:?}");
            }
        }
    }

    #[test]
    fn without_delay_there_is_nothing_ahead_and_without_commands_the_robot_goes_on() {
        let mut in_flight = InFlight::default();
        let twist = Twist::new(0.5, 0.0);
        assert_eq!(in_flight.ahead(&robot(0), twist, 0), None);
        let ahead = in_flight.ahead(&robot(10), twist, 0).expect("a delay");
        assert!((ahead.shift.x_m - 0.1).abs() < 1e-12 && ahead.twist == twist);
        // A command of the same moment replaces the one before, and one from the past what came after.
        in_flight.send(100, Twist::REST);
        in_flight.send(200, Twist::new(0.1, 0.0));
        in_flight.send(200, Twist::new(0.2, 0.0));
        in_flight.send(150, Twist::new(0.3, 0.0));
        let kept: Vec<(u64, f64)> = in_flight.sent.iter().map(|it| (it.0, it.1.v_mps)).collect();
        assert_eq!(kept, [(100, 0.0), (150, 0.3)]);
    }

    #[test]
    fn as_many_commands_are_kept_as_any_delay_needs_and_no_more() {
        let mut in_flight = InFlight::default();
        for n in 0..1000 {
            in_flight.send(n * TICK_NS, Twist::REST);
        }
        let kept_ns = in_flight.sent[in_flight.sent.len() - 1].0 - in_flight.sent[0].0;
        assert!(kept_ns >= ACTUATION_DELAY_NS_MAX && in_flight.sent.len() < 250);
        for n in 0..10_000 {
            in_flight.send(1000 * TICK_NS + n, Twist::REST);
        }
        assert_eq!(in_flight.sent.len(), COMMANDS_MAX);
    }
}
