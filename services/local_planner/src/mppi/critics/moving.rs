//! Contact with a tracked obstacle where it will be by then, with the radius that its uncertainty has
//! grown to. Never less than a third, so that the robot gives way as soon as it sees it coming.

use super::cycle::Cycle;
use crate::lanes::data::narrow;
use crate::lanes::strike;
use crate::mppi::batch::{Batch, LANES, Lanes};
use zeronav_casts::Cast;

/// [m] kept from predicted obstacles.
const MARGIN_M: f32 = 0.15;

/// [m] by which an overlap with a predicted disc is left at least.
const OVERLAP_M: f32 = 0.01;

pub(super) fn score(cycle: &Cycle<'_>, batch: &Batch, weight: f32, costs: &mut Lanes) {
    if cycle.dynamic.now().is_empty() {
        return;
    }
    let steps = batch.steps.to_f32();
    for (cost, struck) in costs.iter_mut().zip(&struck(cycle, batch)) {
        if struck.is_finite() {
            *cost += weight * (1.0 / 3.0 + 2.0 / 3.0 * (1.0 - struck / steps));
        }
    }
}

/// First step that is looked at in which each sample touches a predicted obstacle; infinite for none.
pub(crate) fn struck(cycle: &Cycle<'_>, batch: &Batch) -> Lanes {
    let robot_m = cycle.radius_m + MARGIN_M;
    let step_s = narrow(cycle.config.step_s);
    let fastest_mps = narrow(cycle.robot.v_mps_max.max(-cycle.robot.v_mps_min));
    let mut struck = [f32::INFINITY; LANES];
    for &step in &batch.looks {
        let discs = cycle.dynamic.at_step(step).iter().zip(cycle.dynamic.now());
        let reach_m = fastest_mps * step_s * (step.to_f32() + 1.0);
        for (disc, now) in discs {
            // Who overlaps the grown disc already must be able to leave it.
            let overlap = robot_m + now[2] - now[0].hypot(now[1]);
            let left = if overlap > 0.0 {
                overlap + OVERLAP_M
            } else {
                0.0
            };
            let radius = robot_m + disc[2] - left;
            let away = disc[0] * disc[0] + disc[1] * disc[1];
            if radius > 0.0 && away <= (reach_m + radius) * (reach_m + radius) {
                let disc = [disc[0], disc[1], radius];
                strike(
                    &batch.x[step],
                    &batch.y[step],
                    disc,
                    step.to_f32(),
                    &mut struck,
                );
            }
        }
    }
    struck
}
