//! Starting the processes of a stack, watching them, and leaving nothing behind.

pub mod algorithms;
pub mod binaries;
pub mod child;
pub mod cleaner;
pub mod control;
pub mod hang;
pub mod occupant;
pub mod question;
pub mod restart;
pub mod stack;
pub mod warden;

pub use child::Child;
pub use stack::Stack;
