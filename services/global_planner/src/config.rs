//! The configuration of the process.

use crate::options::PlannerOptions;
use crate::planner::{CornerRule, Unknown};
use zeronav_params::parameters;

/// Largest [`GlobalPlannerConfig::smooth_m`]. [m]
pub(crate) const SMOOTH_M_MAX: f64 = 2.0;

parameters! {
    /// Configuration of the global planner.
    pub struct GlobalPlannerConfig {
        /// Key of the planner.
        planner: String = "mpgaa".to_owned();
        /// What the planner is told when it is built.
        options: PlannerOptions;
        /// Whether unknown cells may be crossed.
        unknown: Unknown = Unknown::default();
        /// Which diagonal steps are legal.
        corner_rule: CornerRule = CornerRule::default();
        /// Where only blocked corners close the way, they are passed: in an aisle askew to the cells the free ones
        /// touch at corners alone. Beside the corner the robot's centre comes up to 0.7 cells nearer to an obstacle
        /// than in the cells themselves; the local planner and the guard look at the outline. It lasts for the rest of the way to that goal.
        past_corners: bool = true;
        /// Most expansions of a search; without, the search ends by itself, at the latest when
        /// every cell has been expanded.
        #[serde(skip_serializing_if = "Option::is_none")]
        budget_expansions: Option<u64> = None, [0, u64::MAX];
        /// Distance of the control points of the curve that rounds the path; 0 = the path stays as
        /// the planner made it.
        smooth_m: f64 = 0.0, [0.0, SMOOTH_M_MAX] "m";
        /// Distance of the robot from its path beyond which it replans.
        off_path_m: f64 = 1.5, [0.05, 1.0e3] "m";
        /// Part of the remaining cost that a shortcut must save.
        shortcut_gain: f64 = 0.05, [0.0, 1.0];
        /// What the lidar saw closes the only way to the goal when it is at most so far from the robot; what is
        /// farther is looked at from there first.
        look_from_m: f64 = 1.5, [0.3, 1.0e3] "m";
        /// Speed below which a tracked obstacle blocks the way like a static one. Faster ones are left
        /// to the local planner.
        blocks_below_mps: f64 = 0.3, [0.0, 1.0e3] "m/s";
        /// Map revisions between two searches for a shortcut.
        shortcut_every_revisions: u32 = 5, [1, u32::MAX];
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Path of the parameter that is rejected after `change`, empty for none.
    fn rejected(change: impl FnOnce(&mut GlobalPlannerConfig)) -> String {
        let mut config = GlobalPlannerConfig::default();
        change(&mut config);
        zeronav_params::check(&config).map_or_else(|error| error.path, |()| String::new())
    }

    #[test]
    fn the_defaults_are_accepted_and_wrong_numbers_are_named() {
        assert_eq!(rejected(|_| ()), "");
        assert_eq!(
            rejected(|config| config.off_path_m = f64::NAN),
            "off_path_m"
        );
        let weight = "options.papers.weight";
        assert_eq!(
            rejected(|config| config.options.papers.weight = 0.5),
            weight
        );
        let step = "options.papers.tree.step_cells";
        assert_eq!(
            rejected(|config| config.options.papers.tree.step_cells = 0.05),
            step
        );
    }
}
