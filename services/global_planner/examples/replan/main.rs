//! What a local change of the map costs: the check of the path (filter), an incremental search
//! (`mpgaa`), a search from scratch (A*, and jumps where all cells cost the same), and the whole
//! cycle of the replanner with `policy`: map update taken in, filter, search, path.
//!
//! `cargo run --release -p zeronav-global-planner --no-default-features --example replan --
//! [--map FILE] [--data FOLDER] [--events N]`
//!
//! `detour` is the answer of bounded effort; the incremental search comes after it and has learnt from the
//! search for it, where there was one.
//!
//! Every event is repeated five times and counts with its median (A* from scratch: once); the table
//! shows the median, the 99th percentile and the worst over the events. Times in microseconds of
//! wall time, without the work ahead that is done between two updates, which has its own column. Ends with 1 when the
//! incremental search found another cost than the one from scratch, or took more than 1.3 times
//! its expansions.

#![allow(clippy::print_stdout, reason = "it is a table")]

mod change;
#[path = "../common/mod.rs"]
mod common;
mod measure;
#[path = "../../tests/support/mod.rs"]
mod support;

use change::{INFLATION_FACTOR, INFLATION_M, INSCRIBED_M, KINDS, Kind};
use clap::Parser;
use common::movingai::GridMap;
use measure::{Bench, Times, query, whole};
use std::fmt::Display;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use support::{Map, Rng, of_cost};
use zeronav_casts::Cast;
use zeronav_global_planner::{
    CellPath, Choose, Control, GlobalPlanner, Jps, Mpgaa, PlannerOptions,
};
use zeronav_msgs::Cell;
use zeronav_msgs::map::COST_LETHAL;
use zeronav_observe::statistics::{median, percentile};

/// Maps of the data set, without their ending.
const DATA_MAPS: [&str; 3] = [
    "mazes__maze512-32-0",
    "cities__Boston_0_512",
    "cities__Paris_1_1024",
];

#[derive(Parser)]
struct Flags {
    /// A `MovingAI` map in place of the generated offices.
    #[arg(long)]
    map: Option<PathBuf>,
    /// The data set `movingai`: after the offices, a maze and street maps of two cities.
    #[arg(long)]
    data: Option<PathBuf>,
    /// Events of each kind.
    #[arg(long, default_value_t = 40)]
    events: usize,
    /// Largest side of the generated offices. [cells]
    #[arg(long, default_value_t = 4000)]
    largest: u32,
}

fn table(name: &str, map: &Map, uniform: bool, n_events: usize) -> Result<usize, String> {
    let mut bench = Bench::new(map.clone(), uniform)?;
    let costs = if uniform { "uniform" } else { "inflated" };
    println!("\n{name}, {costs}: p50 / p99 / worst [us]; ratio: expansions of incremental by A*'s");
    println!(
        "| event | n | kept | notify | filter | cut, no detour | detour | detour's cost | incremental | A* from scratch | jps from scratch | \
         policy | ahead | ratio, median / worst |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|---|---|---|---|");
    for (name, kind) in KINDS {
        let events = events(&mut bench, kind, n_events);
        let cut: Vec<&Times> = events.iter().filter(|event| !event.kept).collect();
        let missed = cut.iter().filter(|event| event.detour.is_nan()).count();
        let mut dearer: Vec<f64> = cut.iter().map(|event| event.detour_ratio).collect();
        dearer.retain(|ratio| !ratio.is_nan());
        let mut dearer = |share| percentile(&mut dearer, share).unwrap_or(0.0);
        let of = |field: fn(&Times) -> f64| {
            let mut numbers: Vec<f64> = events.iter().map(field).collect();
            numbers.retain(|number| !number.is_nan());
            let mut at = |share| percentile(&mut numbers, share).unwrap_or(0.0);
            if at(0.5) < 10.0 {
                format!("{:.1} / {:.1} / {:.1}", at(0.5), at(0.99), at(1.0))
            } else {
                format!("{:.0} / {:.0} / {:.0}", at(0.5), at(0.99), at(1.0))
            }
        };
        let mid = |field: fn(&Times) -> f64| median(events.iter().map(field)).unwrap_or(0.0);
        let worst_ratio = events.iter().map(|event| event.ratio).fold(0.0, f64::max);
        let jumps = if uniform {
            of(|event| event.jumps)
        } else {
            "-".to_owned()
        };
        println!(
            "| {name} | {} | {} | {:.1} | {} | {missed} | {} | {:.3} / {:.3} | {} | {} | {jumps} | {} | {:.0} | {:.2} / {worst_ratio:.2} |",
            events.len(),
            events.iter().filter(|event| event.kept).count(),
            mid(|event| event.notify),
            of(|event| event.filter),
            of(|event| event.detour),
            dearer(0.5),
            dearer(1.0),
            of(|event| event.incremental),
            of(|event| event.scratch),
            of(|event| event.cycle),
            mid(|event| event.ahead),
            mid(|event| event.ratio),
        );
    }
    if bench.wrong > 0 {
        println!(
            "{} events with another cost or too many expansions",
            bench.wrong
        );
    }
    Ok(bench.wrong)
}

/// Up to `n_events` changes of one kind, each measured.
fn events(bench: &mut Bench, kind: Kind, n_events: usize) -> Vec<Times> {
    let (width, height) = bench.map.geometry.size();
    let mut rng = Rng(7);
    let mut events = Vec::new();
    let mut tries = 0;
    while events.len() < n_events && tries < 4 * n_events {
        // New ends every eight events.
        let mut ends_rng = Rng(100 + (tries / 8) as u64);
        tries += 1;
        let mut end = |shift: i32| {
            bench.map.free_near(Cell::new(
                shift + ends_rng.below(width / 3),
                ends_rng.below(height),
            ))
        };
        let (mut start, goal) = (end(0), end(width * 2 / 3));
        // The robot has come a little further each time.
        let mut path = CellPath::default();
        let query = query(&bench.map, (start, goal));
        let found = bench.scratch.plan(&query, &mut |_| Control::Go, &mut path);
        if found.is_err() {
            continue;
        }
        start = path.cells.get((tries % 8) * 10).copied().unwrap_or(start);
        events.extend(bench.measure(kind, (start, goal), &mut rng));
    }
    events
}

/// Bytes per cell that the planners hold after a question was answered and all work ahead done.
fn print_memory(map: &Map) {
    let options = PlannerOptions::default().map();
    let (mut kept, mut jumps) = (Mpgaa::new(options), Jps::new(options, Choose::Jumps));
    let mut canonical = Jps::new(options, Choose::Canonical);
    let (width, height) = map.geometry.size();
    let ends = (
        map.free_near(Cell::new(width / 30, height / 20)),
        map.free_near(Cell::new(width - width / 30, height - height / 20)),
    );
    let mut path = CellPath::default();
    let planners: [&mut dyn GlobalPlanner; 3] = [&mut kept, &mut jumps, &mut canonical];
    for planner in planners {
        planner.map_changed(&map.view(), &[whole(map)]);
        let query = query(map, ends);
        let _ = planner.plan(&query, &mut |_| Control::Go, &mut path);
        while planner.prepare(&map.pose(ends.0), 10_000) {}
    }
    let per_cell = |bytes: usize| bytes.to_f64() / map.cells.len().to_f64();
    println!(
        "memory per cell [bytes]: mpgaa {:.1}, jps {:.1}, canonical {:.1}",
        per_cell(kept.memory_bytes()),
        per_cell(jumps.memory_bytes()),
        per_cell(canonical.memory_bytes()),
    );
}

fn without_costs(map: &Map) -> Map {
    let mut map = map.clone();
    for cell in &mut map.cells {
        *cell = of_cost(if cell.blocks_centre() { COST_LETHAL } else { 0 });
    }
    map
}

/// A `MovingAI` map, inflated.
fn read(file: &Path) -> Result<(String, Map), String> {
    let named = |error: &dyn Display| format!("{}: {error}", file.display());
    let text = std::fs::read_to_string(file).map_err(|error| named(&error))?;
    let read = GridMap::parse(&text).map_err(|error| named(&error))?;
    let mut map = Map::free(read.geometry.width, read.geometry.height);
    map.cells = read.cells;
    map.inflate(INSCRIBED_M, INFLATION_M, INFLATION_FACTOR);
    Ok((file.display().to_string(), map))
}

fn run(flags: &Flags) -> Result<usize, String> {
    let mut maps = match &flags.map {
        Some(file) => vec![read(file)?],
        None => [(600, 400), (1000, 1000), (4000, 4000)]
            .into_iter()
            .filter(|(width, _)| *width <= flags.largest)
            .map(|(width, height)| {
                (
                    format!("office {width} x {height}"),
                    Map::office(width, height, 7),
                )
            })
            .collect(),
    };
    if let Some(folder) = &flags.data {
        for name in DATA_MAPS {
            let (_, map) = read(&folder.join(format!("{name}.map")))?;
            maps.push((name.to_owned(), map));
        }
    }
    let mut wrong = 0;
    for (name, map) in &maps {
        let n_events = if map.cells.len() > 4_000_000 {
            flags.events.div_ceil(5)
        } else {
            flags.events
        };
        println!("\n{name}");
        print_memory(map);
        wrong += table(name, map, false, n_events)?;
        wrong += table(name, &without_costs(map), true, n_events)?;
    }
    Ok(wrong)
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
