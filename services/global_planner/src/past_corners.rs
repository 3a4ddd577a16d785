//! Passing blocked corners where nothing else leads to the goal.
//!
//! In an aisle askew to the cells the free ones may touch at corners alone: a robot of 0.40 m in an aisle of 0.61 m.
//! What blocks beside such a corner is the margin around an obstacle; obstacles that touch stay closed.

use crate::config::GlobalPlannerConfig;
use crate::corridor::Legality;
use crate::line::supercover;
use crate::plan::Target;
use crate::planner::{
    CellPath, Control, CornerRule, Expansions, GlobalPlanner, PlanError, PlanQuery, PlanStats,
};

/// Only blocked corners close the way.
const CLOSED_BY_CORNERS: PlanError = PlanError::Unreachable {
    blocked_by_corner: true,
};

/// See the module's description.
#[derive(Debug)]
pub(crate) struct PastCorners {
    is_wanted: bool,
    /// What no way leads to but past blocked corners.
    to: Option<Target>,
}

impl PastCorners {
    pub(crate) const fn new(config: &GlobalPlannerConfig) -> Self {
        Self {
            is_wanted: config.past_corners,
            to: None,
        }
    }

    /// Which steps of the path to `target` are legal.
    pub(crate) fn legality(&self, config: &GlobalPlannerConfig, target: &Target) -> Legality {
        Legality {
            unknown: config.unknown,
            corner_rule: config.corner_rule,
            past_margin: self.to.as_ref() == Some(target),
        }
    }

    /// Plans, and past blocked corners where they alone close the way to `target`; `query` then has the rule of the
    /// path.
    ///
    /// # Errors
    /// Those of the planner.
    pub(crate) fn plan(
        &mut self,
        planner: &mut dyn GlobalPlanner,
        (query, target): (&mut PlanQuery<'_>, Target),
        budget: &mut dyn FnMut(Expansions) -> Control,
        path: &mut CellPath,
    ) -> Result<PlanStats, PlanError> {
        let mut tried = PlanStats::default();
        if self.to != Some(target) {
            let result = planner.plan(query, budget, path);
            if !self.is_wanted || result != Err(CLOSED_BY_CORNERS) {
                return result;
            }
            tried = path.stats;
        }
        let mut rest = |Expansions(n)| budget(Expansions(n + tried.expanded));
        let past = PlanQuery {
            corner_rule: CornerRule::Allow,
            ..*query
        };
        let mut result = planner.plan(&past, &mut rest, path);
        path.stats.add_effort(&tried);
        if result.is_ok() && passes_obstacles(query, path) {
            path.cells.clear();
            path.curve.clear();
            result = Err(CLOSED_BY_CORNERS);
        }
        self.to = result.is_ok().then_some(target);
        if result.is_ok() {
            *query = past;
        }
        result
    }
}

/// True when the path passes a corner that its rule forbids, where only obstacles count and what is unknown as one.
fn passes_obstacles(query: &PlanQuery<'_>, path: &CellPath) -> bool {
    let is_lethal = |cell| {
        let cell = query.map.get(cell);
        cell.is_none_or(|cell| query.unknown.is_lethal(cell))
    };
    let mut passes = false;
    for pair in path.cells.windows(2) {
        supercover(pair[0], pair[1], |crossing| {
            passes |= crossing.touched.is_some_and(|beside| {
                let [one, other] = beside.map(is_lethal);
                !query.corner_rule.permits(one, other)
            });
        });
    }
    passes
}
