//! The line on the terminal while a run goes on.

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::time::Duration;

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
