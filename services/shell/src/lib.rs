//! What every process of a stack shares, so that a service's `main.rs` is its algorithm and
//! nothing else: the five flags, the domain, typed ports over the topics of `zeronav-msgs`, one
//! doorbell per role, the clock, the roster, the heartbeat, the spans, exit codes and logs.
//!
//! A service implements [`Service`] and calls [`run`]. The loop is always the same: wait for a
//! ring or the next deadline, read who is obeyed, let the service take in its inputs and answer,
//! ring whoever waits for the answer, leave a span, beat.

pub mod clock;
pub mod domain;
pub mod doorbell;
pub mod error;
pub mod flags;
pub mod logs;
pub mod memory;
pub mod peer;
pub mod reader;
pub mod records;
pub mod roster;
pub mod service;
pub mod tasks;
pub mod track;
pub mod writer;

pub use domain::Domain;
pub use error::StartError;
pub use peer::Peer;
pub use reader::{Latest, Stream, View};
pub use roster::Roster;
pub use service::{Cycle, Service, Shell, run};
pub use tasks::{HeldTask, Tasks};
pub use track::{Moment, Track};
pub use writer::{Draft, Sent, Writer};
