//! What became of a swap, and how a newcomer compared with the process in the seat.

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// A swap or a comparison: where it is, or how it ended.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct SwapResult {
    /// Number of the swap in this run, from 1.
    pub id: u64,
    /// Its seat.
    pub role: String,
    /// File name of the newcomer's binary.
    pub binary: String,
    /// `asking`, `starting`, `shadow`, `keep`, `leaving` while it goes on; `swapped`, `compared`, `rejected`,
    /// `rolled_back` or `cancelled` when it is over.
    pub state: String,
    /// Why it was rejected or rolled back.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub why: Option<String>,
    /// Process id of the newcomer; 0 before it was started.
    pub pid: u32,
    /// Epoch of the newcomer; 0 before it was started.
    pub epoch: u32,
    /// First tick of which the newcomer heard in lockstep, or that counts for the comparison.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub warm_tick: Option<u64>,
    /// First tick at which the newcomer was obeyed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cut_over_tick: Option<u64>,
    /// First tick at which the process before it was obeyed again.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub roll_back_tick: Option<u64>,
    /// Most ticks from one velocity command to the next while it went on; 1 when none was missing.
    pub command_gap_ticks: u64,
    /// Both processes side by side.
    pub comparison: Comparison,
}

impl SwapResult {
    /// True when nothing more will happen.
    #[must_use]
    pub fn is_over(&self) -> bool {
        !matches!(
            self.state.as_str(),
            "asking" | "starting" | "shadow" | "keep" | "leaving"
        )
    }
}

/// Two processes of a seat that answered the same ticks.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct Comparison {
    /// Ticks that both answered, and on which one of them did something.
    pub ticks: u64,
    /// Share of them on which they agreed, 0 to 1; null before the first. Of mapping: mean share of
    /// the cells that are lethal, or known to one only, of which both say the same.
    pub agree: Option<f64>,
    /// What differed, in the terms of the role; the unit is part of each name.
    pub measures: BTreeMap<String, f64>,
    /// Messages of the newcomer that were rejected.
    pub rejected: u64,
    /// The process that was in the seat.
    pub office: AnswerTimes,
    /// The newcomer.
    pub newcomer: AnswerTimes,
}

/// Times from the wake of a process to its answer.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct AnswerTimes {
    /// Answers.
    pub n: u64,
    /// Median; null without answers. [us]
    pub p50_us: Option<f64>,
    /// 99th percentile; null without answers. [us]
    pub p99_us: Option<f64>,
}
