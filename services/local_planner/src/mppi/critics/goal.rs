//! Distance from the goal at the end, on the last metre of the path.

use super::cycle::Cycle;
use crate::mppi::batch::{Batch, Lanes};

/// [m] of path that are left when it begins to count.
const FROM_M: f32 = 1.0;

pub(super) fn score(cycle: &Cycle<'_>, batch: &Batch, weight: f32, costs: &mut Lanes) {
    if cycle.remaining_m >= FROM_M {
        return;
    }
    let last = batch.steps - 1;
    for (lane, cost) in costs.iter_mut().enumerate() {
        let (dx, dy) = (
            batch.x[last][lane] - cycle.goal.0,
            batch.y[last][lane] - cycle.goal.1,
        );
        *cost += weight * (dx * dx + dy * dy).sqrt();
    }
}
