//! `policy`: the search that pays on the current map, for maps that change.
//!
//! Where cells have prices, jumps do not find the cheapest way, and a field that is kept (`mpgaa`)
//! expands a fraction of what a search from scratch does: it answers alone.
//!
//! Where all free cells cost the same, the kept field is many times faster than jump point search
//! from scratch (`jps`) when little of the map has to be looked at again, and slower when half of it
//! has to be. Nobody knows beforehand which it is, so the field is tried first, with a budget that
//! costs a part of an answer by jumps: it follows from the effort of the last one on the map at
//! hand. Where jumps take next to nothing there is no trial. Effort is counted, not
//! timed, so that the same calls give the same paths. `--example replan` measures all three.
//!
//! Which of the two a map is, is counted, not configured: a single free cell with a price is
//! enough. Until all of the map is rewritten it then stays one with prices.

use crate::jps::{Choose, Jps};
use crate::map_options::MapOptions;
use crate::mpgaa::Mpgaa;
use crate::planner::{
    CellPath, Control, CornerRule, Expansions, GlobalPlanner, PlanError, PlanQuery, PlanStats,
};
use zeronav_msgs::map::COST_UNKNOWN;
use zeronav_msgs::{Cell, CellRect, GridGeometry, MapCell, MapView, Pose};

/// Effort of a search from scratch for each expansion of a trial. Measured on 4000 x 4000 cells: a
/// trial that fails costs an eighth to a fifth of the answer; those that succeed take some 0.2 ms.
const EFFORT_PER_EXPANSION: u64 = 8;

/// Searches from scratch of less effort take at most some 0.3 ms: there is little to gain.
const EFFORT_MIN: u64 = 8192;

/// See the module's description.
#[derive(Debug)]
pub(crate) struct Policy {
    jumps: Jps,
    field: Mpgaa,
    cost_weight: f64,
    geometry: GridGeometry,
    told: bool,
    priced: bool,
    /// What the last search from scratch on this map took, [`Jps::effort`].
    effort: u64,
}

impl Policy {
    /// A planner with empty memory.
    #[must_use]
    pub(crate) fn new(options: MapOptions) -> Self {
        Self {
            jumps: Jps::new(options, Choose::ByClutter),
            field: Mpgaa::new(options),
            cost_weight: options.cost_weight(),
            geometry: GridGeometry::default(),
            told: false,
            priced: false,
            effort: 0,
        }
    }

    fn has_price(&self, cell: MapCell) -> bool {
        self.cost_weight > 0.0
            && cell.cost != 0
            && cell.cost != COST_UNKNOWN
            && !cell.blocks_centre()
    }

    /// Jumps from scratch, unless the field has the answer for less.
    fn plan_unpriced(
        &mut self,
        query: &PlanQuery<'_>,
        budget: &mut dyn FnMut(Expansions) -> Control,
        path: &mut CellPath,
    ) -> Result<PlanStats, PlanError> {
        let mut spent = PlanStats::default();
        // A planner that is not told of changes keeps no field.
        if self.told {
            let mut stopped = false;
            let mut watched = |expansions| {
                let control = budget(expansions);
                stopped |= control == Control::Stop;
                control
            };
            // Also when it is not tried, it learns where the goal is, and is made.
            let most = if self.effort >= EFFORT_MIN {
                self.effort / EFFORT_PER_EXPANSION
            } else {
                0
            };
            let tried = self.field.plan_by_field(query, most, &mut watched, path);
            if stopped || tried != Err(PlanError::OutOfBudget) {
                return tried;
            }
            spent = path.stats;
        }
        let mut with_spent = |Expansions(expanded)| budget(Expansions(expanded + spent.expanded));
        let result = self.jumps.plan(query, &mut with_spent, path);
        self.effort = self.jumps.effort(&path.stats);
        path.stats.add_effort(&spent);
        result.map(|_| path.stats)
    }
}

impl GlobalPlanner for Policy {
    fn plan(
        &mut self,
        query: &PlanQuery<'_>,
        budget: &mut dyn FnMut(Expansions) -> Control,
        path: &mut CellPath,
    ) -> Result<PlanStats, PlanError> {
        if !self.told {
            self.priced = query.map.cells.iter().any(|cell| self.has_price(*cell));
        }
        // Without jumps, which cut no corner, from scratch is what the field is never worse than.
        if self.priced || query.corner_rule != CornerRule::ForbidAny {
            self.field.plan(query, budget, path)
        } else {
            self.plan_unpriced(query, budget, path)
        }
    }

    fn map_changed(&mut self, map: &MapView<'_>, changed: &[CellRect]) {
        let (width, height) = map.geometry.size();
        let whole = CellRect {
            min: Cell::new(0, 0),
            max: Cell::new(width, height),
        };
        let anew = !self.told || *map.geometry != self.geometry || changed.contains(&whole);
        self.told = true;
        self.geometry = *map.geometry;
        let had = self.priced && !anew;
        let changed = if anew {
            core::slice::from_ref(&whole)
        } else {
            changed
        };
        self.priced = had
            || changed.iter().any(|rect| {
                let rect = rect.grown(0, map.geometry);
                (rect.min.y..rect.max.y).any(|y| {
                    (rect.min.x..rect.max.x).any(|x| {
                        let cell = map.get(Cell::new(x, y));
                        cell.is_some_and(|cell| self.has_price(cell))
                    })
                })
            });
        if anew {
            self.effort = 0;
        }
        self.field.map_changed(map, changed);
        // Prices only go with all that was on the map, so jumps have then missed nothing.
        if !self.priced {
            self.jumps.map_changed(map, changed);
        }
    }

    fn prepare(&mut self, robot: &Pose, expansions: u64) -> bool {
        self.field.prepare(robot, expansions)
    }

    fn detour(
        &mut self,
        query: &PlanQuery<'_>,
        budget: &mut dyn FnMut(Expansions) -> Control,
        path: &mut CellPath,
    ) -> Option<PlanStats> {
        self.field.detour(query, budget, path)
    }
}
