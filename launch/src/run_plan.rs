//! What a run is asked to be, before anything is read or checked.

use std::collections::BTreeMap;
use std::path::PathBuf;
use zeronav_msgs::role::Role;
use zeronav_msgs::run::RunMode;

/// The order for one run.
#[derive(Debug, Clone)]
pub struct RunPlan {
    /// Name or path of the scenario.
    pub scenario: String,
    /// Real time or lockstep.
    pub mode: RunMode,
    /// Seed of everything random; `None` = the scenario's.
    pub seed: Option<u64>,
    /// Seats that are left to processes started by hand.
    pub external: Vec<Role>,
    /// Trials to make instead of the scenario's drive.
    pub trials: Option<u32>,
    /// Delays injected into seats, in steps of [`zeronav_msgs::run::DELAY_STEP_NS`].
    pub delays: BTreeMap<Role, u16>,
    /// Folder in which the run's own folder is made.
    pub out: PathBuf,
    /// What the services log: a level or a filter.
    pub log_level: String,
    /// True when a progress line is shown.
    pub progress: bool,
}
