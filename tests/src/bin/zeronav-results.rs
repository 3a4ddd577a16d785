//! Makes the figures of the READMEs.

use clap::{Parser, Subcommand};
use std::path::PathBuf;
use std::process::ExitCode;
use zeronav_tests::results::{self, experiments::EXPERIMENTS, record};

/// Measures, and writes tests/results.json, tests/RESULTS.md and the marked blocks of the READMEs.
#[derive(Debug, Parser)]
#[command(version)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Makes experiments: those with these keys, or the default set.
    Measure {
        /// Keys of experiments, see `list`.
        keys: Vec<String>,
        /// All of them.
        #[arg(long, conflicts_with = "keys")]
        all: bool,
        /// Folder of the data sets; without, where `zeronav suite` looks for them.
        #[arg(long, env = "ZERONAV_DATA")]
        data: Option<PathBuf>,
    },
    /// Writes the pages again from the stored records.
    Render,
    /// Lists the experiments and how long they take.
    List,
}

fn main() -> ExitCode {
    match run(Arguments::parse().command) {
        Ok(()) => ExitCode::SUCCESS,
        Err(problem) => {
            eprintln!("zeronav-results: {problem}");
            ExitCode::FAILURE
        }
    }
}

#[allow(clippy::print_stdout, reason = "this is what the user asked for")]
fn run(command: Command) -> Result<(), String> {
    match command {
        Command::Measure { keys, all, data } => {
            let experiments = if all {
                EXPERIMENTS.iter().collect()
            } else {
                results::chosen(&keys)?
            };
            let data = data.map(std::path::absolute).transpose();
            let data = data.map_err(|error| format!("--data: {error}"))?;
            results::measure(&experiments, data)
        }
        Command::Render => results::render(&record::load(&results::records_file())?),
        Command::List => {
            for one in EXPERIMENTS {
                let set = if one.by_default { "default" } else { "" };
                println!(
                    "{:18} {:4} min  {set:8} {}",
                    one.key, one.minutes, one.title
                );
            }
            Ok(())
        }
    }
}
