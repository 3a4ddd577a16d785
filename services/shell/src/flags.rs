//! The flags that every service and every companion understands.

use crate::error::StartError;
use crate::logs;
use crate::nearest::hinted;
use crate::places::{Places, line_of};
use crate::printable::printable;
use clap::{ArgGroup, Args, Parser};
use core::ops::Range;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;
use toml::de::DeTable;
use zeronav_files::read;

/// Highest epoch of a process that may be obeyed; those above are for shadows.
const EPOCH_MAX: i64 = zeronav_msgs::header::SHADOW_EPOCH_MIN as i64 - 1;

/// The group of the flags that ask a program something instead of starting it.
const QUESTIONS: &str = "question";

/// The flags that services and companions share.
#[derive(Debug, Clone, Args)]
#[command(group = ArgGroup::new(QUESTIONS).multiple(true))]
pub struct MemberFlags {
    /// Root folder of the run, directly under /dev/shm; its name is the prefix of everything.
    #[arg(long, value_name = "ROOT", required_unless_present = QUESTIONS)]
    pub domain: Option<PathBuf>,
    /// TOML file with the program's configuration; without it, defaults.
    #[arg(long, value_name = "FILE")]
    pub config: Option<PathBuf>,
    /// error, warn, info, debug, trace, or a filter such as `warn,zeronav_mapping=debug`.
    #[arg(long, value_name = "LEVEL", default_value = "info", value_parser = logs::filter)]
    pub log_level: String,
    /// Print the configuration that would be used as TOML and leave.
    #[arg(long, group = QUESTIONS)]
    pub print_config: bool,
    /// Print all parameters of the configuration as a JSON list and leave.
    #[arg(long, group = QUESTIONS)]
    pub print_params: bool,
}

/// The flags of a service, and what people want to know of one.
#[derive(Debug, Clone, Parser)]
#[command(about = "A service of a zeronav stack; normally started by `zeronav run`.", long_about = None)]
pub struct Flags {
    /// Those that it shares with companions.
    #[command(flatten)]
    pub member: MemberFlags,
    /// Which start of this role this is, as launch says: it gives every process a higher one and
    /// obeys that one alone.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=EPOCH_MAX), required_unless_present_any = [QUESTIONS, "shadow"], conflicts_with = "shadow")]
    pub epoch: Option<u32>,
    /// Run beside the process that sits in this seat: hear and answer, but never be obeyed.
    #[arg(long)]
    pub shadow: bool,
    /// With --print-config: ticks and scans per second of the run that the configuration is for.
    #[arg(long, value_name = "TICKS,SCANS", value_parser = Rates::parse, requires = "print_config")]
    pub rates: Option<Rates>,
    /// Print the algorithms that the configuration can name, one a line, and leave.
    #[arg(long, group = QUESTIONS)]
    pub list: bool,
}

/// The flags of a companion.
#[derive(Debug, Clone, Parser)]
#[command(about = "A companion of a zeronav stack; normally started by `zeronav run`.", long_about = None)]
pub struct CompanionFlags {
    /// Those that it shares with services.
    #[command(flatten)]
    pub member: MemberFlags,
    /// Which start of this companion this is; it counts the messages on its own topics onwards from
    /// those of the starts before.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=EPOCH_MAX), default_value = "1")]
    pub epoch: u32,
}

/// How often a run ticks and scans.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rates {
    /// Time from tick to tick. [s]
    pub tick_s: f64,
    /// Time from scan to scan. [s]
    pub scan_s: f64,
}

impl Rates {
    /// Reads `TICKS,SCANS`, both per second.
    fn parse(text: &str) -> Result<Self, String> {
        let period_s = |rate_hz: &str| {
            let rate_hz: f64 = rate_hz.trim().parse().ok()?;
            (rate_hz > 0.0 && rate_hz.is_finite()).then(|| rate_hz.recip())
        };
        text.split_once(',')
            .and_then(|(ticks, scans)| {
                Some(Self {
                    tick_s: period_s(ticks)?,
                    scan_s: period_s(scans)?,
                })
            })
            .ok_or_else(|| "must be two rates above 0, such as 50,10".to_owned())
    }
}

/// The configuration of a program that has nothing to set; an unknown key is refused.
#[derive(Debug, Clone, Copy, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NoConfig {}

impl MemberFlags {
    /// The configuration of the file; without one, that of an empty file. What `check` refuses is
    /// reported like what cannot be read.
    ///
    /// # Errors
    /// [`StartError::Usage`] naming file, line and field.
    pub fn read_config<C: Serialize + DeserializeOwned>(
        &self,
        check: impl FnOnce(&C) -> Result<(), StartError>,
    ) -> Result<C, StartError> {
        let Some(path) = &self.config else {
            let config = toml::from_str("").map_err(|error| {
                StartError::Usage(format!("--config FILE is needed: {}", error.message()))
            })?;
            return check(&config).map(|()| config);
        };
        let file = path.display();
        let text = read::text(path, read::TEXT_BYTES_MAX)
            .map_err(|error| StartError::Usage(format!("configuration {file}: {error}")))?;
        let at = |offset: usize, why: &str| {
            let line = line_of(&text, offset);
            StartError::Usage(format!("configuration {file}:{line}: {why}"))
        };
        let start = |span: Option<Range<usize>>| span.unwrap_or_default();
        let table = DeTable::parse(&text)
            .map_err(|error| at(start(error.span()).start, &hinted(error.message())))?;
        let places = Places::of(table.get_ref());
        let refused = |field: &str, why: &str| {
            let offset = places.key_of(field).unwrap_or(0);
            at(offset, &format!("{field}: {why}"))
        };
        let config = C::deserialize(toml::Deserializer::from(table)).map_err(|error| {
            let span = start(error.span());
            match places.at_span(&span, error.message()) {
                (field, why) if field.is_empty() => at(span.start, &why),
                (field, why) => at(span.start, &format!("{field}: {why}")),
            }
        })?;
        if let Some((field, why)) = places.surplus(&config) {
            return Err(refused(&field, &why));
        }
        match check(&config) {
            Err(StartError::Config { field, why }) => Err(refused(&field, &why)),
            other => other.map(|()| config),
        }
    }

    /// The configuration as TOML, for `--print-config`.
    ///
    /// # Errors
    /// [`StartError::Usage`] when a value has no TOML form.
    pub(crate) fn config_text<C: Serialize>(config: &C) -> Result<String, StartError> {
        toml::to_string_pretty(config)
            .map_err(|error| StartError::Usage(format!("configuration has no TOML form: {error}")))
    }
}

/// What is wrong with the arguments of a command line, in one line.
#[must_use]
pub fn one_line(error: &clap::Error) -> String {
    let text = error.to_string();
    let parts = text
        .split("\n\n")
        .take_while(|part| !part.starts_with("Usage:") && !part.starts_with("For more"));
    let in_one = |part: &str| part.split_whitespace().collect::<Vec<_>>().join(" ");
    let line = parts.map(in_one).collect::<Vec<_>>().join("; ");
    let line = line.strip_prefix("error: ").unwrap_or(&line);
    printable(line).into_owned()
}
