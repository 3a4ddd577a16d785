//! What a person sees: the picture of a run, the table at its end, the line while it runs.

pub mod log;
pub mod picture;
pub mod progress;
pub mod report;
pub mod terminal;
