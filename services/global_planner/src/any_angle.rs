//! `any_angle`: the way of `mpgaa`, pulled straight where the straight line costs no more.
//!
//! Costs are those of lines: the length in each cell times the cell's price. A single step costs
//! by that measure half of each of its two cells, so the numbers are not those of `mpgaa`.

use crate::map_options::MapOptions;
use crate::mpgaa::Mpgaa;
use crate::planner::{
    CellPath, Control, Expansions, GlobalPlanner, PlanError, PlanQuery, PlanStats,
};
use crate::pull::{Pull, cost_of_line};
use zeronav_msgs::{CellRect, MapView, Pose};

/// See the module's description.
#[derive(Debug)]
pub(crate) struct AnyAngle {
    search: Mpgaa,
    pull: Pull,
    cost_weight: f64,
}

impl AnyAngle {
    /// A planner with empty memory.
    #[must_use]
    pub(crate) fn new(options: MapOptions) -> Self {
        Self {
            search: Mpgaa::new(options),
            pull: Pull::default(),
            cost_weight: options.cost_weight(),
        }
    }
}

impl GlobalPlanner for AnyAngle {
    fn plan(
        &mut self,
        query: &PlanQuery<'_>,
        budget: &mut dyn FnMut(Expansions) -> Control,
        path: &mut CellPath,
    ) -> Result<PlanStats, PlanError> {
        self.search.plan(query, budget, path)?;
        // The way out of the inflation stays as it is.
        let blocked = |cell| {
            query
                .map
                .get(cell)
                .is_none_or(|cell| query.unknown.blocks(cell))
        };
        let first = path
            .cells
            .iter()
            .position(|cell| !blocked(*cell))
            .unwrap_or(0);
        self.pull
            .run(query, self.cost_weight, first, &mut path.cells);
        let resolution_m = query.map.geometry.resolution_m;
        path.stats.bound = 0.0;
        path.stats.cost = path
            .cells
            .windows(2)
            .map(|pair| {
                let straight =
                    f64::from(pair[1].x - pair[0].x).hypot(f64::from(pair[1].y - pair[0].y));
                cost_of_line(query, self.cost_weight, pair[0], pair[1]).unwrap_or(straight)
                    * resolution_m
            })
            .sum();
        Ok(path.stats)
    }

    fn map_changed(&mut self, map: &MapView<'_>, changed: &[CellRect]) {
        self.search.map_changed(map, changed);
    }

    fn prepare(&mut self, robot: &Pose, expansions: u64) -> bool {
        self.search.prepare(robot, expansions)
    }
}
