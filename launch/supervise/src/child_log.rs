//! Where the output of a process goes: a file in the folder of a run, opened for more at its end.

use super::warden;
use std::fs::File;
use std::os::fd::AsFd;
use std::path::PathBuf;
use zeronav_files::{Folder, read};

/// Most of a log that is looked at for its last lines. [bytes]
const TAIL_BYTES: u64 = 16 * 1024;

/// A log that a process, and those after it in its seat, write to.
#[derive(Debug, Clone)]
pub struct LogPlace {
    folder: Folder,
    name: String,
}

impl LogPlace {
    /// The file `name` in `folder`.
    #[must_use]
    pub fn new(folder: &Folder, name: impl Into<String>) -> Self {
        Self {
            folder: folder.clone(),
            name: name.into(),
        }
    }

    /// Its path, for people.
    #[must_use]
    pub fn path(&self) -> PathBuf {
        self.folder.path().join(&self.name)
    }

    /// Opens it for more, and makes it when it is missing. It is kept short from now on.
    ///
    /// # Errors
    /// What is in its place, naming it.
    pub fn open(&self) -> std::io::Result<File> {
        let named = |error: std::io::Error| {
            let why = format!("{}: {error}", self.path().display());
            std::io::Error::new(error.kind(), why)
        };
        let file = self.folder.append(&self.name).map_err(named)?;
        warden::watch_log(file.as_fd());
        Ok(file)
    }
}

/// The last lines of a log.
#[must_use]
pub fn last_lines(log: &File, lines: usize) -> Vec<String> {
    let text = read::tail(log, TAIL_BYTES).unwrap_or_default();
    let all: Vec<&str> = text.lines().collect();
    let last = &all[all.len().saturating_sub(lines)..];
    last.iter().map(|line| (*line).to_owned()).collect()
}
