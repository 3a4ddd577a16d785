//! After how long the wheels obey, as the run itself shows it: the delay with which the commands explain
//! the speeds that odometry tells, against the one that the robot's description declares.
//!
//! For every delay that a robot may have, the speeds of each odometry are predicted from those of the one
//! before and the command that would be obeyed by then, within the robot's accelerations; the delay with
//! the least error is the one of the robot.

use crate::result::CommandLag;
use std::collections::VecDeque;
use zeronav_msgs::command::VelocityCommand;
use zeronav_msgs::description::Description;
use zeronav_msgs::odometry::Odometry;
use zeronav_msgs::time::seconds;

/// [ns] from one delay that is tried to the next, and how many are.
const STEP_NS: u64 = 20_000_000;
const STEPS: usize = 51;

/// Commands that are kept: a second of more than a control loop sends.
const COMMANDS_MAX: usize = 1024;

/// Odometry at which the delays that are tried must tell the speeds apart, before one is believed.
const TOLD_APART_MIN: u64 = 50;

/// Share of the declared delay's error that the best one may have to be believed instead.
const BETTER_SHARE: f64 = 0.5;

/// [ns] by which a delay may be off its declaration: what is tried is no finer.
const SAME_NS: u64 = STEP_NS;

/// [m/s] forward and [rad/s] of yaw.
type Speeds = [f64; 2];

/// The speeds after obeying a command, when each can change by a step.
fn obeyed(before: Speeds, command: Speeds, steps: [f64; 2]) -> Speeds {
    [0, 1].map(|of| command[of].clamp(before[of] - steps[of], before[of] + steps[of]))
}

/// Of a run so far.
#[derive(Debug, Clone, Default)]
pub struct LagSeen {
    robot: Option<Description>,
    commands: VecDeque<(u64, Speeds)>,
    last: Option<(u64, Speeds)>,
    errors: Vec<f64>,
    told_apart: u64,
}

impl LagSeen {
    /// What the robot says of itself.
    pub const fn description(&mut self, robot: &Description) {
        self.robot = Some(*robot);
    }

    /// A command, sent at `run_ns`.
    pub fn command(&mut self, run_ns: u64, command: &VelocityCommand) {
        while self.commands.back().is_some_and(|last| last.0 >= run_ns) {
            self.commands.pop_back();
        }
        if self.commands.len() == COMMANDS_MAX {
            self.commands.pop_front();
        }
        let speeds = [command.v_mps, command.w_radps];
        self.commands.push_back((run_ns, speeds));
    }

    /// Odometry of `run_ns`.
    pub fn odometry(&mut self, run_ns: u64, odometry: &Odometry) {
        let speeds = [odometry.v_mps, odometry.w_radps];
        let before = self.last.replace((run_ns, speeds));
        let (Some(robot), Some((before_ns, before))) = (&self.robot, before) else {
            return;
        };
        let elapsed_ns = run_ns.saturating_sub(before_ns);
        if elapsed_ns == 0 || elapsed_ns > STEP_NS {
            return;
        }
        let elapsed_s = seconds(elapsed_ns);
        let rates = [
            robot.a_mps2_max.max(robot.brake_mps2),
            robot.alpha_radps2_max,
        ];
        let steps = rates.map(|rate| rate * elapsed_s);
        let mut errors = [0.0; STEPS];
        for (delay, error) in errors.iter_mut().enumerate() {
            let delay_ns = delay as u64 * STEP_NS;
            let sent = self
                .commands
                .partition_point(|(sent_ns, _)| sent_ns.saturating_add(delay_ns) <= before_ns);
            // What was sent before is not known for every delay yet.
            let Some((_, command)) = sent.checked_sub(1).and_then(|it| self.commands.get(it))
            else {
                return;
            };
            let expected = obeyed(before, *command, steps);
            let off = [0, 1].map(|of| ((speeds[of] - expected[of]) / steps[of]).abs().min(1.0));
            *error = off[0] + off[1];
        }
        let most = errors.iter().copied().fold(0.0, f64::max);
        let least = errors.iter().copied().fold(f64::INFINITY, f64::min);
        if most - least < 0.1 {
            return;
        }
        self.told_apart += 1;
        self.errors.resize(STEPS, 0.0);
        for (sum, error) in self.errors.iter_mut().zip(errors) {
            *sum += error;
        }
    }

    /// The delay that was seen, when it is not the one that is declared; `None` when it is, or the run
    /// does not tell.
    pub fn result(&self) -> Option<CommandLag> {
        let declared_ns = self.robot?.actuation_delay_ns;
        if self.told_apart < TOLD_APART_MIN {
            return None;
        }
        let errors = self.errors.iter().enumerate();
        let (best, least) = errors.min_by(|a, b| a.1.total_cmp(b.1))?;
        let seen_ns = best as u64 * STEP_NS;
        let near = usize::try_from(declared_ns / STEP_NS).ok()?;
        let around = [near, near + 1].into_iter();
        let declared = around.filter_map(|at| self.errors.get(at).copied());
        let declared = declared.fold(f64::INFINITY, f64::min);
        let differs = seen_ns.abs_diff(declared_ns) > SAME_NS && *least < BETTER_SHARE * declared;
        differs.then(|| CommandLag {
            seen_s: seconds(seen_ns),
            declared_s: seconds(declared_ns),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A robot that declares one delay and has another, in periods of 20 ms; what a run shows.
    fn shown(declared: u64, real: usize, moves: bool) -> Option<CommandLag> {
        let robot = Description {
            v_mps_max: 1.0,
            w_radps_max: 2.0,
            a_mps2_max: 1.0,
            brake_mps2: 1.0,
            alpha_radps2_max: 4.0,
            actuation_delay_ns: declared * STEP_NS,
            ..Description::default()
        };
        let mut seen = LagSeen::default();
        seen.description(&robot);
        let mut sent = Vec::new();
        let mut speeds = [0.0; 2];
        for tick in 1..1500_u32 {
            let run_ns = u64::from(tick) * STEP_NS;
            // Odometry's speeds shake a little.
            let noise = 0.002 * f64::from(tick * 7919 % 13) / 13.0;
            let odometry = Odometry {
                v_mps: speeds[0] + noise,
                w_radps: speeds[1] - noise,
                ..Odometry::default()
            };
            seen.odometry(run_ns, &odometry);
            let (slow, fast) = (f64::from(tick) * 0.03, f64::from(tick) * 0.11);
            let asked = if moves {
                [0.4 + 0.3 * slow.sin(), fast.sin()]
            } else {
                [0.0; 2]
            };
            let command = VelocityCommand {
                v_mps: asked[0],
                w_radps: asked[1],
                ..VelocityCommand::default()
            };
            seen.command(run_ns, &command);
            sent.push(asked);
            let command = sent
                .len()
                .checked_sub(1 + real)
                .map_or([0.0; 2], |at| sent[at]);
            speeds = super::obeyed(speeds, command, [0.02, 0.08]);
        }
        seen.result()
    }

    #[test]
    fn a_delay_that_is_not_declared_is_found_and_one_that_is_is_not_told() {
        for (ticks, late_s) in [(3, 0.06), (14, 0.28), (30, 0.6)] {
            assert_eq!(shown(ticks as u64, ticks, true), None);
            let found = shown(0, ticks, true).expect("not what it says");
            assert!((found.seen_s - late_s).abs() < 1e-9, "{found:?}");
            assert!(found.declared_s.abs() < 1e-9);
        }
        let found = shown(15, 0, true).expect("not what it says");
        assert!(found.seen_s.abs() < 1e-9 && (found.declared_s - 0.3).abs() < 1e-9);
        assert_eq!(shown(0, 0, true), None);
        assert_eq!(
            shown(15, 0, false),
            None,
            "a robot that stands tells nothing"
        );
    }
}
