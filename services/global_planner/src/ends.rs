//! Both ends of a path: out of the inflation at the start, into the tolerance at the goal.

use crate::bits::BitMap;
use crate::goal_cell::GoalCell;
use crate::map_options::MapOptions;
use crate::padded::padded;
use crate::planner::{CornerRule, PlanError, PlanQuery, Unknown};
use crate::regions::Regions;
use zeronav_msgs::escape::{Escape, Standing};
use zeronav_msgs::{Cell, MapView};

/// Where a search begins and ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Ends {
    /// First free cell; the last of [`WayOut::cells`].
    pub start: Cell,
    /// The goal's own cell, or the free one that takes its place.
    pub goal: Cell,
}

/// The way from a robot too close to an obstacle to a free cell, and other such cells. Its memory
/// is reused.
#[derive(Debug, Default)]
pub(crate) struct WayOut {
    escape_m: f64,
    cells: Vec<Cell>,
    escape: Escape,
    goal: GoalCell,
    bits: BitMap,
    regions: Regions,
}

impl WayOut {
    /// Without memory of any question.
    #[must_use]
    pub(crate) fn new(options: MapOptions) -> Self {
        Self {
            escape_m: options.escape_m(),
            ..Self::default()
        }
    }

    /// Cells from the robot's own to the first free one, both included; one cell when the robot
    /// is free.
    #[must_use]
    pub(crate) fn cells(&self) -> &[Cell] {
        &self.cells
    }

    /// Begins a path with the way out, but for the cell where the search begins.
    pub(crate) fn lead(&self, path: &mut Vec<Cell>) {
        let last = self.cells.len().saturating_sub(1);
        path.extend_from_slice(&self.cells[..last]);
    }

    /// Turns to the nearest free cell of which `tried` does not hold; `None` when there is none.
    pub(crate) fn turn_to_next(&mut self, tried: impl FnMut(Cell) -> bool) -> Option<Cell> {
        self.escape.turn_to_next(tried, &mut self.cells)
    }
}

/// Finds the first and the last cell of the search.
///
/// A start that is blocked, but not lethal, is left on a shortest way (in steps) over cells that
/// are not lethal and have as much room as the robot has now, at most [`MapOptions::escape_m`] from the
/// robot along either axis. A blocked goal is replaced
/// by the free cell whose centre is nearest to it, within the tolerance; the lower row, then the
/// lower column, of two equally near. `connected` says whether a way may lead from one free cell to
/// another.
///
/// # Errors
/// [`PlanError::StartOutsideMap`], [`PlanError::GoalOutsideMap`], [`PlanError::StartBlocked`],
/// [`PlanError::GoalBlocked`], in this order.
pub(crate) fn find_ends(
    query: &PlanQuery<'_>,
    way_out: &mut WayOut,
    connected: &mut dyn FnMut(Cell, Cell) -> bool,
) -> Result<Ends, PlanError> {
    let geometry = query.map.geometry;
    let start = geometry
        .cell_at(query.start.point())
        .ok_or(PlanError::StartOutsideMap)?;
    let goal = geometry
        .cell_at(query.goal.point())
        .ok_or(PlanError::GoalOutsideMap)?;
    let start = leave_inflation(query, start, way_out).ok_or(PlanError::StartBlocked)?;
    let goal = way_out
        .goal
        .find(query, goal, way_out.escape.exits(), connected)
        .ok_or(PlanError::GoalBlocked)?;
    Ok(Ends { start, goal })
}

/// [`find_ends`] for planners that keep no bits of the map: all of it is read where it matters which
/// cells are connected.
///
/// # Errors
/// As [`find_ends`].
pub(crate) fn find_ends_on_map(
    query: &PlanQuery<'_>,
    way_out: &mut WayOut,
) -> Result<Ends, PlanError> {
    let (mut bits, mut regions) = (
        core::mem::take(&mut way_out.bits),
        core::mem::take(&mut way_out.regions),
    );
    let mut read = false;
    let ends = find_ends(query, way_out, &mut |one, other| {
        if !read {
            bits.follow(&query.map, query.unknown);
            regions.follow(&bits, query.corner_rule);
            read = true;
        }
        regions.connected(padded(one), padded(other))
    });
    (way_out.bits, way_out.regions) = (bits, regions);
    ends
}

/// Writes the way out and gives its last cell.
///
/// Clearance does not fall on it. Only where that leaves no free cell within reach, as on a map that is
/// wrong, any cell will do that is not lethal.
fn leave_inflation(query: &PlanQuery<'_>, start: Cell, way_out: &mut WayOut) -> Option<Cell> {
    let own = query.map.get(start)?;
    let least_mm = query.map.least_clearance_mm(own);
    flood(query, start, least_mm, way_out)?;
    if way_out.escape.exits().is_empty() {
        flood(query, start, 0, way_out)?;
    }
    way_out.turn_to_next(|_| false)
}

/// Finds the free cells within reach over cells with at least this clearance. [mm] `None` when the
/// robot is in an obstacle.
fn flood(query: &PlanQuery<'_>, start: Cell, least_mm: u16, way_out: &mut WayOut) -> Option<()> {
    let (map, unknown) = (query.map, query.unknown);
    let standing = |cell| {
        if unknown.is_lethal(cell) {
            Standing::Obstacle
        } else if unknown.blocks(cell) {
            Standing::Inflated
        } else {
            Standing::Free
        }
    };
    let diagonal = |from, to| corner_is_free(map, unknown, query.corner_rule, from, to);
    let reach = (way_out.escape_m, least_mm);
    let is_out = (way_out.escape).flood(&map, start, reach, standing, diagonal);
    is_out.then_some(())
}

fn passable(map: MapView<'_>, unknown: Unknown, cell: Cell) -> bool {
    map.get(cell).is_some_and(|cell| !unknown.is_lethal(cell))
}

fn corner_is_free(
    map: MapView<'_>,
    unknown: Unknown,
    rule: CornerRule,
    from: Cell,
    to: Cell,
) -> bool {
    rule.permits(
        !passable(map, unknown, Cell::new(to.x, from.y)),
        !passable(map, unknown, Cell::new(from.x, to.y)),
    )
}
