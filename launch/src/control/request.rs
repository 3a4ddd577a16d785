//! What can be asked of a stack over its control socket, and the answers.

use crate::swap_order::SwapOrder;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::PathBuf;
use zeronav_measure::result::Restart;
use zeronav_measure::result::fault::FaultResult;
use zeronav_measure::result::moment::Moment;
use zeronav_measure::result::swap::SwapResult;
use zeronav_observe::control;
use zeronav_scenario::zones::ZoneSpec;
use zeronav_scenario::{GoalSpec, StackFault};

/// What can be asked of a stack.
pub(crate) type Request = control::Request<GoalSpec, StackFault, SwapOrder, ZoneSpec>;

/// One process of a stack. What an older program does not tell has its default.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub(crate) struct ServiceReport {
    /// Its seat.
    pub role: String,
    /// Its process id.
    pub pid: u32,
    /// Which start of the seat it is.
    pub epoch: u32,
    /// What its heartbeat says.
    pub state: String,
    /// Its progress counter.
    pub progress: u64,
    /// Largest resident memory, without shared memory. [bytes]
    pub memory_peak_bytes: u64,
    /// File name of its binary.
    pub binary: String,
    /// Restarts of its seat.
    pub restarts: u32,
    /// The host that fills its seat, in a stack of two.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub host: Option<String>,
}

/// A process beside a stack. What an older program does not tell has its default.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub(crate) struct CompanionReport {
    /// Its name.
    pub name: String,
    /// Its process id; 0 while there is no process.
    pub pid: u32,
    /// `running`, `restarting` or `ended`.
    pub state: String,
    /// How many times it was started.
    pub starts: u32,
    /// File name of its binary.
    pub binary: String,
    /// How the last process ended that has ended.
    pub end: String,
}

/// What becomes of a client's goals.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct GoalReport {
    /// The stack's number for them.
    pub id: u64,
    /// `queued`, `active`, `reached`, `cancelled`, `replaced`, `time_limit`, or why they failed.
    pub outcome: String,
    /// How many other clients' goals are served before.
    pub before: usize,
    /// Goals that are not reached yet; of an active one.
    pub goals_left: usize,
    /// Run time since it became active, until its end. [s]
    pub elapsed_s: f64,
    /// Way left to the current goal. [m]
    pub distance_remaining_m: Option<f64>,
    /// The same at the present speed; `None` while the robot is almost stopped. [s]
    pub time_remaining_s: Option<f64>,
    /// Manoeuvres and waits of the recovery.
    pub recoveries: u32,
    /// Why they failed, in the words of `zeronav why`, or will when the robot has waited; empty when
    /// neither is so.
    #[serde(default)]
    pub why: String,
    /// For which the robot waits at most for what is in its way to go; 0 = it does not wait. [s]
    #[serde(default)]
    pub waits_s: u16,
}

/// A stack and its processes. What an older program does not tell has its default.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub(crate) struct RunReport {
    /// Its scenario.
    pub scenario: String,
    /// Its domain.
    pub domain: String,
    /// Its own folder, with the logs.
    pub folder: PathBuf,
    /// Process id of launch.
    pub pid: u32,
    /// `real_time` or `lockstep`.
    pub mode: String,
    /// True once every service can answer.
    pub ready: bool,
    /// True while run time is held.
    pub paused: bool,
    /// True when a paused lockstep stack has answered every tick that it may do.
    pub stands: bool,
    /// Lockstep only: times real time; `None` = as fast as it can.
    pub speed: Option<f64>,
    /// Binaries that the scenario names for each seat that can be swapped, as it names them; the
    /// stock service first.
    pub binaries: BTreeMap<String, Vec<PathBuf>>,
    /// Run time. [s]
    pub time_s: f64,
    /// Newest tick of the robot.
    pub tick: u64,
    /// True `map_from_base` of the simulated robot: x [m], y [m], yaw [rad].
    pub pose: Option<[f64; 3]>,
    /// `map_from_base` as the stack takes it to be: x [m], y [m], yaw [rad].
    pub estimate: Option<[f64; 3]>,
    /// Contacts of the simulated robot since its start.
    pub contacts: Option<u32>,
    /// State of the task.
    pub task: String,
    /// Why the robot does what it does, in words; empty before the stages have said anything.
    pub why: String,
    /// Clients' goals that are being driven to.
    pub goal: Option<GoalReport>,
    /// Clients' goals that wait.
    pub goals_waiting: usize,
    /// The swap that goes on, or the last one.
    pub swap: Option<SwapResult>,
    /// Its processes; the second one of a seat is not obeyed.
    pub services: Vec<ServiceReport>,
    /// The processes beside it.
    pub companions: Vec<CompanionReport>,
    /// The last restarts of services, the newest last.
    pub restarts: Vec<Restart>,
    /// The last faults that were made on purpose, the newest last.
    pub faults: Vec<FaultResult>,
}

/// The answer to a request.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Reply {
    /// The answer to [`Request::Ps`].
    Run(Box<RunReport>),
    /// The answer to [`Request::Goal`] and [`Request::GoalStatus`].
    Goal(GoalReport),
    /// The answer to [`Request::Swap`] and [`Request::SwapStatus`].
    Swap(Box<SwapResult>),
    /// The answer to [`Request::Why`].
    Why(Box<Moment>),
    /// The answer to [`Request::Zones`].
    Zones(Vec<ZoneSpec>),
    /// Done.
    Done,
    /// Not done, and why.
    Error(String),
}
