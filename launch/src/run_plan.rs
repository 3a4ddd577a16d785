//! What a run is asked to be, before anything is read or checked.

use crate::live_view::PageArgs;
use crate::recorder::RecordTo;
use std::collections::BTreeMap;
use std::path::PathBuf;
use zeronav_msgs::role::Role;
use zeronav_msgs::run::RunMode;
use zeronav_scenario::settings::Settings;

/// Rounds of trials, each with a stack of its own.
pub(crate) const TRIAL_ROUNDS: usize = 3;

/// Where a scenario comes from.
#[derive(Debug, Clone, PartialEq)]
pub enum Source {
    /// Its name or path.
    Named(String),
    /// Its text, with everything that it builds on.
    Text {
        /// Its name.
        name: String,
        /// What [`zeronav_scenario::Scenario::to_toml`] has written.
        text: String,
    },
    /// Made of a map and a robot, without goals.
    Map {
        /// YAML file of a ROS `map_server` map.
        map: PathBuf,
        /// Name of a base that describes a robot.
        robot: String,
        /// x [m], y [m] and yaw [rad] in the map frame; `None` = a free pose near the map's middle.
        start: Option<[f64; 3]>,
    },
}

/// What else the machine does.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, clap::ValueEnum)]
pub enum MachineLoad {
    /// Nothing that this command starts.
    #[default]
    Idle,
    /// A process per core computes all the time.
    Busy,
}

impl MachineLoad {
    /// The word for it.
    #[must_use]
    pub const fn label(self) -> &'static str {
        match self {
            Self::Idle => "idle",
            Self::Busy => "busy",
        }
    }
}

/// The order for one run.
#[derive(Debug, Clone)]
#[allow(clippy::struct_excessive_bools, reason = "independent choices")]
pub struct RunPlan {
    /// The live page that is wanted beside it.
    pub view: Option<PageArgs>,
    /// Where every message is recorded.
    pub record: Option<RecordTo>,
    /// What to drive in.
    pub scenario: Source,
    /// Real time or lockstep.
    pub mode: RunMode,
    /// Seed of everything random; `None` = the scenario's.
    pub seed: Option<u64>,
    /// Scans per second in place of the scenario's. [Hz]
    pub rate_hz: Option<f64>,
    /// Binaries in place of the scenario's, by seat.
    pub binaries: BTreeMap<Role, PathBuf>,
    /// Keys of configurations in place of the scenario's.
    pub settings: Settings,
    /// What else the machine does.
    pub load: MachineLoad,
    /// Seats that are left to processes started by hand.
    pub external: Vec<Role>,
    /// Which of the scenario's hosts this is; `None` = this computer fills every seat.
    pub host: Option<String>,
    /// Trials to make instead of the scenario's drive.
    pub trials: Option<u32>,
    /// True when the stack stays up and waits for goals, in place of the scenario's drive.
    pub stays: bool,
    /// True when its robot shall be where the last stack of the scenario was left.
    pub resume_pose: bool,
    /// Delays injected into seats, in steps of [`zeronav_msgs::run::DELAY_STEP_NS`].
    pub delays: BTreeMap<Role, u16>,
    /// Folder in which the run's own folder is made.
    pub out: PathBuf,
    /// Name of that; `None` = one with the time and the process.
    pub folder: Option<String>,
    /// What the services log: a level or a filter.
    pub log_level: String,
    /// True when a progress line is shown.
    pub progress: bool,
    /// True when a run that passes leaves no report.
    pub report_failures_only: bool,
    /// False when a run in real time does without the times of the stages in its trace.
    pub stages: bool,
}

impl RunPlan {
    /// A plain run of a scenario in the folder `runs`.
    #[must_use]
    pub fn of(scenario: Source, mode: RunMode) -> Self {
        Self {
            view: None,
            record: None,
            folder: None,
            report_failures_only: false,
            stages: true,
            scenario,
            mode,
            seed: None,
            rate_hz: None,
            binaries: BTreeMap::new(),
            settings: Settings::default(),
            load: MachineLoad::Idle,
            external: Vec::new(),
            host: None,
            trials: None,
            stays: false,
            resume_pose: false,
            delays: BTreeMap::new(),
            out: PathBuf::from("runs"),
            log_level: "info".to_owned(),
            progress: true,
        }
    }
}
