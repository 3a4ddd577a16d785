//! The flags that every service understands.

use crate::error::StartError;
use clap::Parser;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// The five flags of a service, and one for curious people.
#[derive(Debug, Clone, Parser)]
#[command(about = "A service of a zeronav stack; normally started by `zeronav run`.", long_about = None)]
pub struct Flags {
    /// Root folder of the run, directly under /dev/shm; its name is the prefix of everything.
    #[arg(long, value_name = "ROOT", required_unless_present_any = ["print_config", "list"])]
    pub domain: Option<PathBuf>,
    /// Which start of this role this is; launch gives every process a higher one.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=0xff_ffff))]
    pub epoch: u32,
    /// TOML file with the service's configuration; without it, defaults.
    #[arg(long, value_name = "FILE")]
    pub config: Option<PathBuf>,
    /// error, warn, info, debug, trace, or a filter such as `warn,zeronav_mapping=debug`.
    #[arg(long, value_name = "LEVEL", default_value = "info")]
    pub log_level: String,
    /// Print the configuration that would be used as TOML and leave.
    #[arg(long)]
    pub print_config: bool,
    /// Print the algorithms that the configuration can name, one a line, and leave.
    #[arg(long)]
    pub list: bool,
}

/// The configuration of a service that has nothing to set; an unknown key is refused.
#[derive(Debug, Clone, Copy, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NoConfig {}

impl Flags {
    /// The configuration of the file; without one, that of an empty file.
    ///
    /// # Errors
    /// [`StartError::Usage`] naming file, line and field.
    pub fn read_config<C: DeserializeOwned>(&self) -> Result<C, StartError> {
        let Some(path) = &self.config else {
            return toml::from_str("").map_err(|error| {
                StartError::Usage(format!("--config FILE is needed: {}", error.message()))
            });
        };
        let text = std::fs::read_to_string(path).map_err(|error| {
            StartError::Usage(format!("configuration {}: {error}", path.display()))
        })?;
        toml::from_str(&text).map_err(|error| {
            let line = error.span().map_or(1, |span| {
                text[..span.start.min(text.len())].matches('\n').count() + 1
            });
            StartError::Usage(format!(
                "configuration {}:{line}: {}",
                path.display(),
                error.message()
            ))
        })
    }

    /// The configuration as TOML, for `--print-config`.
    ///
    /// # Errors
    /// [`StartError::Usage`] when a value has no TOML form.
    pub fn config_text<C: Serialize>(config: &C) -> Result<String, StartError> {
        toml::to_string_pretty(config)
            .map_err(|error| StartError::Usage(format!("configuration has no TOML form: {error}")))
    }
}
