//! What a sample costs: one term per file, in metres of progress.
//!
//! A critic adds its cost to that of every sample of a batch. A new one is a file, a row of
//! [`CRITICS`] and a weight in [`CriticWeights`].

mod calm;
mod clearance;
mod goal;
mod goal_angle;
mod moving;
mod obstacles;
mod path_align;
mod path_angle;
mod path_follow;
mod prefer_forward;
mod smooth;

use crate::cost_to_go::CostToGo;
use crate::dynamic_obstacles::DynamicObstacles;
use crate::local_path::LocalPath;
use crate::mppi::batch::{Batch, Lanes};
use crate::mppi::options::{CriticWeights, MppiConfig};
use nalgebra::Point2;
use zeronav_msgs::description::Description;

/// What the samples of a cycle are judged by.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Cycle<'a> {
    pub(crate) robot: &'a Description,
    pub(crate) config: &'a MppiConfig,
    /// [m] disc around the origin that holds the outline.
    pub(crate) radius_m: f32,
    /// [m] around the outline in which nearness costs, and what must be kept.
    pub(crate) soft_m: f32,
    pub(crate) need_m: f32,
    pub(crate) path: &'a LocalPath,
    /// Cost-to-go and what is to go from here. [m]
    pub(crate) cost_to_go: Option<(&'a CostToGo, Option<f32>)>,
    /// Where the robot is in the map.
    pub(crate) here: Point2<f64>,
    /// Predictions at the ends of the steps.
    pub(crate) dynamic: &'a DynamicObstacles,
    /// The goal relative to the robot, along the axes of the map. [m]
    pub(crate) goal: (f32, f32),
    /// Cosine and sine of the goal's yaw, where one is asked for.
    pub(crate) goal_heading: Option<(f32, f32)>,
    /// [m] along the path to its end.
    pub(crate) remaining_m: f32,
}

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
