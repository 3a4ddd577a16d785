//! What a map update means for planning: did anything open, did anything become cheaper?

use crate::planner::{BLOCKED, Unknown};
use zeronav_msgs::{Cell, CellRect, GridGeometry, MapView};

/// What a map update did.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct Change {
    /// It is another grid, or the first one.
    pub geometry: bool,
    /// A cell that blocked the robot's centre does so no longer.
    pub opened: bool,
    /// Any cell is cheaper or dearer than before.
    pub any: bool,
}

/// The costs seen last, so that the next update can be compared with them. Time follows what
/// changed, not the map.
#[derive(Debug, Default)]
pub(crate) struct CostMemory {
    geometry: GridGeometry,
    /// [`Unknown::cost`] of each cell.
    costs: Vec<u8>,
}

impl CostMemory {
    /// Takes in the cells of `changed` and calls `cost_decreased` with each that became cheaper or opened.
    /// Nothing is called when the grid is another one.
    pub(crate) fn take_in(
        &mut self,
        map: &MapView<'_>,
        changed: &[CellRect],
        unknown: Unknown,
        mut cost_decreased: impl FnMut(Cell),
    ) -> Change {
        if *map.geometry != self.geometry || self.costs.len() != map.cells.len() {
            self.geometry = *map.geometry;
            self.costs.clear();
            self.costs
                .extend(map.cells.iter().map(|cell| unknown.cost(*cell)));
            return Change {
                geometry: true,
                opened: true,
                any: true,
            };
        }
        let mut change = Change::default();
        for rect in changed {
            let rect = rect.grown(0, map.geometry);
            if rect.min.x >= rect.max.x {
                continue;
            }
            for y in rect.min.y..rect.max.y {
                let ends = [Cell::new(rect.min.x, y), Cell::new(rect.max.x - 1, y)];
                let [Some(first), Some(last)] = ends.map(|cell| map.geometry.index_of(cell)) else {
                    continue;
                };
                let cells = map.cells[first..=last].iter();
                let costs = self.costs[first..=last].iter_mut();
                for (x, (cell, cost)) in (rect.min.x..).zip(cells.zip(costs)) {
                    let new = unknown.cost(*cell);
                    let old = core::mem::replace(cost, new);
                    change.any |= new != old;
                    if new < old {
                        change.opened |= old == BLOCKED;
                        cost_decreased(Cell::new(x, y));
                    }
                }
            }
        }
        change
    }
}
