//! What every process of a stack shares, so that a service's `main.rs` is its algorithm and
//! nothing else: the five flags, the domain, typed ports over the topics of `zeronav-msgs`, one
//! doorbell per role, the clock, the roster, the heartbeat, the spans, exit codes and logs.
//!
//! A service implements [`Service`] and calls [`run`]. The loop is always the same: wait for a
//! ring or the next deadline, read who is obeyed, let the service take in its inputs and answer,
//! ring whoever waits for the answer, leave a span, beat. A process leaves when launch is gone, with
//! the robot at rest.
//!
//! What several services take in alike has a type of its own: [`TrackReader`] (odometry),
//! [`MapInput`], [`Tasks`], [`GoalAtHand`], and [`PlanningInputs`], all that a global planner needs,
//! to which [`PathOutput`] is the other end.
//! [`Shell::turns`] says which answers are due.

#![warn(clippy::print_stderr)]

pub mod cleaning;
pub mod clock;
pub mod domain;
pub mod doorbell;
pub mod error;
pub mod flags;
pub mod folder;
pub mod goal_at_hand;
mod leaving;
pub mod logs;
pub mod map_input;
pub mod memory;
pub mod nearest;
pub mod path_output;
pub mod peer;
pub mod places;
pub mod planning_inputs;
pub mod printable;
pub mod reader;
pub mod records;
pub mod roster;
pub mod seat;
pub mod service;
pub mod signals;
pub mod stamp;
pub mod tasks;
pub mod track;
pub mod turn;
pub mod writer;

pub use domain::Domain;
pub use error::StartError;
pub use flags::NoConfig;
pub use goal_at_hand::GoalAtHand;
pub use map_input::MapInput;
pub use path_output::PathOutput;
pub use peer::Peer;
pub use planning_inputs::PlanningInputs;
pub use printable::printable;
pub use reader::{Latest, Stream, View};
pub use roster::Roster;
pub use service::{Cycle, Service, Shell, run};
pub use stamp::Stamp;
pub use tasks::{HeldTask, Tasks};
pub use track::{Moment, Track, TrackReader};
pub use turn::{Trigger, Turn};
pub use writer::{Draft, Sent, Writer};
