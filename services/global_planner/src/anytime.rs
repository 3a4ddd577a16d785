//! `anytime`: a way soon, better ones while the budget lasts, the cheapest in the end.
//!
//! Richter, Thayer, Ruml, "The Joy of Forgetting: Faster Anytime Search via Restarting", ICAPS
//! 2010: weighted A* with falling weights, each search from scratch and only for ways cheaper than
//! the current one. When the budget ends after the first way, the best so far is the answer; how
//! cost fell over the expansions is in [`PlanStats::improved`].

use crate::astar::cost_m;
use crate::goal_field::{GoalField, Guide};
use crate::ground::Ground;
use crate::map_options::MapOptions;
use crate::planner::{
    CellPath, Control, Expansions, GlobalPlanner, IMPROVEMENTS_MAX, Improvement, PlanError,
    PlanQuery, PlanStats,
};
use crate::search::Found;
use zeronav_msgs::{Cell, CellRect, MapView};

/// Weights of the heuristic, times four.
const QUARTERS: [u32; IMPROVEMENTS_MAX] = [20, 10, 6, 4];

/// See the module's description.
#[derive(Debug)]
pub(crate) struct Anytime {
    ground: Ground,
    rounds: Rounds,
}

/// The searches of one plan, each with a lower weight than the one before.
#[derive(Debug)]
struct Rounds {
    search: GoalField,
    cost_weight: f64,
}

impl Anytime {
    /// A planner with empty memory.
    #[must_use]
    pub(crate) fn new(options: MapOptions) -> Self {
        let cost_weight = options.cost_weight();
        Self {
            ground: Ground::new(options),
            rounds: Rounds {
                search: GoalField::new(cost_weight),
                cost_weight,
            },
        }
    }
}

impl Rounds {
    fn run(
        &mut self,
        ground: &mut Ground,
        query: &PlanQuery<'_>,
        (start, goal): (Cell, Cell),
        budget: &mut dyn FnMut(Expansions) -> Control,
        path: &mut CellPath,
    ) -> Found {
        let n_way_out = path.cells.len();
        let mut below = u32::MAX;
        let rule = query.corner_rule;
        let mut found_any = Found::Nothing;
        let mut n = 0;
        for quarters in QUARTERS {
            let mut no_way = false;
            let mut watched = |expansions: Expansions| {
                no_way = below == u32::MAX && !ground.may(rule, (start, goal), expansions.0);
                if no_way {
                    Control::Stop
                } else {
                    budget(expansions)
                }
            };
            let guide = Guide::Weighted { quarters, below };
            let found = self.search.search(
                (start, goal),
                guide,
                u64::MAX,
                &mut watched,
                &mut path.stats,
            );
            match found {
                Found::Path => {
                    found_any = Found::Path;
                    below = self.search.cost_of(goal);
                    path.cells.truncate(n_way_out);
                    self.search.trace(goal, &mut path.cells);
                    path.stats.cost = cost_m(query, self.cost_weight, &path.cells);
                    path.stats.improved[n] = Improvement {
                        expanded: path.stats.expanded,
                        cost: path.stats.cost,
                    };
                    n += 1;
                }
                Found::Stopped if no_way => return Found::Nothing,
                Found::Stopped if found_any == Found::Path => return Found::Path,
                Found::Stopped => return Found::Stopped,
                Found::Nothing if found_any == Found::Nothing => break,
                // Nothing cheaper with this weight: cells that were closed too dear may hide a
                // cheaper way, so only the last round, without a weight, proves that there is none.
                Found::Nothing => {}
            }
        }
        found_any
    }
}

impl GlobalPlanner for Anytime {
    fn plan(
        &mut self,
        query: &PlanQuery<'_>,
        budget: &mut dyn FnMut(Expansions) -> Control,
        path: &mut CellPath,
    ) -> Result<PlanStats, PlanError> {
        let ends = self.ground.open(query, path)?;
        let rounds = &mut self.rounds;
        rounds
            .search
            .follow(&query.map, query.unknown, query.corner_rule);
        self.ground
            .answer(query, &ends, path, |ground, between, path| {
                rounds.run(ground, query, between, budget, path)
            })?;
        Ok(path.stats)
    }

    fn map_changed(&mut self, map: &MapView<'_>, changed: &[CellRect]) {
        self.ground.change(map, changed);
        self.rounds.search.change(map, changed, |_| {});
    }
}
