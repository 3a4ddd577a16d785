//! A simulated differential-drive robot with a planar lidar, in a world of shapes and grid maps.
//!
//! Pure and deterministic: no clock, no I/O but the map file, no threads. Time comes in with
//! [`Simulator::step`], commands with [`Simulator::set_command`], and everything that the robot
//! would publish is asked for after a step. Same seed, same calls, same bits.
//!
//! ```text
//! set point -> delay -> drive (limits, exact arcs) -> slip -> contact (exact footprint) -> pose
//! wheels -> odometer (errors by distance and angle) -> odometry
//! pose + world + obstacles at every beam -> lidar (exact ranges) -> returns (seeded noise) -> scan
//! ```
//!
//! Geometry is parry's, in f64, and shared with launch and mapping through `zeronav-world`.

#![forbid(unsafe_code)]

pub mod bounce;
pub mod config;
pub mod contact;
pub mod delay;
pub mod describe;
pub mod drive;
mod drive_state;
pub mod faults;
pub mod history;
pub mod lidar;
pub mod noise;
pub mod obstacles;
pub mod odometer;
pub mod overlap;
mod phase;
mod placing;
pub mod ray;
pub mod returns;
pub mod scan_schedule;
pub mod simulator;
pub mod slip;
pub mod solid_grid;

pub use config::SimConfig;
pub use drive_state::DriveState;
pub use scan_schedule::DueScan;
pub use simulator::{SimError, Simulator};
