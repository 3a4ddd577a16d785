//! `[foresight]`: what the simulator tells services of what moves, to measure what perception and
//! prediction cost. What is judged is told nothing.

use clap::ValueEnum;
use serde::{Deserialize, Serialize};
use zeronav_msgs::foresight::{FORESIGHT_PERCEIVE, FORESIGHT_PREDICT};

/// How mapping knows what moves.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, ValueEnum)]
#[serde(rename_all = "snake_case")]
pub enum Perceive {
    /// By its scans.
    #[default]
    Sensed,
    /// The simulator tells it: place, velocity and radius of everything that moves, at every scan.
    Truth,
}

/// How the local planner knows where that will be.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, ValueEnum)]
#[serde(rename_all = "snake_case")]
pub enum Predict {
    /// By its own model of motion.
    #[default]
    Model,
    /// The simulator tells it: where everything will be in the next 6.3 s.
    Truth,
}

/// What services are told of what moves; nothing in earnest.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ForesightSpec {
    /// Mapping.
    pub perceive: Perceive,
    /// The local planner.
    pub predict: Predict,
}

impl ForesightSpec {
    /// True when services are told nothing.
    #[must_use]
    pub fn is_none(&self) -> bool {
        *self == Self::default()
    }

    /// As `run/clock` says it.
    #[must_use]
    pub fn bits(&self) -> u16 {
        let bit = |set, bit| if set { bit } else { 0 };
        bit(self.perceive == Perceive::Truth, FORESIGHT_PERCEIVE)
            | bit(self.predict == Predict::Truth, FORESIGHT_PREDICT)
    }

    /// What a report marks its figures with; `None` in earnest.
    #[must_use]
    pub fn label(&self) -> Option<String> {
        let perceive = ["sensed", "truth"][usize::from(self.perceive == Perceive::Truth)];
        let predict = ["model", "truth"][usize::from(self.predict == Predict::Truth)];
        (!self.is_none()).then(|| format!("perceive {perceive}, predict {predict}"))
    }
}
