//! Why a suite did not run to its end.

use super::ran::Ran;
use super::runner::Stopped;

/// Why a suite did not run to its end.
#[derive(Debug)]
pub enum SuiteError {
    /// Usage or configuration, in one line.
    Usage(String),
    /// Ctrl-C: everything is stopped, the report says what there is.
    Interrupted(Option<Box<Ran>>),
    /// A file could not be written, in one line.
    Lost(String),
}

impl From<String> for SuiteError {
    fn from(problem: String) -> Self {
        Self::Usage(problem)
    }
}

impl From<Stopped> for SuiteError {
    fn from(stopped: Stopped) -> Self {
        match stopped {
            Stopped::Refused(problem) => Self::Usage(problem),
            Stopped::Lost(problem) => Self::Lost(problem),
            Stopped::Interrupted => Self::Interrupted(None),
        }
    }
}
