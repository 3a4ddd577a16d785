//! What a robot is, as a scenario describes it: outline, limits, lidar, errors of wheels and odometry,
//! and faults by script; robots and lidars that one can buy as presets.
//!
//! How to read this crate: [`RobotSpec`] (`robot.rs`) and [`LidarSpec`] (`lidar.rs`) declare every
//! field once, with default, range and unit; the macro in `field.rs` makes of that what serde reads
//! and writes, the range check, and the parameters that `zeronav params robot` shows. [`RobotPreset`]
//! and [`LidarPreset`] are tables of data sheets, [`FaultSpec`] what breaks during a run.
//!
//! launch checks a scenario's robot with it, the simulator builds one of it. Pure: no files, no clock.

#![forbid(unsafe_code)]

mod faults;
mod field;
mod lidar;
mod robot;

pub use faults::{Begin, Blackout, FaultSpec};
pub use lidar::{Dropout, LidarPreset, LidarSpec};
pub use robot::{ACTUATION_DELAY_S_MAX, OdometrySpec, RobotPreset, RobotSpec, SLIP_MAX, SlipSpec};

/// Largest speed, acceleration, rate or range that a robot may have, in its SI unit.
const RATE_MAX: f64 = 1.0e3;

/// Smallest positive one.
const RATE_MIN: f64 = 1.0e-3;
