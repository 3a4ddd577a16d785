//! `task/goal` and `task/status`: where to, and what became of it.

use crate::certainty::PoseCertainty;
use crate::map::ObstacleSource;
use crate::message::{COORDINATE_M_MAX, Refusal, ZeroCopySend, ensure, number};
use crate::path::PathBlock;
use crate::pose::Pose;
use crate::{codes, message};

/// Most goals of a task.
pub const GOALS_MAX: usize = 64;

codes! {
    /// What a task message asks.
    pub enum TaskKind: u16 {
        /// Nothing.
        None = 0 => "none",
        /// Drive to the goals in order.
        Go = 1 => "go",
        /// Stop and forget the goals.
        Cancel = 2 => "cancel",
    }
}

codes! {
    /// State of a task or of one goal.
    pub enum TaskState: u16 {
        /// No task.
        Idle = 0 => "idle",
        /// On the way.
        Active = 1 => "active",
        /// Arrived within the tolerance and standing.
        Reached = 2 => "reached",
        /// Given up, see the reason.
        Failed = 3 => "failed",
        /// Cancelled.
        Cancelled = 4 => "cancelled",
    }
}

codes! {
    /// Why a task ended.
    pub enum EndReason: u16 {
        /// It has not ended, or it ended as wished.
        None = 0 => "none",
        /// The global planner proved that there is no way.
        Unreachable = 1 => "unreachable",
        /// No free pose within the tolerance of the goal.
        GoalBlocked = 2 => "goal_blocked",
        /// The goal is not on the map.
        GoalOutsideMap = 3 => "goal_outside_map",
        /// The robot did not come closer for too long.
        Stuck = 4 => "stuck",
        /// The planner gave up: budget, dead end, blocked start.
        NoPath = 5 => "no_path",
        /// A later task took its place.
        Replaced = 6 => "replaced",
        /// The robot did not know where it was for too long, or nothing has confirmed where it was told to be.
        PoseUnknown = 7 => "pose_unknown",
    }
}

codes! {
    /// What was wrong with a robot that got stuck.
    pub enum StuckCause: u16 {
        /// It has not got stuck, or that is unknown.
        None = 0 => "none",
        /// No motion was admissible.
        Blocked = 1 => "blocked",
        /// It moved, but came no closer.
        NoProgress = 2 => "no_progress",
        /// It came closer now and then, but every attempt that it has was made.
        TooManyAttempts = 3 => "too_many_attempts",
    }
}

message! {
    /// Fixed fields of a task. The slice holds the goals in order.
    pub struct Task = "zeronav.Task.v1" {
        /// Code of [`TaskKind`].
        pub kind: u16,
        /// Written as 0.
        pub spare: u16,
        /// [count] Goals in the slice.
        pub n_goals: u32,
        /// [tick] First tick at which it holds; 0 = at once.
        pub from_tick: u64,
    }
}

message! {
    /// A goal.
    pub struct Goal = "zeronav.Goal.v1" {
        /// `map_from_base` to reach.
        pub pose: Pose,
        /// [m] how close counts, > 0.
        pub tolerance_m: f64,
        /// [rad] how close the yaw must be; >= pi = any yaw.
        pub yaw_tolerance_rad: f64,
        /// [number] The sender's own number for it, not 0.
        pub id: u64,
    }
}

message! {
    /// Where the robot is, as a person says, or as mapping knew before it ended: mapping puts it there.
    ///
    /// Two poses of the same moment, so that it does not matter when the message is read.
    pub struct PoseEstimate = "zeronav.PoseEstimate.v2" {
        /// `map_from_base`.
        pub map_from_base: Pose,
        /// `odom_from_base` of the same moment.
        pub odom_from_base: Pose,
        /// [tick] First tick at which it holds.
        pub from_tick: u64,
        /// Code of [`PoseCertainty`]: `unconfirmed` from a person; `unknown` = the robot is lost and stands.
        pub certainty: u16,
        /// Written as 0.
        pub spare: [u16; 3],
    }
}

message! {
    /// Fixed fields of the status. The slice holds one entry per goal that has ended.
    pub struct TaskStatus = "zeronav.TaskStatus.v3" {
        /// Code of [`TaskState`].
        pub state: u16,
        /// Code of [`EndReason`]; while it waits, that for which the goal will end.
        pub reason: u16,
        /// [count] Goals that have ended.
        pub n_ended: u32,
        /// [id] Id on `task/goal` of the task.
        pub task: u64,
        /// [number] [`Goal::id`] of the current goal, 0 = none.
        pub goal: u64,
        /// [m] along the path, or straight without one; >= 0.
        pub remaining_m: f64,
        /// [count] Manoeuvres and waits of the recovery since the task began.
        pub recoveries: u32,
        /// Code of [`StuckCause`], with the reason `stuck`.
        pub cause: u16,
        /// Code of [`PathBlock`]: the cell because of which the task failed, or waits. May be left 0.
        pub block: u16,
        /// [m] x and y of the centre of that cell, `map` frame.
        pub block_m: [f64; 2],
        /// Code of [`ObstacleSource`] of the obstacle in that cell or nearest to it. May be left 0.
        pub source: u16,
        /// [s] for which it waits at most for that obstacle to go, rounded up; 0 = it does not wait.
        pub waits_s: u16,
        /// Written as 0.
        pub spare: [u16; 2],
    }
}

message! {
    /// End of a goal.
    pub struct GoalEnd = "zeronav.GoalEnd.v1" {
        /// [number] [`Goal::id`].
        pub goal: u64,
        /// [tick] Tick at which it ended.
        pub tick: u64,
        /// Code of [`TaskState`].
        pub state: u16,
        /// Code of [`EndReason`].
        pub reason: u16,
        /// Written as 0.
        pub spare: u32,
    }
}

impl Task {
    /// What is asked.
    #[must_use]
    pub const fn kind(&self) -> Option<TaskKind> {
        TaskKind::from_code(self.kind)
    }

    /// Accepts tasks whose goals are finite and have tolerances.
    ///
    /// # Errors
    /// The first field that is wrong.
    pub fn check(&self, goals: &[Goal]) -> Result<(), Refusal> {
        let kind = self.kind().ok_or(Refusal::Code("kind"))?;
        ensure(
            goals.len() == self.n_goals as usize
                && goals.len() <= GOALS_MAX
                && (kind == TaskKind::Go) != goals.is_empty(),
            Refusal::Length("goals"),
        )?;
        for goal in goals {
            goal.pose.check("pose")?;
            number(goal.tolerance_m, 1.0e-3, 1.0e3, "tolerance_m")?;
            number(goal.yaw_tolerance_rad, 1.0e-3, 1.0e3, "yaw_tolerance_rad")?;
            ensure(goal.id != 0, Refusal::OutOfRange("id"))?;
        }
        Ok(())
    }
}

impl PoseEstimate {
    /// `map_from_odom` from now on.
    #[must_use]
    pub fn map_from_odom(&self) -> Pose {
        let base_from_odom = self.odom_from_base.isometry().inverse();
        Pose::from(self.map_from_base.isometry() * base_from_odom)
    }

    /// How far that is known.
    #[must_use]
    pub const fn certainty(&self) -> Option<PoseCertainty> {
        PoseCertainty::from_code(self.certainty)
    }

    /// Accepts finite poses and known codes.
    ///
    /// # Errors
    /// The first field that is wrong.
    pub fn check(&self) -> Result<(), Refusal> {
        self.map_from_base.check("map_from_base")?;
        self.odom_from_base.check("odom_from_base")?;
        ensure(self.certainty().is_some(), Refusal::Code("certainty"))
    }
}

impl TaskStatus {
    /// The state.
    #[must_use]
    pub const fn state(&self) -> Option<TaskState> {
        TaskState::from_code(self.state)
    }

    /// The reason.
    #[must_use]
    pub const fn reason(&self) -> Option<EndReason> {
        EndReason::from_code(self.reason)
    }

    /// Why it got stuck.
    #[must_use]
    pub const fn cause(&self) -> Option<StuckCause> {
        StuckCause::from_code(self.cause)
    }

    /// Because of which cell it failed.
    #[must_use]
    pub const fn block(&self) -> Option<PathBlock> {
        PathBlock::from_code(self.block)
    }

    /// Where the obstacle comes from that blocks that cell.
    #[must_use]
    pub const fn source(&self) -> Option<ObstacleSource> {
        ObstacleSource::from_code(self.source)
    }

    /// Accepts known states.
    ///
    /// # Errors
    /// The first field that is wrong.
    pub fn check(&self, ended: &[GoalEnd]) -> Result<(), Refusal> {
        self.state().ok_or(Refusal::Code("state"))?;
        self.reason().ok_or(Refusal::Code("reason"))?;
        self.cause().ok_or(Refusal::Code("cause"))?;
        self.block().ok_or(Refusal::Code("block"))?;
        self.source().ok_or(Refusal::Code("source"))?;
        for along in self.block_m {
            number(along, -COORDINATE_M_MAX, COORDINATE_M_MAX, "block_m")?;
        }
        ensure(
            ended.len() == self.n_ended as usize && ended.len() <= GOALS_MAX,
            Refusal::Length("ends"),
        )?;
        for end in ended {
            TaskState::from_code(end.state).ok_or(Refusal::Code("end.state"))?;
            EndReason::from_code(end.reason).ok_or(Refusal::Code("end.reason"))?;
        }
        number(self.remaining_m, 0.0, 1.0e9, "remaining_m")
    }
}
