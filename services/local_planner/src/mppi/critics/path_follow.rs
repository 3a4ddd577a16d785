//! What is left of the way: along the path from the last place before a contact, or by the free way
//! where that is longer (a dead end beside the path is no progress). Half of it counts half way, so
//! that being there early is better where all arrive.

use super::cycle::Cycle;
use crate::lanes::data::{least, narrow};
use crate::mppi::batch::{Batch, Lanes};
use nalgebra::Point2;

/// [m] by which the free way may be longer than the way along the path before it counts.
const DEAD_END_M: f32 = 0.3;

pub(super) fn score(cycle: &Cycle<'_>, batch: &Batch, weight: f32, costs: &mut Lanes) {
    let ahead = narrow(cycle.path.ahead_m);
    for (lane, cost) in costs.iter_mut().enumerate() {
        let last = batch.free[lane] - 1;
        let mut progress = batch.projections[last].along[lane];
        if let Some((cost_to_go, Some(now))) = cycle.cost_to_go {
            let step = batch.station(last);
            let at = Point2::new(
                cycle.here.x + f64::from(batch.x[step][lane]),
                cycle.here.y + f64::from(batch.y[step][lane]),
            );
            let nearer = cost_to_go.at(at).map_or(progress, |then| now - then);
            if nearer < progress - DEAD_END_M {
                progress = nearer;
            }
        }
        let half = batch.projections[last / 2].along[lane];
        *cost += weight * (ahead - 0.5 * (progress + least(progress, half)));
    }
}
