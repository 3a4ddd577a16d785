//! Files that others have a hand in: how they are read, and how those are written that a command
//! leaves.
//!
//! [`read`] reads regular files only, never waits and never takes more than it was told to.
//! [`Folder`] is a folder of this user, opened once: everything in it is made by that descriptor, so
//! nothing that is put in the place of its path later counts, and no link that another user has
//! planted is followed.

mod folder;
pub mod read;

pub use folder::{Folder, Part, Replace, parts};
