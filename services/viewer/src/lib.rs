//! A live page of a running stack, and the renderer that it shares with reports of recorded ones.
//!
//! Without the feature `process` this crate holds the files of the page and writes the format that
//! they draw; `page/README.md` describes both.

pub mod page;
pub mod scene;
