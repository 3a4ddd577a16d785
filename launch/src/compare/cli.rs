//! The command line of `zeronav compare`.

use crate::output_args::OutputArgs;
use clap::Args;
use std::path::PathBuf;
use zeronav_console::arguments::seat;
use zeronav_msgs::role::Role;

/// Arguments of `zeronav compare`.
#[derive(Debug, Clone, Args)]
pub struct CompareArgs {
    /// Name (see `zeronav list`) or path of a scenario with `[trials]`, with --lockstep of any. Two runs with --record
    /// (folders or MCAP files) are compared as `zeronav diff` does.
    pub a: String,
    /// What it is compared with: another scenario or run, or the same scenario with `--swap`.
    #[arg(required_unless_present = "swap", conflicts_with = "swap")]
    pub b: Option<String>,
    /// Compare the scenario with itself, but with this binary in a seat. May be given several times.
    #[arg(long, value_name = "ROLE=BINARY", value_parser = seat)]
    pub swap: Vec<(Role, PathBuf)>,
    /// Drive both sides once in lockstep, with --record, and say where they begin to differ, by tick, topic and field, in
    /// place of their latencies. The exit code is 0 whether they differ or not.
    #[arg(long)]
    pub lockstep: bool,
    /// Trials of each side, in six rounds that take turns.
    #[arg(long, value_name = "N", default_value_t = 30, conflicts_with = "lockstep",
          value_parser = clap::value_parser!(u32).range(6..=10_000))]
    pub trials: u32,
    /// Seed of the first round, in place of the scenario's; both sides have the same.
    #[arg(long, value_name = "N")]
    pub seed: Option<u64>,
    /// What it shows.
    #[command(flatten)]
    pub output: OutputArgs,
}
