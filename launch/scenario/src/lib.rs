//! What to run: scenario files, read and checked before anything is started.
//!
//! ```toml
//! title = "A crate in the way"
//! base = ["warehouse", "porter"]   # a world and a robot to start from
//! start = [3.0, 8.5, 0.0]          # x, y in metres, yaw in radians
//!
//! [[goals]]
//! pose = [27.0, 8.5, 0.0]
//!
//! [services.global_planner]
//! config.planner = "theta_star"
//!
//! [variants.slow]                  # `zeronav run NAME_slow`: the same with these values
//! robot.v_mps_max = 0.3
//! ```
//!
//! Unknown fields are refused, and every error is one line that names file, line and field.

pub mod as_far;
pub mod assignment;
mod check;
pub mod companions;
mod document;
mod error;
#[cfg(test)]
mod every_field;
pub mod fault_plan;
mod faults;
mod foresight;
pub mod hosts;
mod library;
mod limits;
mod made;
pub mod methods;
mod random_faults;
pub mod restart;
pub mod scheduling;
mod schema;
pub mod settings;
#[cfg(test)]
mod shipped;
mod swaps;
#[cfg(test)]
mod tests;
mod tolerant;
pub mod zones;

pub use check::Checked;
pub use error::ScenarioError;
pub use faults::{CLOCK_MS, DELAY_MS, KINDS, SHARE, SLOW_MS, faultable, mortals};
pub use faults::{FAULTS_MAX, StackFault};
pub use foresight::{ForesightSpec, Perceive, Predict};
pub use library::{Library, Listed};
pub use limits::{COORDINATE_M_MAX, TIME_LIMIT_S_MAX, TOLERANCE, YAW_RAD_MAX};
pub use made::goals_in;
pub use random_faults::RandomFaults;
pub use schema::schema;
pub use swaps::{KEEP_S, KEEP_S_MIN, SHADOW_S, ShadowSpec, SwapSpec};

use crate::companions::CompanionSpec;
use crate::hosts::HostSpec;
use crate::restart::RestartSpec;
use crate::scheduling::SchedulingSpec;
use crate::zones::ZoneSpec;
use core::f64::consts::PI;
use document::Document;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use zeronav_casts::Cast;
use zeronav_msgs::task::Goal;
use zeronav_msgs::{Pose, Role};
use zeronav_params::parameters;
use zeronav_robot_description::RobotSpec;
use zeronav_world::{Tolerance, WorldSpec};

/// A scenario: a world, a robot, where it starts and where it shall go, who sits in the seats,
/// and what is expected.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scenario {
    /// Name of its file without `.toml`.
    #[serde(skip_deserializing)]
    pub name: String,
    /// What it belongs to in lists.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub group: String,
    /// One line for lists and reports.
    pub title: String,
    /// What happens and why it is interesting.
    #[serde(default)]
    pub description: String,
    /// Time and chance.
    #[serde(default)]
    pub run: RunSpec,
    /// The world. The paths of its files are absolute.
    pub world: WorldSpec,
    /// The robot.
    pub robot: RobotSpec,
    /// `map_from_base` at the start; `[x, y, yaw]` in the file. [m, m, rad]
    #[serde(deserialize_with = "pose_of", serialize_with = "numbers_of")]
    pub start: Pose,
    /// Where to, in order. Without goals the run waits for goals from outside until its time is
    /// over.
    #[serde(default)]
    pub goals: Vec<GoalSpec>,
    /// Where the robot may not go, where it is slow, which ways it prefers.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub zones: Vec<ZoneSpec>,
    /// Who sits in the seats.
    #[serde(default)]
    pub services: ServicesSpec,
    /// Whether mapping starts from the static world ([`zeronav_world::World::rasterise`]) or from
    /// nothing.
    #[serde(default = "yes")]
    pub static_map: bool,
    /// How often services are restarted, and when they count as hung.
    #[serde(default)]
    pub restart: RestartSpec,
    /// What breaks in the middle of the drive.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub faults: Vec<StackFault>,
    /// What breaks besides, drawn from a seed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub random_faults: Option<RandomFaults>,
    /// Services that are exchanged while the robot drives, one after the other.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub swaps: Vec<SwapSpec>,
    /// Processes beside the stack on which nothing in it waits, by name.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub companions: BTreeMap<String, CompanionSpec>,
    /// The computers that fill the seats, by name; without, the one on which it is started fills all.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub hosts: BTreeMap<String, HostSpec>,
    /// What the verdict asks for.
    #[serde(default)]
    pub expect: ExpectSpec,
    /// What services are told of what moves, to measure what perception and prediction cost.
    #[serde(default, skip_serializing_if = "ForesightSpec::is_none")]
    pub foresight: ForesightSpec,
    /// How `--trials` measures in this world; without, it cannot.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub trials: Option<TrialsSpec>,
    #[serde(skip)]
    folder: Option<PathBuf>,
    #[serde(skip)]
    document: Document,
}

parameters! {
    /// Time and chance of a run.
    pub struct RunSpec {
        /// Run time after which the run ends.
        time_limit_s: f64 = 120.0, [0.1, TIME_LIMIT_S_MAX] "s";
        /// Control ticks per second, not below the lidar's rate.
        tick_hz: f64 = 50.0, [1.0, 1000.0] "Hz";
        /// Seed of everything random.
        seed: u64 = 1, [0, u64::MAX];
    }
}

impl RunSpec {
    /// Run time from tick to tick. [ns]
    #[must_use]
    pub fn tick_ns(&self) -> u64 {
        (1.0e9 / self.tick_hz).round().to_u64()
    }

    /// Run time after which the run ends. [ns]
    #[must_use]
    pub fn time_limit_ns(&self) -> u64 {
        (self.time_limit_s * 1.0e9).round().to_u64()
    }
}

/// A goal.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GoalSpec {
    /// `map_from_base` to reach; `[x, y, yaw]` in the file. [m, m, rad]
    #[serde(deserialize_with = "pose_of", serialize_with = "numbers_of")]
    pub pose: Pose,
    /// How close counts. [m]
    #[serde(default = "default_tolerance_m")]
    pub tolerance_m: f64,
    /// How close the yaw must be; pi = any yaw. [rad]
    #[serde(default = "any_yaw_rad")]
    pub yaw_tolerance_rad: f64,
}

impl GoalSpec {
    /// The goal as a message, with the sender's own number for it (not 0).
    #[must_use]
    pub const fn message(&self, id: u64) -> Goal {
        Goal {
            pose: self.pose,
            tolerance_m: self.tolerance_m,
            yaw_tolerance_rad: self.yaw_tolerance_rad,
            id,
        }
    }

    /// How close counts.
    #[must_use]
    pub const fn tolerance(&self) -> Tolerance {
        Tolerance {
            distance_m: self.tolerance_m,
            yaw_rad: self.yaw_tolerance_rad,
        }
    }
}

/// Who sits in the seats; an empty entry is the stock binary with its defaults.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ServicesSpec {
    /// The robot, simulated or real.
    pub robot: ServiceSpec,
    /// Scans to a map.
    pub mapping: ServiceSpec,
    /// Map and goal to a path.
    pub global_planner: ServiceSpec,
    /// Path to velocity requests.
    pub local_planner: ServiceSpec,
    /// The last check before the wheels.
    pub collision_guard: ServiceSpec,
}

impl ServicesSpec {
    /// Who sits in the seat of `role`; `None` for roles that are no service.
    #[must_use]
    pub const fn of(&self, role: Role) -> Option<&ServiceSpec> {
        match role {
            Role::Robot => Some(&self.robot),
            Role::Mapping => Some(&self.mapping),
            Role::GlobalPlanner => Some(&self.global_planner),
            Role::LocalPlanner => Some(&self.local_planner),
            Role::CollisionGuard => Some(&self.collision_guard),
            Role::Launch | Role::Tap => None,
        }
    }

    /// The roles with what is said of each, to be changed.
    pub fn each_mut(&mut self) -> [(Role, &mut ServiceSpec); 5] {
        [
            (Role::Robot, &mut self.robot),
            (Role::Mapping, &mut self.mapping),
            (Role::GlobalPlanner, &mut self.global_planner),
            (Role::LocalPlanner, &mut self.local_planner),
            (Role::CollisionGuard, &mut self.collision_guard),
        ]
    }
}

/// A service: which binary and its configuration.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ServiceSpec {
    /// Name or path of the binary; without, the stock one. A path that leads to a file from the
    /// folder of the scenario is absolute, any other is as it was written.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub binary: Option<PathBuf>,
    /// What the service finds in its configuration file.
    pub config: toml::Table,
    /// A second process that is compared with it and never obeyed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub shadow: Option<ShadowSpec>,
    /// How the kernel shall schedule the processes in its seat.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub scheduling: Option<SchedulingSpec>,
}

/// What the verdict asks for.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ExpectSpec {
    /// How the task ends.
    pub outcome: Outcome,
    /// Most contacts of the robot with anything.
    pub contacts_max: u32,
    /// Fewest new paths that an obstacle caused.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub obstacle_replans_min: Option<u32>,
    /// Most new paths that an obstacle caused.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub obstacle_replans_max: Option<u32>,
    /// Shortest drive. [m]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub driven_m_min: Option<f64>,
    /// Largest true distance of the robot's centre from the last goal at the end, whatever the stack
    /// believes. [m]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub goal_distance_m_max: Option<f64>,
    /// Fewest times that the collision guard stepped in, for each reason that it must have had: the
    /// labels of [`zeronav_msgs::command::Intervention`].
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub interventions_min: BTreeMap<String, u32>,
    /// Fewest restarts of services.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub restarts_min: Option<u32>,
}

/// Trials: the robot drives to and fro, and one of the world's obstacles is dropped in front of it
/// again and again.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrialsSpec {
    /// Name of the obstacle.
    pub obstacle: String,
    /// The two goals.
    pub goals: [GoalSpec; 2],
    /// The two ends `[x, y]` of the line on which the obstacle's centre may be put, turned as its
    /// shape says. The way between the goals leads along it. [m]
    pub line_m: [[f64; 2]; 2],
    /// How far before the robot's centre the obstacle's is put, along the line. [m]
    pub ahead_m: f64,
}

/// How a task may end.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Outcome {
    /// The robot is stopped at the last goal.
    #[default]
    Reached,
    /// The stack says that there is no way, and the robot is stopped.
    Unreachable,
    /// Nobody says anything until the time is over: what is asked for is asked by the other
    /// expectations.
    Timeout,
}

impl Scenario {
    /// The shadow of a seat.
    pub fn shadows(&self) -> impl Iterator<Item = (Role, &ShadowSpec)> {
        Role::SERVICES
            .into_iter()
            .filter_map(|role| Some((role, self.services.of(role)?.shadow.as_ref()?)))
    }

    /// How the processes of each seat shall be scheduled, where the scenario says so.
    #[must_use]
    pub fn scheduling(&self) -> BTreeMap<Role, SchedulingSpec> {
        Role::SERVICES
            .into_iter()
            .filter_map(|role| Some((role, self.services.of(role)?.scheduling.clone()?)))
            .collect()
    }

    /// The names of the variants of the scenario in `file`; none when it has none or cannot be read.
    #[must_use]
    pub fn variants(file: &Path) -> Vec<String> {
        library::variants_in(file)
    }

    /// The folder of its file; `None` when it is built in.
    #[must_use]
    pub fn folder(&self) -> Option<&Path> {
        self.folder.as_deref()
    }

    /// The error that the value at `field` (such as `services.mapping.binary`) cannot be, naming
    /// file and line.
    #[must_use]
    pub fn error_at(&self, field: &str, why: &str) -> ScenarioError {
        self.document.at_field(field, why)
    }

    /// A hash of the texts of the scenario and of what it builds on, wherever they lie: equal on two computers that
    /// have the same ones. The files of its world are not in it.
    #[must_use]
    pub fn fingerprint(&self) -> u64 {
        self.document.fingerprint()
    }
}

/// Scenarios that can be run by name from the working folder of this process.
#[must_use]
pub fn list() -> Vec<Listed> {
    Library::of("").list()
}

/// The files that a world is read from, and where they are named.
fn files_of(world: &mut WorldSpec) -> impl Iterator<Item = (&'static str, &mut PathBuf)> {
    let map = world.map.as_mut().map(|file| ("world.map", file));
    let barn = world.barn.as_mut().map(|file| ("world.barn", file));
    let dynabarn = world.dynabarn.as_mut();
    let dynabarn = dynabarn.map(|spec| ("world.dynabarn.file", &mut spec.file));
    let people = world.pedestrians.as_mut();
    let people = people.map(|spec| ("world.pedestrians.file", &mut spec.file));
    [map, barn, dynabarn, people].into_iter().flatten()
}

fn absolute(path: &Path) -> PathBuf {
    std::path::absolute(path).unwrap_or_else(|_| path.to_path_buf())
}

fn pose_of<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Pose, D::Error> {
    let [x_m, y_m, yaw_rad] = <[f64; 3]>::deserialize(deserializer)?;
    Ok(Pose::new(x_m, y_m, yaw_rad))
}

fn numbers_of<S: Serializer>(pose: &Pose, serializer: S) -> Result<S::Ok, S::Error> {
    [pose.x_m, pose.y_m, pose.yaw_rad].serialize(serializer)
}

const fn yes() -> bool {
    true
}

const fn default_tolerance_m() -> f64 {
    0.25
}

const fn any_yaw_rad() -> f64 {
    PI
}

/// The binaries that a scenario names, by their fields.
fn binaries_of(scenario: &mut Scenario) -> Vec<(String, &mut PathBuf)> {
    let mut binaries = Vec::new();
    for (role, service) in scenario.services.each_mut() {
        let field = format!("services.{role}");
        binaries.extend(
            service
                .binary
                .iter_mut()
                .map(|file| (format!("{field}.binary"), file)),
        );
        let shadow = service
            .shadow
            .iter_mut()
            .filter_map(|shadow| shadow.binary.as_mut());
        binaries.extend(shadow.map(|file| (format!("{field}.shadow.binary"), file)));
    }
    for (index, swap) in scenario.swaps.iter_mut().enumerate() {
        let binary = swap.binary.as_mut();
        binaries.extend(binary.map(|file| (format!("swaps[{index}].binary"), file)));
    }
    for (name, companion) in &mut scenario.companions {
        binaries.push((format!("companions.{name}.binary"), &mut companion.binary));
    }
    binaries
}
