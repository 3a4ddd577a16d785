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
    /// Where nothing else is needed.
    rule: CornerRule,
    /// What no way led to but past blocked corners.
    to: Option<Target>,
}

impl PastCorners {
    pub(crate) const fn new(config: &GlobalPlannerConfig) -> Self {
        Self {
            is_wanted: config.past_corners,
            rule: config.corner_rule,
            to: None,
        }
    }

    fn lead_to(&self, target: &Target) -> bool {
        self.to.as_ref() == Some(target)
    }

    /// What a planner is told of diagonal steps on the way to `target`.
    pub(crate) fn rule(&self, target: &Target) -> CornerRule {
        if self.lead_to(target) {
            CornerRule::Allow
        } else {
            self.rule
        }
    }

    /// Which steps of the path to `target` are legal.
    pub(crate) fn legality(&self, config: &GlobalPlannerConfig, target: &Target) -> Legality {
        Legality {
            unknown: config.unknown,
            corner_rule: self.rule,
            past_margin: self.lead_to(target),
        }
    }

    /// Plans, past blocked corners where they alone close the way to `target`, and from then on; `query` then has the rule
    /// of the path.
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
        if !self.lead_to(&target) {
            let result = planner.plan(query, budget, path);
            if !self.is_wanted || result != Err(CLOSED_BY_CORNERS) {
                return result;
            }
            tried = path.stats;
        }
        let mut rest = |Expansions(n)| budget(Expansions(n + tried.expanded));
        query.corner_rule = CornerRule::Allow;
        let mut result = planner.plan(query, &mut rest, path);
        path.stats.add_effort(&tried);
        if result.is_ok() && self.passes_obstacles(query, path) {
            path.cells.clear();
            path.curve.clear();
            result = Err(CLOSED_BY_CORNERS);
        }
        self.to = result.is_ok().then_some(target);
        if result.is_err() {
            query.corner_rule = self.rule;
        }
        result
    }

    /// True when the path of `query` passes a corner that the rule forbids, where only obstacles count and what is unknown
    /// as one.
    pub(crate) fn passes_obstacles(&self, query: &PlanQuery<'_>, path: &CellPath) -> bool {
        if query.corner_rule == self.rule {
            return false;
        }
        let is_lethal = |cell| {
            let cell = query.map.get(cell);
            cell.is_none_or(|cell| query.unknown.is_lethal(cell))
        };
        let mut passes = false;
        for pair in path.cells.windows(2) {
            supercover(pair[0], pair[1], |crossing| {
                passes |= crossing.touched.is_some_and(|beside| {
                    let [one, other] = beside.map(is_lethal);
                    !self.rule.permits(one, other)
                });
            });
        }
        passes
    }
}
