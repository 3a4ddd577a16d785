//! Mapping: what the lidar sees and what is known beforehand become the map that planners use.
//!
//! A scan goes through four stages, each in its file: [`belief`] decides which cells are obstacles,
//! [`clearance`] keeps the exact distance to them, [`cell_value`] turns distances into costs, and
//! [`tiles`] remembers what changed. [`mapper::Mapper`] is the four in a row. Everything here is
//! pure: no clock, no files, no threads, no processes.
//!
//! Coordinates are those of the map: metres in the `map` frame, cells as columns and rows.

pub mod belief;
pub mod cell_value;
pub mod clearance;
pub mod config;
pub mod mapper;
pub mod ray;
pub mod tiles;

pub use config::{LogOdds, MappingConfig, MappingError};
pub use mapper::{Integrated, Mapper};
pub use tiles::{TileIndex, all_tiles};
