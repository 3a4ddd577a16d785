//! The line on the terminal while a run goes on.

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::time::Duration;

/// How far the trials are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrialProgress {
    /// Trials that are over, of all rounds.
    pub done: usize,
    /// Trials of all rounds.
    pub total: usize,
    /// Wall time of one. [s]
    pub per_trial_s: Option<f64>,
}

/// What the line says.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Progress {
    /// Run time. [s]
    pub time_s: f64,
    /// State of the task.
    pub state: String,
    /// Way left. [m]
    pub remaining_m: Option<f64>,
    /// Last new path: run time and cause. [s]
    pub last_replan: Option<(f64, String)>,
    /// The trials, if that is what the run is for.
    pub trials: Option<TrialProgress>,
}

/// The line. Silent when it is not wanted or standard error is no terminal.
#[derive(Debug)]
pub struct ProgressLine {
    bar: ProgressBar,
}

impl ProgressLine {
    /// A line for a run of `scenario`.
    #[must_use]
    pub fn new(scenario: &str, wanted: bool) -> Self {
        let target = if wanted {
            ProgressDrawTarget::stderr_with_hz(10)
        } else {
            ProgressDrawTarget::hidden()
        };
        let bar = ProgressBar::with_draw_target(None, target);
        if let Ok(style) = ProgressStyle::with_template("{spinner} {prefix}  {msg}") {
            bar.set_style(style);
        }
        bar.set_prefix(scenario.to_owned());
        bar.enable_steady_tick(Duration::from_millis(200));
        Self { bar }
    }

    /// Shows the newest state.
    pub fn show(&self, progress: &Progress) {
        if self.bar.is_hidden() {
            return;
        }
        if let Some(trials) = progress.trials {
            self.bar.set_message(in_words(trials));
            return;
        }
        let remaining = progress
            .remaining_m
            .map_or_else(String::new, |way| format!("  {way:.1} m to go"));
        let replan = progress
            .last_replan
            .as_ref()
            .map_or_else(String::new, |(time, cause)| {
                format!("  last path {time:.2} s ({cause})")
            });
        self.bar.set_message(format!(
            "{:7.2} s  {}{remaining}{replan}",
            progress.time_s, progress.state
        ));
    }

    /// Takes the line away.
    pub fn clear(&self) {
        self.bar.finish_and_clear();
    }
}

/// Trial 37 of 200, about 4.2 min left.
#[allow(clippy::cast_precision_loss, reason = "counts far below 2^53")]
fn in_words(trials: TrialProgress) -> String {
    let left = trials.total.saturating_sub(trials.done) as f64;
    let time = trials.per_trial_s.map_or_else(String::new, |each_s| {
        format!(", about {:.1} min left", left * each_s / 60.0)
    });
    format!("{} of {} trials{time}", trials.done, trials.total)
}
