//! Nearness to static obstacles, quadratic within the soft clearance and dearer at speed: its worst
//! moment. A goal beside a wall must be reached, so it counts less and less on the last metre.

use super::cycle::Cycle;
use crate::lanes::data::{least, most, narrow};
use crate::mppi::batch::{Batch, LANES, Lanes};

pub(super) fn score(cycle: &Cycle<'_>, batch: &Batch, weight: f32, costs: &mut Lanes) {
    let weight = weight * cycle.remaining_m.min(1.0);
    let hard_m = cycle.need_m.clamp(0.0, 0.9 * cycle.soft_m);
    let inverse = 1.0 / (cycle.soft_m - hard_m).max(1.0e-3);
    let per_speed = 0.7 / narrow(cycle.robot.v_mps_max);
    let mut worst = [0.0; LANES];
    for &step in &batch.looks {
        let (space, v) = (&batch.space[step], &batch.v[step]);
        for lane in 0..LANES {
            let near = most(least((cycle.soft_m - space[lane]) * inverse, 1.0), 0.0);
            let price = near * near * (0.3 + per_speed * v[lane].abs());
            worst[lane] = most(worst[lane], price);
        }
    }
    for (cost, worst) in costs.iter_mut().zip(&worst) {
        *cost += weight * worst;
    }
}
