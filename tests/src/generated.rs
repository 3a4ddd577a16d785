//! What lies in the repository and is written from code: the one command that writes it again, and what the
//! tests compare.

use crate::built::{command, workspace};
use crate::results::{self, record};
use std::path::PathBuf;
use std::process::Command;

/// What to say where something is not current.
pub const COMMAND: &str = "cargo run -p zeronav-tests --bin zeronav-regenerate";

/// A file that holds what `zeronav` prints with some words.
#[derive(Debug, Clone, Copy)]
pub struct Printed {
    /// From the root of the workspace.
    pub file: &'static str,
    /// The words.
    pub words: &'static [&'static str],
}

/// Every file of that kind.
pub const PRINTED: [Printed; 2] = [
    Printed {
        file: "services/PARAMETERS.md",
        words: &["params", "--markdown"],
    },
    Printed {
        file: "launch/scenario.schema.json",
        words: &["schema"],
    },
];

impl Printed {
    /// Where it lies.
    #[must_use]
    pub fn path(&self) -> PathBuf {
        workspace().join(self.file)
    }

    /// What it should hold.
    ///
    /// # Errors
    /// The words, and what `zeronav` said, when it did not succeed.
    pub fn text(&self) -> Result<String, String> {
        let words = self.words.join(" ");
        let ended = command().args(self.words).output();
        let ended = ended.map_err(|error| format!("zeronav {words}: {error}"))?;
        if !ended.status.success() {
            let said = String::from_utf8_lossy(&ended.stderr);
            return Err(format!("zeronav {words}: {}: {said}", ended.status));
        }
        String::from_utf8(ended.stdout).map_err(|error| format!("zeronav {words}: {error}"))
    }
}

/// Writes everything again: the contract for other languages, what `zeronav` prints, and the pages with
/// figures from their stored records.
///
/// # Errors
/// What could not be made or written, and why.
pub fn write_all() -> Result<(), String> {
    let bindings = [
        "run",
        "--quiet",
        "-p",
        "zeronav-msgs",
        "--example",
        "bindings",
    ];
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let ended = (Command::new(cargo).args(bindings))
        .current_dir(workspace())
        .status()
        .map_err(|error| format!("cargo: {error}"))?;
    if !ended.success() {
        return Err(format!("cargo {}: {ended}", bindings.join(" ")));
    }
    for printed in PRINTED {
        let path = printed.path();
        std::fs::write(&path, printed.text()?)
            .map_err(|error| format!("{}: {error}", path.display()))?;
    }
    results::render(&record::load(&results::records_file())?)
}
