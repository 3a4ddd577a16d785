//! What every planner of the papers does around its own method: both ends, inflation at the
//! start, proof that there is no way, cost and remarks.

use crate::ends::{WayOut, find_ends_on_map};
use crate::map_options::MapOptions;
use crate::moves::STEPS;
use crate::papers::field::{Field, Look, Marks, Meter, Prices};
use crate::papers::flood::Flood;
use crate::papers::spline::{Spline, curve_of};
use crate::planner::{
    CellPath, Control, CornerRule, Expansions, GlobalPlanner, PlanError, PlanQuery, PlanStats,
};
use crate::remarks::Fallback;
use nalgebra::Point2;
use zeronav_msgs::Cell;

/// A method that finds a way between two free cells.
pub(crate) trait Solver: Send {
    /// Appends the way from `start` to `goal`, both included, to `cells`, straight between the
    /// centres of two entries that follow each other. What is there after an error does not
    /// count.
    ///
    /// # Errors
    /// [`PlanError::Unreachable`] when there is provably none (which of the two is found out
    /// later), [`PlanError::DeadEnd`] when the method gave up, [`PlanError::OutOfBudget`] also at a
    /// limit of the method's own.
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

    /// Flags of the map's cells that are obstacles for this planner, such as
    /// [`zeronav_msgs::map::FLAG_REGULARISED`]. Without them it tries again when it finds no way,
    /// unless it [`Self::keeps_layers`].
    fn layers(&self) -> u8 {
        0
    }

    /// True when virtual obstacles are the method itself: what they close stays closed.
    fn keeps_layers(&self) -> bool {
        false
    }

    /// A way of the last search that is not straight between the centres of its cells. The origin is
    /// the map's lower left corner. [cells]
    fn polyline(&self) -> Option<&[Point2<f64>]> {
        None
    }

    /// True when a fault that is printed in the paper is switched on.
    fn is_literal(&self) -> bool {
        false
    }

    /// How the path is rounded.
    fn spline(&self) -> Spline {
        Spline::OFF
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
            self.flood
                .fill(&field.without_layers(), goal, None, meter)?;
            let flood = &self.flood;
            let exit = self
                .way_out
                .turn_to_next(|cell| !flood.has(field.index(cell)));
            let Some(exit) = exit else {
                let plain = field.without_layers();
                return Err(self.kind_of_no_way(&plain, start, goal, meter)?);
            };
            start = exit;
        }
        self.way_out.lead(cells);
        let first = cells.len();
        let field = Field {
            spared: [start, goal],
            ..*field
        };
        let given_up = |error| matches!(error, PlanError::Unreachable { .. } | PlanError::DeadEnd);
        let mut result = self.solver.solve(&field, start, goal, meter, cells);
        let has_layers = field.layers != 0;
        if has_layers && !self.solver.keeps_layers() && result.is_err_and(given_up) {
            cells.truncate(first);
            let plain = field.without_layers();
            result = self.solver.solve(&plain, start, goal, meter, cells);
            let remarks = &mut meter.stats.remarks;
            remarks.fallback = remarks.fallback.max(Fallback::WithoutRectangles);
        }
        match result {
            // No way among virtual obstacles says nothing about the map.
            Err(PlanError::Unreachable { .. }) if self.solver.keeps_layers() => Err(NO_WAY),
            Err(PlanError::Unreachable { .. }) => {
                Err(self.kind_of_no_way(&field.without_layers(), start, goal, meter)?)
            }
            // From the goal: those that cannot be reached mostly lie in small pockets.
            Err(PlanError::DeadEnd | PlanError::OutOfBudget)
                if !meter.is_stopped()
                    && !(self.flood).fill(&field.without_layers(), goal, Some(start), meter)? =>
            {
                Err(self.kind_of_no_way(&field.without_layers(), start, goal, meter)?)
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
        let layers = self.solver.layers();
        let field = Field {
            map: query.map,
            unknown: query.unknown,
            corner_rule: self.solver.corner_rule().unwrap_or(query.corner_rule),
            prices: &prices,
            walls: &[],
            layers: if query.map.cells.iter().any(|cell| cell.flags & layers != 0) {
                layers
            } else {
                0
            },
            spared: [ends.start, ends.goal],
        };
        let mut meter = Meter::new(budget, &mut path.stats);
        let cells = &mut path.cells;
        if let Err(error) = self.search(&field, ends.start, ends.goal, &mut meter, cells) {
            cells.clear();
            return Err(error);
        }
        self.remark(&field.without_layers(), &path.cells, &mut path.stats);
        let lead = self.way_out.cells().len().saturating_sub(1);
        let cost_cells = if let Some(polyline) = self.solver.polyline() {
            curve_along(
                query,
                &path.cells[..lead.min(path.cells.len())],
                polyline,
                &mut path.curve,
            )
        } else {
            let remarks = &mut path.stats.remarks;
            curve_of(
                query,
                &path.cells,
                self.solver.spline(),
                remarks,
                &mut path.curve,
            );
            let pairs = path.cells.windows(2);
            pairs.map(|pair| field.line_cost(pair[0], pair[1])).sum()
        };
        path.stats.cost = cost_cells * query.map.geometry.resolution_m;
        Ok(path.stats)
    }
}

/// Writes a way that does not go through the centres of cells, after the centres of `lead`, as the
/// curve of the path and gives the length of both. [cells]
fn curve_along(
    query: &PlanQuery<'_>,
    lead: &[Cell],
    polyline: &[Point2<f64>],
    curve: &mut Vec<Point2<f64>>,
) -> f64 {
    let geometry = query.map.geometry;
    let origin = Point2::new(geometry.origin_x_m, geometry.origin_y_m);
    curve.clear();
    curve.extend(lead.iter().map(|cell| geometry.centre_of(*cell)));
    curve.extend((polyline.iter()).map(|at| origin + at.coords * geometry.resolution_m));
    let length_m: f64 = curve
        .windows(2)
        .map(|pair| (pair[1] - pair[0]).norm())
        .sum();
    length_m / geometry.resolution_m
}
