//! What became of a fault that was made on purpose.

use serde::{Deserialize, Serialize};

/// A fault of the stack, of the scenario or of `zeronav fault`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct FaultResult {
    /// Number of the fault in this run, from 1.
    pub id: u64,
    /// `kill`, `stop`, `slow`, `drop`, `delay`, `corrupt`, `clock`, `fill_shm` or `disk_full`.
    pub kind: String,
    /// What broke: a seat, a topic, `shared_memory` or `disk`.
    pub target: String,
    /// Its figures, such as `20 ms`; empty when there are none.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub figures: String,
    /// Tick of the robot at which it began.
    pub tick: u64,
    /// Run time at which it began. [s]
    pub time_s: f64,
    /// Run time at which it ended; null for faults without an end, and for those that went on to the
    /// end of the run. [s]
    pub until_s: Option<f64>,
    /// From its begin, of `kill` and `stop`, or else from its end to the next answer of the seat (of
    /// a topic: of its first reader): of the successor when there is one, of the global planner a path
    /// that it has found. Run time in lockstep. Null when none came. [ms]
    pub recovery_ms: Option<f64>,
    /// Why it was not made.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub why: Option<String>,
}
