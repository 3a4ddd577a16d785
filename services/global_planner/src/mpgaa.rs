//! `mpgaa`: A* over costs that keeps what it knows about the goal, for maps that change.
//!
//! The first search to a goal is A* from scratch. When it has been answered, the cost to the goal
//! is found for every cell (`goal_field`) and guides all further searches to it. The
//! field stays valid while obstacles appear; where they vanish it is bounded at once and repaired
//! when the answer is out. Whatever happens, an answer expands no more nodes than a search from
//! scratch, ties left aside: the tests hold it to 1.3 times.

use crate::astar::cost_m;
use crate::goal_field::{GoalField, Guide};
use crate::ground::Ground;
use crate::map_options::MapOptions;
use crate::planner::{
    CellPath, Control, Expansions, GlobalPlanner, PlanError, PlanQuery, PlanStats,
};
use crate::search::Found;
use zeronav_msgs::{Cell, CellRect, MapView};

/// See the module's description.
#[derive(Debug)]
pub struct Mpgaa {
    field: GoalField,
    ground: Ground,
    cost_weight: f64,
    /// Where the last search led.
    goal: Option<Cell>,
}

impl Mpgaa {
    /// A planner with empty memory.
    #[must_use]
    pub fn new(options: MapOptions) -> Self {
        let cost_weight = options.cost_weight();
        Self {
            field: GoalField::new(cost_weight),
            ground: Ground::new(options),
            cost_weight,
            goal: None,
        }
    }

    /// Bytes held for the map and the search.
    #[must_use]
    pub fn memory_bytes(&self) -> usize {
        self.field.bytes() + self.ground.bytes()
    }

    /// An answer that costs at most `most` expansions, from the field of the query's goal alone.
    ///
    /// # Errors
    /// [`PlanError::OutOfBudget`] also when there is no such field yet: [`GlobalPlanner::prepare`]
    /// then makes it.
    pub(crate) fn plan_by_field(
        &mut self,
        query: &PlanQuery<'_>,
        most: u64,
        budget: &mut dyn FnMut(Expansions) -> Control,
        path: &mut CellPath,
    ) -> Result<PlanStats, PlanError> {
        self.answer(query, Some(most), budget, path)
    }

    /// With `most` from the field alone.
    fn answer(
        &mut self,
        query: &PlanQuery<'_>,
        most: Option<u64>,
        budget: &mut dyn FnMut(Expansions) -> Control,
        path: &mut CellPath,
    ) -> Result<PlanStats, PlanError> {
        let ends = self.ground.open(query, path)?;
        let rule = query.corner_rule;
        self.field.follow(&query.map, query.unknown, rule);
        self.goal = Some(ends.goal);
        let whole = self.field.is_whole_for(ends.goal);
        if most.is_some_and(|most| most == 0 || !whole) {
            return Err(PlanError::OutOfBudget);
        }
        let guide = if whole { Guide::Field } else { Guide::Octile };
        let most = most.unwrap_or(u64::MAX);
        self.ground
            .answer(query, &ends, path, |ground, between, path| {
                let mut no_way = false;
                let mut watched = |expansions: Expansions| {
                    no_way = !ground.may(rule, between, expansions.0);
                    if no_way {
                        Control::Stop
                    } else {
                        budget(expansions)
                    }
                };
                let stats = &mut path.stats;
                let found = self.field.search(between, guide, most, &mut watched, stats);
                if found == Found::Path {
                    self.field.trace(ends.goal, &mut path.cells);
                }
                if no_way { Found::Nothing } else { found }
            })?;
        path.stats.cost = cost_m(query, self.cost_weight, path);
        Ok(path.stats)
    }
}

impl GlobalPlanner for Mpgaa {
    fn plan(
        &mut self,
        query: &PlanQuery<'_>,
        budget: &mut dyn FnMut(Expansions) -> Control,
        path: &mut CellPath,
    ) -> Result<PlanStats, PlanError> {
        self.answer(query, None, budget, path)
    }

    fn map_changed(&mut self, map: &MapView<'_>, changed: &[CellRect]) {
        self.ground.change(map, changed);
        self.field.change(map, changed);
    }

    fn prepare(&mut self, expansions: u64) -> bool {
        self.goal
            .is_some_and(|goal| self.field.improve(goal, expansions))
    }
}
