//! The part of a result that compares mapping with the ground truth of the simulator.

use serde::{Deserialize, Serialize};

/// Where mapping said the robot was, scan by scan, against where it was.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct PoseResult {
    /// Scans that were compared.
    pub scans: usize,
    /// Largest distance of `map_from_odom * odom_from_base` from the true place. [m]
    pub error_m_max: f64,
    /// Root of its mean square. [m]
    pub error_m_rms: f64,
    /// Distance at the last scan. [m]
    pub error_m_last: f64,
    /// Largest error of the yaw. [rad]
    pub error_rad_max: f64,
    /// Error of the yaw at the last scan; older results are without. [rad]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub error_rad_last: Option<f64>,
    /// Whether the robot knew where it was at the last scan, and had that confirmed; older results are without.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub known_last: Option<bool>,
    /// How often the robot no longer knew where it was.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub lost: usize,
    /// True place and yaw of the robot at the last scan, `map` frame. [m, m, rad]
    pub true_pose_last: [f64; 3],
    /// Largest distance of the odometry alone from the true place. [m]
    pub odometry_error_m_max: f64,
}

#[allow(clippy::trivially_copy_pass_by_ref, reason = "as serde calls it")]
const fn is_zero(n: &usize) -> bool {
    *n == 0
}

/// How well mapping followed what moved.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct TrackingResult {
    /// Times a moving obstacle came into sight and was found.
    pub found: usize,
    /// Moving obstacles that were in sight for more than a second and not found.
    pub missed: usize,
    /// From the first scan with three beams on it to the first in which it is tracked, median. [s]
    pub detection_delay_s_median: Option<f64>,
    /// The longest. [s]
    pub detection_delay_s_max: Option<f64>,
    /// Root of the mean squared error of the velocity vector; null without a sample. [m/s]
    pub velocity_rmse_mps: Option<f64>,
    /// Samples of it.
    pub velocity_samples: usize,
    /// Tracks that were called moving where nothing moved, while they were seen.
    pub false_moving: usize,
    /// The same per minute of run time.
    pub false_moving_per_min: f64,
    /// Run time that was looked at. [s]
    pub duration_s: f64,
}
