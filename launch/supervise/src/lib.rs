//! Starting the processes of a stack, watching them, and leaving nothing behind.

pub mod algorithms;
pub mod binaries;
pub mod child;
pub mod child_log;
pub mod cleaner;
pub mod crash_result;
pub mod descendants;
pub mod hang;
mod log_limit;
pub mod occupant;
pub mod own_time;
pub mod process;
pub mod question;
pub mod restart;
pub mod scheduling;
pub mod shared_memory;
pub mod stack;
pub mod taps;
pub mod temporary;
pub mod warden;
pub mod will;

pub use child::Child;
pub use stack::Stack;
