//! Heading against the path: one less the cosine of the angle, on average.

use super::cycle::Cycle;
use crate::mppi::batch::{Batch, Lanes};
use zeronav_casts::Cast;

pub(super) fn score(_: &Cycle<'_>, batch: &Batch, weight: f32, costs: &mut Lanes) {
    for (lane, cost) in costs.iter_mut().enumerate() {
        let free = batch.free[lane];
        let mut sum = 0.0;
        for (index, station) in batch.projections[..free].iter().enumerate() {
            let step = batch.station(index);
            let (x, y) = (station.direction_x[lane], station.direction_y[lane]);
            // A path that is a single point has no direction.
            if (x, y) != (0.0, 0.0) {
                sum += 1.0 - (batch.cos[step][lane] * x + batch.sin[step][lane] * y);
            }
        }
        *cost += weight * sum / free.to_f32();
    }
}
