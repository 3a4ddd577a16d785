//! String pulling: a way of single steps made of few straight lines, where that is no dearer.

use crate::line::supercover;
use crate::moves::price;
use crate::planner::PlanQuery;
use zeronav_msgs::Cell;

/// Memory of the pulling, reused from call to call.
#[derive(Debug, Default)]
pub(crate) struct Pull {
    /// Cost of the way up to each of its cells. [cells]
    so_far: Vec<f64>,
    corners: Vec<Cell>,
}

impl Pull {
    /// Replaces pieces of `cells[first..]` by straight lines that are free and cost no more: the
    /// length in each cell times the price of the cell, so that clearance is kept where the way
    /// kept it.
    ///
    /// From each corner the line is tried to ever farther cells, twice as far each time, then
    /// between the last that was free and the first that was not.
    pub(crate) fn run(
        &mut self,
        query: &PlanQuery<'_>,
        cost_weight: f64,
        first: usize,
        cells: &mut Vec<Cell>,
    ) {
        let way = &cells[first..];
        if way.len() < 3 {
            return;
        }
        self.so_far.clear();
        self.so_far.push(0.0);
        let mut sum = 0.0;
        for pair in way.windows(2) {
            sum += cost_of_line(query, cost_weight, pair[0], pair[1]).unwrap_or(0.0);
            self.so_far.push(sum);
        }
        self.corners.clear();
        self.corners.push(way[0]);
        let mut from = 0;
        while from + 1 < way.len() {
            let so_far = &self.so_far;
            let straight = |to: usize| {
                cost_of_line(query, cost_weight, way[from], way[to])
                    .is_some_and(|cost| cost <= so_far[to] - so_far[from] + 1e-9)
            };
            let last = way.len() - 1;
            let (mut near, mut stride) = (from + 1, 1);
            while near < last && straight((near + stride).min(last)) {
                near = (near + stride).min(last);
                stride *= 2;
            }
            while stride > 1 {
                stride /= 2;
                if near + stride <= last && straight(near + stride) {
                    near += stride;
                }
            }
            self.corners.push(way[near]);
            from = near;
        }
        cells.truncate(first);
        cells.extend_from_slice(&self.corners);
    }
}

/// Cost of the straight line between two centres [cells]; `None` when it is not legal.
pub(crate) fn cost_of_line(
    query: &PlanQuery<'_>,
    cost_weight: f64,
    from: Cell,
    to: Cell,
) -> Option<f64> {
    let length = f64::from(to.x - from.x).hypot(f64::from(to.y - from.y));
    let mut sum = 0.0;
    let mut legal = true;
    let blocked = |cell: Cell| {
        query
            .map
            .get(cell)
            .is_none_or(|cell| query.unknown.blocks(cell))
    };
    supercover(from, to, |crossing| {
        if !legal {
            return;
        }
        legal = !blocked(crossing.cell)
            && crossing
                .touched
                .is_none_or(|[a, b]| query.corner_rule.permits(blocked(a), blocked(b)));
        let cost = query.map.get(crossing.cell).map_or(0, |cell| cell.cost);
        sum += (crossing.leaves - crossing.enters) * length * price(cost, cost_weight);
    });
    legal.then_some(sum)
}
