//! What all controllers have in common, those of the papers too: arriving, verifying the stop, and
//! the command.
//!
//! A [`Pilot`] asks its chooser for an output (`pilot/scene.rs`, one method) and publishes the
//! part of the way towards it that one control period allows:
//!
//! - **What is published is checked itself**: hold the twist for the reaction time, then ramp to
//!   rest, on poses 3 cm apart, against the map and every point of the scan with the true outline,
//!   and against the predictions of tracked obstacles unless the controller ignores them. If that is
//!   not free, the chooser's next best wishes follow, then slowing down, then the stop that was
//!   checked the period before. So a verified stop exists at every moment, and choosers only decide
//!   what is wise.
//! - A robot inside the safety margin (noise, a new obstacle) may move as long as it does not come
//!   nearer.

mod arrive_and_turn;
pub(crate) mod limit;
pub(crate) mod perception;
pub(crate) mod scene;
pub(crate) mod verify;

use crate::dwa::options::DwaConfig;
use crate::shaping::{Shaper, ShapingConfig};
use crate::situation::{Decision, Situation};
use crate::surroundings::Surroundings;
use perception::{Perception, Tracks, horizon_s};
use scene::{BLOCKED_S, Choose, ControlOutput, Memory, Mode, Scene};
use verify::first_with_free_stop;
use zeronav_motion::{Twist, stop_distance_m, towards_rest};
use zeronav_msgs::command::{RequestCause, Validity};
use zeronav_msgs::rollouts::{Rollout, Rollouts};
use zeronav_msgs::stages::{Stage, StageTimer};

/// [s] of acceleration by which the last command may lead the measured twist: three
/// control periods of 20 ms. Commands start from the last command, not from the measurement,
/// so that latency does not halve the acceleration.
const COMMAND_LEAD_S: f64 = 0.06;

/// Twists that are tried at most, best first, when the best one is not free.
const RESERVE: usize = 6;

/// A controller: a chooser and what all choosers have in common.
#[derive(Debug)]
pub struct Pilot {
    config: DwaConfig,
    perception: Perception,
    memory: Memory,
    shaper: Shaper,
    chooser: Box<dyn Choose>,
    pub(crate) timer: StageTimer,
}

impl Pilot {
    /// A controller at rest. The numbers must be those that the range check of the configuration
    /// accepts.
    pub(crate) fn new(config: DwaConfig, tracks: Tracks, chooser: Box<dyn Choose>) -> Self {
        Self {
            config,
            perception: Perception::new(tracks),
            memory: Memory::default(),
            shaper: Shaper::new(ShapingConfig::OFF),
            chooser,
            timer: StageTimer::default(),
        }
    }

    /// The same with commands whose accelerations change no faster than this.
    #[must_use]
    pub fn shaped(self, config: ShapingConfig) -> Self {
        Self {
            shaper: Shaper::new(config),
            ..self
        }
    }

    /// From now on keeps what a period looks at, or no longer. Nothing is decided by it.
    pub fn record(&mut self, on: bool) {
        if on != self.memory.record.is_some() {
            self.memory.record = on.then(Box::default);
        }
    }

    /// What the last period looked at, while that is kept; `None` when it looked at nothing new.
    #[must_use]
    pub fn rollouts(&self) -> Option<(Rollouts, &[Rollout])> {
        self.memory.record.as_ref()?.message()
    }

    /// The twist that this period's command starts from: the last command, as far as the
    /// measured twist can have followed it.
    fn start(&self, situation: &Situation<'_>) -> Twist {
        let measured = Twist::new(situation.v_mps, situation.w_radps);
        self.memory
            .last
            .near(situation.robot, measured, COMMAND_LEAD_S)
    }

    /// The output of this period, or `None` without a path.
    fn output(&mut self, situation: &Situation<'_>, from: Twist) -> Option<ControlOutput> {
        let place = self.perception.tracker.advance(
            situation.path_geometry,
            situation.path,
            situation.map_from_base.point(),
        )?;
        self.perception.look(&self.config, situation, &place);
        self.timer.mark(Stage::Look);
        let mut scene = Scene {
            situation,
            config: &self.config,
            place,
            from,
            seen: &mut self.perception,
            memory: &mut self.memory,
        };
        let arriving = scene.arrive();
        if arriving.is_some() {
            self.chooser.forget();
        }
        let output = arriving.unwrap_or_else(|| self.chooser.choose(&mut scene));
        self.timer.mark(Stage::Rollouts);
        Some(output)
    }

    /// The twist for this period. Finite, within the robot's limits, reachable from the twist of
    /// the period before, and never one from which the robot cannot stop before contact as far as
    /// the map and the scan tell.
    ///
    /// Deterministic: the same sequence of situations gives the same decisions. After the first
    /// periods nothing is allocated.
    pub fn decide(&mut self, situation: &Situation<'_>) -> Decision {
        self.memory.begin(situation.goal.id);
        self.begin_record(situation);
        let from = self.start(situation);
        let Some(output) = self.output(situation, from) else {
            self.memory.mode = Mode::Follow;
            self.chooser.forget();
            return self.publish(situation, from, &ControlOutput::Rest(Validity::NoPath));
        };
        let blocked_arc_m = self.perception.blocked_arc_m();
        let against = self.memory.against;
        Decision {
            blocked_arc_m,
            against,
            ..self.publish(situation, from, &output)
        }
    }

    /// What is near the robot, tracked obstacles included, for a manoeuvre that follows no path, at
    /// least so far. [m]
    pub(crate) fn look_around(&mut self, situation: &Situation<'_>, reach_m: f64) -> &Surroundings {
        self.perception
            .look_around(&self.config, situation, reach_m);
        self.timer.mark(Stage::Look);
        &self.perception.surroundings
    }

    /// What was near in the last period that looked.
    pub(crate) const fn seen(&self) -> &Surroundings {
        &self.perception.surroundings
    }

    /// The command of a manoeuvre after [`Self::look_around`]: the step towards the first one wanted from
    /// which a stop is free, else the first step of a stop.
    pub(crate) fn manoeuvre(
        &mut self,
        situation: &Situation<'_>,
        mut wanted: impl Iterator<Item = Twist>,
    ) -> Decision {
        self.chooser.forget();
        self.begin_record(situation);
        let from = self.start(situation);
        let first = wanted.next();
        let command = self.command(situation, from, first.into_iter().chain(wanted));
        let first = first.filter(|_| command.is_some());
        self.end_record(situation, (from, first), 1);
        self.decision(situation, from, command.ok_or(Validity::Blocked))
    }

    /// A manoeuvre begins or ends: its commands are shaped by themselves.
    pub(crate) fn interrupted(&mut self) {
        self.shaper.interrupted();
    }

    /// Another command than the pilot's was published for a period: its next one starts there.
    pub fn overruled(&mut self, published: Twist) {
        self.shaper.interrupted();
        self.memory.last = published;
        self.chooser.forget();
        if let Some(record) = &mut self.memory.record {
            record.clear();
        }
    }

    /// The first step towards the output from which a stop is free; else the first step of a stop.
    fn publish(
        &mut self,
        situation: &Situation<'_>,
        from: Twist,
        output: &ControlOutput,
    ) -> Decision {
        let command = match output {
            ControlOutput::Rest(validity) => Err(*validity),
            ControlOutput::Towards(wanted) => self
                .command(situation, from, self.candidates(*wanted))
                .ok_or(Validity::Blocked),
        };
        self.tell(situation, from, output, command.ok().map(|(step, _)| step));
        let mut decision = self.decision(situation, from, command);
        // Not moving although a motion is wanted is being blocked, whatever the cause.
        let (robot, period_s) = (situation.robot, situation.period_s);
        let resting = matches!(
            output,
            ControlOutput::Rest(Validity::AtGoal | Validity::NoPath)
        );
        let idle = from.is_stopped()
            && decision.v_mps.abs() < 0.5 * robot.a_mps2_max * period_s
            && decision.w_radps.abs() < 0.5 * robot.alpha_radps2_max * period_s;
        let memory = &mut self.memory;
        memory.blocked_s = if resting || !idle {
            0.0
        } else {
            memory.blocked_s + period_s
        };
        if decision.validity == Validity::Drive && memory.blocked_s > BLOCKED_S {
            decision.validity = Validity::Blocked;
        }
        decision.turns = memory.turns && decision.validity == Validity::Drive;
        decision.rollouts = memory.rollouts;
        (decision.cause, decision.limit_mps) = match (decision.validity, output) {
            (Validity::Drive, ControlOutput::Towards(wanted)) => {
                self.memory
                    .limit
                    .with(situation, self.config.window_s, from, *wanted)
            }
            (Validity::Blocked, _) => (RequestCause::Blocked, 0.0),
            _ => (RequestCause::None, 0.0),
        };
        decision
    }

    /// What may be gone towards for an output, best first.
    fn candidates(&self, wanted: Twist) -> impl Iterator<Item = Twist> {
        let slowed = Twist::new(0.0, wanted.w_radps);
        let others = self.memory.reserve.iter().map(|(_, twist)| *twist);
        let others = others.take(RESERVE).filter(move |twist| *twist != wanted);
        core::iter::once(wanted)
            .chain(others)
            .chain(core::iter::once(slowed))
    }

    fn begin_record(&mut self, situation: &Situation<'_>) {
        if let Some(record) = &mut self.memory.record {
            record.begin(situation.map_from_base);
        }
    }

    /// Tells the record which candidate `step`, the command of this period, goes towards.
    fn tell(
        &mut self,
        situation: &Situation<'_>,
        from: Twist,
        output: &ControlOutput,
        step: Option<Twist>,
    ) {
        if self.memory.record.is_none() {
            return;
        }
        let picked = match (output, step) {
            // Of two candidates with the same step the first one was taken.
            (ControlOutput::Towards(wanted), Some(step)) => {
                self.candidates(*wanted).find(|candidate| {
                    let (robot, period_s) = (situation.robot, situation.period_s);
                    self.shaper.next(robot, from, *candidate, period_s) == step
                })
            }
            _ => None,
        };
        // An output of the arrival or of a turn is one motion, and no rollout.
        self.end_record(situation, (from, picked), self.memory.rollouts.max(1));
    }

    fn end_record(
        &mut self,
        situation: &Situation<'_>,
        motion: (Twist, Option<Twist>),
        looked_at: u32,
    ) {
        let horizon_s = horizon_s(&self.config, situation.robot);
        if let Some(record) = &mut self.memory.record {
            record.end(situation.robot, motion, horizon_s, looked_at);
        }
    }

    /// The step of this period towards the first candidate from which a stop is free, with the arc
    /// of that stop. [m]
    fn command(
        &self,
        situation: &Situation<'_>,
        from: Twist,
        candidates: impl Iterator<Item = Twist>,
    ) -> Option<(Twist, f64)> {
        let robot = situation.robot;
        let mut steps =
            candidates.map(|wanted| self.shaper.next(robot, from, wanted, situation.period_s));
        let stop_arc_m = |twist| self.perception.stop_arc_m(&self.config, robot, twist);
        if self.memory.searched {
            let first = steps.next()?;
            let arc_m = stop_arc_m(first).or_else(|| {
                self.perception
                    .flight_arc_m(&self.config, robot, from, first)
            });
            if let Some(arc_m) = arc_m {
                return Some((first, arc_m));
            }
        }
        first_with_free_stop(steps, stop_arc_m)
    }

    /// The decision for a command, or for the first step of a ramp to rest and its reason; the next
    /// period starts from it.
    fn decision(
        &mut self,
        situation: &Situation<'_>,
        from: Twist,
        command: Result<(Twist, f64), Validity>,
    ) -> Decision {
        self.timer.mark(Stage::Verify);
        let (robot, period_s) = (situation.robot, situation.period_s);
        let rest = towards_rest(robot, from, period_s);
        let (twist, validity, braking_arc_m) = match command {
            Ok((twist, arc_m)) => (twist, Validity::Drive, arc_m),
            Err(validity) => (rest, validity, stop_distance_m(robot, rest.v_mps, 0.0)),
        };
        self.memory.last = twist;
        if twist == rest {
            self.shaper.interrupted();
        } else {
            self.shaper.published(from, twist, period_s);
        }
        Decision {
            v_mps: twist.v_mps,
            w_radps: twist.w_radps,
            validity,
            braking_arc_m,
            turns: false,
            rollouts: 1,
            blocked_arc_m: None,
            against: None,
            cause: RequestCause::None,
            limit_mps: 0.0,
        }
    }
}
