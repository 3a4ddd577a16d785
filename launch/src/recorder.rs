//! The recorder of a run: `--record` of `zeronav run` and `zeronav up`. It is a companion: when it dies, the
//! run goes on. In lockstep launch gives it time to keep up, so that nothing is lost however busy the
//! machine is.

use clap::Args;
use clap::builder::{OsStringValueParser, TypedValueParser};
use rustix::fs::OFlags;
use std::ffi::OsString;
use std::fs::File;
use std::os::unix::fs::FileExt;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};
use zeronav_recorder::domain_files::{END, RECORDED};
use zeronav_shell::folder::Folder;
use zeronav_supervise::child_log::{LogPlace, last_lines};

/// The binary.
pub(crate) const BINARY: &str = "zeronav-recorder";

/// How long the recorder may take to begin, of its own time: time without a processor does not count.
pub(crate) const START_LIMIT: Duration = Duration::from_secs(5);

/// How long it may take in any case.
pub(crate) const WALL_LIMIT: Duration = Duration::from_secs(60);

/// How long a lockstep run waits for a recorder that reads nothing.
const WAIT_LIMIT: Duration = Duration::from_secs(5);

/// Ticks that the robot may be ahead of the recorder, lockstep only: its queues hold the messages of
/// some more.
const TICKS_AHEAD: u64 = 24;

/// Whether a run is recorded.
#[derive(Debug, Clone, Default, Args)]
pub struct RecordArgs {
    /// Record every message into an MCAP file, for ROS 2 tools and for replay; without FILE, into
    /// `recording.mcap` in the run's own folder.
    #[arg(long, value_name = "FILE", num_args = 0..=1, require_equals = true, default_missing_value = "",
          value_parser = OsStringValueParser::new().map(RecordTo::of))]
    pub record: Option<RecordTo>,
}

/// Where to.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum RecordTo {
    /// `recording.mcap` in the run's own folder.
    RunFolder,
    /// This file.
    File(PathBuf),
}

impl RecordTo {
    fn of(text: OsString) -> Self {
        if text.is_empty() {
            Self::RunFolder
        } else {
            Self::File(text.into())
        }
    }

    /// The file, of a run in `folder`.
    pub(crate) fn file(&self, folder: &Path) -> PathBuf {
        match self {
            Self::RunFolder => folder.join("recording.mcap"),
            Self::File(file) => file.clone(),
        }
    }
}

/// The recording that is meant: the file itself, or that in the folder of a run.
///
/// # Errors
/// One line when the folder holds none.
pub(crate) fn recording_in(file: &Path) -> Result<PathBuf, String> {
    if !file.is_dir() {
        return Ok(file.to_owned());
    }
    let within = RecordTo::RunFolder.file(file);
    if within.symlink_metadata().is_ok() {
        return Ok(within);
    }
    Err(format!(
        "{}: there is none; a run leaves it with --record",
        within.display()
    ))
}

/// The file of one of several drives that are recorded to `file`: `recording-2.mcap` of the second one.
pub(crate) fn file_of_round(file: &Path, round: usize) -> PathBuf {
    let mut name = file.file_stem().unwrap_or_default().to_owned();
    name.push(format!("-{round}"));
    if let Some(extension) = file.extension() {
        name.push(".");
        name.push(extension);
    }
    file.with_file_name(name)
}

/// Who decides where the robot of a run drives.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum DrivenBy {
    /// The scenario alone: the run can be driven again.
    Scenario,
    /// Clients, or processes that were started by hand.
    Clients,
    /// A recording that is played.
    Recording,
}

impl DrivenBy {
    /// The word for it in a recording.
    pub(crate) const fn label(self) -> &'static str {
        match self {
            Self::Scenario => "scenario",
            Self::Clients => "clients",
            Self::Recording => "recording",
        }
    }
}

/// How far a recorder is.
#[derive(Debug)]
pub(crate) struct RecordedTicks {
    file: File,
    /// Tick up to which everything was read, and when it became so.
    tick: u64,
    since: Instant,
}

impl RecordedTicks {
    /// Of the recorder of the domain in `folder`, once it records.
    pub(crate) fn open(folder: &Folder) -> Option<Self> {
        Some(Self {
            file: folder.file(RECORDED, OFlags::RDONLY).ok()?,
            tick: 0,
            since: Instant::now(),
        })
    }

    /// The last tick that the robot may begin, so that the recorder misses nothing.
    pub(crate) fn last_tick(&mut self) -> u64 {
        let mut bytes = [0; 8];
        let read = self.file.read_exact_at(&mut bytes, 0);
        let tick = read.map_or(0, |()| u64::from_le_bytes(bytes));
        if tick != self.tick {
            (self.tick, self.since) = (tick, Instant::now());
        }
        if self.since.elapsed() > WAIT_LIMIT {
            // It hangs, or its disk does, or the robot stands: what it misses, it counts.
            return u64::MAX;
        }
        tick.saturating_add(TICKS_AHEAD)
    }
}

/// Says to a recorder of the domain in `folder` with which tick the run ended, and its outcome. When that cannot be said,
/// a recording has all of what comes behind as well.
pub(crate) fn say_end(folder: &Folder, end_tick: u64, outcome: &str) {
    let file = folder.file(END, OFlags::WRONLY | OFlags::CREATE);
    let said = [&end_tick.to_le_bytes(), outcome.as_bytes()].concat();
    let said = file.and_then(|file| file.write_all_at(&said, 0));
    if let Err(error) = said {
        tracing::warn!(%error, "a recorder could not be told of the end of the run");
    }
}

/// What the recorder said last, without its name.
pub(crate) fn last_words(log: &LogPlace) -> Option<String> {
    let said = last_lines(&log.open().ok()?, 1).pop()?;
    let own = said.strip_prefix("zeronav-recorder: ");
    Some(own.unwrap_or(&said).to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_of_several_drives_has_a_file_of_its_own() {
        let of = |file: &str, round| file_of_round(Path::new(file), round);
        assert_eq!(
            of("runs/a/recording.mcap", 1),
            Path::new("runs/a/recording-1.mcap")
        );
        assert_eq!(of("my.run.mcap", 12), Path::new("my.run-12.mcap"));
        assert_eq!(of("/tmp/trials", 3), Path::new("/tmp/trials-3"));
    }
}
