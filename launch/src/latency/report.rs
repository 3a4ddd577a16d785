//! The report of `zeronav latency`: what `--json` prints and a baseline holds.

use serde::{Deserialize, Serialize};
use std::path::Path;
use zeronav_files::read;
use zeronav_measure::lints::{disturbances, lints};
use zeronav_measure::result::profile::{CommandGaps, Edge, ProfileRow};
use zeronav_measure::result::trials::Disturbance;
use zeronav_measure::result::{Environment, RunResult};

/// First word of every report: a file without it is no report.
const FORMAT: &str = "zeronav latency 1";

/// Longest baseline. [bytes]
const BYTES_MAX: u64 = 16 * 1024 * 1024;

/// All measurements.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Report {
    format: String,
    /// The measurements, one per rate and load.
    pub cells: Vec<Cell>,
    /// What was asserted.
    #[serde(default)]
    pub assertions: Vec<Assertion>,
}

/// One measurement.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Cell {
    /// Scenario.
    pub scenario: String,
    /// Scans per second. [Hz]
    pub rate_hz: f64,
    /// `idle` or `busy`.
    pub load: String,
    /// Trials that were made; 0 for a plain run.
    pub trials: usize,
    /// Rounds; 1 for a plain run.
    pub rounds: usize,
    /// `pass` or `fail`.
    pub verdict: String,
    /// The same in words.
    pub reason: String,
    /// Every latency by name.
    pub rows: Vec<ProfileRow>,
    /// Median of replanning over that of the empty ring; null without both.
    pub replanning_to_floor: Option<f64>,
    /// Every edge between two processes.
    pub edges: Vec<Edge>,
    /// The velocity commands and their period.
    pub commands: CommandGaps,
    /// What the kernel did meanwhile, round by round.
    pub disturbances: Vec<Disturbance>,
    /// What to know before believing it.
    pub lints: Vec<String>,
    /// Machine and build.
    pub environment: Environment,
    /// Folder of the run.
    pub directory: String,
}

/// A clause and what was measured.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Assertion {
    /// The clause as it was written.
    pub clause: String,
    /// The measurement that it was held against: scans per second and load.
    pub rate_hz: f64,
    /// Load of the same.
    pub load: String,
    /// True when it holds.
    pub met: bool,
    /// The figure: a time [us], or a count; null when the samples do not tell it.
    pub measured: Option<f64>,
    /// The same figure of the baseline; null without one.
    pub baseline: Option<f64>,
    /// Samples.
    pub n: u64,
    /// What was measured, in words.
    pub said: String,
}

impl Report {
    /// A report without measurements.
    pub(super) fn new() -> Self {
        Self {
            format: FORMAT.to_owned(),
            cells: Vec::new(),
            assertions: Vec::new(),
        }
    }

    /// Reads a baseline.
    ///
    /// # Errors
    /// One line naming the file.
    pub(super) fn read(file: &Path) -> Result<Self, String> {
        let name = file.display();
        let text = read::text(file, BYTES_MAX).map_err(|error| format!("{name}: {error}"))?;
        let report: Self = serde_json::from_str(&text).map_err(|error| {
            format!("{name} is no report of `zeronav latency --save-baseline`: {error}")
        })?;
        if report.format != FORMAT {
            return Err(format!(
                "{name} is no report of this version: its format is not {FORMAT}"
            ));
        }
        Ok(report)
    }

    /// The measurement of a rate and a load.
    pub(super) fn cell(&self, rate_hz: f64, load: &str) -> Option<&Cell> {
        let same = |cell: &&Cell| (cell.rate_hz - rate_hz).abs() < 1.0e-6 && cell.load == load;
        self.cells.iter().find(same)
    }
}

impl Cell {
    /// The measurement that a result holds.
    ///
    /// # Errors
    /// One line when it holds none.
    pub(super) fn of(result: &RunResult) -> Result<Self, String> {
        let Some(profile) = &result.profile else {
            let why = if result.mode == "lockstep" {
                "a run in lockstep has no latencies"
            } else {
                "the run was made by an older version, which left no intervals"
            };
            return Err(format!("{}: {why}", result.directory));
        };
        let trials = result.trials.as_ref();
        let latency = result.latency.as_ref();
        Ok(Self {
            scenario: result.scenario.clone(),
            rate_hz: profile.rate_hz,
            load: profile.load.clone(),
            trials: trials.map_or(0, |trials| trials.made),
            rounds: trials.map_or(1, |trials| trials.rounds.len()),
            verdict: result.verdict.clone(),
            reason: result.reason.clone(),
            rows: profile.rows.clone(),
            replanning_to_floor: latency.and_then(|latency| latency.replanning_to_floor),
            edges: profile.edges.clone(),
            commands: profile.commands.clone(),
            disturbances: disturbances(result).into_iter().cloned().collect(),
            lints: lints(result),
            environment: result.environment.clone(),
            directory: result.directory.clone(),
        })
    }

    /// A latency by its name.
    pub(super) fn row(&self, name: &str) -> Option<&ProfileRow> {
        self.rows.iter().find(|row| row.name == name)
    }
}
