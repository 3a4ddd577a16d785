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

/// What no way leads to but past blocked corners.
#[derive(Debug, Default)]
pub(crate) struct PastCorners(Option<Target>);

impl PastCorners {
    /// Which steps of the path to `target` are legal.
    pub(crate) fn legality(&self, config: &GlobalPlannerConfig, target: &Target) -> Legality {
        Legality {
            unknown: config.unknown,
            corner_rule: config.corner_rule,
            past_margin: self.0.as_ref() == Some(target),
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
        if self.0 != Some(target) {
            let result = planner.plan(query, budget, path);
            if result != Err(CLOSED_BY_CORNERS) {
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
        self.0 = result.is_ok().then_some(target);
        if result.is_ok() {
            *query = past;
        }
        result
    }
}

/// True when the path passes a corner of an obstacle, or of a cell that blocks because it is unknown.
fn passes_obstacles(query: &PlanQuery<'_>, path: &CellPath) -> bool {
    let mut passes = false;
    for pair in path.cells.windows(2) {
        supercover(pair[0], pair[1], |crossing| {
            for beside in crossing.touched.into_iter().flatten() {
                let cell = query.map.get(beside);
                passes |= cell.is_none_or(|cell| query.unknown.is_lethal(cell));
            }
        });
    }
    passes
}
