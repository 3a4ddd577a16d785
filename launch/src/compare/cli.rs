//! The command line of `zeronav compare`.

use clap::Args;
use std::path::PathBuf;
use zeronav_console::arguments::seat;
use zeronav_msgs::role::Role;
use zeronav_shell::logs;

/// Arguments of `zeronav compare`.
#[derive(Debug, Clone, Args)]
pub struct CompareArgs {
    /// Name (see `zeronav list`) or path of a scenario with `[trials]`.
    pub a: String,
    /// What it is compared with: another scenario, or the same one with `--swap`.
    #[arg(required_unless_present = "swap", conflicts_with = "swap")]
    pub b: Option<String>,
    /// Compare the scenario with itself, but with this binary in a seat. May be given several times.
    #[arg(long, value_name = "ROLE=BINARY", value_parser = seat)]
    pub swap: Vec<(Role, PathBuf)>,
    /// Trials of each side, in six rounds that take turns.
    #[arg(long, value_name = "N", default_value_t = 30,
          value_parser = clap::value_parser!(u32).range(6..=10_000))]
    pub trials: u32,
    /// Seed of the first round, in place of the scenario's; both sides have the same.
    #[arg(long, value_name = "N")]
    pub seed: Option<u64>,
    /// Print one JSON object.
    #[arg(long)]
    pub json: bool,
    /// Show nothing while it runs.
    #[arg(long)]
    pub headless: bool,
    /// Folder in which the folders of both sides are made.
    #[arg(long, value_name = "FOLDER", default_value = "runs")]
    pub out: PathBuf,
    /// What the services log: error, warn, info, debug, trace, or a filter.
    #[arg(long, value_name = "LEVEL", default_value = "info", value_parser = logs::filter)]
    pub log_level: String,
}
