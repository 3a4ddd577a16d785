//! What a suite took on its machine: beside the results, which do not depend on that.

use super::row::Row;
use serde::{Deserialize, Serialize};
use std::path::Path;
use zeronav_console::artifacts;
use zeronav_files::{Folder, read};
use zeronav_measure::result::Environment;

/// Its file in the suite's folder.
const NAME: &str = "timing.json";

/// What a suite took.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Timing {
    /// Wall time of all calls; of a suite that was merged, that of its longest shard. [s]
    pub wall_s: f64,
    /// Machine and build.
    pub environment: Environment,
    /// Folder with everything.
    pub directory: String,
    /// Wall time of each run, in the order of the report; null where none was driven. [s]
    pub run_wall_s: Vec<Option<f64>>,
    /// The same of the shards that were merged.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub shards: Vec<Timing>,
}

impl Timing {
    pub(super) fn new(
        rows: &[Row],
        directory: &Path,
        wall_s: f64,
        environment: Environment,
    ) -> Self {
        Self {
            wall_s,
            environment,
            directory: directory.display().to_string(),
            run_wall_s: rows.iter().map(|row| row.wall_s).collect(),
            shards: Vec::new(),
        }
    }

    /// That of the suite in this folder.
    ///
    /// # Errors
    /// One line naming the file.
    pub(super) fn read(directory: &Path) -> Result<Self, String> {
        let file = directory.join(NAME);
        let text = read::text(&file, read::RESULT_BYTES_MAX);
        let timing = text
            .map_err(|error| error.to_string())
            .and_then(|text| serde_json::from_str(&text).map_err(|error| error.to_string()));
        timing.map_err(|error| format!("{}: {error}", file.display()))
    }

    /// Writes it into the suite's folder.
    ///
    /// # Errors
    /// One line naming the file.
    pub(super) fn leave(&self, folder: &Folder) -> Result<(), String> {
        let text = serde_json::to_string_pretty(self).map_err(|error| error.to_string())?;
        artifacts::write_in(folder, NAME, &(text + "\n"))
    }
}
