//! What the critics know of a cycle.

use crate::cost_to_go::CostToGo;
use crate::dynamic_obstacles::DynamicObstacles;
use crate::local_path::LocalPath;
use crate::mppi::options::MppiConfig;
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
