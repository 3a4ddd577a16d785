//! One drive while it goes on.

use super::clients::Clients;
use super::course::trial_runner;
use super::current_task::CurrentTask;
use super::faults::Faults;
use super::last_pose::LastPose;
use super::phase::{Begin, Phase};
use super::run_time::RunTime;
use super::standstill::{Standing, Standstill};
use super::swaps::Swaps;
use super::zone_store::ZoneStore;
use crate::collect::Collector;
use crate::companions::Companions;
use crate::control::socket::Server;
use crate::disturbance::Reading;
use crate::ending::Ending;
use crate::orders::{End, Orders};
use crate::placed_obstacles::PlacedObstacles;
use crate::prepare::Prepared;
use crate::recorder::RecordedTicks;
use crate::restarter::Restarter;
use crate::trial_runner::{Quota, Step, TrialRunner};
use crate::why;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;
use zeronav_console::progress::ProgressLine;
use zeronav_console::terminal::note;
use zeronav_measure::run_totals::TaskReport;
use zeronav_msgs::Pose;
use zeronav_msgs::role::Role;
use zeronav_msgs::run::RunMode;
use zeronav_msgs::task::{EndReason, Goal, PoseEstimate, TaskState};
use zeronav_msgs::topics::{GroundTruth, Topic};
use zeronav_shell::clock::now_ns;
use zeronav_supervise::stack::Stack;

/// Ticks that the robot may be ahead of what launch has seen, lockstep only. The buffers of the
/// taps hold the messages of that many ticks, so that nothing is lost however late launch is.
pub(super) const LEASE_TICKS: u64 = 30;

const _: () = assert!(LEASE_TICKS <= GroundTruth::ROW.buffer() as u64);

/// One drive while it goes on: the services, what they report, and the goals.
pub(super) struct Session<'a> {
    pub(super) prepared: &'a Prepared,
    pub(super) interrupted: Arc<AtomicBool>,
    pub(super) quota: Option<Quota>,
    pub(super) trial_runner: Option<TrialRunner<'a>>,
    pub(super) phase: Phase,
    pub(super) begin: Begin,
    pub(super) collector: Collector,
    pub(super) restarter: Restarter<'a>,
    line: ProgressLine,
    /// Faults of the scenario and of clients.
    pub(super) faults: Faults,
    pub(super) task: CurrentTask,
    /// Goals of clients.
    pub(super) orders: Orders,
    /// Obstacles that clients have put into the world.
    pub(super) placed: PlacedObstacles,
    /// Where the robot may not go.
    pub(super) zones: ZoneStore,
    /// Where a client has said last that the robot is.
    pub(super) given_pose: Option<PoseEstimate>,
    /// Where it was left; of a stack that stays up.
    pub(super) last_pose: Option<LastPose>,
    /// The swap that goes on, and those before it.
    pub(super) swaps: Swaps,
    /// What runs beside the stack.
    pub(super) companions: Companions,
    /// How far the recorder is, in a lockstep run that is recorded.
    pub(super) recorded: Option<RecordedTicks>,
    pub(super) run_time: RunTime,
    pub(super) clients: Clients,
}

impl<'a> Session<'a> {
    pub(super) fn new(
        prepared: &'a Prepared,
        quota: Option<Quota>,
        interrupted: &Arc<AtomicBool>,
        configs: BTreeMap<Role, PathBuf>,
    ) -> Self {
        Self {
            prepared,
            interrupted: Arc::clone(interrupted),
            quota,
            trial_runner: quota.and_then(|quota| trial_runner(prepared, quota)),
            phase: Phase::Starting,
            begin: Begin::now(),
            collector: Collector::default(),
            restarter: Restarter::new(prepared, configs),
            line: ProgressLine::new(&prepared.scenario.name, prepared.progress),
            faults: Faults::new(prepared),
            task: CurrentTask::default(),
            orders: Orders::default(),
            placed: PlacedObstacles::new(
                (prepared.world.obstacles().iter()).map(|obstacle| obstacle.spec.name.clone()),
            ),
            zones: ZoneStore::default(),
            given_pose: None,
            last_pose: LastPose::of(prepared),
            swaps: Swaps::default(),
            companions: Companions::default(),
            recorded: None,
            run_time: RunTime::held_before(prepared.stands_before),
            clients: Clients::default(),
        }
    }

    /// Starts the services and drives until something ends the run.
    ///
    /// # Errors
    /// One line when the stack could not be started at all.
    pub(super) fn run(&mut self, stack: &mut Stack) -> Result<Ending, String> {
        let ending = self.until_it_ends(stack);
        self.phase.end();
        self.line.clear();
        ending
    }

    fn until_it_ends(&mut self, stack: &mut Stack) -> Result<Ending, String> {
        let folder = stack.folder().ok_or("the stack is closed")?;
        folder
            .make_files_private()
            .map_err(|error| error.to_string())?;
        let server =
            Server::open(folder).map_err(|error| format!("opening the control socket: {error}"))?;
        self.clients.server = Some(server);
        // All of them before the first start: no process started by hand gets in between.
        for role in self.prepared.binaries.keys() {
            stack.hold_seat(*role).map_err(|error| error.to_string())?;
        }
        self.begin_zones(stack)?;
        self.start_companions(stack)?;
        for role in Role::SERVICES {
            self.restarter.start(stack, role)?;
            if self.prepared.binaries.contains_key(&role) {
                self.begin.stamps.started_ns.insert(role, now_ns());
            }
        }
        if let Some(ending) = self.wait_until_ready(stack) {
            return Ok(ending);
        }
        self.begin.goals_run_ns = if self.lockstep() {
            0
        } else {
            self.collector.run_ns
        };
        let goals: Vec<Goal> = match &self.trial_runner {
            Some(trial_runner) => vec![trial_runner.goal().message(0)],
            None => (self.prepared.scenario.goals.iter())
                .map(|goal| goal.message(0))
                .collect(),
        };
        if !self.lockstep() && !self.prepared.stays {
            self.begin.reading = Some(reading(stack));
        }
        self.ready(stack);
        if !goals.is_empty() && !self.prepared.stays {
            self.send(stack, goals, 1);
            self.begin.stamps.goals_ns = now_ns();
        }
        self.begin_order(stack);
        Ok(self.watch(stack))
    }

    /// Every service can answer.
    fn ready(&mut self, stack: &mut Stack) {
        self.phase = Phase::Ready;
        self.show_page(stack);
        if self.prepared.stays {
            note(&format!(
                "{} is up in {}; `zeronav goal X Y YAW` drives, `zeronav down` ends it",
                self.prepared.scenario.name,
                stack.root().display()
            ));
        }
    }

    pub(super) fn lockstep(&self) -> bool {
        self.prepared.mode == RunMode::Lockstep
    }

    /// Sends goals, numbered in the order of this run.
    pub(super) fn send(&mut self, stack: &mut Stack, mut goals: Vec<Goal>, from_tick: u64) {
        self.task.number(&mut goals);
        let from_tick = if self.lockstep() { from_tick } else { 0 };
        self.task.is_cancelling = false;
        self.task.id = stack.send_goals(&goals, from_tick);
        for Goal { id, pose, .. } in goals.iter().filter(|_| self.task.id != 0) {
            let (x_m, y_m, yaw_rad) = (pose.x_m, pose.y_m, pose.yaw_rad);
            tracing::info!(task = self.task.id, goal = id, x_m, y_m, yaw_rad, "sent");
        }
        self.collector.goals(&goals);
        self.task.goals = goals;
    }

    /// Sends goals from the first tick on that the robot may not have begun.
    pub(super) fn send_now(&mut self, stack: &mut Stack, goals: Vec<Goal>) {
        let from_tick = self.next_tick(stack);
        self.send(stack, goals, from_tick);
    }

    /// The first tick that the robot may not have begun; 0 = at once, in real time.
    pub(super) fn next_tick(&self, stack: &Stack) -> u64 {
        if self.lockstep() {
            stack.roster.control.lease + 1
        } else {
            0
        }
    }

    /// The goals of the current task that are not reached yet.
    pub(super) fn left(&self) -> Vec<Goal> {
        self.task.left(&self.collector.reached)
    }

    /// Sees to the processes. A new local planner knows nothing of goals that were reached before,
    /// so it gets those that are left; in lockstep while the robot is held for the answer of its
    /// seat, which makes the tick from which they hold the same in every run.
    pub(super) fn keep(&mut self, stack: &mut Stack) -> Option<Ending> {
        self.update_swap(stack);
        let left_out = self.swaps.keeps();
        let restarts_before = self.restarter.records().len();
        let taken = match self.restarter.look(stack, &self.collector, left_out) {
            Ok(taken) => taken,
            Err(ending) => return Some(ending),
        };
        self.hand_pose_on(stack, restarts_before);
        for taken in taken {
            let left = self.left();
            let goes_on = taken.role == Role::LocalPlanner && !self.task.is_cancelling;
            if goes_on && left.len() < self.task.goals.len() && !left.is_empty() {
                let from_tick = taken.on_tick.max(self.collector.robot_tick() + 1);
                self.send(stack, left, from_tick);
            }
            stack.obey_newest(taken.role, taken.off_tick, taken.on_tick);
        }
        None
    }

    /// One look at everything.
    pub(super) fn listen(&mut self, stack: &mut Stack) {
        let world = &self.prepared.world;
        let placed = |index: usize, pose: &Pose| {
            let obstacle = world.obstacles().get(index)?;
            Some(obstacle.shape.placed_at(pose))
        };
        let Stack { taps, roster, .. } = stack;
        if self.collector.listen(taps, roster, &placed) {
            stack.ask_for_keyframe();
        }
        stack.refresh();
    }

    /// Watches the drive until something ends it.
    fn watch(&mut self, stack: &mut Stack) -> Ending {
        let pause = Duration::from_millis(if self.lockstep() { 1 } else { 10 });
        let tick_ns = self.prepared.scenario.run.tick_ns();
        let limit_ns = self.prepared.scenario.run.time_limit_ns();
        let last_tick = if self.prepared.stays {
            u64::MAX
        } else {
            limit_ns.div_ceil(tick_ns)
        };
        let mut standstill = Standstill::new(&self.prepared.scenario.restart);
        loop {
            self.listen(stack);
            // Before the requests: what was reached is not cancelled.
            if let Some(ending) = self.task_ended(stack) {
                return ending;
            }
            self.serve(stack);
            if let Some(ending) = self.asked_to_end(stack) {
                return ending;
            }
            self.update_order(stack);
            if let Some(ending) = self.keep(stack) {
                return ending;
            }
            if let Some(ending) = self.try_again(stack) {
                return ending;
            }
            self.update_faults(stack);
            self.keep_zones(stack);
            self.companions.look(stack);
            let tick = self.collector.robot_tick();
            let hold_tick = self.held_at(tick);
            let held = self.held(stack, tick, hold_tick);
            if let Some(why) = standstill.look(tick, held, || stack.is_quiet()) {
                let role = self.silent(stack);
                return match why {
                    Standing::Silent => Ending::Silent(role),
                    Standing::TooLong => Ending::Stalled(role),
                };
            }
            if self.lockstep() {
                if self.collector.all_answered(last_tick, &stack.roster) {
                    return Ending::Timeout;
                }
                let last_tick = last_tick.min(hold_tick).min(self.last_recorded_tick());
                stack.extend_lease((tick + LEASE_TICKS).min(last_tick));
            } else if self.trial_runner.is_none()
                && !self.prepared.stays
                && self
                    .collector
                    .run_ns
                    .saturating_sub(self.begin.goals_run_ns)
                    > limit_ns
            {
                return Ending::Timeout;
            }
            let progress = self.progress();
            self.line.show(|| progress);
            if self.prepared.stays {
                self.collector.forget();
                self.update_last_pose(stack);
            }
            let soon = Duration::from_millis(1);
            let is_busy = self.restarter.is_busy() || self.swaps.is_busy();
            std::thread::sleep(if is_busy { soon } else { pause });
        }
    }

    /// How the run ends because the task has. In trials the robot turns around at its goal.
    fn task_ended(&mut self, stack: &mut Stack) -> Option<Ending> {
        let report = self.report()?;
        match (report.state, &mut self.trial_runner) {
            // A local planner without a task has nothing to cancel.
            (TaskState::Idle, None) if self.task.is_cancelling => {
                self.over(stack, TaskState::Cancelled, report.reason)
            }
            (TaskState::Idle | TaskState::Active, _) => None,
            (TaskState::Reached, Some(trial_runner)) => {
                trial_runner.turn();
                let goal = trial_runner.goal().message(0);
                self.send(stack, vec![goal], 0);
                None
            }
            (state, None) => self.over(stack, state, report.reason),
            (state, _) => Some(Ending::Task(state, report.reason)),
        }
    }

    /// The task is over: how the run ends, or nothing when it goes on with the order of a client or
    /// with the scenario's goals that one had taken the place of.
    fn over(&mut self, stack: &mut Stack, state: TaskState, reason: EndReason) -> Option<Ending> {
        // The last goal may have been reached before the cancellation was due.
        let is_reached = self.task.is_cancelling && self.left().is_empty();
        let state = if is_reached {
            TaskState::Reached
        } else {
            state
        };
        if !self.orders.is_active() && !self.prepared.stays {
            return Some(Ending::Task(state, reason));
        }
        let report = self.report();
        let outcome = report.map(|report| report.outcome());
        let end = End {
            state,
            reason,
            why: outcome.and_then(|outcome| why::failure(&outcome)),
            may_open: outcome.is_some_and(|outcome| outcome.may_open()),
            recoveries: report.map_or(0, |report| report.recoveries),
            left: self.left(),
        };
        let run_ns = self.collector.run_ns;
        if let Some(goals) = self.orders.ended(end, run_ns) {
            self.send_now(stack, goals);
            return None;
        }
        if self.begin_order(stack) {
            return None;
        }
        if self.prepared.stays {
            self.rest(stack);
            return None;
        }
        if state == TaskState::Reached {
            return Some(Ending::Redirected);
        }
        tracing::warn!(%reason, "going on with the scenario's goals");
        // Without goals of its own the scenario waits for its time limit.
        self.rest(stack);
        let left = self.orders.take_aside().unwrap_or_default();
        if !left.is_empty() {
            self.send_now(stack, left);
        }
        None
    }

    /// Sees to the trials, if that is what this drive is for.
    fn try_again(&mut self, stack: &mut Stack) -> Option<Ending> {
        let tick_ns = self.prepared.scenario.run.tick_ns();
        let run_ns = self.collector.robot_tick() * tick_ns;
        let trial_runner = self.trial_runner.as_mut()?;
        match trial_runner.look(&mut self.collector, run_ns) {
            Step::Wait => None,
            Step::Place(placement) => {
                stack.place(&[placement]);
                trial_runner.note(reading(stack), &self.collector.records);
                None
            }
            Step::Done => Some(Ending::TrialsOver),
            Step::Stuck => Some(Ending::Timeout),
        }
    }

    /// What is said about the current task.
    pub(super) fn report(&self) -> Option<TaskReport> {
        self.collector.task.filter(|report| self.task.is_of(report))
    }

    /// The tick that ends the measured part of the run: the same in every lockstep run.
    pub(super) fn end_tick(&self, ending: &Ending) -> u64 {
        let tick_ns = self.prepared.scenario.run.tick_ns();
        match (ending, self.report()) {
            (Ending::Task(..) | Ending::Redirected, Some(report)) => report.tick,
            (Ending::Timeout, _) if self.lockstep() => {
                self.prepared.scenario.run.time_limit_ns().div_ceil(tick_ns)
            }
            _ => self.collector.robot_tick(),
        }
    }
}

/// The kernel's counters of all processes.
pub(super) fn reading(stack: &Stack) -> Reading {
    let children = stack.children.iter();
    Reading::take(children.map(|child| (child.role, child.pid())))
}
