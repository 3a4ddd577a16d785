//! Speed by clearance: a metre per second beyond what the space allows costs the weight.

use super::cycle::Cycle;
use crate::lanes::data::most;
use crate::mppi::batch::{Batch, LANES, Lanes};

/// [m/s] that cost nothing however near obstacles are; below that of `dwa_t`.
const BASE_MPS: f32 = 0.5;

/// [1/s] speed that costs nothing in addition, per metre of free space around the footprint.
const GAIN_HZ: f32 = 6.0;

pub(super) fn score(_: &Cycle<'_>, batch: &Batch, weight: f32, costs: &mut Lanes) {
    let mut worst = [0.0; LANES];
    for &step in &batch.looks {
        let (space, v) = (&batch.space[step], &batch.v[step]);
        for lane in 0..LANES {
            worst[lane] = most(
                worst[lane],
                v[lane] - BASE_MPS - GAIN_HZ * most(space[lane], 0.0),
            );
        }
    }
    for (cost, worst) in costs.iter_mut().zip(&worst) {
        *cost += weight * worst;
    }
}
