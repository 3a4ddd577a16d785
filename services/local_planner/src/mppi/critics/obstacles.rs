//! Contact with the map or the scan: the sooner, the worse. What comes after the robot could have
//! stopped is a bad plan, not a danger, and still costs a quarter.

use super::cycle::Cycle;
use crate::mppi::batch::{Batch, Lanes};
use zeronav_casts::Cast;

pub(super) fn score(_: &Cycle<'_>, batch: &Batch, weight: f32, costs: &mut Lanes) {
    let steps = batch.steps.to_f32();
    for (cost, hit) in costs.iter_mut().zip(&batch.hit) {
        if hit.is_finite() {
            let early = 1.0 - hit / steps;
            *cost += weight * (0.25 + 0.75 * early * early);
        }
    }
}
