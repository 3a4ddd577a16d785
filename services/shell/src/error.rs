//! Why a process could not start, and the exit code that says so.

use crate::shm;
use std::process::ExitCode;
use zeronav_params::ParameterError;

/// Exit code of a process that stopped because it was asked to.
pub(crate) const EXIT_STOPPED: u8 = 0;
/// Exit code of bad flags or bad configuration. Not restarted.
pub const EXIT_USAGE: u8 = 2;
/// Exit code of a peer built from another contract. Not restarted.
pub(crate) const EXIT_CONTRACT: u8 = 3;
/// Exit code of too little shared memory, which a later restart may find.
pub(crate) const EXIT_MEMORY: u8 = 4;
/// Exit code of everything else that a restart may cure.
pub(crate) const EXIT_CRASH: u8 = 1;

/// Why a process could not start. Each names the thing that is wrong.
#[derive(Debug, thiserror::Error)]
pub enum StartError {
    /// Flags or configuration.
    #[error("{0}")]
    Usage(String),
    /// A value of the configuration.
    #[error("configuration: {field}: {why}")]
    Config {
        /// Path of the value, such as `dwa.horizon_s`.
        field: String,
        /// What is wrong and what would be right.
        why: String,
    },
    /// A topic exists with another layout, or not at all.
    #[error("contract: topic {topic}: {problem}")]
    Contract {
        /// Name of the topic.
        topic: String,
        /// What is wrong with it.
        problem: String,
    },
    /// Too little shared memory.
    #[error(
        "shared memory: {needed} bytes more are needed in /dev/shm and {free} are free; \
         enlarge it (docker: --shm-size) or remove what fills it"
    )]
    Memory {
        /// Bytes that the process would take.
        needed: u64,
        /// Bytes that are free.
        free: u64,
    },
    /// Too few inodes for the files of a stack.
    #[error(
        "shared memory: a stack needs some {needed} inodes in /dev/shm and {free} are free \
         (`df -i /dev/shm`); enlarge it (mount option nr_inodes) or remove what fills it"
    )]
    Inodes {
        /// Inodes that a stack takes.
        needed: u64,
        /// Inodes that are free.
        free: u64,
    },
    /// A topic has no place left for one more process.
    #[error("{what}: all {places} places are taken")]
    Full {
        /// What was tried.
        what: String,
        /// How many places there are.
        places: usize,
    },
    /// The middleware or the system refused something.
    #[error("{what}: {why}")]
    System {
        /// What was tried.
        what: String,
        /// What came back.
        why: String,
    },
}

impl From<ParameterError> for StartError {
    fn from(error: ParameterError) -> Self {
        let why = format!("{}, not {}", error.rule, error.value);
        Self::config(error.path, why)
    }
}

impl StartError {
    /// A refusal of the middleware or the system.
    pub fn system(what: impl Into<String>, why: impl core::fmt::Display) -> Self {
        let mut why = why.to_string();
        // All that the middleware says of most errors of the system.
        if why.contains("InternalFailure") {
            why.push_str(shm::shortage());
        }
        Self::System {
            what: what.into(),
            why,
        }
    }

    /// A value of the configuration that cannot be.
    pub fn config(field: impl Into<String>, why: impl core::fmt::Display) -> Self {
        Self::Config {
            field: field.into(),
            why: why.to_string(),
        }
    }

    /// The process's exit code.
    #[must_use]
    pub fn exit_code(&self) -> ExitCode {
        ExitCode::from(match self {
            Self::Usage(_) | Self::Config { .. } => EXIT_USAGE,
            Self::Memory { .. } | Self::Inodes { .. } => EXIT_MEMORY,
            Self::Contract { .. } => EXIT_CONTRACT,
            Self::Full { .. } | Self::System { .. } => EXIT_CRASH,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn too_little_memory_is_not_called_bad_configuration() {
        let shortage = StartError::Memory { needed: 2, free: 1 };
        assert_eq!(shortage.exit_code(), ExitCode::from(EXIT_MEMORY));
        let usage = StartError::Usage(String::new());
        assert_eq!(usage.exit_code(), ExitCode::from(EXIT_USAGE));
    }
}
