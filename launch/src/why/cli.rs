//! The arguments of `zeronav why`.

use crate::remote::cli::StackArgs;
use clap::Args;
use std::path::PathBuf;

/// Arguments of `zeronav why`.
#[derive(Debug, Clone, Args)]
pub struct WhyArgs {
    /// Folder of a run that is over, or a time in the newest run of ./runs [s]; without, the running
    /// stack as it is now, or as it was `--ago`.
    #[arg(value_name = "RUN|TIME")]
    pub of: Option<PathBuf>,
    /// Time in that run, from its first goal on; without, its end. [s]
    #[arg(value_name = "TIME", value_parser = time)]
    pub time: Option<f64>,
    /// Every change of the run, a line each.
    #[arg(long, requires = "of", conflicts_with = "time")]
    pub all: bool,
    /// Run time before now, of the running stack: what the stages said last until then. [s]
    #[arg(long, value_name = "TIME", value_parser = time, conflicts_with = "of")]
    pub ago: Option<f64>,
    /// The stack.
    #[command(flatten)]
    pub stack: StackArgs,
}

/// Longest run that a time can name. [s]
const TIME_S_MAX: f64 = 1.0e8;

/// A time of a run. [s]
pub(super) fn time(text: &str) -> Result<f64, String> {
    let time_s = text.trim_end_matches('s').parse::<f64>().ok();
    let time_s = time_s.filter(|time_s| (0.0..=TIME_S_MAX).contains(time_s));
    time_s.ok_or_else(|| format!("a time is from 0 to {TIME_S_MAX} seconds, such as 12.5"))
}
