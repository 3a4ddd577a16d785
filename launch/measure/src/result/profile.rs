//! The part of a result that says how sure its latencies are, and what lies behind them.

use super::latency::Figures;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Latencies with their intervals, and what was overtaken and missed meanwhile.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct Profile {
    /// Scans per second that the lidar should give. [Hz]
    pub rate_hz: f64,
    /// `idle`, or `busy` when a process per core computed beside the stack.
    pub load: String,
    /// Every latency by name.
    pub rows: Vec<ProfileRow>,
    /// Every edge between two processes.
    pub edges: Vec<Edge>,
    /// The velocity commands and their period.
    pub commands: CommandGaps,
    /// Answers of each service.
    pub answers: BTreeMap<String, u64>,
}

/// One latency.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct ProfileRow {
    /// Its name, as in an assertion.
    pub name: String,
    /// Its figures.
    #[serde(flatten)]
    pub figures: Figures,
    /// 95 % interval of the median; null as the median. [us]
    pub p50_interval_us: Option<[f64; 2]>,
    /// The same of the 90th percentile. [us]
    pub p90_interval_us: Option<[f64; 2]>,
    /// The same of the 99th percentile. [us]
    pub p99_interval_us: Option<[f64; 2]>,
    /// 99.9th percentile of the samples of all rounds together, unanswered ones at the deadline; there
    /// from [`Self::P999_N_MIN`] samples on. [us]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub p999_us: Option<f64>,
}

impl ProfileRow {
    /// Fewest samples that tell a 99.9th percentile from the worst. A round of trials rarely has so
    /// many, so this percentile is not the median of the rounds'.
    pub const P999_N_MIN: usize = 1000;
}

/// Messages of a topic on their way to one of its readers.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct Edge {
    /// The topic.
    pub topic: String,
    /// The seat that reads it.
    pub reader: String,
    /// Messages that were sent between the first and the last one that an answer was made from.
    pub sent: u64,
    /// Those of which no answer was made, because a newer one was there.
    pub superseded: u64,
}

/// Times from one velocity command to the next while a path was followed.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct CommandGaps {
    /// What the time should be. [us]
    pub period_us: f64,
    /// Commands.
    pub n: u64,
    /// Longest time. [us]
    pub gap_us_max: f64,
    /// Times beyond one and a half periods.
    pub missed: u64,
    /// The same by cause: the hop that took longest beyond its time before.
    pub missed_by_cause: BTreeMap<String, u64>,
}
