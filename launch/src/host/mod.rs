//! `zeronav up SCENARIO --host NAME`: a stack whose seats are filled by two computers.
//!
//! The host with the robot is driven by launch as any stack: in the seats that the other host fills sits a program
//! that stands for the process there, and a companion carries the topics (`on_host.rs`). The other host (`serve.rs`)
//! fills its seats as the link tells it.

mod filled;
pub mod keys;
mod link_result;
mod programs;
mod serve;

pub(crate) use link_result::link_result;
pub(crate) use serve::serve;
