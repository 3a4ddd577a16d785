//! Drives in the real stack: scenes as a suite of `zeronav`, in lockstep, so that the same seed
//! gives the same drive.

use crate::scenes::Scene;
use serde::Deserialize;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// Why the stack did not drive.
#[derive(Debug, thiserror::Error)]
pub enum StackError {
    /// `zeronav` is not there.
    #[error("{} is missing: run `cargo build --release --workspace --bins`", .0.display())]
    Missing(PathBuf),
    /// The binaries do not build.
    #[error("the services do not build, see above")]
    Build,
    /// A file or a process.
    #[error("{what}: {error}")]
    Io {
        /// What was tried.
        what: String,
        /// Why it failed.
        error: std::io::Error,
    },
    /// `zeronav` ended otherwise than with a report.
    #[error("zeronav suite: {0}")]
    Suite(String),
}

/// What came of a drive.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct Drive {
    /// `reached`, `stuck`, `timeout` and so on.
    pub outcome: String,
    /// Contacts while the robot moved.
    pub contacts_moving: u64,
    /// Contacts while it stood: something ran into it.
    pub contacts_standing: u64,
    /// Run time. [s]
    pub time_s: f64,
    /// Way of the robot. [m]
    pub driven_m: f64,
    /// Least distance of its outline from anything. [m]
    pub clearance_m_min: Option<f64>,
    /// Folder of the run.
    directory: PathBuf,
    #[serde(skip)]
    root: PathBuf,
}

impl Drive {
    /// True when the robot stands at its goal.
    #[must_use]
    pub fn arrived(&self) -> bool {
        self.outcome == "reached"
    }

    /// True when the robot arrived and touched nothing.
    #[must_use]
    pub fn is_clean(&self) -> bool {
        self.arrived() && self.contacts_moving == 0 && self.contacts_standing == 0
    }

    /// True when the robot arrived and never drove into anything, though it may have been run into.
    #[must_use]
    pub fn is_blameless(&self) -> bool {
        self.arrived() && self.contacts_moving == 0
    }

    /// Its result.
    ///
    /// # Errors
    /// When the file cannot be read.
    pub fn result(&self) -> Result<RunResult, StackError> {
        let file = self.root.join(&self.directory).join("result.json");
        let text = std::fs::read_to_string(&file).map_err(|error| StackError::Io {
            what: file.display().to_string(),
            error,
        })?;
        serde_json::from_str(&text)
            .map_err(|error| StackError::Suite(format!("{}: {error}", file.display())))
    }
}

/// What of `result.json` the tables read.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct RunResult {
    /// Every path, in order.
    pub plans: Vec<PlanRow>,
    /// Positions of the robot. [m]
    pub track_m: Vec<[f64; 2]>,
}

/// A path of a run.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct PlanRow {
    /// `found`, `unreachable` and so on.
    pub status: String,
    /// `goal`, `obstacle`, `request` and so on.
    pub cause: String,
    /// Expansions of the search.
    pub expanded: u64,
    /// Its points. [m]
    pub points_m: Vec<[f64; 2]>,
}

#[derive(Deserialize)]
struct Report {
    runs: Vec<Row>,
    /// Folder of the suite, in which those of the runs are.
    directory: PathBuf,
}

#[derive(Deserialize)]
struct Row {
    world: String,
    #[serde(flatten)]
    drive: Drive,
}

/// The stack, and a folder for its runs that is gone with it.
#[derive(Debug)]
pub struct Stack {
    zeronav: PathBuf,
    folder: tempfile::TempDir,
    suites: u32,
}

impl Stack {
    /// Finds `zeronav` beside this program; under cargo builds it and the services first.
    ///
    /// # Errors
    /// See [`StackError`].
    pub fn new() -> Result<Self, StackError> {
        let io = |what: &str, error| StackError::Io {
            what: what.to_owned(),
            error,
        };
        let own = std::env::current_exe().map_err(|error| io("this program", error))?;
        let beside = own.parent().unwrap_or(Path::new("."));
        // A test program lies one folder deeper.
        let beside = match beside.file_name() {
            Some(name) if name == "deps" => beside.parent().unwrap_or(beside),
            _ => beside,
        };
        build(beside)?;
        let zeronav = beside.join(format!("zeronav{}", std::env::consts::EXE_SUFFIX));
        if !zeronav.is_file() {
            return Err(StackError::Missing(zeronav));
        }
        Ok(Self {
            zeronav,
            folder: tempfile::tempdir().map_err(|error| io("a temporary folder", error))?,
            suites: 0,
        })
    }

    /// Drives every scene with these settings, `ROLE.KEY=VALUE` as of `zeronav suite --set`; the drives
    /// come in the order of the scenes.
    ///
    /// # Errors
    /// See [`StackError`].
    pub fn drive(&mut self, scenes: &[Scene], settings: &[&str]) -> Result<Vec<Drive>, StackError> {
        if scenes.is_empty() {
            return Ok(Vec::new());
        }
        self.suites += 1;
        let root = self.folder.path().join(format!("suite_{}", self.suites));
        let io = |what: &Path, error| StackError::Io {
            what: what.display().to_string(),
            error,
        };
        std::fs::create_dir(&root).map_err(|error| io(&root, error))?;
        let folder = root.join("scenes");
        std::fs::create_dir(&folder).map_err(|error| io(&folder, error))?;
        for (index, scene) in scenes.iter().enumerate() {
            let file = folder.join(format!("{}.toml", name_of(index)));
            std::fs::write(&file, &scene.text).map_err(|error| io(&file, error))?;
        }
        let mut command = Command::new(&self.zeronav);
        command
            .args(["suite", "./scenes", "--headless", "--json", "--out", "runs"])
            // The binaries are fresh, and cargo looking again would only take time.
            .env_remove("CARGO")
            .current_dir(&root)
            .stdin(Stdio::null());
        for setting in settings {
            command.args(["--set", setting]);
        }
        let output = command.output().map_err(|error| io(&self.zeronav, error))?;
        let report: Report = serde_json::from_slice(&output.stdout).map_err(|error| {
            let told = String::from_utf8_lossy(&output.stderr);
            StackError::Suite(format!("{}: {error}: {}", output.status, told.trim_end()))
        })?;
        let mut drives = Vec::with_capacity(scenes.len());
        for index in 0..scenes.len() {
            let name = name_of(index);
            let row = report.runs.iter().find(|row| row.world == name);
            let row = row.ok_or_else(|| StackError::Suite(format!("{name} was not driven")))?;
            drives.push(Drive {
                root: root.join(&report.directory),
                ..row.drive.clone()
            });
        }
        Ok(drives)
    }
}

fn name_of(index: usize) -> String {
    format!("scene_{index:04}")
}

/// Builds `zeronav` and the services in this program's own profile when cargo runs it.
fn build(beside: &Path) -> Result<(), StackError> {
    let own = Path::new(env!("CARGO_MANIFEST_DIR"));
    let runs_this =
        std::env::var_os("CARGO_MANIFEST_DIR").is_some_and(|run| Path::new(&run) == own);
    let (Some(cargo), true) = (std::env::var_os("CARGO"), runs_this) else {
        return Ok(());
    };
    let profile = match beside.file_name().and_then(|name| name.to_str()) {
        Some("debug") | None => "dev",
        Some(name) => name,
    };
    let status = Command::new(cargo)
        .args([
            "build",
            "--quiet",
            "--workspace",
            "--bins",
            "--profile",
            profile,
        ])
        .args(["--exclude", "zeronav-tests", "--exclude", "zeronav-papers"])
        .arg("--target-dir")
        .arg(beside.parent().unwrap_or(beside))
        .current_dir(own)
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .status()
        .map_err(|error| StackError::Io {
            what: "running cargo to build the services".to_owned(),
            error,
        })?;
    if status.success() {
        Ok(())
    } else {
        Err(StackError::Build)
    }
}
