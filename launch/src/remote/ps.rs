//! `zeronav ps`: the stacks of this user.

use crate::control::request::RunReport;
use crate::running::{self, Silent};
use core::fmt::Write;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use zeronav_casts::Cast;
use zeronav_console::exit::EXIT_PASS;
use zeronav_console::terminal::{say, say_json};
use zeronav_shell::printable;

/// `zeronav ps`.
#[must_use]
pub fn ps(json: bool) -> ExitCode {
    let runs = running::all();
    if json {
        let runs: Vec<Value> = runs.iter().map(in_json).collect();
        say_json(&json!({ "runs": runs }));
        return ExitCode::from(EXIT_PASS);
    }
    if runs.is_empty() {
        say("no run goes on\n");
    }
    for (root, run) in &runs {
        say(&match run {
            Ok(report) => processes(report),
            Err(silent) => not_answering(root, silent),
        });
    }
    ExitCode::from(EXIT_PASS)
}

fn in_json((root, run): &(PathBuf, Result<RunReport, Silent>)) -> Value {
    match run {
        Ok(report) => json!(report),
        Err(silent) => json!({
            "domain": root.display().to_string(),
            "pid": silent.pid,
            "silent": silent.why,
        }),
    }
}

fn not_answering(root: &Path, silent: &Silent) -> String {
    let pid = (silent.pid).map_or_else(|| "?".to_owned(), |pid| pid.to_string());
    let domain = root.display().to_string();
    format!(
        "does not answer  pid {pid}  {}  {}; `zeronav down --domain {}` ends it\n",
        printable(&domain),
        silent.why,
        printable(&domain)
    )
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
            "  {:<16} pid {:<8} epoch {}  {:<9} {:>5.0} MB  {}{}",
            printable(&service.role),
            service.pid,
            service.epoch,
            printable(&service.state),
            megabytes(service.memory_peak_bytes),
            printable(&service.binary),
            on_host(service.host.as_deref())
        );
    }
    for companion in &run.companions {
        let pid = match companion.pid {
            0 => "-".to_owned(),
            pid => pid.to_string(),
        };
        let _ = writeln!(
            text,
            "  {:<16} pid {pid:<8} start {}  {:<9} beside    {}",
            printable(&companion.name),
            companion.starts,
            printable(&companion.state),
            printable(&companion.binary)
        );
    }
    text
}

/// Where a seat is filled, behind the name of a program; empty when one computer fills all.
pub(crate) fn on_host(host: Option<&str>) -> String {
    host.map_or_else(String::new, |host| format!(" on {}", printable(host)))
}

fn megabytes(bytes: u64) -> f64 {
    bytes.to_f64() / 1.0e6
}
