//! The part of a result that says what the start took.

use serde::{Deserialize, Serialize};

/// From the command to the first motion.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct StartUp {
    /// Until the robot moved; null when it has not. [ms]
    pub first_motion_ms: Option<f64>,
    /// Everything that was done, in the order in which it ended.
    pub stages: Vec<Stage>,
}

/// Something that was done on the way to the first motion. Times count from the command.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct Stage {
    /// What.
    pub name: String,
    /// Who did it: `launch` or a seat.
    pub who: String,
    /// When it could begin: the last thing that it needs was there. [ms]
    pub from_ms: f64,
    /// When it was done. [ms]
    pub to_ms: f64,
    /// Name of the stage that it waited for; null for the first.
    pub waited_for: Option<String>,
}
