//! The result of a run as plain data: what `zeronav run --json` prints and `result.json` holds.
//!
//! The modules that drive, judge, draw and report share these types; nothing here computes anything.
//! `launch/result.schema.json` is the JSON schema of every `result.json`: that of a run, a [`RunResult`],
//! and that of a stack that stayed up.

pub mod companion;
pub mod fault;
pub mod latency;
pub mod link;
pub mod moment;
pub mod profile;
pub mod scheduling;
pub mod start_up;
pub mod stay;
pub mod swap;
pub mod trials;
pub mod truth;

use companion::CompanionResult;
use fault::FaultResult;
use latency::Latency;
use link::LinkResult;
use moment::Moment;
use profile::Profile;
use scheduling::Scheduling;
use serde::{Deserialize, Serialize};
use start_up::StartUp;
use std::collections::BTreeMap;
use std::path::Path;
use swap::SwapResult;
use trials::{Disturbance, TrialsResult};
use truth::{PoseResult, TrackingResult};
use zeronav_files::read;

/// The result of a run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct RunResult {
    /// Scenario.
    pub scenario: String,
    /// `pass` or `fail`.
    pub verdict: String,
    /// The same in words.
    pub reason: String,
    /// `reached`, `unreachable`, `stuck`, `timeout` and so on.
    pub outcome: String,
    /// True when every goal was reached.
    pub reached: bool,
    /// Contacts of the robot with anything.
    pub contacts: u32,
    /// Contacts that began while the robot moved.
    pub contacts_moving: u32,
    /// Contacts that began while the robot stood.
    pub contacts_standing: u32,
    /// Smallest distance of the footprint to anything; null when nothing was near. [m]
    pub clearance_m_min: Option<f64>,
    /// Run time from the first goal to the end. [s]
    pub time_s: f64,
    /// Run time of the first goal, from which `motion`, `touches` and `plans` count; 0 in lockstep, and left
    /// out then. [s]
    #[serde(default, skip_serializing_if = "is_zero")]
    pub first_goal_s: f64,
    /// Distance driven. [m]
    pub driven_m: f64,
    /// `real_time` or `lockstep`.
    pub mode: String,
    /// Seed.
    pub seed: u64,
    /// Wall time of the drive. [s]
    pub wall_s: f64,
    /// Run time per wall time.
    pub speed_factor: f64,
    /// Run time that was lost because the machine was busy. [ms]
    pub slipped_ms: f64,
    /// Every path, the first ones included.
    pub plans: Vec<PlannedPath>,
    /// Every path that took the place of another.
    pub replans: Vec<PlannedPath>,
    /// Scripted obstacles that appeared.
    pub obstacles: Vec<ObstacleResult>,
    /// Where the robot really drove, every 5 cm. [m]
    pub track_m: Vec<[f64; 2]>,
    /// Ten times a second: time since the first goal [s], true x [m], y [m] and yaw [rad], forward
    /// speed [m/s], yaw rate [rad/s]. Empty after trials.
    pub motion: Vec<[f64; 6]>,
    /// Mean absolute jerk of the forward speed. [m/s^3] Of trials: of the last drive.
    pub jerk_mps3: Option<f64>,
    /// Manoeuvres and waits of the local planner's recovery. Of trials: in the last drive.
    pub recoveries: u32,
    /// Why the robot got stuck, `blocked`, `no_progress` or `too_many_attempts`; null when it has
    /// not.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stuck_cause: Option<String>,
    /// What the robot touched. Of trials: in the last drive.
    pub touches: Vec<Touch>,
    /// How often the collision guard stepped in. Of trials: in the last drive.
    pub interventions: usize,
    /// The same by reason.
    pub interventions_by_reason: BTreeMap<String, usize>,
    /// Where mapping said the robot was against where it was; of trials: of the last drive.
    pub pose: Option<PoseResult>,
    /// Moving obstacles as mapping followed them; null when nothing moved. Of trials: of the last
    /// drive.
    pub tracking: Option<TrackingResult>,
    /// After how long the wheels obeyed, when that is not what the robot's description says.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub command_lag: Option<CommandLag>,
    /// Latencies; null in lockstep. Of trials: the median of the rounds, the worst of all.
    pub latency: Option<Latency>,
    /// How sure they are and what lies behind them; null in lockstep.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub profile: Option<Profile>,
    /// What disturbed the run; of trials each round has its own.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub disturbance: Option<Disturbance>,
    /// From the command to the first motion; null in lockstep and of trials.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub start_up: Option<StartUp>,
    /// The rounds of `--trials`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub trials: Option<TrialsResult>,
    /// Delays of `--inject` by seat. [us]
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub injected_us: BTreeMap<String, f64>,
    /// The processes.
    pub services: Vec<ServiceResult>,
    /// The processes that ran beside the stack.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub companions: Vec<CompanionResult>,
    /// What the link between two hosts carried; left out when one computer fills every seat.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub link: Option<LinkResult>,
    /// Restarts of services during the run.
    pub restarts: Vec<Restart>,
    /// Services that got no processor for longer than `hang_after_s`, in real time.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub starved: Vec<Starved>,
    /// Faults that were made on purpose.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub faults: Vec<FaultResult>,
    /// Goals that were given by hand.
    pub redirects: Vec<Redirect>,
    /// Swaps and comparisons of services during the run.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub swaps: Vec<SwapResult>,
    /// What the stages said of why the robot did what it did: a moment for every change of their words,
    /// the last thousand.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub reasons: Vec<Moment>,
    /// Machine and build.
    pub environment: Environment,
    /// Shared memory of the run. [bytes]
    pub shared_memory_bytes: u64,
    /// Hash of a lockstep run.
    pub run_hash: Option<String>,
    /// True when the same command gives the same hash again, false when something decided about the
    /// run that the scenario does not know of; null in real time.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reproducible: Option<bool>,
    /// Why it is not, one line each.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub not_reproducible: Vec<String>,
    /// What was expected.
    pub expectations: Vec<Expectation>,
    /// Folder with everything that the run left.
    pub directory: String,
}

#[allow(
    clippy::trivially_copy_pass_by_ref,
    reason = "as serde asks for a field"
)]
fn is_zero(time_s: &f64) -> bool {
    *time_s == 0.0
}

impl RunResult {
    /// The result in the folder of a run.
    ///
    /// # Errors
    /// One line naming the file.
    pub fn read(run: &Path) -> Result<Self, String> {
        let file = run.join("result.json");
        let name = file.display();
        let text = read::text(&file, read::RESULT_BYTES_MAX)
            .map_err(|error| format!("{name}: {error}; the folder of a run holds a result.json"))?;
        serde_json::from_str(&text)
            .map_err(|error| format!("{name} is no result of a run: {error}"))
    }
}

/// Commands that take effect later or sooner than the robot's description says.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct CommandLag {
    /// As commands and odometry show it, to 20 ms. [s]
    pub seen_s: f64,
    /// As the description says. [s]
    pub declared_s: f64,
}

/// A path that was published.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct PlannedPath {
    /// Run time. [s]
    pub time_s: f64,
    /// Why it was made.
    pub cause: String,
    /// Who made it.
    pub planner: String,
    /// `found`, or why there is none.
    pub status: String,
    /// Length. [m]
    pub length_m: f64,
    /// From its end to the goal, above 0 when the goal itself cannot be reached. [m]
    pub beside_goal_m: f64,
    /// Nodes expanded.
    pub expanded: u64,
    /// Least distance of the robot's inscribed circle from everything static in the true world
    /// when its centre follows the path exactly; null without a path or without anything static. [m]
    #[serde(default)]
    pub clearance_m_min: Option<f64>,
    /// True when that is below 0.
    #[serde(default)]
    pub collides: bool,
    /// Its corners, `map` frame. [m]
    pub points_m: Vec<[f64; 2]>,
}

/// A scripted obstacle that appeared.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct ObstacleResult {
    /// Its name.
    pub name: String,
    /// Corners of its outline where it was last, `map` frame. [m]
    pub corners_m: Vec<[f64; 2]>,
}

/// The begin of a contact.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct Touch {
    /// Time since the first goal. [s]
    pub time_s: f64,
    /// True when the robot moved.
    pub moving: bool,
    /// Forward speed just before. [m/s]
    pub v_mps: f64,
    /// What was touched: a scripted obstacle's name, or `world`.
    pub with: String,
    /// True `map_from_base`: x [m], y [m], yaw [rad].
    pub pose: [f64; 3],
}

/// What was expected, and whether it came.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct Expectation {
    /// What.
    pub name: String,
    /// As the scenario wishes.
    pub expected: String,
    /// As it came.
    pub actual: String,
    /// True when both agree.
    pub met: bool,
}

/// One process of the run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct ServiceResult {
    /// Its seat.
    pub name: String,
    /// File name of the program that answered.
    pub binary: String,
    /// The host that fills the seat, in a stack of two: memory and scheduling are of the program that stands in for
    /// it on the robot's host.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub host: Option<String>,
    /// Its process id; 0 when none answered.
    pub pid: u32,
    /// True when the seat was left to a process that was started by hand.
    pub external: bool,
    /// Key of its algorithm, where it has told one.
    pub key: Option<String>,
    /// How many times it was started.
    pub starts: u32,
    /// Largest resident memory, without shared memory. [bytes]
    pub memory_peak_bytes: u64,
    /// How the kernel scheduled it; null when launch did not start it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub scheduling: Option<Scheduling>,
    /// How it ended.
    pub end: String,
}

/// Where and with what the run was made.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct Environment {
    /// Version of the project.
    pub version: String,
    /// `release` or `debug`.
    pub build: String,
    /// Processor.
    pub cpu: String,
    /// Processors that this process may use.
    pub cores: usize,
    /// Kernel.
    pub kernel: String,
    /// Load average of the last minute at the start.
    pub load_start: f64,
    /// Load average of the last minute at the end.
    pub load_end: f64,
    /// Share of processor time that the host gave to others during the run, 0 to 1.
    pub steal: f64,
}

/// A restart that was made.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct Restart {
    /// Its seat.
    pub service: String,
    /// Run time at which the end was noticed. [s]
    pub time_s: f64,
    /// How the process ended.
    pub how: String,
    /// Wait before the successor. [ms]
    pub wait_ms: u64,
}

/// A service that was ready to run and got no processor: the machine had too much to do.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct Starved {
    /// Its seat.
    pub service: String,
    /// Run time at which it first stood still. [s]
    pub time_s: f64,
    /// How often it did for longer than `hang_after_s`.
    pub times: u32,
    /// The longest time without progress. [s]
    pub longest_s: f64,
    /// Time in the run queue in all of them. [s]
    pub waited_s: f64,
}

/// A goal that was given by hand.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct Redirect {
    /// Run time at which it came. [s]
    pub time_s: f64,
    /// `[x, y, yaw]`. [m, m, rad]
    pub goal: [f64; 3],
    /// `active`, `reached`, `replaced`, or why it was given up.
    pub outcome: String,
}

#[cfg(test)]
mod tests;
