//! What a suite is asked to be.

use super::noise::Noise;
use super::shard::Shard;
use core::ops::Range;
use std::num::NonZeroUsize;
use std::path::PathBuf;
use zeronav_files::Folder;
use zeronav_scenario::ForesightSpec;
use zeronav_scenario::settings::Settings;

/// The order for a suite.
#[derive(Debug, Clone)]
pub struct SuitePlan {
    /// `generated`, `barn`, `dynabarn`, `pedestrians`, `field`, `kidnapped`, `soak`, or a folder of scenarios.
    pub suite: String,
    /// Folder of an interrupted suite to continue; its journal then has the order.
    pub resume: Option<PathBuf>,
    /// Key of the local planner's controller; `None` = the suite's default.
    pub controller: Option<String>,
    /// Keys of configurations in place of the scenarios'.
    pub settings: Settings,
    /// True when nothing is driven and a way through each run is planned, with every future known.
    pub bound: bool,
    /// Runs of each world, with the seeds 1 to N.
    pub seeds: u64,
    /// Numbers of the worlds; `None` = all.
    pub worlds: Option<Range<u32>>,
    /// Noise of wheels, odometry and lidar.
    pub noise: Noise,
    /// What services are told of what moves.
    pub foresight: ForesightSpec,
    /// Folder of the data sets; `None` = `$ZERONAV_DATA` or `./data`.
    pub data: Option<PathBuf>,
    /// The part of the runs that is made; `None` = all.
    pub shard: Option<Shard>,
    /// Wall time of a soak in all its calls; `None` = an hour. [h]
    pub hours: Option<f64>,
    /// Runs at a time; `None` = as many as there are cores.
    pub jobs: Option<NonZeroUsize>,
    /// True when a progress line is shown.
    pub progress: bool,
    /// Folder in which the suite's own folder is made.
    pub out: PathBuf,
}

#[cfg(test)]
impl SuitePlan {
    /// A suite with nothing asked for, in the working folder.
    pub(super) fn of(suite: &str) -> Self {
        Self {
            suite: suite.to_owned(),
            resume: None,
            controller: None,
            settings: Settings::default(),
            bound: false,
            seeds: 1,
            worlds: None,
            noise: Noise::Default,
            foresight: ForesightSpec::default(),
            data: None,
            shard: None,
            hours: None,
            jobs: None,
            progress: false,
            out: PathBuf::new(),
        }
    }
}

/// What all cases of a suite have in common.
#[derive(Debug, Clone, Copy)]
pub(super) struct Setup<'a> {
    pub(super) plan: &'a SuitePlan,
    /// Key of the local planner's controller; `None` = its own default, or the scenario's.
    pub(super) controller: Option<&'a str>,
    /// Folder for the scenarios that are written.
    pub(super) scenarios: &'a Folder,
}

impl Setup<'_> {
    /// Who drives, for reports: a key, or what stands for none.
    pub(super) fn driver(&self) -> &str {
        if self.plan.bound {
            "bound (every future known)"
        } else {
            let said = self.plan.settings.controller();
            said.or(self.controller).unwrap_or("default")
        }
    }
}
