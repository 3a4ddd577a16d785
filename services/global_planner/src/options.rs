//! The options of the planners, as a configuration holds them.

use crate::map_options::{COST_WEIGHT_MAX, ESCAPE_M_MAX, MapOptions};
use crate::papers::options::PaperOptions;
use zeronav_msgs::escape::ESCAPE_M;
use zeronav_params::parameters;

parameters! {
    /// What a planner is told once, when it is built.
    #[derive(Copy)]
    pub struct PlannerOptions {
        /// Weight of cell costs: a step costs its length times `1 + cost_weight * cost / 252`. 0 =
        /// the shortest path; larger values keep away from obstacles.
        cost_weight: f64 = 3.0, [0.0, COST_WEIGHT_MAX];
        /// How far a robot inside the inflation may be led out of it.
        escape_m: f64 = ESCAPE_M, [0.0, ESCAPE_M_MAX] "m";
        /// Options of the planners of the papers.
        papers: PaperOptions;
    }
}

impl PlannerOptions {
    /// What every planner reads, numbers clamped to their ranges.
    #[must_use]
    pub const fn map(&self) -> MapOptions {
        MapOptions::new(self.cost_weight, self.escape_m)
    }
}
