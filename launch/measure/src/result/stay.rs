//! What a stack that stayed up leaves: its goals, its contacts, its processes.

use super::companion::CompanionResult;
use super::fault::FaultResult;
use super::latency::Latency;
use super::link::LinkResult;
use super::swap::SwapResult;
use super::{Environment, Redirect, Restart, ServiceResult, Starved};
use serde::{Deserialize, Serialize};

/// What became of a stack.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct StayResult {
    /// Scenario.
    pub scenario: String,
    /// How it ended: `down`, `interrupted`, or what went wrong.
    pub outcome: String,
    /// Run time since it was ready. [s]
    pub time_s: f64,
    /// Wall time since its start. [s]
    pub wall_s: f64,
    /// The goals of clients, at most the newest 1000.
    pub goals: Vec<Redirect>,
    /// Contacts of the simulated robot.
    pub contacts: u32,
    /// Restarts of services.
    pub restarts: Vec<Restart>,
    /// Services that got no processor for longer than `hang_after_s`, in real time.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub starved: Vec<Starved>,
    /// Faults that were made on purpose.
    pub faults: Vec<FaultResult>,
    /// Swaps and comparisons, at most the newest 100.
    pub swaps: Vec<SwapResult>,
    /// Latencies, in real time only; of a long stay those of its end.
    #[serde(default)]
    pub latency: Option<Latency>,
    /// The processes.
    pub services: Vec<ServiceResult>,
    /// The processes that ran beside it.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub companions: Vec<CompanionResult>,
    /// What the link between two hosts carried; left out when one computer fills every seat.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub link: Option<LinkResult>,
    /// Machine and build.
    pub environment: Environment,
    /// Folder with everything that it left.
    pub directory: String,
}
