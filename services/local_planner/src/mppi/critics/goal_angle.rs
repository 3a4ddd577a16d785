//! Heading against the goal's yaw at the end, on the last half metre, where a yaw is asked for.

use super::cycle::Cycle;
use crate::mppi::batch::{Batch, Lanes};

/// [m] of path that are left when it begins to count.
const FROM_M: f32 = 0.5;

pub(super) fn score(cycle: &Cycle<'_>, batch: &Batch, weight: f32, costs: &mut Lanes) {
    let Some((cos, sin)) = cycle.goal_heading.filter(|_| cycle.remaining_m < FROM_M) else {
        return;
    };
    let last = batch.steps - 1;
    for (lane, cost) in costs.iter_mut().enumerate() {
        let aligned = batch.cos[last][lane] * cos + batch.sin[last][lane] * sin;
        *cost += weight * (1.0 - aligned);
    }
}
