//! Faults of a running stack: which come when, which go on, and how long each seat took to answer
//! again.
//!
//! A service is broken from outside: a signal, or a delay in the roster. In lockstep a fault begins and
//! ends while the robot waits at a tick that everybody has answered, and a run with faults is as
//! reproducible as one without. What is planned and drawn is pure; `drive/breaking.rs` carries it out.

mod random;
mod recovery;
mod schedule;

pub use random::draw;
pub use recovery::{Awaited, Recoveries};
pub use schedule::{Event, Pace, Schedule, Sight};
