//! Speed by clearance: a metre per second beyond what the space allows costs the weight.

use super::cycle::Cycle;
use crate::lanes::data::{most, narrow};
use crate::mppi::batch::{Batch, LANES, Lanes};

pub(super) fn score(cycle: &Cycle<'_>, batch: &Batch, weight: f32, costs: &mut Lanes) {
    let base = narrow(cycle.config.speed_base_mps);
    let gain = narrow(cycle.config.speed_gain_hz);
    let mut worst = [0.0; LANES];
    for &step in &batch.looks {
        let (space, v) = (&batch.space[step], &batch.v[step]);
        for lane in 0..LANES {
            worst[lane] = most(worst[lane], v[lane] - base - gain * most(space[lane], 0.0));
        }
    }
    for (cost, worst) in costs.iter_mut().zip(&worst) {
        *cost += weight * worst;
    }
}
