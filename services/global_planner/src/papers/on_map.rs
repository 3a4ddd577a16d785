//! What every planner of the papers does around its own method: both ends, inflation at the
//! start, proof that there is no way, cost and remarks.

use crate::ends::{WayOut, find_ends_on_map};
use crate::map_options::MapOptions;
use crate::moves::STEPS;
use crate::papers::field::{Field, Look, Marks, Meter, Prices};
use crate::papers::flood::Flood;
use crate::papers::spline::{SplineEnds, curve_of};
use crate::planner::{
    CellPath, Control, CornerRule, Expansions, GlobalPlanner, PlanError, PlanQuery, PlanStats,
};
use zeronav_msgs::Cell;

/// A method that finds a way between two free cells.
pub(crate) trait Solver: Send {
    /// Appends the way from `start` to `goal`, both included, to `cells`, straight between the
    /// centres of two entries that follow each other. What is there after an error does not
    /// count.
    ///
    /// # Errors
    /// [`PlanError::Unreachable`] when there is provably none (which of the two is found out
    /// later), [`PlanError::DeadEnd`] when the method gave up, [`PlanError::OutOfBudget`].
    fn solve(
        &mut self,
        field: &Field<'_>,
        start: Cell,
        goal: Cell,
        meter: &mut Meter<'_>,
        cells: &mut Vec<Cell>,
    ) -> Result<(), PlanError>;

    /// The corner rule of the paper, where it has one that is stricter than any other. Otherwise
    /// that of the query holds.
    fn corner_rule(&self) -> Option<CornerRule> {
        None
    }

    /// True when a fault that is printed in the paper is switched on.
    fn is_literal(&self) -> bool {
        false
    }

    /// How the path is rounded.
    fn spline(&self) -> SplineEnds {
        SplineEnds::Off
    }
}

/// A method as a planner of the table.
#[derive(Debug)]
pub(crate) struct OnMap<S> {
    /// The method.
    pub solver: S,
    prices: Prices,
    way_out: WayOut,
    flood: Flood,
    seen: Marks,
}

/// No way: which kind is found out by [`OnMap`].
pub(crate) const NO_WAY: PlanError = PlanError::Unreachable {
    blocked_by_corner: false,
};

impl<S: Solver> OnMap<S> {
    /// A planner with empty memory.
    #[must_use]
    pub(crate) fn new(solver: S, options: MapOptions) -> Self {
        Self {
            solver,
            prices: Prices::new(options.cost_weight()),
            way_out: WayOut::new(options),
            flood: Flood::default(),
            seen: Marks::default(),
        }
    }

    fn search(
        &mut self,
        field: &Field<'_>,
        mut start: Cell,
        goal: Cell,
        meter: &mut Meter<'_>,
        cells: &mut Vec<Cell>,
    ) -> Result<(), PlanError> {
        if self.way_out.cells().len() > 1 {
            // A robot too close to an obstacle may have been led into the wrong pocket.
            self.flood.fill(field, goal, None, meter)?;
            let flood = &self.flood;
            let exit = self
                .way_out
                .turn_to_next(|cell| !flood.has(field.index(cell)));
            match exit {
                Some(exit) => start = exit,
                None => return Err(self.kind_of_no_way(field, start, goal, meter)?),
            }
        }
        self.way_out.lead(cells);
        match self.solver.solve(field, start, goal, meter, cells) {
            Err(PlanError::Unreachable { .. }) => {
                Err(self.kind_of_no_way(field, start, goal, meter)?)
            }
            // From the goal: those that cannot be reached mostly lie in small pockets.
            Err(PlanError::DeadEnd) if !self.flood.fill(field, goal, Some(start), meter)? => {
                Err(self.kind_of_no_way(field, start, goal, meter)?)
            }
            result => result,
        }
    }

    fn kind_of_no_way(
        &mut self,
        field: &Field<'_>,
        start: Cell,
        goal: Cell,
        meter: &mut Meter<'_>,
    ) -> Result<PlanError, PlanError> {
        let blocked_by_corner = field.corner_rule != CornerRule::Allow && {
            let field = field.with_rule(CornerRule::Allow);
            self.flood.fill(&field, goal, Some(start), meter)?
        };
        Ok(PlanError::Unreachable { blocked_by_corner })
    }

    /// What \[BAO\] counts along the path, and how often it cuts a corner.
    fn remark(&mut self, field: &Field<'_>, cells: &[Cell], stats: &mut PlanStats) {
        self.seen.begin(field.n_cells());
        let strict = field.with_rule(CornerRule::ForbidAny);
        let ends = [cells.first(), cells.last()];
        for cell in cells {
            for n in 0..STEPS.len() {
                if let Look::PastCorner(to) = strict.look(*cell, n)
                    && !ends.contains(&Some(&to))
                {
                    stats.remarks.virtual_on_path += u64::from(self.seen.insert(field.index(to)));
                }
            }
        }
        let is_diagonal = |pair: &[Cell]| {
            (pair[1].x - pair[0].x).abs() == 1 && (pair[1].y - pair[0].y).abs() == 1
        };
        stats.remarks.corner_cuts = cells
            .windows(2)
            .filter(|pair| is_diagonal(pair) && !strict.is_step(pair[0], pair[1]))
            .count() as u64;
    }
}

impl<S: Solver> GlobalPlanner for OnMap<S> {
    fn plan(
        &mut self,
        query: &PlanQuery<'_>,
        budget: &mut dyn FnMut(Expansions) -> Control,
        path: &mut CellPath,
    ) -> Result<PlanStats, PlanError> {
        path.clear();
        path.stats.remarks.literal = self.solver.is_literal();
        let ends = find_ends_on_map(query, &mut self.way_out)?;
        let prices = self.prices.clone();
        let field = Field {
            map: query.map,
            unknown: query.unknown,
            corner_rule: self.solver.corner_rule().unwrap_or(query.corner_rule),
            prices: &prices,
            walls: &[],
        };
        let mut meter = Meter::new(budget, &mut path.stats);
        let cells = &mut path.cells;
        if let Err(error) = self.search(&field, ends.start, ends.goal, &mut meter, cells) {
            cells.clear();
            return Err(error);
        }
        self.remark(&field, &path.cells, &mut path.stats);
        let cost_cells: f64 = path
            .cells
            .windows(2)
            .map(|pair| field.line_cost(pair[0], pair[1]))
            .sum();
        path.stats.cost = cost_cells * query.map.geometry.resolution_m;
        curve_of(query, &path.cells, self.solver.spline(), &mut path.curve);
        Ok(path.stats)
    }
}
