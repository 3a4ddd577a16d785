//! `zeronav ps`: the stacks of this user.

use crate::control::request::RunReport;
use crate::exit::EXIT_PASS;
use crate::running;
use crate::show::terminal::{say, say_json};
use core::fmt::Write;
use serde_json::json;
use std::process::ExitCode;
use zeronav_shell::printable;

/// `zeronav ps`.
#[must_use]
pub fn ps(json: bool) -> ExitCode {
    let runs: Vec<RunReport> = running::all()
        .into_iter()
        .map(|(_, report)| report)
        .collect();
    if json {
        say_json(&json!({ "runs": runs }));
        return ExitCode::from(EXIT_PASS);
    }
    if runs.is_empty() {
        say("no run goes on\n");
    }
    for run in &runs {
        say(&processes(run));
    }
    ExitCode::from(EXIT_PASS)
}

/// A stack in one line, and its processes in one each.
pub(crate) fn processes(run: &RunReport) -> String {
    let mut text = format!(
        "{}  pid {}  {}  {}  {:.1} s  task {}{}\n",
        printable(&run.scenario),
        run.pid,
        printable(&run.domain),
        printable(&run.mode),
        run.time_s,
        printable(&run.task),
        if run.paused { "  paused" } else { "" }
    );
    for service in &run.services {
        let _ = writeln!(
            text,
            "  {:<16} pid {:<8} epoch {}  {:<9} {:>5.0} MB  {}",
            printable(&service.role),
            service.pid,
            service.epoch,
            printable(&service.state),
            megabytes(service.memory_peak_bytes),
            printable(&service.binary)
        );
    }
    text
}

#[allow(clippy::cast_precision_loss, reason = "sizes far below 2^53")]
fn megabytes(bytes: u64) -> f64 {
    bytes as f64 / 1.0e6
}
