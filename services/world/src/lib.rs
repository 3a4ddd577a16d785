//! Worlds as data: what a scenario says about them, ROS map files, and the questions
//! that launch, the simulator and mapping ask of them.
//!
//! This is a library, not a service: it knows no process and no clock. The simulator moves things
//! through the world it describes, launch refuses scenarios that cannot work before anything is
//! started, and mapping reads its static map with it, so all three read the same file the same
//! way.
//!
//! Shapes and distances are parry's, in f64 ([`convex`]).

#![forbid(unsafe_code)]

pub mod barn;
pub mod convex;
pub mod dynabarn;
pub mod error;
pub mod footprint;
pub mod free_pose;
pub mod generate;
pub mod map_file;
mod map_file_error;
mod map_image;
pub mod movingai_map;
mod parry_pose;
pub mod pedestrians;
mod polygon;
mod raster;
mod rectangles;
pub mod shape;
pub mod spec;
pub mod static_map;
pub mod synthetic;
pub mod table;
pub mod track;
pub mod tracking_score;
pub mod world;

pub use convex::Convex;
pub use error::SpecError;
pub use footprint::Footprint;
pub use free_pose::Tolerance;
pub use map_file::{LoadedMap, MapWarning};
pub use map_file_error::MapFileError;
pub use parry_pose::parry_pose;
pub use polygon::POLYGON_CORNERS_MAX;
pub use shape::Shape;
pub use spec::{ObstacleSpec, ShapeSpec, WorldSpec};
pub use static_map::{Occupancy, StaticMap};
pub use table::DataError;
pub use tracking_score::{TrackingReport, TrackingScore};
pub use world::{Obstacle, World, WorldError};
