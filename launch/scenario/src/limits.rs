//! Bounds of the numbers in a scenario.

/// Largest coordinate of a pose. [m]
pub const COORDINATE_M_MAX: f64 = 1.0e6;

/// Largest yaw of a pose: ten turns. [rad]
pub const YAW_RAD_MAX: f64 = 62.8;

/// Longest run. [s]
pub const TIME_LIMIT_S_MAX: f64 = 1.0e6;

/// Smallest and largest tolerance of a goal. [m or rad]
pub const TOLERANCE: [f64; 2] = [1.0e-3, 1.0e3];
