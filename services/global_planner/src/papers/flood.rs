//! Which cells can be reached at all.

use crate::moves::STEPS;
use crate::papers::field::{Field, Look, Marks, Meter};
use crate::planner::PlanError;
use zeronav_msgs::Cell;

/// The cells that legal steps connect with one cell. Steps are legal both ways or neither.
#[derive(Debug, Default)]
pub(crate) struct Flood {
    seen: Marks,
    stack: Vec<Cell>,
}

impl Flood {
    /// Fills from `from`; stops at `until` when it is met, and says whether it was.
    ///
    /// # Errors
    /// [`PlanError::OutOfBudget`].
    pub(crate) fn fill(
        &mut self,
        field: &Field<'_>,
        from: Cell,
        until: Option<Cell>,
        meter: &mut Meter<'_>,
    ) -> Result<bool, PlanError> {
        self.seen.begin(field.n_cells());
        self.stack.clear();
        self.seen.insert(field.index(from));
        self.stack.push(from);
        while let Some(cell) = self.stack.pop() {
            meter.expand()?;
            if Some(cell) == until {
                return Ok(true);
            }
            for n in 0..STEPS.len() {
                if let Look::Free(to) = field.look(cell, n)
                    && self.seen.insert(field.index(to))
                {
                    self.stack.push(to);
                }
            }
        }
        Ok(false)
    }

    /// True when the last fill reached the cell at `index`.
    #[must_use]
    pub(crate) fn has(&self, index: usize) -> bool {
        self.seen.has(index)
    }
}
