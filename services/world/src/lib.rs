//! Worlds as data: what a scenario says about them, and the questions that launch, the simulator and
//! mapping ask of them.
//!
//! How to read this crate: [`WorldSpec`] (`spec.rs`) are the words of a scenario, [`World`] (`world.rs`)
//! answers what is solid and how far away it is. Shapes and distances are parry's, in f64: [`Convex`],
//! [`Shape`], [`Footprint`]; `rectangles.rs` and `raster.rs` go from cells to shapes and back,
//! [`generate`] draws random maps, `free_pose.rs` looks for room at a goal, `largest_room.rs` for the room of a whole map.
//!
//! Pure: no files, no processes, no clock. Files are read by the crate `zeronav-world-files`.

#![forbid(unsafe_code)]

pub mod convex;
pub mod error;
pub mod footprint;
pub mod free_pose;
pub mod generate;
mod largest_room;
mod parry_pose;
mod polygon;
mod raster;
mod rectangles;
pub mod shape;
pub mod spec;
pub mod static_map;
pub mod track;
pub mod world;

pub use convex::Convex;
pub use error::SpecError;
pub use footprint::Footprint;
pub use free_pose::Tolerance;
pub use parry_pose::parry_pose;
pub use polygon::POLYGON_CORNERS_MAX;
pub use shape::Shape;
pub use spec::{ObstacleSpec, ShapeSpec, WorldSpec};
pub use static_map::{Occupancy, StaticMap};
pub use world::{Obstacle, World};
