//! Distance from the path, quadratic up to 30 cm and linear beyond, on average.

use super::cycle::Cycle;
use crate::mppi::batch::{Batch, Lanes};
use crate::rollout_scores::cost_beside;
use zeronav_casts::Cast;

pub(super) fn score(_: &Cycle<'_>, batch: &Batch, weight: f32, costs: &mut Lanes) {
    for (lane, cost) in costs.iter_mut().enumerate() {
        let free = batch.free[lane];
        let stations = &batch.projections[..free];
        let sum: f32 = stations
            .iter()
            .map(|station| cost_beside(station.beside[lane]))
            .sum();
        *cost += weight * sum / free.to_f32();
    }
}
