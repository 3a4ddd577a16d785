//! What a sample costs: one term per file, in metres of progress.
//!
//! A critic adds its cost to that of every sample of a batch. A new one is a file, a row of
//! [`CRITICS`] and a weight in [`CriticWeights`].

mod calm;
mod clearance;
pub(crate) mod cycle;
mod goal;
mod goal_angle;
pub(crate) mod moving;
mod obstacles;
mod path_align;
mod path_angle;
mod path_follow;
mod prefer_forward;
mod smooth;

use crate::mppi::batch::{Batch, Lanes};
use crate::mppi::options::CriticWeights;
use cycle::Cycle;
use zeronav_msgs::command::RequestCause;

/// Adds `weight` times the cost of every sample.
type Critic = fn(cycle: &Cycle<'_>, batch: &Batch, weight: f32, costs: &mut Lanes);

/// A cost term.
pub(crate) struct CriticRow {
    pub(crate) score: Critic,
    pub(crate) weight: fn(&CriticWeights) -> f64,
    /// What is told when it decided.
    pub(crate) cause: RequestCause,
}

/// Every critic.
pub(crate) const CRITICS: &[CriticRow] = &[
    CriticRow {
        score: obstacles::score,
        weight: |weights| weights.obstacles,
        cause: RequestCause::ClearanceCritic,
    },
    CriticRow {
        score: clearance::score,
        weight: |weights| weights.clearance,
        cause: RequestCause::ClearanceCritic,
    },
    CriticRow {
        score: calm::score,
        weight: |weights| weights.calm,
        cause: RequestCause::ClearanceCritic,
    },
    CriticRow {
        score: moving::score,
        weight: |weights| weights.moving,
        cause: RequestCause::DynamicObstacleCritic,
    },
    CriticRow {
        score: path_follow::score,
        weight: |weights| weights.path_follow,
        cause: RequestCause::ProgressCritic,
    },
    CriticRow {
        score: path_align::score,
        weight: |weights| weights.path_align,
        cause: RequestCause::PathCritic,
    },
    CriticRow {
        score: path_angle::score,
        weight: |weights| weights.path_angle,
        cause: RequestCause::PathCritic,
    },
    CriticRow {
        score: goal::score,
        weight: |weights| weights.goal,
        cause: RequestCause::ProgressCritic,
    },
    CriticRow {
        score: goal_angle::score,
        weight: |weights| weights.goal_angle,
        cause: RequestCause::PathCritic,
    },
    CriticRow {
        score: prefer_forward::score,
        weight: |weights| weights.prefer_forward,
        cause: RequestCause::Critics,
    },
    CriticRow {
        score: smooth::score,
        weight: |weights| weights.smooth,
        cause: RequestCause::SmoothnessCritic,
    },
];
