//! A suite that ran: its results, and what they took.

use super::report::Report;
use super::timing::Timing;
use serde::Serialize;

/// What a suite gave, and what it took.
#[derive(Debug, Clone, Serialize)]
pub struct Ran {
    /// What it gave.
    #[serde(flatten)]
    pub report: Report,
    /// What it took.
    #[serde(flatten)]
    pub timing: Timing,
}

impl Ran {
    /// The page for people.
    #[must_use]
    pub fn to_text(&self) -> String {
        self.report.to_text(&self.timing)
    }
}
