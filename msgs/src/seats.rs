//! Every seat once: which topics it reads and writes, when it answers, and what an answer holds.

use crate::role::Role;
use crate::topics::{
    ControlRequest, Discipline, MapKeyframe, MapObstacles, MapUpdate, PlanPath, PlanRequests,
    RobotCommand, RobotDescription, RobotOdometry, RobotScan, SimForesight, SimPlacement, TaskGoal,
    TaskPose, TaskState, TaskZones, Topic, TopicRow, topics,
};

/// Ticks that a seat has to answer in lockstep.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Answers {
    /// Every one.
    EveryTick,
    /// Those with a scan.
    TicksWithScan,
}

/// One row of the table. Besides these, every seat reads `run/clock` and `run/control`, and writes
/// its heartbeat and `run/spans`.
#[derive(Debug)]
pub struct SeatRow {
    /// The seat.
    pub role: Role,
    /// Topics that the stock service reads.
    pub reads: &'static [&'static TopicRow],
    /// Those of them that it opens when it needs them; the others it has open when it is ready.
    pub reads_at_need: &'static [&'static TopicRow],
    /// Ticks that it answers.
    pub answers: Answers,
    /// Roles whose answer to the same tick it waits for in lockstep.
    pub after: &'static [Role],
    /// Topics that are part of every answer; the others that it writes are sent when there is news.
    pub owes: &'static [&'static TopicRow],
    /// Topics of its idle output: what it sends before the first tick to say that it runs.
    pub idle: &'static [&'static TopicRow],
    /// What it does when an input is missing or dropped, in a few words.
    pub without_input: &'static str,
}

impl SeatRow {
    /// Topics that it may write, without heartbeat and records.
    #[must_use]
    pub fn writes(&self) -> Vec<&'static TopicRow> {
        let mut rows = topics();
        rows.retain(|row| {
            row.writers == [self.role].as_slice() && row.discipline != Discipline::Records
        });
        rows.retain(|row| {
            crate::topics::health_of(self.role).is_none_or(|own| own.name != row.name)
        });
        rows
    }
}

/// Every seat, in the order of the data flow.
pub static SEATS: [SeatRow; 5] = [
    SeatRow {
        role: Role::Robot,
        reads: &[RobotCommand::ROW, SimPlacement::ROW],
        reads_at_need: &[],
        answers: Answers::EveryTick,
        after: &[],
        owes: &[RobotOdometry::ROW],
        idle: &[RobotDescription::ROW],
        without_input: "no command for `command_timeout_s`: the robot brakes to a stop",
    },
    SeatRow {
        role: Role::Mapping,
        reads: &[
            RobotDescription::ROW,
            RobotOdometry::ROW,
            RobotScan::ROW,
            TaskGoal::ROW,
            TaskState::ROW,
            TaskPose::ROW,
            TaskZones::ROW,
            SimForesight::ROW,
        ],
        reads_at_need: &[SimForesight::ROW],
        answers: Answers::TicksWithScan,
        after: &[],
        owes: &[MapObstacles::ROW, MapUpdate::ROW],
        idle: &[MapUpdate::ROW, MapKeyframe::ROW],
        without_input: "no scan for 0.5 s: an empty update with `current` = 0",
    },
    SeatRow {
        role: Role::GlobalPlanner,
        reads: &[
            RobotOdometry::ROW,
            MapUpdate::ROW,
            MapKeyframe::ROW,
            MapObstacles::ROW,
            PlanRequests::ROW,
            TaskGoal::ROW,
            TaskState::ROW,
        ],
        reads_at_need: &[],
        answers: Answers::TicksWithScan,
        after: &[Role::Mapping],
        owes: &[PlanPath::ROW],
        idle: &[PlanPath::ROW],
        without_input: "an update missed: asks mapping for a keyframe; the path stays",
    },
    SeatRow {
        role: Role::LocalPlanner,
        reads: &[
            RobotDescription::ROW,
            RobotOdometry::ROW,
            RobotScan::ROW,
            RobotCommand::ROW,
            MapUpdate::ROW,
            MapKeyframe::ROW,
            MapObstacles::ROW,
            PlanPath::ROW,
            TaskGoal::ROW,
            TaskState::ROW,
            TaskZones::ROW,
            SimForesight::ROW,
        ],
        reads_at_need: &[SimForesight::ROW],
        answers: Answers::EveryTick,
        after: &[Role::Mapping, Role::GlobalPlanner],
        owes: &[ControlRequest::ROW],
        idle: &[TaskState::ROW, ControlRequest::ROW],
        without_input: "an input beyond its age: a ramp to zero, validity `stale`",
    },
    SeatRow {
        role: Role::CollisionGuard,
        reads: &[
            RobotDescription::ROW,
            RobotOdometry::ROW,
            RobotScan::ROW,
            ControlRequest::ROW,
            TaskZones::ROW,
            MapUpdate::ROW,
        ],
        reads_at_need: &[MapUpdate::ROW],
        answers: Answers::EveryTick,
        after: &[Role::LocalPlanner],
        owes: &[RobotCommand::ROW],
        idle: &[RobotCommand::ROW],
        without_input: "an input beyond its age: a ramp to rest, intervention `*_stale`",
    },
];
