//! What every process of a stack shares, so that a service's `main.rs` is its data flow and nothing
//! else: the flags, the domain, typed ports over the topics of `zeronav-msgs`, one doorbell per
//! role, the clock, the roster, the heartbeat, the spans, exit codes and logs.
//!
//! A service implements [`Service`] and calls [`run`]. Every wake is the same: poll the inputs,
//! odometry first; [`Shell::due`] says which answers are due; for each, [`Shell::begin`], a step of
//! the algorithm, [`Shell::send`] per message and [`Shell::finish`]. The shell waits for the next
//! ring or deadline, rings the readers, leaves a span per answer, beats, and ends the process when
//! launch is gone, with the robot at rest.
//!
//! Inputs that several services read alike have a type of their own: [`OdometryReader`],
//! [`MapInput`], [`Tasks`] and [`CurrentGoal`].

#![warn(clippy::print_stderr)]

pub mod cleaning;
pub mod clock;
pub mod current_goal;
pub mod domain;
pub mod doorbell;
pub mod due;
pub mod error;
pub mod flags;
pub mod folder;
mod heartbeat;
pub mod input;
mod leaving;
pub mod logs;
pub mod map_input;
pub mod memory;
pub mod nearest;
pub mod odometry;
pub mod peer;
pub mod places;
pub mod printable;
pub mod reader;
pub mod received;
pub mod records;
pub mod roster;
pub mod roster_reader;
pub mod seat;
pub mod service;
pub mod shell;
pub mod signals;
pub mod tasks;
pub mod writer;

pub use current_goal::CurrentGoal;
pub use domain::Domain;
pub use due::{Due, Trigger};
pub use error::StartError;
pub use flags::NoConfig;
pub use input::Input;
pub use map_input::MapInput;
pub use odometry::{OdometryHistory, OdometryReader, OdometrySample};
pub use peer::Peer;
pub use printable::printable;
pub use reader::{Latest, Stream, View};
pub use received::Received;
pub use roster::Roster;
pub use service::{Service, run};
pub use shell::Shell;
pub use tasks::{HeldTask, Tasks};
pub use writer::{Draft, Sent, Writer};
