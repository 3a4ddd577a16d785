//! What every process of a stack shares, so that the main program of a service is its data flow.
//!
//! A service implements [`Service`] and calls [`run`]. Every wake is the same: poll the inputs,
//! odometry first; [`Shell::due`] says which answers are due; for each, [`Shell::begin`], a step of
//! the algorithm, [`Shell::send`] per message and [`Shell::finish`]. The shell waits for the next
//! ring or deadline, rings the readers, leaves a span per answer, beats, and ends the process when
//! launch is gone, with the robot stopped.
//!
//! How to read the crate, each line on top of those above it:
//!
//! | what | where |
//! |---|---|
//! | the run's folder, its locks, and how it is removed | [`domain`], [`folder`], [`cleaning`], [`memory`], [`damage`] |
//! | a member of a run, and the typed ports that it opens | [`Peer`]: [`Latest`], [`Stream`], [`Writer`], [`records`]; [`RawReader`] for recorders |
//! | the middleware's ports, on bytes: the one place where they are compiled | `middleware` |
//! | which process is obeyed, and how time runs | [`Roster`], [`roster_reader`], [`seat`], [`clock`] |
//! | inputs that several services read alike | [`OdometryReader`], [`MapInput`], [`Tasks`], [`CurrentGoal`], [`ZoneInput`] |
//! | when an answer is due, and how it is given | [`Trigger`], [`Due`], [`Shell`], [`Draft`] |
//! | a question to launch over the run's socket | [`control`] |
//! | a process: flags, configuration, logs, exit code, loop | [`Service`], [`run`], [`Companion`], [`flags`], [`logs`], [`error`] |
//! | topics of a user's own | [`user_topics`] |
//! | seats that are filled on another host | [`remote_seats`] |
//!
//! `examples/own_planner` is a service in a package of its own.

#![warn(clippy::print_stderr)]

pub mod cleaning;
pub mod clock;
pub mod companion;
pub mod control;
mod current_goal;
pub mod damage;
pub mod domain;
pub mod doorbell;
mod due;
pub mod error;
#[cfg(test)]
mod fixture;
pub mod flags;
pub mod folder;
pub mod half_made;
mod heartbeat;
mod input;
mod leaving;
mod link;
mod locked;
pub mod logs;
mod map_input;
pub mod memory;
mod middleware;
pub mod nearest;
pub mod odometry;
pub mod peer;
pub mod places;
pub mod printable;
mod program;
mod raw;
mod reader;
mod received;
pub mod records;
pub mod remote_seats;
mod roster;
pub mod roster_reader;
pub mod seat;
mod service;
mod shell;
mod shm;
pub mod signals;
mod tasks;
pub mod user_topics;
mod writer;
mod zone_input;

pub use companion::{Companion, Guest};
pub use current_goal::CurrentGoal;
pub use domain::Domain;
pub use due::{Due, Trigger};
pub use error::StartError;
pub use flags::{NoConfig, Rates};
pub use input::Input;
pub use link::View;
pub use locked::LOCK_MEMORY;
pub use map_input::MapInput;
pub use odometry::{OdometryHistory, OdometryReader, OdometrySample};
pub use peer::Peer;
pub use printable::printable;
pub use raw::{RawReader, RawUnsent, RawWriter};
pub use reader::{Latest, Stream};
pub use received::Received;
pub use roster::Roster;
pub use service::{Service, run};
pub use shell::Shell;
pub use tasks::{HeldTask, Tasks};
pub use user_topics::{UserReader, UserWriter};
pub use writer::{Draft, Sent, Writer};
pub use zone_input::ZoneInput;
