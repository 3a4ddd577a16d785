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

/// Adds `weight` times the cost of every sample.
type Critic = fn(cycle: &Cycle<'_>, batch: &Batch, weight: f32, costs: &mut Lanes);

/// A cost term.
pub(crate) struct CriticRow {
    pub(crate) score: Critic,
    pub(crate) weight: fn(&CriticWeights) -> f64,
}

/// Every critic.
pub(crate) const CRITICS: &[CriticRow] = &[
    CriticRow {
        score: obstacles::score,
        weight: |weights| weights.obstacles,
    },
    CriticRow {
        score: clearance::score,
        weight: |weights| weights.clearance,
    },
    CriticRow {
        score: calm::score,
        weight: |weights| weights.calm,
    },
    CriticRow {
        score: moving::score,
        weight: |weights| weights.moving,
    },
    CriticRow {
        score: path_follow::score,
        weight: |weights| weights.path_follow,
    },
    CriticRow {
        score: path_align::score,
        weight: |weights| weights.path_align,
    },
    CriticRow {
        score: path_angle::score,
        weight: |weights| weights.path_angle,
    },
    CriticRow {
        score: goal::score,
        weight: |weights| weights.goal,
    },
    CriticRow {
        score: goal_angle::score,
        weight: |weights| weights.goal_angle,
    },
    CriticRow {
        score: prefer_forward::score,
        weight: |weights| weights.prefer_forward,
    },
    CriticRow {
        score: smooth::score,
        weight: |weights| weights.smooth,
    },
];
