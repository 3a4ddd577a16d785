//! `lwx_oa`: the "optimised A*" of \[LWX\], which has no open list: it goes to the best neighbour
//! of the cell where it is.
//!
//! Greedy, so not the path of A*. What happens in a dead end is not printed and is an option;
//! going back makes it a depth-first search, which is complete. Literal mode chooses by straight
//! distance from the start plus straight distance to the goal.

use crate::papers::best_first::{BestFirst, Recipe};
use crate::papers::field::{Field, LENGTHS, Look, Marks, Meter, distance};
use crate::papers::heuristic::Heuristic;
use crate::papers::on_map::{NO_WAY, Solver};
use crate::planner::PlanError;
use crate::remarks::Fallback;
use zeronav_msgs::Cell;
use zeronav_params::{choices, parameters};

/// The planner's method.
#[must_use]
pub(crate) fn lwx_oa(options: GreedyOptions, literal: bool) -> LwxOa {
    LwxOa {
        options,
        literal,
        visited: Marks::default(),
        astar: BestFirst::default(),
    }
}

parameters! {
    /// `lwx_oa`: the greedy search.
    #[derive(Copy)]
    pub struct GreedyOptions {
        /// What happens where no neighbour is left.
        dead_end: DeadEndPolicy = DeadEndPolicy::default();
        /// By what the best neighbour is chosen.
        child_cost: ChildCost = ChildCost::default();
    }
}

choices! {
    /// What the greedy search does where no neighbour is left.
    pub enum DeadEndPolicy {
        /// Gives up.
        Fail = "fail",
        /// Goes back to the last cell that has one: depth-first search, complete, but the ways it
        /// finds are long.
        Backtrack = "backtrack",
        /// A* from the start.
        #[default]
        FallbackAstar = "fallback_astar",
    }
}

choices! {
    /// By what the greedy search chooses.
    pub enum ChildCost {
        /// Distance to the goal.
        #[default]
        Distance = "distance",
        /// Distance to the goal and cost of the step.
        DistanceAndStep = "distance_and_step",
    }
}

/// See the module's description.
#[derive(Debug)]
pub(crate) struct LwxOa {
    options: GreedyOptions,
    literal: bool,
    visited: Marks,
    astar: BestFirst,
}

impl LwxOa {
    /// The best neighbour that was not visited: least cost, then nearest to the goal, then the
    /// first counter-clockwise from +x.
    fn best_child(
        &self,
        field: &Field<'_>,
        from: Cell,
        (start, goal): (Cell, Cell),
    ) -> Option<Cell> {
        let mut best: Option<(f64, f64, Cell)> = None;
        for (n, length) in LENGTHS.iter().enumerate() {
            let Look::Free(to) = field.look(from, n) else {
                continue;
            };
            if self.visited.has(field.index(to)) {
                continue;
            }
            let h = distance(to, goal);
            let cost = if self.literal {
                distance(start, to) + h
            } else {
                match self.options.child_cost {
                    ChildCost::Distance => h,
                    ChildCost::DistanceAndStep => h + length * field.price(to),
                }
            };
            let better = best.is_none_or(|(least, nearest, _)| {
                cost < least - 1e-12 || (cost <= least + 1e-12 && h < nearest - 1e-12)
            });
            if better {
                best = Some((cost, h, to));
            }
        }
        best.map(|(.., to)| to)
    }
}

impl Solver for LwxOa {
    fn solve(
        &mut self,
        field: &Field<'_>,
        start: Cell,
        goal: Cell,
        meter: &mut Meter<'_>,
        cells: &mut Vec<Cell>,
    ) -> Result<(), PlanError> {
        let first = cells.len();
        self.visited.begin(field.n_cells());
        self.visited.insert(field.index(start));
        cells.push(start);
        let mut is_new = true;
        while let Some(at) = cells[first..].last().copied() {
            if core::mem::take(&mut is_new) {
                meter.expand()?;
            }
            if at == goal {
                return Ok(());
            }
            meter.stats.evaluated += LENGTHS.len() as u64;
            if let Some(to) = self.best_child(field, at, (start, goal)) {
                self.visited.insert(field.index(to));
                cells.push(to);
                meter.stats.generated += 1;
                is_new = true;
                continue;
            }
            match self.options.dead_end {
                DeadEndPolicy::Fail => return Err(PlanError::DeadEnd),
                DeadEndPolicy::Backtrack => {
                    cells.pop();
                    meter.turn_back()?;
                }
                DeadEndPolicy::FallbackAstar => {
                    cells.truncate(first);
                    meter.stats.remarks.fallback = Fallback::Astar;
                    let recipe = Recipe::plain(Heuristic::Octile);
                    if !self.astar.search(field, &recipe, start, goal, meter)? {
                        return Err(NO_WAY);
                    }
                    self.astar.trace(field, goal, cells);
                    return Ok(());
                }
            }
        }
        Err(NO_WAY)
    }

    fn is_literal(&self) -> bool {
        self.literal
    }
}
