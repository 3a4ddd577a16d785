//! What the stages said of why the robot does what it does, at one moment.

use serde::{Deserialize, Serialize};
use zeronav_casts::Cast;
use zeronav_msgs::command::{Intervention, PlannerInput, RecoveryReason, RequestCause, Validity};
use zeronav_msgs::map::ObstacleSource;
use zeronav_msgs::path::{PathBlock, PathCause, PathStatus};
use zeronav_msgs::task::{EndReason, StuckCause, TaskState};

/// Codes as the words of the contract.
macro_rules! words {
    ($($module:ident = $code:ty),* $(,)?) => {$(
        mod $module {
            use serde::de::Error;
            use serde::{Deserialize, Deserializer, Serializer};

            #[allow(clippy::trivially_copy_pass_by_ref, reason = "as serde calls it")]
            pub(super) fn serialize<S: Serializer>(code: &$code, to: S) -> Result<S::Ok, S::Error> {
                to.serialize_str(code.label())
            }

            pub(super) fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<$code, D::Error> {
                let word = String::deserialize(from)?;
                let known = <$code>::ALL.iter().find(|code| code.label() == word);
                known.copied().ok_or_else(|| {
                    let problem = format!("{}: no such word", zeronav_shell::printable(&word));
                    D::Error::custom(problem)
                })
            }
        }
    )*};
}

words!(
    validity = zeronav_msgs::command::Validity,
    request_cause = zeronav_msgs::command::RequestCause,
    planner_input = zeronav_msgs::command::PlannerInput,
    recovery_reason = zeronav_msgs::command::RecoveryReason,
    intervention = zeronav_msgs::command::Intervention,
    path_status = zeronav_msgs::path::PathStatus,
    path_cause = zeronav_msgs::path::PathCause,
    path_block = zeronav_msgs::path::PathBlock,
    obstacle_source = zeronav_msgs::map::ObstacleSource,
    task_state = zeronav_msgs::task::TaskState,
    end_reason = zeronav_msgs::task::EndReason,
    stuck_cause = zeronav_msgs::task::StuckCause,
);

/// What the stages said at one moment. Of a run it is kept when the words change.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct Moment {
    /// Run time since the first goal. [s]
    pub time_s: f64,
    /// The local planner, if it has answered.
    pub request: Option<Request>,
    /// The collision guard, if it has answered.
    pub command: Option<Command>,
    /// The global planner, if it has answered.
    pub path: Option<Path>,
    /// What became of the task.
    pub task: Option<Task>,
    /// The zone because of which the robot is slow, stands, or has no path.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub zone: Option<Zone>,
}

/// What the stages say of a zone.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ZoneTold {
    /// The robot is slow in one.
    Slow,
    /// A keepout zone holds it back, leaves no path, or has ended the task.
    Keepout,
}

impl Moment {
    /// What the stages say of a zone; `None` when they speak of none.
    #[must_use]
    pub fn zone_told(&self) -> Option<ZoneTold> {
        match self.command.as_ref().map(|command| command.intervention) {
            Some(Intervention::ZoneStopped) => return Some(ZoneTold::Keepout),
            Some(Intervention::ZoneSlowed) => return Some(ZoneTold::Slow),
            _ => {}
        }
        let cause = self.request.as_ref().map(|request| request.cause);
        let path = self.path.as_ref();
        let has_path = path.is_none_or(|path| path.status == PathStatus::Found);
        let task = self.task.as_ref();
        let ended_by = task.and_then(|task| Some(task.blocked.as_ref()?.source));
        if ended_by == Some(ObstacleSource::Keepout) {
            return Some(ZoneTold::Keepout);
        }
        match path.map(|path| path.source) {
            Some(ObstacleSource::Keepout) if !has_path => Some(ZoneTold::Keepout),
            _ => (cause == Some(RequestCause::SpeedZone)).then_some(ZoneTold::Slow),
        }
    }
}

/// A zone.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct Zone {
    /// Its name.
    pub name: String,
    /// Fastest speed in it; null for a keepout zone. [m/s]
    pub limit_mps: Option<f64>,
}

/// What the local planner said.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct Request {
    /// Forward speed that it asked for. [m/s]
    pub v_mps: f64,
    /// Yaw rate that it asked for. [rad/s]
    pub w_radps: f64,
    /// What its request means.
    #[serde(with = "validity")]
    #[cfg_attr(test, schemars(with = "String"))]
    pub validity: Validity,
    /// What decided it.
    #[serde(with = "request_cause")]
    #[cfg_attr(test, schemars(with = "String"))]
    pub cause: RequestCause,
    /// The input that is old.
    #[serde(with = "planner_input")]
    #[cfg_attr(test, schemars(with = "String"))]
    pub input: PlannerInput,
    /// Why the recovery does what it does.
    #[serde(with = "recovery_reason")]
    #[cfg_attr(test, schemars(with = "String"))]
    pub recovery: RecoveryReason,
    /// Fastest forward speed that the cause allows; 0 = it sets none. [m/s]
    pub limit_mps: f64,
    /// Along the path to the first obstacle on it; 0 = none in sight. [m]
    pub blocked_arc_m: f64,
    /// Ages of odometry, scan, map and path; 65535 = never received, or older; all 0
    /// with the cause `none` = not told. [ms]
    pub ages_ms: [u16; 4],
    /// The nearest dynamic obstacle within 2.5 m.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub obstacle: Option<Obstacle>,
}

/// A dynamic obstacle.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct Obstacle {
    /// Its track.
    pub track: u64,
    /// Where it is, `map` frame. [m]
    pub at_m: [f64; 2],
    /// Its speed. [m/s]
    pub speed_mps: f64,
}

/// What the collision guard said.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct Command {
    /// Forward speed that it let pass. [m/s]
    pub v_mps: f64,
    /// Yaw rate that it let pass. [rad/s]
    pub w_radps: f64,
    /// What its command means.
    #[serde(with = "validity")]
    #[cfg_attr(test, schemars(with = "String"))]
    pub validity: Validity,
    /// What it did to the request.
    #[serde(with = "intervention")]
    #[cfg_attr(test, schemars(with = "String"))]
    pub intervention: Intervention,
    /// The point of a scan that decided.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub point: Option<Point>,
}

/// A point of a scan.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct Point {
    /// Beam towards it, from 1.
    pub beam: u16,
    /// Where it is, in `base`. [m]
    pub at_m: [f64; 2],
    /// Least distance to the outline on the way that was asked for. [m]
    pub clearance_m: f64,
}

/// What the global planner said.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct Path {
    /// Its planner.
    pub planner: String,
    /// The outcome.
    #[serde(with = "path_status")]
    #[cfg_attr(test, schemars(with = "String"))]
    pub status: PathStatus,
    /// Why it was looked for.
    #[serde(with = "path_cause")]
    #[cfg_attr(test, schemars(with = "String"))]
    pub cause: PathCause,
    /// Run time since the first goal at which it was new; null when that was not seen. [s]
    pub time_s: Option<f64>,
    /// Length when it was new. [m]
    pub length_m: f64,
    /// From its end to the goal. [m]
    pub beside_goal_m: f64,
    /// The cell that decided.
    #[serde(with = "path_block")]
    #[cfg_attr(test, schemars(with = "String"))]
    pub block: PathBlock,
    /// Its centre, `map` frame. [m]
    pub block_m: [f64; 2],
    /// Where the obstacle comes from that blocks it.
    #[serde(
        with = "obstacle_source",
        default = "not_told",
        skip_serializing_if = "is_not_told"
    )]
    #[cfg_attr(test, schemars(with = "String"))]
    pub source: ObstacleSource,
}

/// What results of older versions say of an obstacle's source.
const fn not_told() -> ObstacleSource {
    ObstacleSource::None
}

#[allow(clippy::trivially_copy_pass_by_ref, reason = "as serde calls it")]
fn is_not_told(source: &ObstacleSource) -> bool {
    *source == ObstacleSource::None
}

/// A cell that is blocked.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct Blocked {
    /// What it is.
    #[serde(with = "path_block")]
    #[cfg_attr(test, schemars(with = "String"))]
    pub block: PathBlock,
    /// Its centre, `map` frame. [m]
    pub at_m: [f64; 2],
    /// Where the obstacle comes from that blocks it.
    #[serde(with = "obstacle_source")]
    #[cfg_attr(test, schemars(with = "String"))]
    pub source: ObstacleSource,
}

/// What became of the task.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct Task {
    /// Its state.
    #[serde(with = "task_state")]
    #[cfg_attr(test, schemars(with = "String"))]
    pub state: TaskState,
    /// Why it ended, or will when it has waited.
    #[serde(with = "end_reason")]
    #[cfg_attr(test, schemars(with = "String"))]
    pub reason: EndReason,
    /// Why the robot got stuck.
    #[serde(with = "stuck_cause")]
    #[cfg_attr(test, schemars(with = "String"))]
    pub stuck: StuckCause,
    /// The cell because of which it failed, or waits.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub blocked: Option<Blocked>,
    /// For which it waits at most for that obstacle to go; 0 = it does not wait. [s]
    #[serde(default, skip_serializing_if = "is_zero")]
    pub waits_s: u16,
}

#[allow(clippy::trivially_copy_pass_by_ref, reason = "as serde calls it")]
const fn is_zero(seconds: &u16) -> bool {
    *seconds == 0
}

impl Request {
    /// What a message says; `None` for unknown codes. `obstacle` is the one that it names.
    #[must_use]
    pub fn of(
        request: &zeronav_msgs::command::VelocityRequest,
        obstacle: Option<Obstacle>,
    ) -> Option<Self> {
        Some(Self {
            v_mps: request.v_mps,
            w_radps: request.w_radps,
            validity: request.validity()?,
            cause: request.cause()?,
            input: request.input()?,
            recovery: request.recovery()?,
            limit_mps: request.limit_mps,
            blocked_arc_m: request.blocked_arc_m,
            ages_ms: request.ages_ms,
            obstacle,
        })
    }
}

impl Obstacle {
    /// A tracked obstacle.
    #[must_use]
    pub fn of(obstacle: &zeronav_msgs::obstacles::Obstacle) -> Self {
        Self {
            track: obstacle.track,
            at_m: [obstacle.x_m, obstacle.y_m],
            speed_mps: obstacle.vx_mps.hypot(obstacle.vy_mps),
        }
    }
}

impl Command {
    /// What a message says; `None` for unknown codes.
    #[must_use]
    pub fn of(command: &zeronav_msgs::command::VelocityCommand) -> Option<Self> {
        Some(Self {
            v_mps: command.v_mps,
            w_radps: command.w_radps,
            validity: command.validity()?,
            intervention: command.intervention()?,
            point: (command.beam != 0).then_some(Point {
                beam: command.beam,
                at_m: command.point_m,
                clearance_m: command.point_clearance_m,
            }),
        })
    }
}

impl Path {
    /// What a message says, new at `time_s`; `None` for unknown codes.
    #[must_use]
    pub fn of(path: &zeronav_msgs::path::Path, time_s: Option<f64>) -> Option<Self> {
        Some(Self {
            planner: path.planner().to_owned(),
            status: path.status()?,
            cause: path.cause()?,
            time_s,
            length_m: path.length_m,
            beside_goal_m: path.beside_goal_m,
            block: path.block()?,
            block_m: path.block_m,
            source: path.source()?,
        })
    }

    /// The cell that decided, if one is named.
    #[must_use]
    pub fn blocked(&self) -> Option<Blocked> {
        Blocked::named(self.block, self.block_m, self.source)
    }
}

impl Blocked {
    /// A cell, if one is named.
    fn named(block: PathBlock, at_m: [f64; 2], source: ObstacleSource) -> Option<Self> {
        let blocked = Self {
            block,
            at_m,
            source,
        };
        (block != PathBlock::None).then_some(blocked)
    }
}

impl Task {
    /// What a message says; `None` for unknown codes.
    #[must_use]
    pub fn of(status: &zeronav_msgs::task::TaskStatus) -> Option<Self> {
        Some(Self {
            state: status.state()?,
            reason: status.reason()?,
            stuck: status.cause()?,
            blocked: Blocked::named(status.block()?, status.block_m, status.source()?),
            waits_s: status.waits_s,
        })
    }

    /// The same so much later, if nothing else has been heard. [s]
    #[must_use]
    pub fn after(self, time_s: f64) -> Self {
        let past_s = time_s.clamp(0.0, f64::from(u16::MAX)).to_u16();
        // Waiting does not end by its being told late.
        let waits_s = self.waits_s.saturating_sub(past_s).max(self.waits_s.min(1));
        Self { waits_s, ..self }
    }

    /// True while it waits for what blocks robot, way or goal to go.
    #[must_use]
    pub const fn waits(&self) -> bool {
        self.waits_s > 0
    }

    /// True when what it failed by may go: it is in no static map.
    #[must_use]
    pub fn may_open(&self) -> bool {
        let source = self.blocked.map(|blocked| blocked.source);
        let is_passing = matches!(
            source,
            Some(ObstacleSource::Lidar | ObstacleSource::Tracked)
        );
        let is_blocked = matches!(
            self.reason,
            EndReason::Unreachable | EndReason::GoalBlocked | EndReason::NoPath
        );
        is_passing && is_blocked
    }
}
