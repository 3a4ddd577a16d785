//! `jps`: jump point search on bit maps, for the shortest way whatever the cells cost.
//!
//! Harabor, Grastien, "Improving Jump Point Search", ICAPS 2014: block scans (B) and the pruning
//! of intermediate points (P), so that only the ends of straight jumps enter the open list; with
//! the rules for steps that cut no corner. Added to it: one bit per cell that stops a scan
//! (`jump_map`), and one look along the diagonal-then-straight way from the start, which
//! answers most questions of open maps.
//!
//! Where jumps are short, as in clutter, `canonical` is faster and takes over. With
//! another rule than [`CornerRule::ForbidAny`] the search is that of `c_astar` without costs.

use crate::canonical::Canonical;
use crate::ground::{FreeCells as _, Ground};
use crate::jump_map::JumpMap;
use crate::jumps::{Jumps, straight_way};
use crate::limits::Limits;
use crate::map_options::MapOptions;
use crate::padded::padded;
use crate::planner::{
    CellPath, Control, CornerRule, Expansions, GlobalPlanner, PlanError, PlanQuery, PlanStats,
};
use crate::search::{Found, Search, Task};
use zeronav_msgs::{Cell, CellRect, MapView};

/// Share of cells with a forced neighbour above which jumping does not pay. Measured: jumps are 13
/// times faster in a maze with a share of 0.10, 1.8 times slower in clutter with one of 0.16.
const CLUTTER_SHARE: f64 = 0.13;

/// See the module's description.
#[derive(Debug)]
pub struct Jps {
    ground: Ground<JumpMap>,
    jumps: Jumps,
    canonical: Canonical,
    /// For the other corner rules.
    plain: Search,
    choose: Choose,
}

/// Which search answers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Choose {
    /// What is likely to be faster on the map.
    ByClutter,
    /// Always jumps.
    Jumps,
    /// Always canonical A*.
    Canonical,
}

impl Jps {
    /// A planner with empty memory.
    #[must_use]
    pub fn new(options: MapOptions, choose: Choose) -> Self {
        Self {
            ground: Ground::new(options),
            jumps: Jumps::default(),
            canonical: Canonical::default(),
            plain: Search::new(0.0),
            choose,
        }
    }

    /// Bytes held for the map and the search.
    #[must_use]
    pub fn memory_bytes(&self) -> usize {
        self.ground.bytes() + self.jumps.bytes() + self.canonical.bytes()
    }

    /// What a search with these counters took: a jump or a diagonal step counts as much as an
    /// expansion of canonical A*, which takes a time of the same order.
    pub(crate) const fn effort(&self, stats: &PlanStats) -> u64 {
        if self.is_clutter() {
            stats.expanded
        } else {
            stats.evaluated
        }
    }

    /// Whether canonical A* is the faster search on the map that was last read.
    const fn is_clutter(&self) -> bool {
        match self.choose {
            Choose::ByClutter => self.ground.map.forced_share() > CLUTTER_SHARE,
            Choose::Jumps => false,
            Choose::Canonical => true,
        }
    }
}

impl GlobalPlanner for Jps {
    fn plan(
        &mut self,
        query: &PlanQuery<'_>,
        budget: &mut dyn FnMut(Expansions) -> Control,
        path: &mut CellPath,
    ) -> Result<PlanStats, PlanError> {
        let ends = self.ground.open(query, path)?;
        let is_clutter = self.is_clutter();
        self.ground
            .answer(query, &ends, path, |ground, between, path| {
                if query.corner_rule != CornerRule::ForbidAny {
                    return without_jumps(&mut self.plain, query, between, budget, path);
                }
                let (map, mut may_reach) = ground.parts(query.corner_rule, between);
                let mut limits = Limits {
                    budget,
                    may_reach: &mut may_reach,
                };
                let (start, goal) = (padded(between.0), padded(between.1));
                if straight_way(map, start, goal, path) {
                    Found::Path
                } else if is_clutter {
                    let rows = map.bits().rows();
                    self.canonical.run(rows, start, goal, &mut limits, path)
                } else {
                    self.jumps.run(map, start, goal, &mut limits, path)
                }
            })?;
        path.stats.cost = path.length_cells() * query.map.geometry.resolution_m;
        Ok(path.stats)
    }

    fn map_changed(&mut self, map: &MapView<'_>, changed: &[CellRect]) {
        self.ground.change(map, changed);
    }
}

/// A* without costs.
fn without_jumps(
    search: &mut Search,
    query: &PlanQuery<'_>,
    (start, goal): (Cell, Cell),
    budget: &mut dyn FnMut(Expansions) -> Control,
    path: &mut CellPath,
) -> Found {
    let task = Task {
        map: query.map,
        start,
        goal,
        unknown: query.unknown,
        corner_rule: query.corner_rule,
    };
    let found = search.run(&task, budget, &mut path.stats);
    if found == Found::Path {
        search.trace(&task, &mut path.cells);
    }
    found
}
