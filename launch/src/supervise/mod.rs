//! Starting the processes of a stack, watching them, and leaving nothing behind.

pub(crate) mod algorithms;
pub(crate) mod binaries;
pub(crate) mod child;
pub mod child_log;
pub mod cleaner;
pub(crate) mod crash_result;
pub(crate) mod descendants;
pub(crate) mod hang;
mod log_limit;
pub(crate) mod occupant;
pub(crate) mod own_time;
pub(crate) mod question;
pub(crate) mod restart;
pub(crate) mod scheduling;
pub(crate) mod stack;
pub(crate) mod taps;
pub mod warden;
pub mod will;

pub use child::Child;
pub use stack::Stack;
