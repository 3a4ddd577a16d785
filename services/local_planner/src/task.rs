//! The task: which goal is current, and what became of the others.

use crate::patience::Patience;
pub use crate::planned::Planned;
use crate::stall::{Stall, Stalled};
use zeronav_casts::Cast;
use zeronav_motion::Twist;
use zeronav_msgs::Pose;
use zeronav_msgs::certainty::PoseCertainty;
use zeronav_msgs::path::PathStatus;
use zeronav_msgs::pose::wrap_angle;
use zeronav_msgs::task::{
    EndReason, GOALS_MAX, Goal, GoalEnd, Task, TaskKind, TaskState, TaskStatus,
};
use zeronav_msgs::time::seconds;
use zeronav_params::parameters;

parameters! {
    /// When a task has succeeded or failed.
    #[derive(Copy)]
    pub struct TaskConfig {
        /// Run time that a planning failure must last, with the robot stopped, before the task
        /// fails by it.
        failure_s: f64 = 1.0, [0.0, 600.0] "s";
        /// The same where what blocks robot, way or goal may go: it is no obstacle of the static map,
        /// or a path has led to the goal. In sum, since the robot last came closer.
        blocked_goal_s: f64 = 30.0, [0.0, 600.0] "s";
        /// Decrease of the remaining path that counts as progress.
        progress_m: f64 = 0.1, [0.001, 10.0] "m";
        /// Run time without progress after which another path is requested. A turn on the spot is
        /// progress, once around.
        no_progress_s: f64 = 10.0, [0.1, 3600.0] "s";
        /// Run time without progress after which the task fails as stuck. Waiting for what blocks the
        /// way does not count, nor do motions to find out where the robot is.
        stuck_s: f64 = 30.0, [0.1, 3600.0] "s";
        /// Run time that a goal which would end, as reached or failed, waits at most for what confirms where the robot
        /// was told to be. In sum, since the robot last came closer.
        unconfirmed_s: f64 = 10.0, [0.0, 600.0] "s";
    }
    relations |own| {
        stuck_s: own.stuck_s >= own.no_progress_s, "must be at least no_progress_s";
    }
}

/// [m/s] below which a robot is stopped.
const STOPPED_MPS: f64 = 0.02;

/// [rad/s] below which a robot that does not drive is stopped.
const STOPPED_RADPS: f64 = 0.05;

fn is_stopped(twist: Twist) -> bool {
    twist.v_mps.abs() < STOPPED_MPS && twist.w_radps.abs() < STOPPED_RADPS
}

/// What the task is judged by in one period.
#[derive(Debug, Clone, Copy, PartialEq)]
#[allow(clippy::struct_excessive_bools, reason = "independent observations")]
pub struct TaskInputs {
    /// Control tick.
    pub tick: u64,
    /// [ns] run time of the tick.
    pub run_ns: u64,
    /// `map_from_base` and the measured twist; `None` = unknown.
    pub robot: Option<(Pose, Twist)>,
    /// How far the robot knows where it is: unless that is confirmed it can neither have arrived nor be shut in.
    pub certainty: PoseCertainty,
    /// The newest path.
    pub path: Option<Planned>,
    /// [m] along the path to its end and the id of its geometry, when it leads to the goal at
    /// hand.
    pub remaining: Option<(f64, u64)>,
    /// The robot turns on the spot, towards its path or the goal's yaw.
    pub turns: bool,
    /// Nothing more can be tried.
    pub given_up: bool,
    /// It does not know where it is and moves to find out: no progress is to be expected.
    pub seeks_pose: bool,
    /// Something that moves is near the current goal, which may be free again soon.
    pub moves_at_goal: bool,
}

/// What a period did to the task.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct TaskStep {
    /// State, current goal or ends differ from those before: the status is worth sending.
    pub changed: bool,
    /// The robot has not come closer for long: another path may help.
    pub no_progress: bool,
    /// It has not for so long that the task has failed, or nothing more can be tried.
    pub stuck: bool,
    /// [s] since it came closer to the current goal.
    pub stalled_s: f64,
    /// [s] since it came closer, or turned on towards its way.
    pub idle_s: f64,
}

/// A failure that is waited out: what it comes from may go.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Wait {
    /// How the goal ends if it does not.
    reason: EndReason,
    /// [s] until then.
    left_s: f64,
}

#[derive(Debug, Clone, Default)]
struct Assignment {
    id: u64,
    go: bool,
    from_tick: u64,
    goals: Vec<Goal>,
}

/// The task's state: `Idle`, `Active` with a current goal, `Reached`, `Failed` or `Cancelled`.
///
/// Goals are taken in order. An intermediate goal counts on passing within its tolerance, the
/// last one standing; the yaw counts where its tolerance is below pi. Goals after a failed or
/// cancelled one never began and get no end. An outcome stays until the next goal.
#[derive(Debug, Clone)]
pub struct TaskMachine {
    config: TaskConfig,
    task: Assignment,
    pending: Assignment,
    /// Id of the task that state, reason and ends are about: the newest one with goals.
    subject: u64,
    state: TaskState,
    reason: EndReason,
    /// Index of the current goal while active.
    index: usize,
    ends: Vec<GoalEnd>,
    /// Since when the robot is stopped without a path. [ns]
    failing_since_ns: Option<u64>,
    /// A path has led to the current goal.
    was_free: bool,
    stall: Stall,
    patience: Patience,
    /// Waits for the pose to be confirmed.
    doubt: Patience,
    wait: Option<Wait>,
    remaining_m: f64,
}

impl TaskMachine {
    /// No task.
    #[must_use]
    pub fn new(config: TaskConfig) -> Self {
        let assignment = || Assignment {
            goals: Vec::with_capacity(GOALS_MAX),
            ..Assignment::default()
        };
        Self {
            config,
            task: assignment(),
            pending: assignment(),
            subject: 0,
            state: TaskState::Idle,
            reason: EndReason::None,
            index: 0,
            ends: Vec::with_capacity(GOALS_MAX),
            failing_since_ns: None,
            was_free: false,
            stall: Stall::default(),
            patience: Patience::default(),
            doubt: Patience::default(),
            wait: None,
            remaining_m: 0.0,
        }
    }

    /// Takes in a task by its id on `task/goal`. It holds from its tick on; until then the task
    /// before goes on. One that is still active ends at that tick as cancelled and replaced, and
    /// the new one begins with the next period. Ids that are not newer than the newest one known, and tasks that ask
    /// nothing, are ignored.
    pub fn accept(&mut self, id: u64, task: &Task, goals: &[Goal]) {
        let asks = task
            .kind()
            .is_some_and(|kind| matches!(kind, TaskKind::Go | TaskKind::Cancel));
        if !asks || id <= self.pending.id.max(self.task.id) {
            return;
        }
        self.pending.id = id;
        self.pending.go = task.kind() == Some(TaskKind::Go);
        self.pending.from_tick = task.from_tick;
        self.pending.goals.clear();
        self.pending
            .goals
            .extend_from_slice(&goals[..goals.len().min(GOALS_MAX)]);
    }

    /// Goes on from where the local planner that is obeyed has come to with the same task: it drives
    /// the robot, whatever this one would have done. A status that does not fit the goals of the task
    /// changes nothing.
    pub fn follow(&mut self, status: &TaskStatus, ends: &[GoalEnd]) {
        let (own, _) = self.status();
        let Some((state, reason)) = status.state().zip(status.reason()) else {
            return;
        };
        // While it is active the reason is that of a wait.
        let is_active = state == TaskState::Active;
        let is_same = (own.state, own.goal) == (status.state, status.goal)
            && (is_active || own.reason == status.reason)
            && self.ends == ends;
        let goals = &self.task.goals;
        if status.task == self.task.id && goals.is_empty() && self.state == TaskState::Idle {
            // It has heard no more of the task than that it is over.
            if !matches!(state, TaskState::Idle | TaskState::Active) && ends.len() <= GOALS_MAX {
                (self.state, self.reason) = (state, reason);
                self.ends.extend_from_slice(ends);
            }
            return;
        }
        let in_order = ends.len() <= goals.len()
            && (ends.iter().zip(goals)).all(|(end, goal)| end.goal == goal.id);
        let fits = match state {
            TaskState::Active => goals
                .get(ends.len())
                .is_some_and(|goal| goal.id == status.goal),
            TaskState::Reached => ends.len() == goals.len(),
            TaskState::Failed | TaskState::Cancelled => true,
            TaskState::Idle => false,
        };
        if status.task != self.task.id || is_same || !in_order || !fits {
            return;
        }
        self.state = state;
        self.reason = if is_active { EndReason::None } else { reason };
        self.index = ends.len().min(goals.len().saturating_sub(1));
        self.ends.clear();
        self.ends.extend_from_slice(ends);
        self.start_goal();
    }

    /// The current goal.
    #[must_use]
    pub fn goal(&self) -> Option<&Goal> {
        (self.state == TaskState::Active)
            .then(|| self.task.goals.get(self.index))
            .flatten()
    }

    /// True when the current goal is the last one.
    #[must_use]
    pub fn is_last_goal(&self) -> bool {
        self.index + 1 >= self.task.goals.len()
    }

    /// The state of the task.
    #[must_use]
    pub const fn state(&self) -> TaskState {
        self.state
    }

    /// Id on `task/goal` of the newest task with goals, which the state is about; 0 = none.
    #[must_use]
    pub const fn subject(&self) -> u64 {
        self.subject
    }

    /// True while it waits for what blocks robot, way or goal to go.
    #[must_use]
    pub const fn waits(&self) -> bool {
        self.wait.is_some()
    }

    /// The message of the task's state and the ends of its goals, without what the recovery did.
    #[must_use]
    pub fn status(&self) -> (TaskStatus, &[GoalEnd]) {
        let status = TaskStatus {
            state: self.state.code(),
            reason: self.wait.map_or(self.reason, |wait| wait.reason).code(),
            waits_s: self.wait.map_or(0, |wait| whole_seconds(wait.left_s)),
            n_ended: u32::try_from(self.ends.len()).unwrap_or(0),
            task: self.task.id,
            goal: self.goal().map_or(0, |goal| goal.id),
            remaining_m: self.remaining_m,
            ..TaskStatus::default()
        };
        (status, &self.ends)
    }

    /// One period: new tasks, then goals reached, then failures, then progress.
    pub fn step(&mut self, inputs: &TaskInputs) -> TaskStep {
        let mut step = TaskStep {
            changed: self.begin(inputs),
            ..TaskStep::default()
        };
        self.remaining_m = 0.0;
        let (Some(goal), Some((pose, twist))) = (self.goal().copied(), inputs.robot) else {
            return step;
        };
        self.remaining_m = inputs.remaining.map_or_else(
            || pose.distance_m(&goal.pose),
            |(remaining_m, _)| remaining_m,
        );
        let knows_pose = inputs.certainty.is_known();
        if !knows_pose && self.doubt.pause() {
            // What it waited with was tried elsewhere.
            self.stall = Stall::default();
        }
        let reached = knows_pose && self.is_reached(&goal, &pose, twist);
        let failure = (!reached)
            .then(|| self.failure(&goal, inputs, twist))
            .flatten();
        if reached || failure.is_some() {
            step.changed = self.conclude(inputs, failure);
            return step;
        }
        let geometry = inputs.remaining.map_or(0, |(_, geometry)| geometry);
        // A meaningless pose may look like progress.
        let remaining_m = if knows_pose {
            self.remaining_m
        } else {
            f64::INFINITY
        };
        if self.wait.is_some() || inputs.seeks_pose {
            self.stall.hold(inputs.run_ns);
        }
        let Stalled {
            far_s,
            idle_s,
            closer,
        } = self.stall.step(
            inputs.run_ns,
            (geometry, remaining_m),
            inputs.turns.then_some(pose.yaw_rad),
            self.config.progress_m,
        );
        if closer {
            self.patience.renew();
            self.doubt.renew();
        }
        (step.stalled_s, step.idle_s) = (far_s, idle_s);
        if idle_s > self.config.stuck_s || (inputs.given_up && knows_pose) {
            step.changed = self.conclude(inputs, Some(EndReason::Stuck));
            step.stuck = step.changed;
        } else {
            self.doubt.pause();
            step.no_progress = idle_s > self.config.no_progress_s;
        }
        step
    }

    /// The current goal ends, as reached without a failure, unless nothing has confirmed where the robot is: then it
    /// waits for that. True when it has ended.
    fn conclude(&mut self, inputs: &TaskInputs, failure: Option<EndReason>) -> bool {
        if inputs.certainty.is_confirmed() {
            match failure {
                None => self.reach(inputs),
                Some(reason) => self.end(inputs.tick, TaskState::Failed, reason),
            }
            return true;
        }
        let left_s = self.config.unconfirmed_s - self.doubt.wait(inputs.run_ns);
        if inputs.certainty.is_known() && left_s > 0.0 {
            let reason = EndReason::PoseUnknown;
            self.wait = Some(Wait { reason, left_s });
            self.stall.hold(inputs.run_ns);
            return false;
        }
        self.end(inputs.tick, TaskState::Failed, EndReason::PoseUnknown);
        true
    }

    /// Lets the pending task take over when its tick has come.
    fn begin(&mut self, inputs: &TaskInputs) -> bool {
        if self.pending.id <= self.task.id || self.pending.from_tick > inputs.tick {
            return false;
        }
        if !self.pending.go {
            // A cancel ends the current task and keeps its goals' ends. What has ended before keeps
            // its outcome until the next goal: launch cancels after every end, so that a successor
            // does not begin the task again.
            if self.state == TaskState::Active {
                self.end(inputs.tick, TaskState::Cancelled, EndReason::None);
            }
            self.task.id = self.pending.id;
            self.task.goals.clear();
            return true;
        }
        if self.state == TaskState::Active {
            // One period tells the end of the task before, the next begins this one.
            self.end(inputs.tick, TaskState::Cancelled, EndReason::Replaced);
            return true;
        }
        core::mem::swap(&mut self.task, &mut self.pending);
        self.subject = self.task.id;
        // The id stays known, so the same task is not taken in twice.
        self.pending.id = self.task.id;
        self.ends.clear();
        self.state = TaskState::Active;
        self.reason = EndReason::None;
        self.index = 0;
        self.start_goal();
        true
    }

    fn start_goal(&mut self) {
        self.failing_since_ns = None;
        self.was_free = false;
        self.stall = Stall::default();
        (self.patience, self.doubt) = (Patience::default(), Patience::default());
        self.wait = None;
    }

    fn is_reached(&self, goal: &Goal, pose: &Pose, twist: Twist) -> bool {
        let near = pose.distance_m(&goal.pose) <= goal.tolerance_m;
        let any_yaw = goal.yaw_tolerance_rad >= core::f64::consts::PI;
        let yaw_error_rad = wrap_angle(pose.yaw_rad - goal.pose.yaw_rad).abs();
        let aligned = any_yaw || yaw_error_rad <= goal.yaw_tolerance_rad;
        near && aligned && (!self.is_last_goal() || is_stopped(twist))
    }

    fn reach(&mut self, inputs: &TaskInputs) {
        if self.is_last_goal() {
            self.end(inputs.tick, TaskState::Reached, EndReason::None);
        } else {
            self.push_end(inputs.tick, TaskState::Reached, EndReason::None);
            self.index += 1;
            self.start_goal();
        }
    }

    /// The failure that has lasted long enough with the robot standing.
    fn failure(&mut self, goal: &Goal, inputs: &TaskInputs, twist: Twist) -> Option<EndReason> {
        self.wait = None;
        let planned = inputs.path.filter(|planned| planned.goal == goal.id);
        self.was_free |= planned.is_some_and(|planned| planned.status == PathStatus::Found);
        let failing = planned
            .and_then(|planned| Some((planned, planned.end()?)))
            .filter(|_| inputs.certainty.is_known() && is_stopped(twist));
        let Some((planned, reason)) = failing else {
            self.failing_since_ns = None;
            self.patience.pause();
            return None;
        };
        if planned.may_open(self.was_free, inputs.moves_at_goal) {
            self.failing_since_ns = None;
            let left_s = self.config.blocked_goal_s - self.patience.wait(inputs.run_ns);
            if left_s <= 0.0 {
                return Some(reason);
            }
            self.wait = Some(Wait { reason, left_s });
            return None;
        }
        self.patience.pause();
        let since_ns = *self.failing_since_ns.get_or_insert(inputs.run_ns);
        let lasted_s = seconds(inputs.run_ns.saturating_sub(since_ns));
        (lasted_s >= self.config.failure_s).then_some(reason)
    }

    /// The current goal and the task with it end.
    fn end(&mut self, tick: u64, state: TaskState, reason: EndReason) {
        self.push_end(tick, state, reason);
        self.state = state;
        self.reason = reason;
        self.wait = None;
    }

    fn push_end(&mut self, tick: u64, state: TaskState, reason: EndReason) {
        if let Some(goal) = self.task.goals.get(self.index) {
            self.ends.push(GoalEnd {
                goal: goal.id,
                tick,
                state: state.code(),
                reason: reason.code(),
                spare: 0,
            });
        }
    }
}

/// A time as the status tells it, rounded up. [s]
fn whole_seconds(time_s: f64) -> u16 {
    time_s.ceil().clamp(0.0, f64::from(u16::MAX)).to_u16()
}
