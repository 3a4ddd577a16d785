//! `bao_full`: A* on a map whose obstacles are all inflated by one cell, reference 31 of \[BAO\].
//!
//! Gaps of one or two cells close, so it finds nothing on many maps that have a way: what it calls
//! unreachable cannot be reached among the virtual obstacles. Start and goal are exempt. Virtual
//! obstacles that mapping put around obstacles (`virtual_obstacles` there) count like those of its
//! own ring.

use crate::moves::{Neighbours, STEPS};
use crate::papers::best_first::{BestFirst, Recipe};
use crate::papers::field::{Field, Meter};
use crate::papers::heuristic::Heuristic;
use crate::papers::on_map::{NO_WAY, Solver};
use crate::planner::{CornerRule, PlanError};
use zeronav_msgs::Cell;
use zeronav_msgs::map::FLAG_VIRTUAL;

/// The planner's method.
#[must_use]
pub(crate) fn bao_full(ring: Neighbours) -> BaoFull {
    BaoFull {
        ring,
        walls: Vec::new(),
        memory: BestFirst::default(),
    }
}

/// See the module's description.
#[derive(Debug)]
pub(crate) struct BaoFull {
    ring: Neighbours,
    walls: Vec<bool>,
    memory: BestFirst,
}

/// Marks the free cells next to an obstacle in `walls`, row-major; gives their number.
pub(crate) fn inflate(field: &Field<'_>, ring: Neighbours, walls: &mut Vec<bool>) -> u64 {
    walls.clear();
    walls.resize(field.n_cells(), false);
    let mut marked = 0;
    for (index, wall) in (0..).zip(walls.iter_mut()) {
        let cell = field.cell(index);
        let is_obstacle = |(n, (dx, dy)): (usize, &(i32, i32))| {
            let beside = Cell::new(cell.x + dx, cell.y + dy);
            ring.has(n) && field.map.geometry.contains(beside) && !field.is_free(beside)
        };
        *wall = field.is_free(cell) && STEPS.iter().enumerate().any(is_obstacle);
        marked += u64::from(*wall);
    }
    marked
}

impl Solver for BaoFull {
    fn solve(
        &mut self,
        field: &Field<'_>,
        start: Cell,
        goal: Cell,
        meter: &mut Meter<'_>,
        cells: &mut Vec<Cell>,
    ) -> Result<(), PlanError> {
        // One pass over the map, as long as a search's own memory takes to be made.
        meter.stats.remarks.aux_cells += field.n_cells() as u64;
        let marked = inflate(&field.without_layers(), self.ring, &mut self.walls);
        self.walls[field.index(start)] = false;
        self.walls[field.index(goal)] = false;
        let inflated = field.with_walls(&self.walls);
        let recipe = Recipe::plain(Heuristic::Octile);
        let found = self.memory.search(&inflated, &recipe, start, goal, meter)?;
        meter.stats.remarks.virtual_total = marked;
        if !found {
            return Err(NO_WAY);
        }
        self.memory.trace(field, goal, cells);
        Ok(())
    }

    fn corner_rule(&self) -> Option<CornerRule> {
        Some(CornerRule::ForbidAny)
    }

    fn layers(&self) -> u8 {
        FLAG_VIRTUAL
    }

    fn keeps_layers(&self) -> bool {
        true
    }
}
