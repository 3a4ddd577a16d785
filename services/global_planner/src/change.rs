//! What a map update means for planning: did anything open, did anything become cheaper?

use crate::planner::Unknown;
use zeronav_msgs::map::COST_UNKNOWN;
use zeronav_msgs::{Cell, CellRect, GridGeometry, MapCell, MapView};

/// Rank of cells that block the robot's centre; of all others it is their cost.
const BLOCKED: u8 = u8::MAX;

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
    ranks: Vec<u8>,
}

impl CostMemory {
    /// Takes in the cells of `changed` and calls `eased` with each that became cheaper or opened.
    /// Nothing is called when the grid is another one.
    pub(crate) fn take_in(
        &mut self,
        map: &MapView<'_>,
        changed: &[CellRect],
        unknown: Unknown,
        mut eased: impl FnMut(Cell),
    ) -> Change {
        if *map.geometry != self.geometry || self.ranks.len() != map.cells.len() {
            self.geometry = *map.geometry;
            self.ranks.clear();
            self.ranks
                .extend(map.cells.iter().map(|cell| rank(*cell, unknown)));
            return Change {
                geometry: true,
                opened: true,
                any: true,
            };
        }
        let mut change = Change::default();
        for rect in changed {
            let rect = rect.grown(0, map.geometry);
            for y in rect.min.y..rect.max.y {
                for x in rect.min.x..rect.max.x {
                    let Some(index) = map.geometry.index_of(Cell::new(x, y)) else {
                        continue;
                    };
                    let (old, new) = (self.ranks[index], rank(map.cells[index], unknown));
                    if old != new {
                        self.ranks[index] = new;
                        change.any = true;
                        if new < old {
                            change.opened |= old == BLOCKED;
                            eased(Cell::new(x, y));
                        }
                    }
                }
            }
        }
        change
    }
}

fn rank(cell: MapCell, unknown: Unknown) -> u8 {
    if unknown.blocks(cell) {
        BLOCKED
    } else if cell.cost == COST_UNKNOWN {
        0
    } else {
        cell.cost
    }
}
