//! Requests to a stack that runs: which one, and what its answers look like.

pub mod cli;
pub mod fault;
mod feedback;
pub mod goal;
mod ps;
pub mod swap;
pub mod verbs;
pub mod zone;

pub use ps::ps;
