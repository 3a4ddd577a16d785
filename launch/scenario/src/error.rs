//! What is wrong with a scenario, in one line that says where.

use std::path::PathBuf;

/// Why a scenario cannot be read or cannot work.
#[derive(Debug, thiserror::Error)]
pub enum ScenarioError {
    /// There is none of this name.
    #[error(
        "there is no scenario `{name}`{}; `zeronav list` names all",
        closest.as_ref().map_or_else(String::new, |name| format!(", did you mean `{name}`?"))
    )]
    Unknown {
        /// What was asked for.
        name: String,
        /// The known name that looks most like it.
        closest: Option<String>,
    },
    /// A file cannot be opened or read.
    #[error("scenario {}: {source}", file.display())]
    Read {
        /// The file.
        file: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// The text is not TOML.
    #[error("scenario {file}:{line}: not valid TOML: {why}")]
    Syntax {
        /// The file as the user knows it.
        file: String,
        /// Line, from 1.
        line: usize,
        /// What the parser says.
        why: String,
    },
    /// A value is missing, unknown, of the wrong type, or cannot be.
    #[error("scenario {file}:{line}: {field}: {why}")]
    Field {
        /// The file as the user knows it: the scenario's or one that it builds on.
        file: String,
        /// Line, from 1.
        line: usize,
        /// Path of the value, such as `world.shapes[3].size_m`.
        field: String,
        /// What is wrong and what would be right.
        why: String,
    },
    /// Several of these, each in a line of its own.
    #[error("{}", lines(.0))]
    Several(Vec<ScenarioError>),
}

impl ScenarioError {
    /// All of these as one; `None` when there are none.
    #[must_use]
    pub fn of(mut all: Vec<Self>) -> Option<Self> {
        match all.len() {
            0 | 1 => all.pop(),
            _ => Some(Self::Several(all)),
        }
    }

    /// The value that it is about.
    #[must_use]
    pub fn field(&self) -> Option<&str> {
        match self {
            Self::Field { field, .. } => Some(field),
            _ => None,
        }
    }
}

fn lines(errors: &[ScenarioError]) -> String {
    let lines: Vec<String> = errors.iter().map(ToString::to_string).collect();
    lines.join("\n")
}
