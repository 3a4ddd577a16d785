//! `mpgaa`: A* over costs that keeps what it knows about the goal, for maps that change.
//!
//! The first search to a goal is A* from scratch. When it has been answered, the cost to the goal
//! is found for every cell some way beyond the robot (`goal_field`) and guides all further searches
//! to it. The
//! field stays valid while obstacles appear; where they vanish it is bounded at once and repaired
//! when the answer is out. Whatever happens, an answer expands no more nodes than a search from
//! scratch, ties left aside: the tests hold it to 1.3 times.

use crate::astar::cost_m;
use crate::goal_field::detours::Detours;
use crate::goal_field::{GoalField, Guide};
use crate::ground::Ground;
use crate::map_options::MapOptions;
use crate::moves::STRAIGHT;
use crate::planner::{
    CellPath, Control, Expansions, GlobalPlanner, PlanError, PlanQuery, PlanStats,
};
use crate::search::Found;
use zeronav_msgs::{Cell, CellRect, MapView, Pose};

/// See the module's description.
#[derive(Debug)]
pub struct Mpgaa {
    field: GoalField,
    detours: Detours,
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
            detours: Detours::default(),
            ground: Ground::new(options),
            cost_weight,
            goal: None,
        }
    }

    /// Bytes held for the map and the search.
    #[must_use]
    pub fn memory_bytes(&self) -> usize {
        self.field.bytes() + self.detours.bytes() + self.ground.bytes()
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
        path.stats.cost = cost_m(query, self.cost_weight, &path.cells);
        path.stats.bound = path.stats.cost;
        Ok(path.stats)
    }
}

/// Integer costs of the field in metres of free cells.
fn metres(query: &PlanQuery<'_>, cost: u32) -> f64 {
    f64::from(cost) / f64::from(STRAIGHT) * query.map.geometry.resolution_m
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
        let detours = &mut self.detours;
        let changed = self.field.change(map, changed, |spot| detours.note(spot));
        self.detours.note_update(changed);
    }

    fn prepare(&mut self, robot: &Pose, expansions: u64) -> bool {
        let Some(goal) = self.goal else {
            return false;
        };
        let start = self.field.cell_at(robot);
        let (field, ground) = (&mut self.field, &mut self.ground);
        let rule = field.rule();
        field.improve(start, goal, expansions, |a, b| ground.known(rule, a, b))
            || start.is_some_and(|start| self.detours.prepare(&mut self.field, start, expansions))
            || self.ground.prepare()
    }

    fn detour(
        &mut self,
        query: &PlanQuery<'_>,
        budget: &mut dyn FnMut(Expansions) -> Control,
        path: &mut CellPath,
    ) -> Option<PlanStats> {
        let ends = self.ground.open(query, path).ok()?;
        // A map of which no change is told is read again: nothing is ready on it.
        let rule = query.corner_rule;
        self.field.follow(&query.map, query.unknown, rule);
        let (mut detour, mut n_way_out) = (None, 0);
        self.ground
            .answer(query, &ends, path, |ground, between, path| {
                n_way_out = path.cells.len();
                detour = self.detours.answer(&self.field, between, &mut path.cells);
                if detour.is_none() {
                    let mut no_way = false;
                    let mut watched = |expansions: Expansions| {
                        no_way = no_way || !ground.may(rule, between, expansions.0);
                        if no_way {
                            Control::Stop
                        } else {
                            budget(expansions)
                        }
                    };
                    detour = (self.field).search_around(between, &mut watched, &mut path.stats);
                    if detour.is_some() {
                        self.field.trace(ends.goal, &mut path.cells);
                    }
                }
                if detour.is_some() {
                    Found::Path
                } else {
                    Found::Stopped
                }
            })
            .ok()?;
        let detour = detour?;
        let way_out_m = cost_m(query, self.cost_weight, &path.cells[..=n_way_out]);
        path.stats.cost = way_out_m + metres(query, detour.cost);
        if detour.least > 0 {
            path.stats.bound = way_out_m + metres(query, detour.least);
        }
        Some(path.stats)
    }
}
