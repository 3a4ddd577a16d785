//! `lwx_bi_true`: bidirectional A*, the honest baseline beside `lwx_bi`.
//!
//! Ikeda et al., "A Fast Algorithm for Finding Better Routes by AI Search Techniques", 1994: two
//! frontiers under the average potential `(h_to_goal - h_to_start) / 2`, which is consistent for
//! both, so that the search may stop as soon as the least keys add up to the cost of the best
//! meeting. The cost is that of Dijkstra.

use crate::moves::STEPS;
use crate::papers::best_first::{BestFirst, step_number};
use crate::papers::field::{Field, LENGTHS, Look, Meter};
use crate::papers::heuristic::Heuristic;
use crate::papers::on_map::{NO_WAY, Solver};
use crate::planner::PlanError;
use zeronav_msgs::Cell;

/// See the module's description.
#[derive(Debug, Default)]
pub(crate) struct LwxBiTrue {
    /// From the start, from the goal.
    frontiers: [BestFirst; 2],
}

/// In place of the step at a root.
const NO_STEP: u8 = 8;

impl Solver for LwxBiTrue {
    fn solve(
        &mut self,
        field: &Field<'_>,
        start: Cell,
        goal: Cell,
        meter: &mut Meter<'_>,
        cells: &mut Vec<Cell>,
    ) -> Result<(), PlanError> {
        let potential = |cell| {
            let to_goal = Heuristic::Octile.between(cell, goal);
            let to_start = Heuristic::Octile.between(cell, start);
            0.5 * (to_goal - to_start)
        };
        for (frontier, (root, sign)) in self.frontiers.iter_mut().zip([(start, 1.0), (goal, -1.0)])
        {
            frontier.begin(field.n_cells());
            let key = sign * potential(root);
            frontier.put(field, root, 0.0, NO_STEP, (key, key), meter);
        }
        let mut best: Option<(f64, Cell)> = (start == goal).then_some((0.0, start));
        loop {
            let keys = [0, 1].map(|side| self.frontiers[side].least_key());
            // Also ends when a frontier is empty: its key is infinite then.
            if keys[0] + keys[1] >= best.map_or(f64::INFINITY, |(cost, _)| cost) {
                break;
            }
            // With equal keys the searches take turns by their number of open nodes, which the
            // keys' order decides well enough.
            let side = usize::from(keys[1] < keys[0]);
            let sign = if side == 0 { 1.0 } else { -1.0 };
            let [forward, backward] = &mut self.frontiers;
            let (own, other) = if side == 0 {
                (forward, backward)
            } else {
                (backward, forward)
            };
            let Some(cell) = own.take(field) else {
                break;
            };
            meter.expand()?;
            meter.stats.evaluated += STEPS.len() as u64;
            let so_far = own.node(field.index(cell)).so_far;
            for (n, length) in LENGTHS.iter().enumerate() {
                let Look::Free(to) = field.look(cell, n) else {
                    continue;
                };
                // The path enters `to` coming from the start, and `cell` coming from `to` else.
                let entered = if side == 0 { to } else { cell };
                let through = so_far + length * field.price(entered);
                let index = field.index(to);
                if through >= own.node(index).so_far - 1e-12 {
                    continue;
                }
                let key = sign * potential(to);
                own.put(field, to, through, step_number(n), (key, key), meter);
                let whole = through + other.node(index).so_far;
                if whole < best.map_or(f64::INFINITY, |(cost, _)| cost) {
                    best = Some((whole, to));
                }
            }
        }
        let Some((_, meeting)) = best else {
            return Err(NO_WAY);
        };
        self.frontiers[0].trace(field, meeting, cells);
        cells.pop();
        self.frontiers[1].trace_back(field, meeting, cells);
        Ok(())
    }
}
