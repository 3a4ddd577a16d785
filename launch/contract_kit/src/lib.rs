//! `zeronav contract`: whether a program may be swapped into a seat, clause by clause.
//!
//! The program runs alone in private domains. The kit is launch there and plays every other seat from
//! a small synthetic world; the clauses are numbered in `services/README.md`.

mod bench;
mod clause;
pub mod cli;
mod hostile;
mod legal;
mod lockstep;
pub mod no_memory;
mod others;
mod program;
mod raw;
mod real_time;
mod report;
mod robot;
mod room;
mod seats;
mod short_runs;

use clause::{Clause, Verdict};
use cli::ContractArgs;
use program::Program;
use report::Report;
use serde_json::json;
use std::process::ExitCode;
use zeronav_console::environment;
use zeronav_console::exit::{EXIT_FAIL, EXIT_PASS};
use zeronav_console::terminal::{note, say, say_json, usage};
use zeronav_supervise::temporary::TemporaryFolder;

/// `zeronav contract`.
#[must_use]
pub fn contract(arguments: &ContractArgs) -> ExitCode {
    let folder = match TemporaryFolder::new("zeronav-contract-") {
        Ok(folder) => folder,
        Err(error) => return usage(&format!("making a folder for logs: {error}")),
    };
    let program = match Program::find(arguments, folder.path()) {
        Ok(program) => program,
        Err(problem) => return usage(&problem),
    };
    environment::warn_when_busy();
    note(&format!(
        "{} clauses, {} hostile messages: usually about {} min",
        Clause::ALL.len(),
        arguments.hostile,
        arguments.hostile.div_ceil(1_000_000)
    ));
    let mut report = Report::new(arguments.json);
    short_runs::test(&program, &mut report);
    seats::test(&program, &mut report);
    if lockstep::test(&program, &mut report) {
        real_time::test(&program, arguments.hostile, &mut report);
    } else {
        report.skip_rest(&Clause::ALL, "the program did not get ready");
    }
    let passes = report.passes();
    let lines = report.lines();
    if arguments.json {
        say_json(&json!({
            "role": program.role.label(),
            "binary": program.binary.display().to_string(),
            "passes": passes,
            "hostile_messages": arguments.hostile,
            "clauses": lines,
        }));
    } else {
        let failed = lines.iter().filter(|line| line.verdict == Verdict::Failed);
        let verdict = match failed.count() {
            0 => "it may be swapped in".to_owned(),
            n => format!("{n} of {} clauses are broken", lines.len()),
        };
        say(&format!("{}: {verdict}\n", program.role));
    }
    ExitCode::from(if passes { EXIT_PASS } else { EXIT_FAIL })
}
