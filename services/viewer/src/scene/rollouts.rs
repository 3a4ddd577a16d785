//! Motions that the local planner looked at.

use super::numbers::{Rounded, point};
use serde::Serialize;
use zeronav_msgs::rollouts::{Rollout, RolloutOutcome};

/// A rollout: why it was not chosen, cost, speed, yaw rate, points.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SceneRollout(&'static str, Rounded, Rounded, Rounded, Vec<[Rounded; 2]>);

impl SceneRollout {
    /// One of `debug/rollouts`.
    #[must_use]
    pub fn of(rollout: &Rollout) -> Self {
        let points = rollout.points_m();
        Self(
            rollout.outcome().map_or("unknown", RolloutOutcome::label),
            Rounded::thousandths(f64::from(rollout.cost)),
            Rounded::thousandths(f64::from(rollout.v_mps)),
            Rounded::angle(f64::from(rollout.w_radps)),
            points
                .map(|[x, y]| point(f64::from(x), f64::from(y)))
                .collect(),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_that_are_not_there_are_not_written() {
        let mut rollout = Rollout {
            v_mps: 0.25,
            cost: -1.5,
            outcome: RolloutOutcome::NoStop.code(),
            n_points: 2,
            ..Rollout::default()
        };
        rollout.x_m[1] = 1.000_6;
        let text = serde_json::to_string(&SceneRollout::of(&rollout)).expect("JSON");
        assert_eq!(text, r#"["no_stop",-1.5,0.25,0,[[0,0],[1.001,0]]]"#);
    }
}
