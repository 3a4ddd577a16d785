//! The configuration: the parameters of all parts. Those of the robot are not here: they come with
//! its description.

use crate::beam::options::BeamConfig;
use crate::dwa::options::DwaConfig;
use crate::dwa_t::options::DwaTConfig;
use crate::mppi::options::MppiConfig;
use crate::papers::options::PapersConfig;
use crate::recovery::options::RecoveryConfig;
use crate::requests::RequestConfig;
use crate::shaping::ShapingConfig;
use crate::staleness::StalenessConfig;
use crate::task::TaskConfig;
use zeronav_params::parameters;

parameters! {
    /// Configuration of the local planner.
    pub struct LocalPlannerConfig {
        /// Key of the controller.
        controller: String = "beam".to_owned();
        /// For the controller `dwa`.
        dwa: DwaConfig;
        /// For the controller `dwa_t`, which takes the rest from `dwa`.
        dwa_t: DwaTConfig;
        /// For the controller `mppi`, which takes the rest from `dwa` and `dwa_t`.
        mppi: MppiConfig;
        /// For the controller `beam`, which takes the rest from `dwa` and `dwa_t`.
        beam: BeamConfig;
        /// How fast accelerations change.
        shaping: ShapingConfig;
        /// What the robot does when it makes no progress.
        recovery: RecoveryConfig;
        /// For the controllers of the papers: obstacles are points, as printed, instead of areas.
        literal: bool = false;
        /// Gains of the controllers of the papers, each for its own key.
        papers: PapersConfig;
        /// When a task has succeeded or failed.
        task: TaskConfig;
        /// When another path is requested.
        requests: RequestConfig;
        /// How old inputs may be.
        staleness: StalenessConfig;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Path of the parameter that is rejected after `change`, empty for none.
    fn rejected(change: impl FnOnce(&mut LocalPlannerConfig)) -> String {
        let mut config = LocalPlannerConfig::default();
        change(&mut config);
        zeronav_params::check(&config).map_or_else(|error| error.path, |()| String::new())
    }

    #[test]
    fn the_defaults_are_accepted_and_nan_is_rejected() {
        assert_eq!(rejected(|_| ()), "");
        assert_eq!(
            rejected(|config| config.dwa.reaction_s = f64::NAN),
            "dwa.reaction_s"
        );
        assert_eq!(
            rejected(|config| config.mppi.critics.smooth = -1.0),
            "mppi.critics.smooth"
        );
    }

    #[test]
    fn parameters_that_contradict_each_other_are_rejected() {
        assert_eq!(rejected(|config| config.task.stuck_s = 5.0), "task.stuck_s");
        assert_eq!(
            rejected(|config| config.beam.replan_s = 0.5),
            "beam.replan_s"
        );
    }
}
