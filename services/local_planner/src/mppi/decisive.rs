//! Which critic decided against a faster motion, to explain it. Nothing is decided by it.

use super::batch::{Batch, LANES};
use super::critics::CRITICS;
use super::critics::cycle::Cycle;
use super::options::CriticWeights;
use crate::lanes::data::narrow;
use zeronav_msgs::command::RequestCause;

/// The critic that speaks most for the `chosen` lane of a judged batch and against the `fastest`;
/// `None` when no faster motion was looked at.
pub(super) fn decisive(
    cycle: &Cycle<'_>,
    batch: &Batch,
    weights: &CriticWeights,
    (chosen, fastest): (usize, usize),
) -> Option<RequestCause> {
    if batch.v[0][chosen] >= batch.v[0][fastest] {
        return None;
    }
    let costs = CRITICS.iter().map(|critic| {
        let mut costs = [0.0; LANES];
        (critic.score)(cycle, batch, narrow((critic.weight)(weights)), &mut costs);
        (critic.cause, costs[chosen], costs[fastest])
    });
    Some(most_against(costs))
}

/// Of causes with what they cost a motion and a faster one, the one by which the faster one costs
/// most more. When it costs less in all, it was not free for as long as a stop lasts.
fn most_against(costs: impl Iterator<Item = (RequestCause, f32, f32)>) -> RequestCause {
    let mut against = [(RequestCause::None, 0.0); CRITICS.len()];
    for (cause, chosen, faster) in costs {
        let free =
            |(known, _): &&mut (RequestCause, f32)| *known == cause || *known == RequestCause::None;
        if let Some(sum) = against.iter_mut().find(free) {
            *sum = (cause, sum.1 + faster - chosen);
        }
    }
    if against.iter().map(|(_, more)| more).sum::<f32>() <= 0.0 {
        return RequestCause::StoppingDistance;
    }
    let most = against.into_iter().max_by(|a, b| a.1.total_cmp(&b.1));
    most.map_or(RequestCause::Critics, |(cause, _)| cause)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_cause_whose_critics_cost_a_faster_motion_most_is_named() {
        let costs = [
            (RequestCause::ClearanceCritic, 0.1, 0.5),
            (RequestCause::ClearanceCritic, 0.0, 0.4),
            (RequestCause::PathCritic, 0.2, 0.9),
            (RequestCause::ProgressCritic, 1.0, 0.2),
        ];
        let named = most_against(costs.into_iter());
        assert_eq!(named, RequestCause::ClearanceCritic, "0.4 and 0.4 are more");
        let named = most_against(costs.into_iter().skip(1));
        assert_eq!(named, RequestCause::PathCritic, "0.7 is more than 0.4");
    }

    #[test]
    fn a_faster_motion_that_costs_less_was_not_free() {
        let costs = [
            (RequestCause::ClearanceCritic, 0.1, 0.3),
            (RequestCause::ProgressCritic, 1.0, 0.2),
        ];
        let named = most_against(costs.into_iter());
        assert_eq!(named, RequestCause::StoppingDistance);
    }
}
