//! The planners that are the same best-first search under another recipe.

use crate::papers::best_first::{BestFirst, Recipe};
use crate::papers::field::{Field, Meter};
use crate::papers::on_map::{NO_WAY, Solver};
use crate::papers::options::SplineEnds;
use crate::papers::sight::pull;
use crate::planner::{CornerRule, PlanError};
use zeronav_msgs::Cell;

/// A best-first search and what comes after it.
#[derive(Debug)]
pub struct Variant {
    /// The search.
    pub recipe: Recipe,
    /// Corner rule of the paper.
    pub corner_rule: Option<CornerRule>,
    /// Whether the path is pulled taut.
    pub pull: bool,
    /// How the path is rounded.
    pub spline: SplineEnds,
    memory: BestFirst,
}

impl Variant {
    /// The search alone.
    #[must_use]
    pub fn of(recipe: Recipe) -> Self {
        Self {
            recipe,
            corner_rule: None,
            pull: false,
            spline: SplineEnds::Off,
            memory: BestFirst::default(),
        }
    }
}

impl Solver for Variant {
    fn solve(
        &mut self,
        field: &Field<'_>,
        start: Cell,
        goal: Cell,
        meter: &mut Meter<'_>,
        cells: &mut Vec<Cell>,
    ) -> Result<(), PlanError> {
        let found = self
            .memory
            .search(field, &self.recipe, start, goal, meter)?;
        if !found {
            // A recipe that closes cells for good proves nothing.
            let proof = self.recipe.past_corner == crate::papers::best_first::PastCorner::Edge;
            return Err(if proof { NO_WAY } else { PlanError::DeadEnd });
        }
        let first = cells.len();
        self.memory.trace(field, goal, cells);
        if self.pull {
            pull(field, cells, first, meter)?;
        }
        Ok(())
    }

    fn corner_rule(&self) -> Option<CornerRule> {
        self.corner_rule
    }

    fn spline(&self) -> SplineEnds {
        self.spline
    }
}
