//! `tn_apf`: \[TN\]'s potential field of attraction alone.
//!
//! The force m1 (target - position) always points to the target, and only its direction counts:
//! the trajectory is the straight line. Nothing leads around an obstacle, so the planner gives up
//! at the first.

use crate::papers::field::{Field, Meter};
use crate::papers::on_map::Solver;
use crate::papers::sight::sees;
use crate::planner::PlanError;
use zeronav_msgs::Cell;
use zeronav_msgs::map::FLAG_REGULARISED;

/// See the module's description.
#[derive(Debug)]
pub(crate) struct TnApf;

impl Solver for TnApf {
    fn solve(
        &mut self,
        field: &Field<'_>,
        start: Cell,
        goal: Cell,
        meter: &mut Meter<'_>,
        cells: &mut Vec<Cell>,
    ) -> Result<(), PlanError> {
        if !sees(field, start, goal, meter)? {
            return Err(PlanError::DeadEnd);
        }
        meter.expand()?;
        cells.push(start);
        if goal != start {
            cells.push(goal);
        }
        Ok(())
    }

    fn layers(&self) -> u8 {
        FLAG_REGULARISED
    }
}
