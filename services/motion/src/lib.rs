//! Body and motion of a differential-drive robot: what a velocity is, what the acceleration limits
//! allow, how a stop unfolds.
//!
//! Start with [`Twist`]: a forward speed and a yaw rate, and the exact arc that it drives.
//! [`reachable`] and [`towards_rest`] are the acceleration limits of a
//! [`Description`](zeronav_msgs::description::Description); [`stop_distance_m`] and
//! [`stop_angle_rad`] are closed forms, [`Stop`] gives the poses on the way to rest. [`InFlight`] knows
//! where a robot will be when a command that is sent now takes effect.
//!
//! The crate is pure: no clock, no I/O, no threads, and no allocation once an [`InFlight`] is made.

mod in_flight;
mod limits;
mod stop;
mod twist;

pub use in_flight::{Ahead, InFlight};
pub use limits::{reachable, towards_rest};
pub use stop::{Stop, stop_angle_rad, stop_distance_m};
pub use twist::{Twist, sinc};
