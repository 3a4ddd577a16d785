//! What a run left in its folder, read again. Others may have written it.

use crate::picture;
use crate::show::recording::{self, Recording};
use serde_json::Value;
use std::path::{Path, PathBuf};
use zeronav_files::read;
use zeronav_measure::result::RunResult;
use zeronav_measure::result::latency::Latency;
use zeronav_measure::result::stay::StayResult;

/// What became of a run.
#[derive(Debug, Clone)]
pub(crate) enum Outcome {
    /// Of `zeronav run`.
    Run(Box<RunResult>),
    /// Of `zeronav up`.
    Stay(Box<StayResult>),
}

/// The folder of a run.
#[derive(Debug)]
pub(super) struct RunFolder {
    /// Its path.
    pub path: PathBuf,
    /// `result.json`.
    pub outcome: Outcome,
    /// `recording.json`; runs of older versions may have none.
    pub recording: Option<Recording>,
}

impl RunFolder {
    /// Reads the folder `path`.
    ///
    /// # Errors
    /// One line that names the file and what is wrong with it.
    pub(super) fn read(path: &Path) -> Result<Self, String> {
        let file = path.join("result.json");
        let name = file.display();
        if !path.is_dir() {
            return Err(format!(
                "{}: no such folder; name one that `zeronav run` left, such as runs/...",
                path.display()
            ));
        }
        let text = read_text(&file)?;
        let broken = |error: serde_json::Error| format!("{name}: no result of a run: {error}");
        let value: Value = serde_json::from_str(&text).map_err(broken)?;
        let outcome = if value.get("suite").is_some() {
            return Err(format!(
                "{name}: a suite; name the folder of one of its runs"
            ));
        } else if value.get("verdict").is_some() {
            Outcome::Run(serde_json::from_value(value).map_err(broken)?)
        } else {
            Outcome::Stay(serde_json::from_value(value).map_err(broken)?)
        };
        let recording = if path.join(recording::FILE).exists() {
            Some(picture::read(path)?)
        } else {
            None
        };
        Ok(Self {
            path: path.to_owned(),
            outcome,
            recording,
        })
    }

    /// The result of `zeronav run`.
    pub(super) fn result(&self) -> Option<&RunResult> {
        match &self.outcome {
            Outcome::Run(result) => Some(result),
            Outcome::Stay(_) => None,
        }
    }

    /// Its latencies, in real time.
    pub(super) fn latency(&self) -> Option<&Latency> {
        match &self.outcome {
            Outcome::Run(result) => result.latency.as_ref(),
            Outcome::Stay(result) => result.latency.as_ref(),
        }
    }

    /// Name of the scenario.
    pub(super) fn scenario(&self) -> &str {
        match &self.outcome {
            Outcome::Run(result) => &result.scenario,
            Outcome::Stay(result) => &result.scenario,
        }
    }

    /// Name of the folder, for people.
    pub(super) fn name(&self) -> String {
        let absolute = std::path::absolute(&self.path).unwrap_or_default();
        let name = absolute.file_name().unwrap_or(self.path.as_os_str());
        name.to_string_lossy().into_owned()
    }
}

/// The text of a file that is not too large to be one of a run.
///
/// # Errors
/// One line that names it.
pub(crate) fn read_text(file: &Path) -> Result<String, String> {
    let failed = |error: std::io::Error| format!("{}: {error}", file.display());
    read::text(file, read::RESULT_BYTES_MAX).map_err(failed)
}
