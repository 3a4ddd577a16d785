//! The part of a result that says what became of a companion.

use serde::{Deserialize, Serialize};

/// [`CompanionResult::end`] of a companion that ended when it was asked to.
pub const STOPPED: &str = "stopped";

/// A process that ran beside the stack.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct CompanionResult {
    /// Its name in the scenario, or `viewer` for the live page.
    pub name: String,
    /// File name of its binary.
    pub binary: String,
    /// How many times it was started.
    pub starts: u32,
    /// How it ended: `stopped` when it did so because it was asked to at the end of the run.
    pub end: String,
}
