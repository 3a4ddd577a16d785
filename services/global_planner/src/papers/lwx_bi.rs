//! `lwx_bi`: the "bidirectional A*" that \[LWX\] compares with: A* from both ends to the middle of
//! the line between them.
//!
//! It is not the algorithm of that name (`lwx_bi_true` is), and the path is not the cheapest, as
//! it is forced through the middle.

use crate::papers::best_first::{BestFirst, Recipe};
use crate::papers::field::{Field, Meter, distance};
use crate::papers::heuristic::Heuristic;
use crate::papers::on_map::{NO_WAY, Solver};
use crate::planner::PlanError;
use crate::remarks::Fallback;
use zeronav_msgs::Cell;

/// Cells near the middle that are tried before the search goes without.
const ATTEMPTS: usize = 8;

/// The planner's method.
#[must_use]
pub(crate) fn lwx_bi() -> LwxBi {
    LwxBi {
        middles: Vec::new(),
        astar: BestFirst::default(),
    }
}

/// See the module's description.
#[derive(Debug)]
pub(crate) struct LwxBi {
    middles: Vec<Cell>,
    astar: BestFirst,
}

/// Middle of the line between two cells, rounded down.
#[must_use]
pub(crate) fn middle_of(one: Cell, other: Cell) -> Cell {
    Cell::new(
        (one.x + other.x).div_euclid(2),
        (one.y + other.y).div_euclid(2),
    )
}

/// Writes the [`ATTEMPTS`] free cells nearest to `centre`, nearest first; of equally near ones the
/// lower row, then the lower column first.
fn nearest_free(
    field: &Field<'_>,
    centre: Cell,
    found: &mut Vec<Cell>,
    meter: &mut Meter<'_>,
) -> Result<(), PlanError> {
    let order = |one: &Cell, other: &Cell| {
        distance(centre, *one)
            .total_cmp(&distance(centre, *other))
            .then_with(|| (one.y, one.x).cmp(&(other.y, other.x)))
    };
    found.clear();
    let (width, height) = field.map.geometry.size();
    for ring in 0..width.max(height) {
        let settled = found.get(ATTEMPTS - 1);
        if settled.is_some_and(|cell| distance(centre, *cell) < f64::from(ring)) {
            break;
        }
        for y in -ring..=ring {
            let stride = if y.abs() == ring {
                1
            } else {
                (2 * ring).max(1)
            };
            let mut x = -ring;
            while x <= ring {
                let cell = Cell::new(centre.x + x, centre.y + y);
                if field.is_free(cell) {
                    found.push(cell);
                }
                x += stride;
            }
        }
        meter.aux(8 * u64::from(ring.unsigned_abs()))?;
        found.sort_by(order);
        found.truncate(ATTEMPTS);
    }
    Ok(())
}

impl Solver for LwxBi {
    fn solve(
        &mut self,
        field: &Field<'_>,
        start: Cell,
        goal: Cell,
        meter: &mut Meter<'_>,
        cells: &mut Vec<Cell>,
    ) -> Result<(), PlanError> {
        let recipe = Recipe::plain(Heuristic::Euclid);
        nearest_free(field, middle_of(start, goal), &mut self.middles, meter)?;
        let mut middle = self.middles.first().copied();
        if let Some(nearest) = middle
            && !self.astar.search(field, &recipe, start, nearest, meter)?
        {
            // Now every cell that the start is connected with is closed.
            if !self.astar.has_closed(field.index(goal)) {
                return Err(NO_WAY);
            }
            let astar = &self.astar;
            let connected = |cell: &&Cell| astar.has_closed(field.index(**cell));
            middle = self.middles.iter().find(connected).copied();
            if let Some(middle) = middle {
                self.astar.search(field, &recipe, start, middle, meter)?;
            }
        }
        let Some(middle) = middle else {
            meter.stats.remarks.fallback = Fallback::Astar;
            if !self.astar.search(field, &recipe, start, goal, meter)? {
                return Err(NO_WAY);
            }
            self.astar.trace(field, goal, cells);
            return Ok(());
        };
        self.astar.trace(field, middle, cells);
        if !self.astar.search(field, &recipe, goal, middle, meter)? {
            return Err(NO_WAY);
        }
        cells.pop();
        self.astar.trace_back(field, middle, cells);
        Ok(())
    }
}
