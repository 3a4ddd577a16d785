//! Local planning: from a path, a map and a scan to the next velocity request.
//!
//! [`LocalPlanner`] is one control period: which goal is current ([`task`]), how old the inputs
//! are ([`staleness`]), the next twist ([`pilot`], by default with [`beam`]) and whether another
//! path is needed ([`requests`]). A new controller is a file plus a row in [`table`].
//!
//! The library is pure: no clock, no I/O, no threads; times are passed in, the same calls give
//! the same answers, and after the first periods nothing is allocated.

mod account;
pub mod beam;
mod behaviours;
pub mod config;
mod cost_to_go;
pub mod dwa;
pub mod dwa_t;
mod dynamic_obstacles;
mod explain;
mod field;
mod footprint;
mod inputs;
mod lanes;
mod local_path;
mod manoeuvre;
pub mod mppi;
mod obstruction;
mod outputs;
pub mod papers;
pub mod past_hits;
mod patience;
pub mod period;
pub mod pilot;
mod planned;
pub mod progress;
mod record;
pub mod recovery;
pub mod remembered;
pub mod requests;
mod rollout_scores;
pub mod scan_points;
mod seek_pose;
pub mod shaping;
pub mod situation;
mod squares;
pub mod staleness;
mod stall;
mod surroundings;
pub mod table;
pub mod task;
#[cfg(test)]
mod test_robot;
mod thin;
mod turn;
mod zone_speed;

pub use config::LocalPlannerConfig;
pub use inputs::{Inputs, PathInput};
pub use outputs::Outputs;
pub use period::LocalPlanner;
