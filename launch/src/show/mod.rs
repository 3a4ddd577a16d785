//! What a person sees: the picture of a run, its animation, the table at its end, the line while it runs.

pub(crate) mod animation;
mod captions;
pub mod log;
pub(crate) mod page;
pub(crate) mod picture;
pub(crate) mod recording;
