//! Mapping: what the lidar sees and what is known beforehand become the map that planners use.
//!
//! A scan goes through these stages, each in its file. [`beams`] straightens it, [`localiser`]
//! finds where it was seen from ([`scan_match`]), [`tracker`] finds what moves in it ([`clusters`],
//! [`fit`], [`kalman`], [`track`], [`past_scans`]), [`belief`] decides which cells are obstacles
//! ([`ray`], [`settled`], [`outline`]), [`clearance`] keeps the exact distance to them,
//! [`cell_value`] turns distances into costs, [`regularise`] and [`virtual_obstacles`] flag cells
//! for planners that want them, and [`tiles`] remembers what changed. [`mapper::Mapper`] is the
//! map, [`mapping::Mapping`] is everything in a row; [`window`] decides where the map lies.
//! Everything here is pure: no clock, no files, no threads, no processes.
//!
//! Coordinates are those of the map: metres in the `map` frame, cells as columns and rows.

pub mod beams;
pub mod belief;
pub mod cell_value;
pub mod clearance;
pub mod clusters;
pub mod config;
mod error;
pub mod fit;
pub mod form;
pub mod kalman;
pub mod localiser;
mod log_odds;
pub mod mapper;
pub mod mapping;
mod near_points;
pub mod outline;
pub mod past_scans;
mod pose_error;
pub mod ray;
pub mod regularise;
pub mod scan_match;
mod scan_odometry;
pub mod settled;
mod settling;
pub mod tiles;
pub mod track;
pub mod tracker;
pub mod virtual_obstacles;
pub mod window;

pub use config::MappingConfig;
pub use error::MappingError;
pub use log_odds::LogOdds;
pub use mapper::{Integrated, Mapper};
pub use mapping::{Mapping, Observation};
pub use tiles::{TileIndex, all_tiles};
