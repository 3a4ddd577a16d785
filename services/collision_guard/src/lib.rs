//! The guard between the local planner and the wheels.
//!
//! It sees only the robot's description, the raw scan, odometry and the request, shares no state
//! with the planners and passes a request on only while every one of its inputs is present,
//! well-formed and young enough. Whatever goes wrong becomes a ramp to rest at the deceleration
//! that braking can rely on, with the reason in the command.
//!
//! **What it does not do.** It does not yet compare the braking arc with the points of the scan:
//! that an arc is free is checked by the author of the request alone. The scan is required here
//! because a robot whose lidar is silent must not move, not because its points are looked at.
//! This is not a certified safety function.
//!
//! The library is pure: no clock, no I/O, no threads, no allocation. Ages and periods are passed
//! in, so a recorded run gives the same commands again.

mod config;
mod guard;
mod limits;

pub use config::{ConfigError, GuardConfig};
pub use guard::{Guard, GuardInputs};
pub use limits::{Limits, Twist};
