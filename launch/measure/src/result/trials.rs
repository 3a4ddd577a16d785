//! The part of a result that trials fill.

use super::latency::Latency;
use serde::{Deserialize, Serialize};

/// What the trials were.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct TrialsResult {
    /// Trials that were asked for.
    pub wanted: usize,
    /// Trials that were made and count.
    pub made: usize,
    /// The rounds.
    pub rounds: Vec<Round>,
    /// The slowest trials with what disturbed them, slowest first.
    pub worst: Vec<SlowTrial>,
}

/// One round.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct Round {
    /// Trials that counted.
    pub trials: usize,
    /// Drops that did not count because no path led through the obstacle.
    pub missed: u64,
    /// Run time. [s]
    pub time_s: f64,
    /// What the stages of the floor passed on.
    pub floor_load: Option<Load>,
    /// What disturbed it.
    pub disturbance: Option<Disturbance>,
    /// Its figures.
    pub latency: Latency,
}

/// One of the slowest trials, with what is needed to explain it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct SlowTrial {
    /// Round, from 1.
    pub round: usize,
    /// Trial of the round, from 1.
    pub trial: usize,
    /// Its replanning latency; null when it was not answered in time. [us]
    pub replanning_us: Option<f64>,
    /// The hop that took longest beyond its median in that round.
    pub hop: Option<SlowHop>,
    /// What disturbed the machine from the decision to drop the obstacle to the answer.
    pub disturbance: Option<Disturbance>,
}

/// A hop that took long.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct SlowHop {
    /// Its name.
    pub name: String,
    /// How long it took. [us]
    pub time_us: f64,
    /// Its median in the same round; null where there are too few trials for one. [us]
    pub p50_us: Option<f64>,
}

/// What the stages pass on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Load {
    /// Beams of a scan.
    pub beams: u32,
    /// Tiles of a map update.
    pub tiles: u32,
    /// Waypoints of a path.
    pub waypoints: u32,
    /// From scan to scan. [ns]
    pub period_ns: u64,
}

/// What happened between two readings.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct Disturbance {
    /// Load average of the last minute at the first reading.
    pub load_start: f64,
    /// The same at the second.
    pub load_end: f64,
    /// Share of processor time that the host gave to others in between, 0 to 1.
    pub steal: f64,
    /// Each service.
    pub services: Vec<ServiceDisturbance>,
}

/// What happened to one service between two readings.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct ServiceDisturbance {
    /// Its seat.
    pub name: String,
    /// Processor time that it used. [us]
    pub processor_us: f64,
    /// Time for which it could have run but waited for a processor. [us]
    pub queue_us: f64,
    /// Longest time for which it was off the processor within one cycle, from its wake to the end
    /// of its answer: preempted, waiting for a page, or delayed on purpose. [us]
    pub off_processor_us_max: f64,
    /// Context switches because it waited for something.
    pub voluntary_switches: u64,
    /// Context switches because another process was given its processor.
    pub involuntary_switches: u64,
    /// Pages that were mapped at their first use.
    pub minor_faults: u64,
    /// Pages that were read from a disk.
    pub major_faults: u64,
}
