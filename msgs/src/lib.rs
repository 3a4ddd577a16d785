//! The contract between the processes of zeronav.
//!
//! Whatever two processes would otherwise misread is defined here and nowhere else: the names of the
//! topics, the layout and meaning of every message, what an identity is, who is obeyed, how a
//! map arrives whole at the other end, and how a robot leaves the inflation. A service in any language needs this crate (or a copy of
//! these layouts), the flags of the shell and an exit code; nothing else is shared.
//!
//! Every message is `#[repr(C)]`, free of padding and made of plain numbers, so its bytes can be
//! hashed, recorded and checked. Nothing that was received is believed before
//! [`topics::decode`] has accepted it.
//!
//! Units are SI, frames follow REP-103 and REP-105 (x forward, y left, yaw counter-clockwise,
//! `map` -> `odom` -> `base` -> `laser`), times are nanoseconds.

pub mod certainty;
pub mod checksum;
pub mod command;
pub mod description;
pub mod escape;
pub mod fields;
pub mod foresight;
pub mod grid;
pub mod header;
pub mod health;
pub mod labels;
pub mod map;
pub mod message;
pub mod obstacles;
pub mod odometry;
pub mod path;
pub mod pose;
pub mod replica;
pub mod request;
pub mod role;
pub mod rollouts;
mod row;
pub mod run;
pub mod scan;
pub mod seats;
pub mod span;
pub mod stages;
mod stamp;
pub mod task;
pub mod time;
pub mod topics;
pub mod truth;
pub mod user;
pub mod way_out;
pub mod window;
pub mod zone_marks;
pub mod zone_set;
pub mod zone_shape;
pub mod zones;

pub use grid::{Cell, CellRect, GridGeometry};
pub use header::{Header, Id, Parents, Stamps};
pub use map::{MapCell, MapTile, MapView};
pub use message::{Message, Refusal, Wire};
pub use pose::Pose;
pub use role::Role;
pub use zone_set::ZoneSet;
