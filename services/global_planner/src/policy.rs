//! `policy`: the search that pays on the map at hand, for maps that change.
//!
//! Where all free cells cost the same, jump point search from scratch (`jps`) answers sooner than
//! a search that keeps what it knows (`mpgaa`) in most of the measured changes, and asks for no
//! work ahead. Where cells have prices, jumps do not find the cheapest way, and the kept field
//! expands a fraction of what a search from scratch does. `--example replan` measures both.
//!
//! Which of the two a map is, is counted, not configured: a single free cell with a price is
//! enough. Until a map is all written anew it then stays one with prices.

use crate::jps::{Choose, Jps};
use crate::mpgaa::Mpgaa;
use crate::planner::{
    CellPath, Control, Expansions, GlobalPlanner, PlanError, PlanQuery, PlanStats,
};
use crate::table::{COST_WEIGHT_MAX, PlannerOptions, within};
use zeronav_msgs::map::COST_UNKNOWN;
use zeronav_msgs::{Cell, CellRect, GridGeometry, MapCell, MapView};

/// See the module's description.
#[derive(Debug)]
pub struct Policy {
    jumps: Jps,
    field: Mpgaa,
    cost_weight: f64,
    geometry: GridGeometry,
    told: bool,
    priced: bool,
}

impl Policy {
    /// A planner with empty memory. Options outside their range are taken as its nearest end.
    #[must_use]
    pub fn new(options: &PlannerOptions) -> Self {
        Self {
            jumps: Jps::new(options, Choose::ByClutter),
            field: Mpgaa::new(options),
            cost_weight: within(options.cost_weight, COST_WEIGHT_MAX),
            geometry: GridGeometry::default(),
            told: false,
            priced: false,
        }
    }

    /// Bytes held for the map and the searches.
    #[must_use]
    pub fn memory_bytes(&self) -> usize {
        self.jumps.memory_bytes() + self.field.memory_bytes()
    }

    fn has_price(&self, cell: MapCell) -> bool {
        self.cost_weight > 0.0
            && cell.cost != 0
            && cell.cost != COST_UNKNOWN
            && !cell.blocks_centre()
    }

    fn in_use(&mut self) -> &mut dyn GlobalPlanner {
        if self.priced {
            &mut self.field
        } else {
            &mut self.jumps
        }
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
        self.in_use().plan(query, budget, path)
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
        // Who was not in use has missed what changed meanwhile.
        let changed = if self.priced == had {
            changed
        } else {
            core::slice::from_ref(&whole)
        };
        self.in_use().map_changed(map, changed);
    }

    fn prepare(&mut self, expansions: u64) -> bool {
        self.in_use().prepare(expansions)
    }
}
