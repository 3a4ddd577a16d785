//! Why a map file could not be read or written.

use std::io;
use std::path::PathBuf;

/// Why a map file could not be read or written.
#[derive(Debug, thiserror::Error)]
pub enum MapFileError {
    /// A file could not be opened or read.
    #[error("{}: {source}", file.display())]
    Read {
        /// The YAML file or the image.
        file: PathBuf,
        /// What the system says.
        source: io::Error,
    },
    /// The YAML file is no YAML file of a map.
    #[error("{}: {why}", file.display())]
    Yaml {
        /// The YAML file.
        file: PathBuf,
        /// What the parser says, with line and column.
        why: String,
    },
    /// A value of the YAML file cannot be.
    #[error("{}: {field}: {why}", file.display())]
    Field {
        /// The YAML file.
        file: PathBuf,
        /// The key.
        field: &'static str,
        /// What is wrong with its value.
        why: String,
    },
    /// The image is no PGM or PNG image, broken, or too large.
    #[error("{}: {why}", file.display())]
    Image {
        /// The image.
        file: PathBuf,
        /// What is wrong.
        why: String,
    },
    /// A file could not be written.
    #[error("{}: {source}", file.display())]
    Write {
        /// The YAML file or the image.
        file: PathBuf,
        /// What the system says.
        source: io::Error,
    },
}
