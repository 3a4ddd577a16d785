//! Swaps and shadows that a scenario asks for.

use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// How long a newcomer is compared before it is obeyed, unless said otherwise. [s]
pub const SHADOW_S: f64 = 5.0;

/// How long the process before it stays warm, unless said otherwise. [s]
pub const KEEP_S: f64 = 5.0;

/// Shortest time for which the process before it stays warm: what it sent last is still in use. [s]
pub const KEEP_S_MIN: f64 = 0.5;

/// A service that is exchanged while the robot drives.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SwapSpec {
    /// Its seat: `mapping`, `global_planner`, `local_planner` or `collision_guard`.
    pub service: String,
    /// Run time at which the newcomer begins to hear and answer. [s]
    pub at_s: f64,
    /// Name or path of its binary; without, the one in the seat.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub binary: Option<PathBuf>,
    /// Keys of its configuration.
    #[serde(default)]
    pub config: toml::Table,
    /// For how long it is compared before it is obeyed. [s]
    #[serde(default = "shadow_s")]
    pub shadow_s: f64,
    /// For how long its predecessor stays warm. [s]
    #[serde(default = "keep_s")]
    pub keep_s: f64,
    /// What it has to reach, such as `p99<2ms, agree>0.95`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub require: Option<String>,
}

/// A second process in a seat that is compared for the whole run and never obeyed.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ShadowSpec {
    /// Name or path of its binary; without, the one in the seat.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub binary: Option<PathBuf>,
    /// Keys of its configuration.
    pub config: toml::Table,
}

const fn shadow_s() -> f64 {
    SHADOW_S
}

const fn keep_s() -> f64 {
    KEEP_S
}
