//! Changes of the yaw rate and of the speed, as shares of their largest values, summed up.

use super::cycle::Cycle;
use crate::lanes::data::narrow;
use crate::mppi::batch::{Batch, LANES, Lanes};

/// What a change of speed counts beside one of the yaw rate.
const SPEED_SHARE: f32 = 0.5;

pub(super) fn score(cycle: &Cycle<'_>, batch: &Batch, weight: f32, costs: &mut Lanes) {
    let per_w = 1.0 / narrow(cycle.robot.w_radps_max);
    let per_v = SPEED_SHARE / narrow(cycle.robot.v_mps_max);
    let mut changes = [0.0; LANES];
    for step in 1..batch.steps {
        let (v0, v1) = (&batch.v[step - 1], &batch.v[step]);
        let (w0, w1) = (&batch.w[step - 1], &batch.w[step]);
        for lane in 0..LANES {
            changes[lane] +=
                (w1[lane] - w0[lane]).abs() * per_w + (v1[lane] - v0[lane]).abs() * per_v;
        }
    }
    for (cost, changes) in costs.iter_mut().zip(&changes) {
        *cost += weight * changes;
    }
}
