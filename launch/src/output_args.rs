//! What a verb that drives shows, and where its runs go.

use crate::run_plan::RunPlan;
use clap::Args;
use std::path::PathBuf;
use zeronav_shell::logs;

/// What a verb that drives shows, and where its runs go.
#[derive(Debug, Clone, Args)]
pub struct OutputArgs {
    /// Print the result as one JSON object on standard output.
    #[arg(long)]
    pub json: bool,
    /// Show nothing while it runs.
    #[arg(long)]
    pub headless: bool,
    /// Folder in which every run's own folder is made.
    #[arg(long, value_name = "FOLDER", default_value = "runs")]
    pub out: PathBuf,
    /// What the services log: error, warn, info, debug, trace, or a filter.
    #[arg(long, value_name = "LEVEL", default_value = "info", value_parser = logs::filter)]
    pub log_level: String,
}

impl OutputArgs {
    /// What they mean for a run.
    pub(crate) fn laid_over(&self, plan: RunPlan) -> RunPlan {
        RunPlan {
            out: self.out.clone(),
            log_level: self.log_level.clone(),
            progress: !self.headless,
            ..plan
        }
    }
}
