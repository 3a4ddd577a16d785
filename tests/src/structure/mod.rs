//! The structure of the source code, read from its tokens: module trees, circles of modules, and
//! how long files and functions are.

pub mod length;
mod modules;
mod paths;
mod tokens;

pub use modules::{Crate, crates_of};
