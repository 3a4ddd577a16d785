//! The files that worlds come from, read with a ceiling and validated line by line.
//!
//! How to read this crate: [`load`] makes the world of a scenario's words; each source of worlds is a
//! module: [`map_file`] (ROS `map_server`), `movingai_map`, [`barn`], [`dynabarn`], [`pedestrians`].
//! [`mask`] reads what a costmap filter asks for as parts of zones.
//! [`synthetic`] draws worlds of the same kinds from a seed, for tests and the generated suite.
//!
//! No processes, no clock, no threads; it is the one library that reads files.

#![forbid(unsafe_code)]

pub mod barn;
pub mod dynabarn;
mod load;
pub mod map_file;
mod map_file_error;
mod map_image;
pub mod mask;
mod movingai_map;
pub mod pedestrians;
mod pgm;
mod pixels;
pub mod synthetic;
mod table;

pub use load::{WorldError, load};
pub use map_file::{LoadedMap, MapWarning};
pub use map_file_error::MapFileError;
pub use table::DataError;
