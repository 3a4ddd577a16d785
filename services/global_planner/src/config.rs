//! What a user may set.

use crate::planner::{CornerRule, Unknown};
use crate::table::{
    COST_WEIGHT_MAX, ESCAPE_M_MAX, PlannerOptions, PlannerRow, UnknownPlanner, row_of,
};
use serde::{Deserialize, Serialize};

/// Largest [`GlobalPlannerConfig::smooth_m`]. [m]
pub const SMOOTH_M_MAX: f64 = 2.0;

/// Configuration of the global planner.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct GlobalPlannerConfig {
    /// Key of a row of [`crate::table::PLANNERS`].
    pub planner: String,
    /// What the planner is told when it is built.
    pub options: PlannerOptions,
    /// Whether unknown cells may be crossed.
    pub unknown: Unknown,
    /// Which diagonal steps are legal.
    pub corner_rule: CornerRule,
    /// Most expansions of a search; without, the search ends by itself, at the latest when every
    /// cell has been expanded.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub budget_expansions: Option<u64>,
    /// [m] distance of the control points of the curve that rounds the path, 0 to [`SMOOTH_M_MAX`];
    /// 0 = the path stays as the planner made it.
    pub smooth_m: f64,
    /// [m] distance of the robot from its path from which a new one is made, > 0.
    pub off_path_m: f64,
    /// Part of the remaining cost that a shortcut must save, 0 to 1.
    pub shortcut_gain: f64,
    /// Map revisions between two searches for a shortcut, at least 1.
    pub shortcut_every_revisions: u32,
}

impl Default for GlobalPlannerConfig {
    fn default() -> Self {
        Self {
            planner: "mpgaa".to_owned(),
            options: PlannerOptions::default(),
            unknown: Unknown::default(),
            corner_rule: CornerRule::default(),
            budget_expansions: None,
            smooth_m: 0.0,
            off_path_m: 1.5,
            shortcut_gain: 0.05,
            shortcut_every_revisions: 5,
        }
    }
}

/// A configuration that makes no planner.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ConfigError {
    /// No planner has the key.
    #[error(transparent)]
    Planner(#[from] UnknownPlanner),
    /// A number outside its range.
    #[error("{field} = {value} is not within {min} to {max}")]
    OutOfRange {
        /// Name of the field as in the configuration.
        field: &'static str,
        /// What it was.
        value: f64,
        /// Smallest value allowed.
        min: f64,
        /// Largest value allowed.
        max: f64,
    },
}

impl GlobalPlannerConfig {
    /// The planner's row, when every number is within its range.
    ///
    /// # Errors
    /// The first field that is wrong.
    pub fn check(&self) -> Result<&'static PlannerRow, ConfigError> {
        let row = row_of(&self.planner)?;
        let options = &self.options;
        within(
            "options.cost_weight",
            options.cost_weight,
            0.0,
            COST_WEIGHT_MAX,
        )?;
        within("options.escape_m", options.escape_m, 0.0, ESCAPE_M_MAX)?;
        options.papers.check()?;
        within("smooth_m", self.smooth_m, 0.0, SMOOTH_M_MAX)?;
        within("off_path_m", self.off_path_m, 0.05, 1.0e3)?;
        within("shortcut_gain", self.shortcut_gain, 0.0, 1.0)?;
        let every = f64::from(self.shortcut_every_revisions);
        within("shortcut_every_revisions", every, 1.0, f64::from(u32::MAX))?;
        Ok(row)
    }
}

pub(crate) fn within(
    field: &'static str,
    value: f64,
    min: f64,
    max: f64,
) -> Result<(), ConfigError> {
    if (min..=max).contains(&value) {
        Ok(())
    } else {
        Err(ConfigError::OutOfRange {
            field,
            value,
            min,
            max,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_default_is_valid_and_wrong_numbers_are_named() {
        assert_eq!(
            GlobalPlannerConfig::default().check().map(|row| row.key),
            Ok("mpgaa")
        );
        let wrong = GlobalPlannerConfig {
            off_path_m: f64::NAN,
            ..GlobalPlannerConfig::default()
        };
        let text = wrong.check().map(|row| row.key).unwrap_err().to_string();
        assert!(text.contains("off_path_m"), "{text}");
        let mut wrong = GlobalPlannerConfig::default();
        wrong.options.papers.weight = 0.5;
        let text = wrong.check().map(|row| row.key).unwrap_err().to_string();
        assert!(text.contains("options.papers.weight"), "{text}");
        let wrong = GlobalPlannerConfig {
            planner: "best".to_owned(),
            ..GlobalPlannerConfig::default()
        };
        let text = wrong.check().map(|row| row.key).unwrap_err().to_string();
        assert!(text.contains("c_astar"), "{text}");
    }
}
