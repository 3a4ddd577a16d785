//! The guard between the local planner and the wheels.
//!
//! It sees only the robot's description, the raw scan, odometry and the request, shares no state
//! with the planners and passes a request on only while every one of its inputs is present,
//! well-formed and young enough and the robot could still stop: the way that it takes when it
//! obeys for the reaction time and then brakes must be free of the raw points of the last two
//! scans, with the true footprint. Otherwise the request is slowed down on its arc, or becomes a
//! ramp to rest at the deceleration that braking can rely on, with the reason in the command.
//!
//! This is not a certified safety function. The README says what it does not see.
//!
//! The library is pure: no clock, no I/O, no threads, no allocation after the first scan but when zones
//! change or the robot is near a keepout zone. Ages and
//! periods are passed in, so a recorded run gives the same commands again.

mod blindness;
mod config;
mod dust;
mod explain;
mod guard;
mod hits;
mod in_flight;
mod limits;
mod outline;
mod ramp;
mod sweep;
mod swept;
mod verdict;
mod view;
mod watch;
mod zones;

pub use config::GuardConfig;
pub use guard::{Guard, GuardInputs, OdometryInput, ScanInput};
pub use limits::Limits;
