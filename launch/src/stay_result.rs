//! What a stack that stayed up leaves: its goals, its contacts, its processes.

use crate::drive::Driven;
use crate::judge;
use crate::prepare::Prepared;
use crate::result::fault::FaultResult;
use crate::result::latency::{Figures, Latency};
use crate::result::swap::SwapResult;
use crate::result::{Environment, Redirect, Restart, ServiceResult, Starved};
use crate::show::page::fault_line;
use crate::show::page::starved_line;
use core::fmt::Write;
use serde::{Deserialize, Serialize};
use zeronav_msgs::run::RunMode;
use zeronav_msgs::time::seconds;

/// What became of a stack.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(crate) struct StayResult {
    /// Scenario.
    pub scenario: String,
    /// How it ended: `down`, `interrupted`, or what went wrong.
    pub outcome: String,
    /// Run time since it was ready. [s]
    pub time_s: f64,
    /// Wall time since its start. [s]
    pub wall_s: f64,
    /// The goals of clients, at most the newest 1000.
    pub goals: Vec<Redirect>,
    /// Contacts of the simulated robot.
    pub contacts: u32,
    /// Restarts of services.
    pub restarts: Vec<Restart>,
    /// Services that got no processor for longer than `hang_after_s`, in real time.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub starved: Vec<Starved>,
    /// Faults that were made on purpose.
    pub faults: Vec<FaultResult>,
    /// Swaps and comparisons, at most the newest 100.
    pub swaps: Vec<SwapResult>,
    /// Latencies, in real time only; of a long stay those of its end.
    #[serde(default)]
    pub latency: Option<Latency>,
    /// The processes.
    pub services: Vec<ServiceResult>,
    /// Machine and build.
    pub environment: Environment,
    /// Folder with everything that it left.
    pub directory: String,
}

impl StayResult {
    /// What was seen of it.
    pub(crate) fn of(prepared: &Prepared, driven: &Driven, environment: Environment) -> Self {
        let truth = driven.collector.truth.unwrap_or_default();
        Self {
            scenario: prepared.scenario.name.clone(),
            outcome: driven.ending.outcome().to_owned(),
            time_s: seconds(driven.end_run_ns.saturating_sub(driven.goals_run_ns)),
            wall_s: driven.wall.as_secs_f64(),
            goals: driven.redirects.clone(),
            contacts: truth.contacts_moving + truth.contacts_standing,
            restarts: driven.restarts.clone(),
            starved: driven.starved.clone(),
            faults: driven.faults.clone(),
            swaps: driven.swaps.clone(),
            latency: (prepared.mode == RunMode::RealTime)
                .then(|| judge::latency(prepared, driven).1),
            services: driven.services.clone(),
            environment,
            directory: prepared.directory.display().to_string(),
        }
    }

    /// A few lines.
    pub(crate) fn to_text(&self) -> String {
        let reached = self.goals.iter().filter(|goal| goal.outcome == "reached");
        let mut text = format!(
            "{}: {} after {:.1} s of run time, {} of {} goals reached, {} contacts, {} restarts\n",
            self.scenario,
            self.outcome,
            self.time_s,
            reached.count(),
            self.goals.len(),
            self.contacts,
            self.restarts.len(),
        );
        if let Some(latency) = &self.latency {
            for (name, figures) in [
                ("reaction", &latency.reaction),
                ("replanning", &latency.replanning),
            ] {
                text.push_str(&latency_line(name, figures));
            }
        }
        for restart in &self.restarts {
            let _ = writeln!(
                text,
                "  {:8.2} s  {} restarted: {}",
                restart.time_s, restart.service, restart.how
            );
        }
        for seat in &self.starved {
            text.push_str(&starved_line(seat));
        }
        for fault in &self.faults {
            text.push_str(&fault_line(fault));
        }
        let _ = writeln!(text, "  {}", self.directory);
        text
    }
}

/// Median and 99th percentile, where there are samples enough for them.
fn latency_line(name: &str, figures: &Figures) -> String {
    let figures = figures.supported();
    let times: Vec<String> = [("p50", figures.p50_us), ("p99", figures.p99_us)]
        .into_iter()
        .filter_map(|(percentile, us)| Some(format!("{percentile} {:.2} ms", us? / 1.0e3)))
        .collect();
    if times.is_empty() {
        return String::new();
    }
    format!("  {name} {}, n {}\n", times.join(", "), figures.n)
}
