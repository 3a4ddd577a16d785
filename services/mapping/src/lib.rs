//! Mapping: scans, odometry and a static map become the map that planners read.
//!
//! How to read this crate: start with [`Mapping::take_in`], which is one scan from top to bottom, and
//! follow it into the file of the stage you are interested in.
//!
//! | stage | files | result |
//! |---|---|---|
//! | deskew | [`beams`] | beams in `base` at the time of capture |
//! | localise | [`localiser`]; `scan_odometry`, `near_points`, `slip`: against a key scan; `scan_match`, `hit_means`, `scan_search`, `surface_candidates`: against the map; `pose_error` | `map_from_odom` with its covariance |
//! | relocalise | `lost`, `explained`: whether the robot is lost; `relocaliser`, `places`, `global_search`, `search_map`: where on the map it is; [`localisation`] | the pose of a robot that did not know it |
//! | track | [`tracker`]; `clusters`, `fit`, `form`: what was seen; `track`, `kalman`: what is known of it; `past_scans`: whether it moved; `true_motion`: what the simulator says instead | dynamic obstacles |
//! | decide | `belief`, `log_odds`, `flips`; `located_scan`, [`ray`], `free_blocks`: which cells beams pass; `isolated`: false returns; `outline`: the cells under the robot | which cells are obstacles |
//! | measure | [`clearance`]; `cell_value`: costs | clearance and cost of every cell |
//! | flag | [`regularise`], [`virtual_obstacles`] | cells that some planners avoid |
//! | close | `zone_paint` | cells of keepout zones, and what others cost |
//! | publish | `tiles`; [`window`]: where the map lies | the tiles that changed |
//!
//! [`Mapper`] is the map itself, [`Mapping`] the map with pose and tracks, [`MappingConfig`] what a
//! user may set; each group of options is declared in the file of its stage. Everything is pure: no
//! clock, no files, no threads, no processes; `main.rs` is the process around it.
//!
//! Units are SI and in the names; coordinates are metres in the frame `map`, cells are columns and
//! rows of the grid, indices are row-major.

pub mod beams;
mod belief;
mod cell_value;
pub mod clearance;
mod clusters;
mod config;
mod error;
mod explained;
mod fit;
mod flips;
mod form;
mod free_blocks;
mod global_search;
mod hit_means;
mod isolated;
mod kalman;
pub mod localisation;
pub mod localiser;
mod located_scan;
mod log_odds;
mod lost;
mod mapper;
mod mapping;
mod moved;
mod near_points;
mod outline;
mod past_scans;
mod places;
mod pose_error;
pub mod ray;
pub mod regularise;
mod relocaliser;
mod rows_around;
mod scan_match;
mod scan_odometry;
mod scan_search;
mod search_map;
mod slip;
mod surface_candidates;
mod tiles;
mod track;
pub mod tracker;
mod true_motion;
pub mod virtual_obstacles;
pub mod window;
mod zone_paint;

pub use config::MappingConfig;
pub use error::MappingError;
pub use flips::Integrated;
pub use log_odds::LogOdds;
pub use mapper::Mapper;
pub use mapping::{Mapping, Observation};
pub use relocaliser::Sought;
pub use tiles::{TileIndex, all_tiles};
pub use true_motion::TrueMotion;
