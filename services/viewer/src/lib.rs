//! A live page of a running stack, and the renderer that it shares with reports of recorded ones.
//!
//! Without the feature `process` this crate holds the files of the page and writes the format that
//! they draw; `page/README.md` describes both.

#[cfg(feature = "process")]
mod access;
#[cfg(feature = "process")]
mod act;
#[cfg(feature = "process")]
mod connection;
#[cfg(feature = "process")]
mod events;
#[cfg(feature = "process")]
mod feed;
#[cfg(feature = "process")]
mod handover;
mod hops;
pub mod model;
pub mod page;
#[cfg(feature = "process")]
mod places;
#[cfg(feature = "process")]
pub mod process;
pub mod scene;
#[cfg(feature = "process")]
mod server;
#[cfg(feature = "process")]
mod status;
#[cfg(feature = "process")]
mod tap;
