//! C-LOS: lines of sight and string pulling, PAPERS 0.6.

use crate::papers::field::{Field, Meter};
use crate::planner::{CornerRule, PlanError};
use crate::sight::look;
use zeronav_msgs::Cell;

/// First obstacle on the straight line between the centres of two cells of the map: every cell whose closed square
/// the line touches counts, also at a corner.
///
/// # Errors
/// [`PlanError::OutOfBudget`].
pub(crate) fn first_hit(
    field: &Field<'_>,
    from: Cell,
    to: Cell,
    meter: &mut Meter<'_>,
) -> Result<Option<Cell>, PlanError> {
    let at = |cell: Cell| (cell.x.cast_unsigned(), cell.y.cast_unsigned());
    let cell = |(x, y): (u32, u32)| Cell::new(x.cast_signed(), y.cast_signed());
    let blocked = |at| !field.is_free(cell(at));
    let seen = look(CornerRule::ForbidAny, at(from), at(to), blocked);
    meter.aux(seen.cells)?;
    Ok(seen.hit.map(cell))
}

/// True when the straight line between two cells' centres touches no obstacle.
///
/// # Errors
/// [`PlanError::OutOfBudget`].
pub(crate) fn sees(
    field: &Field<'_>,
    from: Cell,
    to: Cell,
    meter: &mut Meter<'_>,
) -> Result<bool, PlanError> {
    Ok(first_hit(field, from, to, meter)?.is_none())
}

/// Pulls the path from `cells[first]` on taut: greedily, each entry kept is the last in a row that
/// the one before it sees at no more cost than along the path.
///
/// # Errors
/// [`PlanError::OutOfBudget`].
pub(crate) fn pull(
    field: &Field<'_>,
    cells: &mut Vec<Cell>,
    first: usize,
    meter: &mut Meter<'_>,
) -> Result<(), PlanError> {
    let mut kept = first;
    let mut at = first;
    while at + 1 < cells.len() {
        let mut along = field.line_cost(cells[at], cells[at + 1]);
        let mut reach = at + 1;
        while let Some(next) = cells.get(reach + 1).copied() {
            along += field.line_cost(cells[reach], next);
            // Kept entries were written over the part of the path that lies behind.
            if !sees(field, cells[at], next, meter)?
                || field.line_cost(cells[at], next) > along + 1e-9
            {
                break;
            }
            reach += 1;
        }
        kept += 1;
        cells[kept] = cells[reach];
        // `kept` never overtakes `reach`, so what is ahead is still the old path.
        at = reach;
    }
    cells.truncate(kept + 1);
    Ok(())
}
