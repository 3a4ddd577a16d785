//! What is asked of a swap, and whether it can be.

use require::Clause;
pub(crate) mod require;

use serde::{Deserialize, Serialize};
use std::path::PathBuf;
use zeronav_scenario::{KEEP_S_MIN, TIME_LIMIT_S_MAX};

/// What is asked of a swap.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct SwapOrder {
    /// Its seat.
    pub role: String,
    /// The newcomer's binary; without, that of the process in the seat.
    #[serde(default)]
    pub binary: Option<PathBuf>,
    /// Keys of its configuration. With the same binary the others stay as they are.
    #[serde(default)]
    pub config: toml::Table,
    /// For how long it is compared before it is obeyed; `None` = for as long as the stack runs. [s]
    #[serde(default)]
    pub shadow_s: Option<f64>,
    /// For how long the process before it stays warm; `None` = it only compares. [s]
    #[serde(default)]
    pub keep_s: Option<f64>,
    /// What the newcomer has to reach.
    #[serde(default)]
    pub require: Vec<Clause>,
}

impl SwapOrder {
    /// Accepts usable times.
    ///
    /// # Errors
    /// What cannot be.
    pub(crate) fn check(&self) -> Result<(), String> {
        let within = |name: &str, value: Option<f64>, least: f64| match value {
            Some(value) if !(least..=TIME_LIMIT_S_MAX).contains(&value) => Err(format!(
                "{name} is from {least} to {TIME_LIMIT_S_MAX} s, not {value}"
            )),
            _ => Ok(()),
        };
        within("the time as a shadow", self.shadow_s, 0.0)?;
        within("the time to keep the predecessor", self.keep_s, KEEP_S_MIN)?;
        if self.keep_s.is_some() && self.shadow_s.is_none() {
            return Err("a swap needs the time after which the newcomer is obeyed".to_owned());
        }
        Ok(())
    }
}
