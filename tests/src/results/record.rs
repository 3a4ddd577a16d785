//! What is stored of a measurement: `tests/results.json`.

use super::spread::Figure;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::Path;

/// Everything that was measured, by the key of the experiment.
pub type Records = BTreeMap<String, Record>;

/// One experiment as it was made last.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Record {
    /// Commit, with `+changes` when the sources were not exactly those of the commit.
    pub commit: String,
    /// Day, UTC.
    pub date: String,
    /// The commands that gave the figures.
    pub commands: Vec<String>,
    /// Where.
    pub machine: Machine,
    /// Wall time of the experiment. [s]
    pub wall_s: f64,
    /// The figures.
    pub tables: Vec<Table>,
    /// What a program printed, verbatim.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub text: Option<String>,
}

/// The machine of a measurement.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Machine {
    /// Processor.
    pub cpu: String,
    /// Its cores.
    pub cores: usize,
    /// Kernel.
    pub kernel: String,
    /// Compiler.
    pub rustc: String,
    /// Load average of the last minute at the start and at the end.
    pub load: [f64; 2],
    /// Share of processor time that the host gave to others.
    pub steal: f64,
}

/// A table of figures.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Table {
    /// What its rows are.
    pub title: String,
    /// Its columns, with units.
    pub columns: Vec<String>,
    /// Its rows.
    pub rows: Vec<Row>,
}

/// A row of figures.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Row {
    /// What was measured.
    pub name: String,
    /// Samples.
    pub n: u64,
    /// A figure for each column.
    pub figures: Vec<Figure>,
}

/// Reads the stored records; none when there is no file yet.
///
/// # Errors
/// One line naming the file.
pub fn load(file: &Path) -> Result<Records, String> {
    match std::fs::read_to_string(file) {
        Ok(text) => {
            serde_json::from_str(&text).map_err(|error| format!("{}: {error}", file.display()))
        }
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(Records::new()),
        Err(error) => Err(format!("{}: {error}", file.display())),
    }
}

/// Writes the records beside the file and renames them into place.
///
/// # Errors
/// One line naming the file.
pub fn store(file: &Path, records: &Records) -> Result<(), String> {
    let name = |error: &dyn core::fmt::Display| format!("writing {}: {error}", file.display());
    let text = serde_json::to_string_pretty(records).map_err(|error| name(&error))?;
    let beside = file.with_extension("json.new");
    std::fs::write(&beside, text + "\n").map_err(|error| name(&error))?;
    std::fs::rename(&beside, file).map_err(|error| name(&error))
}
