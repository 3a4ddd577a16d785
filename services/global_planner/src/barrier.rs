//! The cell that would have to open where no way leads to the goal. Nothing is decided by it.
//!
//! Dijkstra's algorithm from the robot over all cells of the map: a free cell costs its length, a
//! blocked one much more, and the more the less likely it opens: what the static map closes by
//! itself opens last. The cheapest way passes what closes it; of that its tightest cell is told, of
//! those that the static map closes where there are such.

use crate::blockers::Blockers;
use crate::bucket_queue::BucketQueue;
use crate::moves::STEPS;
use crate::plan::Blocked;
use crate::planner::{CornerRule, PlanQuery};
use zeronav_casts::Cast;
use zeronav_msgs::Cell;
use zeronav_msgs::map::{COST_LETHAL, FLAG_STATIC, ObstacleSource};

/// Cells that are looked at at most: some ten milliseconds.
const SETTLED_MAX: u32 = 1 << 19;

/// Costs, in half cells of a free way: of a straight and a diagonal step, and what a blocked cell
/// adds that is only too close to an obstacle, that the lidar saw or nobody knows, that is too close to
/// an obstacle of the static map, and that is one.
const STRAIGHT: u32 = 2;
const DIAGONAL: u32 = 3;
const CLOSE: u32 = 16;
const SEEN: u32 = 64;
const SHUT: u32 = 512;
const STATIC: u32 = 2048;

/// Instead of the step that led to a cell.
const UNSEEN: u8 = 15;
const START: u8 = 8;

/// Bits of an item of the queue that hold the step.
const STEP_BITS: u32 = 4;

/// See the module's description. Its memory is reused.
#[derive(Debug, Default)]
pub(crate) struct Barrier {
    open: BucketQueue,
    /// The step that led to each cell, [`START`] or [`UNSEEN`].
    steps: Vec<u8>,
    way: Vec<Cell>,
}

impl Barrier {
    /// The tightest cell of what closes the way; `None` when the ends are not on the map or too far
    /// apart.
    pub(crate) fn find(&mut self, query: &PlanQuery<'_>) -> Option<Blocked> {
        let geometry = query.map.geometry;
        let blockers = Blockers::of(query.map);
        let start = geometry.cell_at(query.start.point())?;
        let goal = geometry.cell_at(query.goal.point())?;
        let (width, _) = geometry.size();
        let stride = match query.corner_rule {
            CornerRule::Allow => 1,
            CornerRule::ForbidAny | CornerRule::ForbidBoth => 2,
        };
        self.steps.clear();
        self.steps.resize(query.map.cells.len(), UNSEEN);
        self.open.reset(0, STATIC + DIAGONAL);
        let item = |index: usize, step: u8| index.to_u32() << STEP_BITS | u32::from(step);
        self.open.push(0, item(geometry.index_of(start)?, START));
        let mut settled = 0;
        while let Some((cost, entry)) = self.open.pop_with_key() {
            let index = (entry >> STEP_BITS) as usize;
            if self.steps[index] != UNSEEN {
                continue;
            }
            self.steps[index] = (entry & ((1 << STEP_BITS) - 1)) as u8;
            let from = Cell::new(index.to_i32() % width, index.to_i32() / width);
            if is_end(query, goal, from) {
                return self.tightest(query, &blockers, from);
            }
            settled += 1;
            if settled == SETTLED_MAX {
                return None;
            }
            for (n, (dx, dy)) in STEPS.iter().enumerate().step_by(stride) {
                let to = Cell::new(from.x + dx, from.y + dy);
                if let Some(next) = geometry.index_of(to)
                    && self.steps[next] == UNSEEN
                {
                    let step = if n % 2 == 0 { STRAIGHT } else { DIAGONAL };
                    let cost = cost + step + obstacle_cost(query, &blockers, to);
                    self.open.push(cost, item(next, n.to_u8()));
                }
            }
        }
        None
    }

    /// The cell with the least clearance of the first blocked ones on the way to `end` where the
    /// robot cannot be led out of the inflation; of those that the static map closes by itself
    /// where the way has such.
    fn tightest(
        &mut self,
        query: &PlanQuery<'_>,
        blockers: &Blockers<'_>,
        end: Cell,
    ) -> Option<Blocked> {
        let map = query.map;
        self.way.clear();
        let mut cell = end;
        loop {
            self.way.push(cell);
            let step = map.geometry.index_of(cell).map(|index| self.steps[index])?;
            let Some((dx, dy)) = STEPS.get(usize::from(step)) else {
                break;
            };
            cell = Cell::new(cell.x - dx, cell.y - dy);
        }
        let known = |cell: &Cell| map.get(*cell).filter(|known| query.unknown.blocks(*known));
        let least_mm = map.least_clearance_mm(map.get(cell)?);
        let leaves = |cell: &Cell| {
            known(cell).is_some_and(|known| {
                !query.unknown.is_lethal(known) && known.clearance_mm >= least_mm
            })
        };
        let closed = |closes: &dyn Fn(&Cell) -> bool| {
            let way = self.way.iter().rev().skip_while(|cell| leaves(cell));
            let closed = way
                .skip_while(|cell| !closes(cell))
                .take_while(|cell| closes(cell))
                .filter_map(|cell| Some((known(cell)?.clearance_mm, *cell)));
            closed.min_by_key(|(clearance_mm, _)| *clearance_mm)
        };
        let is_shut = |cell: &Cell| {
            known(cell).is_some() && blockers.source_at(*cell) == ObstacleSource::StaticMap
        };
        let tightest = closed(&is_shut).or_else(|| closed(&|cell| known(cell).is_some()));
        tightest.map(|(_, cell)| blockers.blocked(cell))
    }
}

/// What a blocked cell adds to the cost of a step into it.
fn obstacle_cost(query: &PlanQuery<'_>, blockers: &Blockers<'_>, cell: Cell) -> u32 {
    let Some(known) = query.map.get(cell).filter(|it| query.unknown.blocks(*it)) else {
        return 0;
    };
    if known.cost == COST_LETHAL && known.flags & FLAG_STATIC != 0 {
        STATIC
    } else if blockers.source_at(cell) == ObstacleSource::StaticMap {
        SHUT
    } else if query.unknown.is_lethal(known) {
        SEEN
    } else {
        CLOSE
    }
}

/// True where a path to the goal would end: in its own cell, or beside it when that is blocked.
fn is_end(query: &PlanQuery<'_>, goal: Cell, cell: Cell) -> bool {
    let is_free = |cell| (query.map.get(cell)).is_some_and(|cell| !query.unknown.blocks(cell));
    let away_m = (query.map.geometry.centre_of(cell) - query.goal.point()).norm();
    cell == goal || (away_m <= query.tolerance_m && is_free(cell) && !is_free(goal))
}
