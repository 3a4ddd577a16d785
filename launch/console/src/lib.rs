//! What the commands of `zeronav` share: their arguments, exit codes and signals, what they say on a
//! terminal, and files that are there whole or not at all.

#![warn(clippy::print_stderr)]

pub mod arguments;
pub mod artifacts;
pub mod environment;
pub mod exit;
pub mod interrupts;
pub mod progress;
pub mod svg;
pub mod terminal;
pub mod version;
