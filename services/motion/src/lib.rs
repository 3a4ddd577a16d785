//! Body and motion of a differential-drive robot: what a velocity is, what the acceleration limits
//! allow, how a stop unfolds.
//!
//! Start with [`Twist`]: a forward speed and a yaw rate, and the exact arc that it drives.
//! [`reachable`] and [`towards_rest`] are the acceleration limits of a
//! [`Description`](zeronav_msgs::description::Description); [`stop_distance_m`] and
//! [`stop_angle_rad`] are closed forms, [`Stop`] gives the poses on the way to rest.
//!
//! The crate is pure: no clock, no I/O, no threads, no allocation.

mod limits;
mod stop;
mod twist;

pub use limits::{reachable, towards_rest};
pub use stop::{Stop, stop_angle_rad, stop_distance_m};
pub use twist::{Twist, sinc};
