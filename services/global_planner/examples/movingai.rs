//! Answers the questions of the `MovingAI` collection and compares with the known lengths.
//!
//! `cargo run --release -p zeronav-global-planner --no-default-features --example movingai --
//! --data DIR [--planner KEY] [--sample N] [--json]`
//!
//! Ends with 1 when a length is wrong.

#![allow(clippy::print_stdout, reason = "it is a table")]

mod common;

use clap::Parser;
use serde_json::{Value, json};
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;
use zeronav_global_planner::{
    CellPath, Control, CornerRule, EXACT, GlobalPlanner, PlanQuery, PlannerOptions, Unknown, row_of,
};
use zeronav_msgs::{Cell, CellRect};
use zeronav_observe::statistics::median;

/// Largest difference from the known length, which is printed to 6 digits. [cells]
const TOLERANCE_CELLS: f64 = 0.006;

#[derive(Parser)]
struct Flags {
    /// Folder with .map and .map.scen files.
    #[arg(long)]
    data: PathBuf,
    /// Key of a planner; without, every exact one.
    #[arg(long)]
    planner: Option<String>,
    /// Most questions per map, spread evenly.
    #[arg(long)]
    sample: Option<usize>,
    /// Prints JSON.
    #[arg(long)]
    json: bool,
}

/// What came of a set of questions.
#[derive(Default, Clone)]
struct Tally {
    queries: u64,
    wrong: u64,
    /// [cells]
    worst_error: f64,
    expanded: u64,
    times_us: Vec<f64>,
}

impl Tally {
    fn add(&mut self, other: &Self) {
        self.queries += other.queries;
        self.wrong += other.wrong;
        self.worst_error = self.worst_error.max(other.worst_error);
        self.expanded += other.expanded;
        self.times_us.extend_from_slice(&other.times_us);
    }

    fn median_us(&self) -> f64 {
        median(self.times_us.iter().copied()).unwrap_or(0.0)
    }

    fn json(&self) -> Value {
        json!({
            "queries": self.queries,
            "wrong": self.wrong,
            "worst_error": self.worst_error,
            "expanded": self.expanded,
            "median_us": self.median_us(),
            "sum_us": self.times_us.iter().sum::<f64>(),
        })
    }
}

fn answer(set: &common::Set, planner: &mut dyn GlobalPlanner) -> Tally {
    let map = set.map.view();
    let (width, height) = map.geometry.size();
    let whole = CellRect {
        min: Cell::new(0, 0),
        max: Cell::new(width, height),
    };
    planner.map_changed(&map, &[whole]);
    let mut tally = Tally::default();
    let mut path = CellPath::default();
    // The first question is asked once more: memory is touched then.
    let warm_up = set.scenarios.first().into_iter();
    for (n, scenario) in warm_up.chain(&set.scenarios).enumerate() {
        let query = PlanQuery {
            map,
            start: set.map.pose(scenario.start),
            goal: set.map.pose(scenario.goal),
            tolerance_m: 0.1,
            unknown: Unknown::Free,
            corner_rule: CornerRule::ForbidAny,
        };
        let started = Instant::now();
        let result = planner.plan(&query, &mut |_| Control::Go, &mut path);
        let time_us = started.elapsed().as_secs_f64() * 1e6;
        if n == 0 {
            continue;
        }
        let error = match result {
            Ok(_) => (path.length_cells() - scenario.optimal_cells).abs(),
            Err(_) => f64::INFINITY,
        };
        tally.queries += 1;
        tally.wrong += u64::from(error > TOLERANCE_CELLS);
        tally.worst_error = tally.worst_error.max(error);
        tally.expanded += path.stats.expanded;
        tally.times_us.push(time_us);
    }
    tally
}

fn named(name: &str, value: &str, tally: &Tally) -> Value {
    let mut object = tally.json();
    object[name] = json!(value);
    object
}

fn run(flags: &Flags) -> Result<u64, String> {
    let keys: Vec<&str> = match &flags.planner {
        Some(key) => vec![row_of(key).map_err(|error| error.to_string())?.key],
        None => EXACT.to_vec(),
    };
    let files = common::map_files(&flags.data)?;
    let mut total = Tally::default();
    let mut of_planner: Vec<(Tally, Vec<Value>)> = vec![Default::default(); keys.len()];
    let mut maps = Vec::new();
    for file in &files {
        let set = common::read_set(file, flags.sample)?;
        let mut of_map = Tally::default();
        for (key, (sum, rows)) in keys.iter().zip(&mut of_planner) {
            let row = row_of(key).map_err(|error| error.to_string())?;
            let mut planner = (row.build)(&PlannerOptions::default());
            let tally = answer(&set, planner.as_mut());
            if !flags.json {
                println!(
                    "{key:<12} {:<32} {:>6} queries {:>4} wrong  worst {:.4}  {:>10} expanded  median {:>8.1} us",
                    set.name,
                    tally.queries,
                    tally.wrong,
                    tally.worst_error,
                    tally.expanded,
                    tally.median_us(),
                );
            }
            sum.add(&tally);
            rows.push(named("map", &set.name, &tally));
            of_map.add(&tally);
        }
        maps.push(named("map", &set.name, &of_map));
        total.add(&of_map);
    }
    if flags.json {
        let planners: Vec<Value> = keys
            .iter()
            .zip(&of_planner)
            .map(|(key, (tally, rows))| {
                let mut object = named("planner", key, tally);
                object["maps"] = json!(rows);
                object
            })
            .collect();
        let mut object = total.json();
        object["maps"] = json!(maps);
        object["planners"] = json!(planners);
        println!("{object:#}");
    } else {
        println!();
        for (key, (tally, _)) in keys.iter().zip(&of_planner) {
            println!(
                "{key:<12} {} queries, {} wrong, worst error {:.4} cells, {} expanded, median {:.1} us",
                tally.queries,
                tally.wrong,
                tally.worst_error,
                tally.expanded,
                tally.median_us(),
            );
        }
    }
    Ok(total.wrong)
}

fn main() -> ExitCode {
    match run(&Flags::parse()) {
        Ok(0) => ExitCode::SUCCESS,
        Ok(_) => ExitCode::from(1),
        Err(error) => {
            eprintln!("{error}");
            ExitCode::from(2)
        }
    }
}
