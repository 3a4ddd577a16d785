//! The command line of `zeronav latency`.

use crate::output_args::OutputArgs;
use crate::run_plan::MachineLoad;
use clap::Args;
use std::path::PathBuf;
use zeronav_console::arguments::delay;
use zeronav_msgs::role::Role;

/// Trials without `--trials`.
pub(super) const TRIALS: u32 = 30;

/// Arguments of `zeronav latency`.
#[derive(Debug, Clone, Args)]
pub struct LatencyArgs {
    /// Name (see `zeronav list`) or path of a scenario with `[trials]`, which is measured; or the
    /// folder of a run in real time, whose latencies are shown.
    #[arg(value_name = "SCENARIO|RUN")]
    pub subject: String,
    /// Trials of each measurement, in three rounds; 30 without. A 99th percentile of replanning
    /// needs 100.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=10_000))]
    pub trials: Option<u32>,
    /// Scans per second in place of the scenario's, one measurement for each.
    #[arg(long, value_name = "HZ,HZ", value_delimiter = ',', value_parser = rate_hz)]
    pub rate: Vec<f64>,
    /// What else the machine does, one measurement for each: idle, or busy with a process per core.
    #[arg(long, value_name = "idle,busy", value_delimiter = ',', value_enum)]
    pub load: Vec<MachineLoad>,
    /// Delay every answer of a service, to see that its hop is named. May be given several times.
    #[arg(long, value_name = "ROLE=TIME", value_parser = delay)]
    pub inject: Vec<(Role, u16)>,
    /// What has to hold, such as 'replanning.p99 < 5ms, reaction.p50 < 1.1x'; x is the ratio to the
    /// baseline. Exit code 1 when it does not.
    #[arg(long = "assert", value_name = "EXPR, EXPR")]
    pub assertion: Option<String>,
    /// Report of an earlier measurement, as `--save-baseline` or `--json` wrote it.
    #[arg(long, value_name = "FILE")]
    pub baseline: Option<PathBuf>,
    /// Write the report, to be the baseline of later ones.
    #[arg(long, value_name = "FILE")]
    pub save_baseline: Option<PathBuf>,
    /// Seed of everything random, in place of the scenario's.
    #[arg(long, value_name = "N")]
    pub seed: Option<u64>,
    /// What it shows.
    #[command(flatten)]
    pub output: OutputArgs,
}

impl LatencyArgs {
    /// The first flag that asks for a measurement.
    pub(super) fn measures(&self) -> Option<&'static str> {
        let flags = [
            ("--trials", self.trials.is_some()),
            ("--rate", !self.rate.is_empty()),
            ("--load", !self.load.is_empty()),
            ("--inject", !self.inject.is_empty()),
            ("--seed", self.seed.is_some()),
        ];
        let given = flags.iter().find(|(_, given)| *given);
        given.map(|(flag, _)| *flag)
    }
}

fn rate_hz(text: &str) -> Result<f64, String> {
    let rate_hz = text.trim().parse::<f64>();
    let rate_hz = rate_hz.map_err(|_| format!("`{text}` is no number of scans per second"))?;
    if rate_hz.is_finite() && rate_hz > 0.0 {
        Ok(rate_hz)
    } else {
        Err(format!("`{text}`: a rate is above 0 Hz"))
    }
}
