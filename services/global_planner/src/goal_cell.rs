//! Which cell a path leads to when the goal's own is blocked or cannot be reached.

use crate::moves::STEPS;
use crate::planner::{CornerRule, PlanQuery};
use zeronav_msgs::window::{Window, cells_in};
use zeronav_msgs::{Cell, MapCell};

/// Largest window in which the free cells are looked at one by one before the map is. [cells]
const LOOK_AROUND: i32 = 64;

/// Memory of the choice, reused from call to call.
#[derive(Debug, Default)]
pub(crate) struct GoalCell {
    seen: Vec<bool>,
    queue: Vec<Cell>,
}

impl GoalCell {
    /// The free cell within the tolerance that is nearest to the goal, its own before all, of those that
    /// are connected with one of `exits`; else the nearest that is free.
    ///
    /// Where all free cells within the tolerance hang together, which is seen by looking around,
    /// the nearest is as reachable as any. Only where a wall runs between them `connected` is asked
    /// which of them the robot can reach.
    pub(crate) fn find(
        &mut self,
        query: &PlanQuery<'_>,
        own: Cell,
        exits: &[Cell],
        connected: &mut dyn FnMut(Cell, Cell) -> bool,
    ) -> Option<Cell> {
        let nearest = nearest(query, own, |_| true)?;
        if self.hangs_together(query, own, nearest) {
            return Some(nearest);
        }
        let reachable = |cell: Cell| exits.iter().any(|exit| connected(*exit, cell));
        self::nearest(query, own, reachable).or(Some(nearest))
    }

    /// True when all free cells within the tolerance are connected near the goal.
    fn hangs_together(&mut self, query: &PlanQuery<'_>, own: Cell, nearest: Cell) -> bool {
        let rings = rings(query);
        if rings > LOOK_AROUND {
            return false;
        }
        // One ring more, so that cells are connected around the end of a wall, too.
        let reach = rings + 1;
        let row = |y: i32| (-reach..=reach).map(move |x| Cell::new(own.x + x, own.y + y));
        if (-reach..=reach).flat_map(row).all(|at| is_free(query, at)) {
            return true;
        }
        let window = Window::around(own, reach);
        let stride = if query.corner_rule == CornerRule::Allow {
            1
        } else {
            2
        };
        self.seen.clear();
        self.seen.resize(window.len(), false);
        self.queue.clear();
        let mut see = |cell: Cell, queue: &mut Vec<Cell>| {
            if let Some(n) = window.index_of(cell)
                && !self.seen[n]
                && is_free(query, cell)
            {
                self.seen[n] = true;
                queue.push(cell);
            }
        };
        see(nearest, &mut self.queue);
        while let Some(from) = self.queue.pop() {
            for (dx, dy) in STEPS.iter().step_by(stride) {
                see(Cell::new(from.x + dx, from.y + dy), &mut self.queue);
            }
        }
        let is_apart = |cell: Cell| window.index_of(cell).is_some_and(|n| !self.seen[n]);
        self::nearest(query, own, is_apart).is_none()
    }
}

fn rings(query: &PlanQuery<'_>) -> i32 {
    let (width, height) = query.map.geometry.size();
    cells_in(query.tolerance_m, query.map.geometry.resolution_m)
        .saturating_add(1)
        .min(width.max(height))
}

fn is_free(query: &PlanQuery<'_>, cell: Cell) -> bool {
    let is_free = |cell: MapCell| !query.unknown.blocks(cell);
    query.map.get(cell).is_some_and(is_free)
}

/// The free cell nearest to the goal of those that `counts` holds of, ring by ring.
fn nearest(query: &PlanQuery<'_>, own: Cell, mut counts: impl FnMut(Cell) -> bool) -> Option<Cell> {
    let geometry = query.map.geometry;
    if is_free(query, own) && counts(own) {
        return Some(own);
    }
    let mut best: Option<(f64, Cell)> = None;
    for ring in 1..=rings(query) {
        // Centres of this ring and all later ones are at least this far.
        let at_least_m = (f64::from(ring) - 0.5) * geometry.resolution_m;
        if best.is_some_and(|(distance_m, _)| distance_m < at_least_m) {
            break;
        }
        for y in -ring..=ring {
            let stride = if y.abs() == ring { 1 } else { 2 * ring };
            let mut x = -ring;
            while x <= ring {
                let cell = Cell::new(own.x + x, own.y + y);
                if is_free(query, cell) {
                    let distance_m = (geometry.centre_of(cell) - query.goal.point()).norm();
                    if distance_m <= query.tolerance_m
                        && best.is_none_or(|(nearest_m, _)| distance_m < nearest_m)
                        && counts(cell)
                    {
                        best = Some((distance_m, cell));
                    }
                }
                x += stride;
            }
        }
    }
    best.map(|(_, cell)| cell)
}
