//! `c_astar`: A* over costs, the reference of every comparison and the default.
//!
//! Hart, Nilsson, Raphael, "A Formal Basis for the Heuristic Determination of Minimum Cost
//! Paths", 1968. Eight neighbours, octile heuristic, which is consistent because no step costs
//! less than its length, so that no node is ever opened again and the cost is that of Dijkstra.
//!
//! A step costs its length times `1 + weight * cost / 252` of the cell it enters. Costs are
//! integers inside ([`crate::moves::STRAIGHT`]); the cost reported is recomputed from the path.
//! The integers bend the optimum by at most one part in a thousand.

use crate::ends::{WayOut, find_ends_on_map};
use crate::map_options::MapOptions;
use crate::moves::price;
use crate::planner::{
    CellPath, Control, CornerRule, Expansions, GlobalPlanner, PlanError, PlanQuery, PlanStats,
};
use crate::search::{Found, Search, Task};
use zeronav_msgs::Cell;

/// See the module's description.
#[derive(Debug)]
pub(crate) struct CAstar {
    search: Search,
    way_out: WayOut,
    cost_weight: f64,
}

impl CAstar {
    /// A planner with empty memory.
    #[must_use]
    pub(crate) fn new(options: MapOptions) -> Self {
        let cost_weight = options.cost_weight();
        Self {
            search: Search::new(cost_weight),
            way_out: WayOut::new(options),
            cost_weight,
        }
    }
}

impl GlobalPlanner for CAstar {
    fn plan(
        &mut self,
        query: &PlanQuery<'_>,
        budget: &mut dyn FnMut(Expansions) -> Control,
        path: &mut CellPath,
    ) -> Result<PlanStats, PlanError> {
        path.clear();
        let ends = find_ends_on_map(query, &mut self.way_out)?;
        let mut task = Task {
            map: query.map,
            start: ends.start,
            goal: ends.goal,
            unknown: query.unknown,
            corner_rule: query.corner_rule,
        };
        loop {
            match self.search.run(&task, budget, &mut path.stats) {
                Found::Path => break,
                Found::Stopped => return Err(PlanError::OutOfBudget),
                Found::Nothing => {}
            }
            // A robot too close to an obstacle may have been led into the wrong pocket. Every
            // search closes another one, so that together they expand no cell twice.
            let index_of = |cell| query.map.geometry.index_of(cell);
            let tried = |cell| index_of(cell).is_none_or(|n| self.search.has_closed(n));
            let Some(start) = self.way_out.turn_to_next(tried) else {
                let blocked_by_corner = query.corner_rule != CornerRule::Allow && {
                    task.start = ends.start;
                    task.corner_rule = CornerRule::Allow;
                    self.search.run(&task, budget, &mut path.stats) == Found::Path
                };
                return Err(PlanError::Unreachable { blocked_by_corner });
            };
            task.start = start;
        }
        self.way_out.lead(&mut path.cells);
        self.search.trace(&task, &mut path.cells);
        path.stats.cost = cost_m(query, self.cost_weight, &path.cells);
        Ok(path.stats)
    }
}

/// Cost of a path of single steps, in metres of free cells.
pub(crate) fn cost_m(query: &PlanQuery<'_>, cost_weight: f64, cells: &[Cell]) -> f64 {
    let resolution_m = query.map.geometry.resolution_m;
    cells
        .windows(2)
        .map(|pair| {
            let diagonal = pair[0].x != pair[1].x && pair[0].y != pair[1].y;
            let length = if diagonal {
                core::f64::consts::SQRT_2
            } else {
                1.0
            };
            let cost = query.map.get(pair[1]).map_or(0, |cell| cell.cost);
            length * resolution_m * price(cost, cost_weight)
        })
        .sum()
}
