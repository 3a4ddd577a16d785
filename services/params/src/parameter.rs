//! One parameter: what it is called, what it may be, and what it is.

use crate::setting::Setting;
use crate::value::{Choice, Type, Value};
use serde::{Deserialize, Serialize};

/// What must hold between a parameter and others of its group.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Relation {
    /// In words: `must be at most horizon_s`.
    pub rule: String,
    /// Whether it holds for the visited configuration.
    #[serde(skip, default = "holds")]
    pub holds: bool,
}

const fn holds() -> bool {
    true
}

/// One parameter of a configuration.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Parameter {
    /// Names of its groups and its own, such as `dwa.horizon_s`.
    pub path: String,
    /// Type.
    #[serde(rename = "type")]
    pub kind: Type,
    /// Unit, empty for none.
    #[serde(default)]
    pub unit: String,
    /// The visited configuration's value; the default in a description.
    #[serde(rename = "default")]
    pub value: Value,
    /// Smallest value accepted. [unit]
    #[serde(default)]
    pub min: Option<f64>,
    /// Largest value accepted. [unit]
    #[serde(default)]
    pub max: Option<f64>,
    /// Allowed values of a string; empty when any text may be.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub choices: Vec<Choice>,
    /// What else must hold.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub relations: Vec<Relation>,
    /// One or a few sentences.
    pub description: String,
}

/// A parameter has a value that it must not have.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{path} {rule}, not {value}")]
pub struct ParameterError {
    /// Which one, such as `dwa.horizon_s`.
    pub path: String,
    /// What it must be, such as `must be a number from 0 to 1`.
    pub rule: String,
    /// What it is.
    pub value: String,
}

/// What an age that must exceed a period is set to, in periods: messages may be late by most of one.
const FIT_PERIODS: f64 = 1.75;

impl ParameterError {
    /// An age that an input reaches between two messages, with one that would do. `least_s` is the time that
    /// `what` takes. [s]
    #[must_use]
    pub fn too_short((path, value_s): (&str, f64), (what, least_s): (&str, f64)) -> Self {
        let thousandths = |time_s: f64| (1000.0 * time_s).round() / 1000.0;
        let (least_s, fit_s) = (thousandths(least_s), thousandths(FIT_PERIODS * least_s));
        Self {
            path: path.to_owned(),
            rule: format!("must exceed {what}, {least_s} s ({fit_s} would do)"),
            value: format!("{value_s:?}"),
        }
    }
}

impl Parameter {
    /// A parameter as [`crate::parameters!`] declares it.
    #[doc(hidden)]
    pub fn new<S: Setting>(
        setting: &S,
        group: &str,
        name: &str,
        unit: &str,
        range: Option<(f64, f64)>,
        relations: &[(&str, Relation)],
        doc: &str,
    ) -> Self {
        let own = relations.iter().filter(|(of, _)| *of == name);
        Self {
            path: Self::path_of(group, name),
            kind: S::TYPE,
            unit: unit.to_owned(),
            value: setting.value(),
            min: range.map(|(min, _)| min),
            max: range.map(|(_, max)| max),
            choices: S::choices(),
            relations: own.map(|(_, relation)| relation.clone()).collect(),
            description: doc.trim().to_owned(),
        }
    }

    /// Lists the allowed values of a string that a table of algorithms gives: key and description.
    #[must_use]
    pub fn with_choices<'a>(mut self, rows: impl Iterator<Item = (&'a str, String)>) -> Self {
        let choice = |(key, description): (&str, String)| Choice {
            key: key.to_owned(),
            description,
        };
        self.choices = rows.map(choice).collect();
        self
    }

    /// Path of a member of `group`.
    #[doc(hidden)]
    #[must_use]
    pub fn path_of(group: &str, name: &str) -> String {
        let dot = if group.is_empty() { "" } else { "." };
        format!("{group}{dot}{name}")
    }

    /// The range in words, such as `0 to 1` or `above 0, at most 1`; empty without one.
    #[must_use]
    pub fn range(&self) -> String {
        match (self.min, self.max) {
            (Some(f64::MIN_POSITIVE), Some(max)) => format!("above 0, at most {}", plain(max)),
            (Some(min), Some(max)) => format!("{} to {}", plain(min), plain(max)),
            _ => String::new(),
        }
    }

    /// The error when a number is not finite or out of its range.
    pub(crate) fn out_of_range(&self) -> Option<ParameterError> {
        let (min, max) = (self.min.unwrap_or(f64::MIN), self.max.unwrap_or(f64::MAX));
        let wrong = self
            .value
            .find(&|value| !(value.is_finite() && (min..=max).contains(&value)))?;
        let rule = match self.range() {
            range if range.is_empty() => "must be a finite number".to_owned(),
            range if range.starts_with("above") => format!("must be a number {range}"),
            range => format!("must be a number from {range}"),
        };
        Some(self.error(rule, wrong))
    }

    /// The error when a relation does not hold.
    pub(crate) fn broken_relation(&self) -> Option<ParameterError> {
        let broken = self.relations.iter().find(|relation| !relation.holds)?;
        Some(self.error(broken.rule.clone(), &self.value))
    }

    fn error(&self, rule: String, value: &Value) -> ParameterError {
        ParameterError {
            path: self.path.clone(),
            rule,
            value: value.to_string(),
        }
    }
}

/// A bound as people write it: `0.05`, `1000`, `1e6`.
fn plain(bound: f64) -> String {
    if bound.abs() >= 1.0e5 {
        let exponential = format!("{bound:e}");
        if exponential.len() <= 5 {
            return exponential;
        }
    }
    format!("{bound}")
}
