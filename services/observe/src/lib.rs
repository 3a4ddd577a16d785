//! What a running stack is doing, said once: `zeronav top`, `zeronav why`, the page of the viewer and the
//! result of a run all ask here, so that they say the same of the same moment. Pure but for [`usage`], which
//! reads the kernel's counters.

pub mod control;
pub mod health;
pub mod hop_chain;
pub mod statistics;
pub mod usage;
