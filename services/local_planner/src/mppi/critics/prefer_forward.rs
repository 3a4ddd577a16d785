//! Metres driven backwards.

use super::cycle::Cycle;
use crate::lanes::data::{most, narrow};
use crate::mppi::batch::{Batch, LANES, Lanes};

pub(super) fn score(cycle: &Cycle<'_>, batch: &Batch, weight: f32, costs: &mut Lanes) {
    let mut backwards = [0.0; LANES];
    for v in &batch.v[..batch.steps] {
        for (sum, v) in backwards.iter_mut().zip(v) {
            *sum += most(-v, 0.0);
        }
    }
    let weight = weight * narrow(cycle.config.step_s);
    for (cost, sum) in costs.iter_mut().zip(&backwards) {
        *cost += weight * sum;
    }
}
