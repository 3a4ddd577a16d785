//! What a person sees: the picture of a run, its animation, the table at its end, the line while it runs.

pub mod animation;
mod captions;
pub mod log;
pub mod page;
pub mod picture;
pub mod progress;
pub mod recording;
mod svg;
pub mod terminal;
