//! What is told of the samples, see [`crate::record`].

use super::batch::{Batch, LANES, Lanes};
use super::critics::cycle::Cycle;
use super::critics::moving::struck;
use crate::record::{DrawnRollout, Record};
use zeronav_casts::Cast;
use zeronav_msgs::rollouts::RolloutOutcome;

/// Tells the record of a judged batch.
pub(super) fn samples(record: &mut Record, cycle: &Cycle<'_>, batch: &Batch, costs: &Lanes) {
    let struck = struck(cycle, batch);
    for (lane, cost) in costs.iter().enumerate().take(LANES) {
        let seen = seen(batch, &struck, lane, *cost);
        record.offer(&seen, |step| (batch.x[step][lane], batch.y[step][lane]));
    }
}

/// Tells the record of the last batch: the `chosen` lane, and of `order`, the finalists that were
/// looked at until then, that they were not free.
pub(super) fn finalists(
    record: &mut Record,
    cycle: &Cycle<'_>,
    batch: &Batch,
    (order, chosen): ([usize; 4], Option<usize>),
    costs: &Lanes,
) {
    let struck = struck(cycle, batch);
    for lane in order {
        let place = |step: usize| (batch.x[step][lane], batch.y[step][lane]);
        let seen = seen(batch, &struck, lane, costs[lane]);
        if chosen == Some(lane) {
            record.lead(&seen, place);
            break;
        }
        let outcome = RolloutOutcome::NoStop;
        record.offer(&DrawnRollout { outcome, ..seen }, place);
    }
}

fn seen(batch: &Batch, struck: &Lanes, lane: usize, cost: f32) -> DrawnRollout {
    let end = batch.steps;
    let [hit, struck] = [batch.hit[lane], struck[lane]].map(|mark| first_step(mark, end));
    let outcome = if hit.min(struck) == end {
        RolloutOutcome::Costlier
    } else if struck < hit {
        RolloutOutcome::MovingCollision
    } else {
        RolloutOutcome::Collision
    };
    DrawnRollout {
        twist: (batch.v[0][lane], batch.w[0][lane]),
        cost,
        outcome,
        steps: (hit.min(struck) + 1).min(end),
    }
}

/// The step that a sample was marked with, `end` when it was not.
fn first_step(mark: f32, end: usize) -> usize {
    mark.to_usize().min(end)
}
