//! The words of a scenario for world and robot. Metres, radians, seconds, `map` frame.

use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// The world: a map file, or an area with shapes, or both; and what happens in it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WorldSpec {
    /// ROS `map_server` YAML of the static world.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub map: Option<PathBuf>,
    /// Lower left corner `[x, y]` and upper right corner `[x, y]` of the area. [m] Required
    /// without a map file, refused with one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub area_m: Option<[[f64; 2]; 2]>,
    /// Cell size with which shapes are drawn into a map. [m] A map file brings its own.
    #[serde(default = "default_resolution_m")]
    pub resolution_m: f64,
    /// Walls and other things that never move and stand on the static map.
    #[serde(default)]
    pub shapes: Vec<ShapeSpec>,
    /// Things that appear, move and vanish and stand on no map.
    #[serde(default)]
    pub obstacles: Vec<ObstacleSpec>,
}

fn default_resolution_m() -> f64 {
    0.05
}

/// A shape in its own frame; `centre_m` places it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum ShapeSpec {
    /// A rectangle.
    Box {
        /// Centre `[x, y]`. [m]
        centre_m: [f64; 2],
        /// Full side lengths `[along x, along y]` before the turn. [m]
        size_m: [f64; 2],
        /// Turn, counter-clockwise. [rad]
        #[serde(default)]
        yaw_rad: f64,
    },
    /// A disc.
    Disc {
        /// Centre `[x, y]`. [m]
        centre_m: [f64; 2],
        /// Radius. [m]
        radius_m: f64,
    },
    /// A convex polygon.
    Polygon {
        /// Corners `[x, y]`, 3 to 256, either way around. [m]
        corners_m: Vec<[f64; 2]>,
    },
}

/// A scripted obstacle. Where its shape says is where it appears.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ObstacleSpec {
    /// For reports; unique.
    pub name: String,
    /// Its shape and where it appears.
    pub shape: ShapeSpec,
    /// When it appears; without, it is there from the start.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub appears: Option<Trigger>,
    /// How long it stays; without, to the end. [s]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lasts_s: Option<f64>,
    /// Points `[x, y]` that its centre (of a polygon: its centroid) visits in turn after it appeared, at `speed_mps`. [m]
    #[serde(default)]
    pub waypoints_m: Vec<[f64; 2]>,
    /// Speed along the waypoints. [m/s]
    #[serde(default)]
    pub speed_mps: f64,
    /// Start again at the first waypoint after the last instead of standing there.
    #[serde(default)]
    pub repeat: bool,
}

/// What makes an obstacle appear. Exactly one of the two.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Trigger {
    /// Run time. [s]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub at_s: Option<f64>,
    /// The robot's centre comes near a point.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub robot_near: Option<Near>,
}

/// Within `distance_m` of `point_m`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Near {
    /// `[x, y]`. [m]
    pub point_m: [f64; 2],
    /// Distance of the robot's centre. [m]
    pub distance_m: f64,
}

/// The robot: outline, limits, lidar. The simulator turns it into `robot/description`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RobotSpec {
    /// Radius of a round footprint. [m] Exactly one of this and `footprint_m`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub radius_m: Option<f64>,
    /// Corners `[x, y]` of a convex footprint around the origin of `base`, counter-clockwise. [m]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub footprint_m: Option<Vec<[f64; 2]>>,
    /// Fastest forward speed. [m/s]
    pub v_mps_max: f64,
    /// Fastest backward speed as a number <= 0. [m/s]
    #[serde(default)]
    pub v_mps_min: f64,
    /// Fastest yaw rate. [rad/s]
    pub w_radps_max: f64,
    /// Largest acceleration. [m/s^2]
    pub a_mps2_max: f64,
    /// Braking that can be relied on; without, `a_mps2_max`. [m/s^2]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub brake_mps2: Option<f64>,
    /// Largest yaw acceleration. [rad/s^2]
    pub alpha_radps2_max: f64,
    /// Age of the last command from which the robot brakes by itself. [s]
    #[serde(default = "default_command_timeout_s")]
    pub command_timeout_s: f64,
    /// The lidar.
    pub lidar: LidarSpec,
}

fn default_command_timeout_s() -> f64 {
    0.2
}

/// A planar lidar.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LidarSpec {
    /// `base_from_laser` as `[x, y, yaw]`. [m, m, rad]
    #[serde(default)]
    pub pose: [f64; 3],
    /// Beams of a turn.
    pub n_beams: u32,
    /// Field of view, 2 pi = all around. [rad] Beams lie evenly in it; all around, the last beam
    /// is one step before the first.
    #[serde(default = "default_fov_rad")]
    pub fov_rad: f64,
    /// Turns per second. [Hz]
    pub rate_hz: f64,
    /// Closest range. [m]
    pub range_m_min: f64,
    /// Farthest range. [m]
    pub range_m_max: f64,
    /// Standard deviation of a range. [m]
    #[serde(default)]
    pub sigma_m: f64,
}

fn default_fov_rad() -> f64 {
    core::f64::consts::TAU
}
