//! Measures mapping's tracker against the truth, in one process.

use clap::{Parser, ValueEnum};
use serde::Serialize;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;
use zeronav_tests::results::page;
use zeronav_tests::results::record::Table;
use zeronav_tests::tracker_bench::{self, Plan, Tally, cases, cases::Case};

/// Plays recorded people and `DynaBARN` worlds through the libraries of simulator and mapping, and
/// says how well what moves is tracked: how soon, how exactly, how often for nothing.
#[derive(Debug, Parser)]
#[command(version)]
struct Arguments {
    /// Folder of the data sets `pedestrians` and `dynabarn`.
    #[arg(long, env = "ZERONAV_DATA", default_value = "data")]
    data: PathBuf,
    /// Data set to play, both without.
    #[arg(long)]
    set: Option<Set>,
    /// Seeds of every world; each is another moment of it.
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u64).range(1..=1000))]
    seeds: u64,
    /// Run time of every run. [s]
    #[arg(long, default_value_t = 30.0)]
    duration_s: f64,
    /// Turns of the lidar in a second instead of its own. [Hz]
    #[arg(long)]
    rate_hz: Option<f64>,
    /// Exact wheels, odometry and lidar.
    #[arg(long)]
    exact: bool,
    /// Also lists every obstacle that was never found, lost or swapped and every false track.
    #[arg(long, conflicts_with = "json")]
    events: bool,
    /// One JSON object instead of tables.
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Set {
    Pedestrians,
    Dynabarn,
}

/// What is printed as JSON.
#[derive(Debug, Serialize)]
struct Result {
    /// Runs that were played.
    runs: usize,
    /// How long that took. [s]
    wall_s: f64,
    tables: Vec<Table>,
}

fn main() -> ExitCode {
    match run(&Arguments::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(problem) => {
            eprintln!("zeronav-tracker-bench: {problem}");
            ExitCode::FAILURE
        }
    }
}

#[allow(clippy::print_stdout, reason = "this is what the user asked for")]
fn run(arguments: &Arguments) -> core::result::Result<(), String> {
    let started = Instant::now();
    if !(1.0..=3600.0).contains(&arguments.duration_s) {
        return Err("--duration-s: must be 1 to 3600".to_owned());
    }
    let plan = Plan {
        duration_s: arguments.duration_s,
        rate_hz: arguments.rate_hz,
        exact: arguments.exact,
    };
    let cases = chosen(arguments)?;
    let tallies = tracker_bench::play_all(&cases, &plan)?;
    let noise = if plan.exact { "exact" } else { "noisy" };
    let lidar = format!("{noise} lidar at {} Hz", plan.robot().lidar.rate_hz);
    let result = Result {
        runs: cases.len(),
        wall_s: started.elapsed().as_secs_f64(),
        tables: tracker_bench::tables(&cases, &tallies, &lidar),
    };
    if arguments.json {
        let text = serde_json::to_string(&result).map_err(|error| error.to_string())?;
        println!("{text}");
        return Ok(());
    }
    for table in &result.tables {
        print!("{}", page::table(table));
    }
    if arguments.events {
        print_events(&cases, &tallies);
    }
    println!("{} runs in {:.1} s", result.runs, result.wall_s);
    Ok(())
}

/// The runs that were asked for.
fn chosen(arguments: &Arguments) -> core::result::Result<Vec<Case>, String> {
    let mut all = Vec::new();
    if arguments.set != Some(Set::Dynabarn) {
        let folder = arguments.data.join("pedestrians");
        all.extend(cases::pedestrians(
            &folder,
            arguments.seeds,
            arguments.duration_s,
        )?);
    }
    if arguments.set != Some(Set::Pedestrians) {
        let folder = arguments.data.join("dynabarn");
        all.extend(cases::dynabarn(&folder, arguments.seeds)?);
    }
    Ok(all)
}

#[allow(clippy::print_stdout, reason = "this is what the user asked for")]
fn print_events(cases: &[Case], tallies: &[Tally]) {
    for (case, tally) in cases.iter().zip(tallies) {
        for event in &tally.events {
            println!(
                "{}: {:?} {} at {:.2} s, ({:.2}, {:.2})",
                case.name,
                event.failing,
                event.number & u64::from(u32::MAX),
                zeronav_msgs::time::seconds(event.run_ns),
                event.at.x,
                event.at.y
            );
        }
    }
    println!();
}
