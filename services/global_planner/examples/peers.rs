//! The table against published crates, in one run over the same maps and questions.
//!
//! `cargo run --release -p zeronav-global-planner --no-default-features --features peers --example
//! peers -- --data DIR [--robot-map FILE.pgm]... [--sample N]`
//!
//! Corner rules: ours and our A* over `pathfinding` (its neighbours are ours to give) cut no
//! corner; `grid_pathfinding` passes corners, which is another problem with shorter answers.
//! Ratios are sums of times over the questions, theirs by ours: above 1 we are faster.

#![allow(clippy::print_stdout, reason = "it is a table")]

mod common;
#[path = "../tests/support/mod.rs"]
mod support;

use clap::Parser;
use common::Set;
use common::movingai::{GridMap, Scenario};
use grid_pathfinding::PathingGrid;
use grid_util::grid::ValueGrid;
use grid_util::point::Point;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;
use support::{Map, Rng};
use zeronav_global_planner::moves::{DIAGONAL, STEPS, STRAIGHT, octile, price};
use zeronav_global_planner::{
    CellPath, Control, CornerRule, GlobalPlanner, PlanQuery, PlannerOptions, Unknown, row_of,
};
use zeronav_msgs::map::{COST_FREE, COST_LETHAL};
use zeronav_msgs::{Cell, CellRect, GridGeometry, MapCell, MapView, Pose};
use zeronav_observe::statistics::median;

#[derive(Parser)]
struct Flags {
    /// Folder with .map and .map.scen files.
    #[arg(long)]
    data: PathBuf,
    /// Greyscale maps of robots; dark is blocked. Questions are drawn from a seed.
    #[arg(long)]
    robot_map: Vec<PathBuf>,
    /// Questions per map.
    #[arg(long, default_value_t = 30)]
    sample: usize,
}

const COST_WEIGHT: f64 = 3.0;

/// Sums over the questions of a map. [us]
struct Row {
    name: String,
    jps: f64,
    canonical: f64,
    astar: f64,
    grid_pathfinding: f64,
    pathfinding: f64,
    ours_on_costs: f64,
    pathfinding_on_costs: f64,
    /// What a change of 10 x 10 cells costs before the next answer.
    told: f64,
    grid_pathfinding_told: f64,
    wrong: usize,
}

fn us(started: Instant) -> f64 {
    started.elapsed().as_secs_f64() * 1e6
}

fn query<'a>(map: MapView<'a>, question: &Scenario) -> PlanQuery<'a> {
    let pose = |cell| {
        let centre = map.geometry.centre_of(cell);
        Pose::new(centre.x, centre.y, 0.0)
    };
    PlanQuery {
        map,
        start: pose(question.start),
        goal: pose(question.goal),
        tolerance_m: 0.01,
        unknown: Unknown::Free,
        corner_rule: CornerRule::ForbidAny,
    }
}

/// Sum of the times of a planner, and the cost of each answer [m].
fn ours(
    key: &str,
    cost_weight: f64,
    set: &Set,
    map: MapView<'_>,
) -> Result<(f64, Vec<f64>), String> {
    let options = PlannerOptions {
        cost_weight,
        ..PlannerOptions::default()
    };
    let mut planner: Box<dyn GlobalPlanner> =
        (row_of(key).map_err(|error| error.to_string())?.build)(&options);
    planner.map_changed(&map, &[whole(map.geometry)]);
    let mut path = CellPath::default();
    let mut sum = 0.0;
    let mut costs = Vec::new();
    // Asked twice; the second time counts, memory is touched then.
    for counts in [false, true] {
        for question in &set.scenarios {
            let query = query(map, question);
            let started = Instant::now();
            let result = planner.plan(&query, &mut |_| Control::Go, &mut path);
            if counts {
                sum += us(started);
                costs.push(result.map_or(0.0, |stats| stats.cost));
            }
        }
    }
    Ok((sum, costs))
}

fn whole(geometry: &GridGeometry) -> CellRect {
    let (width, height) = geometry.size();
    CellRect {
        min: Cell::new(0, 0),
        max: Cell::new(width, height),
    }
}

/// A* of `pathfinding` over the same steps with the same integer costs.
fn with_pathfinding(set: &Set, map: MapView<'_>, cost_weight: f64) -> (f64, Vec<f64>) {
    let mut sum = 0.0;
    let mut costs = Vec::new();
    let mut prices = [1.0; 256];
    for (cost, slot) in (0..=u8::MAX).zip(&mut prices) {
        *slot = price(cost, cost_weight);
    }
    let free = |cell: Cell| map.get(cell).is_some_and(|cell| !cell.blocks_centre());
    for question in &set.scenarios {
        let started = Instant::now();
        let found = pathfinding::prelude::astar(
            &(question.start.x, question.start.y),
            |&(x, y)| {
                STEPS.iter().zip(0_u32..).filter_map(move |((dx, dy), n)| {
                    let to = Cell::new(x + dx, y + dy);
                    let legal = free(to)
                        && (n % 2 == 0 || free(Cell::new(to.x, y)) && free(Cell::new(x, to.y)));
                    let price = legal.then(|| map.get(to))?.map(|cell| cell.cost)?;
                    let step = if n % 2 == 0 { STRAIGHT } else { DIAGONAL };
                    let cost = (f64::from(step) * prices[usize::from(price)]).round();
                    let cost = cost as u32;
                    Some(((to.x, to.y), cost))
                })
            },
            |&(x, y)| octile(x.abs_diff(question.goal.x), y.abs_diff(question.goal.y)),
            |&(x, y)| (x, y) == (question.goal.x, question.goal.y),
        );
        sum += us(started);
        let cost = found.map_or(0.0, |(_, cost)| f64::from(cost) / f64::from(STRAIGHT));
        costs.push(cost * map.geometry.resolution_m);
    }
    (sum, costs)
}

/// Jump point search of `grid_pathfinding`, and what a change of its grid costs.
fn with_grid_pathfinding(set: &Set, map: MapView<'_>) -> (f64, f64) {
    let (width, height) = (map.geometry.width as usize, map.geometry.height as usize);
    let mut grid: PathingGrid = PathingGrid::new(width, height, false);
    for (index, cell) in map.cells.iter().enumerate() {
        grid.set(
            (index % width) as i32,
            (index / width) as i32,
            cell.blocks_centre(),
        );
    }
    grid.initialize();
    grid.generate_components();
    let mut sum = 0.0;
    for counts in [false, true] {
        for question in &set.scenarios {
            let started = Instant::now();
            let start = Point::new(question.start.x, question.start.y);
            let goal = Point::new(question.goal.x, question.goal.y);
            let found = grid.get_waypoints_single_goal(start, goal, false);
            if counts {
                sum += us(started);
            }
            core::hint::black_box(found);
        }
    }
    let started = Instant::now();
    let (x0, y0) = (width as i32 / 2, height as i32 / 2);
    for y in y0..(y0 + 10).min(height as i32) {
        for x in x0..(x0 + 10).min(width as i32) {
            grid.set(x, y, true);
        }
    }
    grid.generate_components();
    (sum, us(started))
}

/// Median time that `jps` takes to take in a block of 10 x 10 cells.
fn told(set: &Set) -> Result<f64, String> {
    let mut map = Map::free(set.map.geometry.width, set.map.geometry.height);
    map.geometry = set.map.geometry;
    map.cells.clone_from(&set.map.cells);
    let row = row_of("jps").map_err(|error| error.to_string())?;
    let mut planner = (row.build)(&PlannerOptions::default());
    planner.map_changed(&map.view(), &[whole(&map.geometry)]);
    let (w, h) = map.geometry.size();
    let rect = CellRect {
        min: Cell::new(w / 2, h / 2),
        max: Cell::new((w / 2 + 10).min(w), (h / 2 + 10).min(h)),
    };
    let free: Vec<MapCell> = map.cells.clone();
    let mut times = Vec::new();
    // Bits are made with the first answer.
    if let Some(question) = set.scenarios.first() {
        let mut path = CellPath::default();
        let _ = planner.plan(
            &query(map.view(), question),
            &mut |_| Control::Go,
            &mut path,
        );
    }
    for n in 0..10 {
        if n % 2 == 0 {
            map.block(rect.min, rect.max);
        } else {
            map.cells.clone_from(&free);
        }
        let started = Instant::now();
        planner.map_changed(&map.view(), &[rect]);
        times.push(us(started));
    }
    median(times).ok_or_else(|| "nothing was timed".to_owned())
}

fn compare(set: &Set) -> Result<Row, String> {
    let map = set.map.view();
    let (jps, lengths) = ours("jps", 0.0, set, map)?;
    let (canonical, _) = ours("canonical", 0.0, set, map)?;
    let (astar, _) = ours("c_astar", 0.0, set, map)?;
    let (pathfinding, theirs) = with_pathfinding(set, map, 0.0);
    let (grid_pathfinding, grid_pathfinding_told) = with_grid_pathfinding(set, map);
    let apart = |ours: &[f64], theirs: &[f64]| {
        ours.iter()
            .zip(theirs)
            .filter(|(one, other)| (**one - **other).abs() > 1e-3 * other.max(1.0))
            .count()
    };
    let mut wrong = apart(&lengths, &theirs);
    // The same maps with costs: 5 cells of gradient around what is blocked.
    let mut inflated = Map::free(set.map.geometry.width, set.map.geometry.height);
    inflated.cells.clone_from(&set.map.cells);
    inflated.inflate(0.0, 0.25, 6.0);
    let (ours_on_costs, costs) = ours("mpgaa", COST_WEIGHT, set, inflated.view())?;
    let (pathfinding_on_costs, theirs) = with_pathfinding(set, inflated.view(), COST_WEIGHT);
    wrong += apart(&costs, &theirs);
    Ok(Row {
        name: set.name.clone(),
        jps,
        canonical,
        astar,
        grid_pathfinding,
        pathfinding,
        ours_on_costs,
        pathfinding_on_costs,
        told: told(set)?,
        grid_pathfinding_told,
        wrong,
    })
}

/// A greyscale map with questions from a seed.
fn robot_map(file: &Path, sample: usize) -> Result<Set, String> {
    let named = |error: &dyn core::fmt::Display| format!("{}: {error}", file.display());
    let opened = std::fs::File::open(file).map_err(|error| named(&error))?;
    let mut decoder = png::Decoder::new(std::io::BufReader::new(opened));
    decoder.set_transformations(png::Transformations::normalize_to_color8());
    let mut picture = decoder.read_info().map_err(|error| named(&error))?;
    if picture.output_color_type().0 != png::ColorType::Grayscale {
        return Err(named(&"not a grey PNG"));
    }
    let mut pixels = vec![0; picture.output_buffer_size().unwrap_or(0)];
    let frame = picture.next_frame(&mut pixels);
    let frame = frame.map_err(|error| named(&error))?;
    let geometry = GridGeometry {
        origin_x_m: 0.0,
        origin_y_m: 0.0,
        resolution_m: 1.0,
        width: frame.width,
        height: frame.height,
    };
    let cells = pixels
        .iter()
        .map(|pixel| MapCell {
            cost: if *pixel < 250 { COST_LETHAL } else { COST_FREE },
            flags: 0,
            clearance_mm: 0,
        })
        .collect();
    let map = GridMap { geometry, cells };
    let mut planner =
        (row_of("jps").map_err(|error| error.to_string())?.build)(&PlannerOptions::default());
    planner.map_changed(&map.view(), &[whole(&geometry)]);
    let mut rng = Rng(5);
    let mut scenarios = Vec::new();
    let (w, h) = geometry.size();
    let mut path = CellPath::default();
    for _ in 0..100_000 {
        let mut question = Scenario {
            start: Cell::new(rng.below(w), rng.below(h)),
            goal: Cell::new(rng.below(w), rng.below(h)),
            optimal_cells: 0.0,
        };
        let query = query(map.view(), &question);
        if planner
            .plan(&query, &mut |_| Control::Go, &mut path)
            .is_ok()
        {
            question.optimal_cells = path.length_cells();
            scenarios.push(question);
        }
        if scenarios.len() == sample {
            break;
        }
    }
    let name = file
        .file_name()
        .map(|name| name.to_string_lossy().into_owned())
        .unwrap_or_default();
    Ok(Set {
        name,
        map,
        scenarios,
    })
}

fn run(flags: &Flags) -> Result<usize, String> {
    let mut rows = Vec::new();
    println!("mean time of a question [us]; a change of 10 x 10 cells [us]");
    println!(
        "{:<30} {:>9} {:>9} {:>9} {:>10} {:>11} | {:>9} {:>11} | {:>6} {:>10}",
        "map",
        "jps",
        "canonical",
        "c_astar",
        "grid_path.",
        "pathfinding",
        "costs",
        "pathfinding",
        "told",
        "grid_path."
    );
    let mut add = |set: &Set| -> Result<(), String> {
        let row = compare(set)?;
        let n = set.scenarios.len() as f64;
        println!(
            "{:<30} {:>9.1} {:>9.1} {:>9.1} {:>10.1} {:>11.1} | {:>9.1} {:>11.1} | {:>6.1} {:>10.1}{}",
            row.name,
            row.jps / n,
            row.canonical / n,
            row.astar / n,
            row.grid_pathfinding / n,
            row.pathfinding / n,
            row.ours_on_costs / n,
            row.pathfinding_on_costs / n,
            row.told,
            row.grid_pathfinding_told,
            if row.wrong > 0 { "  WRONG" } else { "" },
        );
        rows.push(row);
        Ok(())
    };
    for file in common::map_files(&flags.data)? {
        add(&common::read_set(&file, Some(flags.sample))?)?;
    }
    for file in &flags.robot_map {
        add(&robot_map(file, flags.sample)?)?;
    }
    println!("\nratios, theirs by ours: geometric mean, smallest, largest");
    let ratio = |name: &str, of: fn(&Row) -> f64| {
        let ratios: Vec<f64> = rows.iter().map(of).collect();
        let (mean, min, max) = common::spread_of(&ratios);
        println!("{name:<46} {mean:>7.1} {min:>7.2} {max:>8.1}");
        for row in rows.iter().filter(|row| of(row) < 1.0) {
            println!("    slower on {} ({:.2})", row.name, of(row));
        }
    };
    ratio("grid_pathfinding 0.3 (cuts corners) / jps", |row| {
        row.grid_pathfinding / row.jps
    });
    ratio("pathfinding 4.16 astar / jps", |row| {
        row.pathfinding / row.jps
    });
    ratio("pathfinding 4.16 astar / c_astar", |row| {
        row.pathfinding / row.astar
    });
    ratio("canonical / jps", |row| row.canonical / row.jps);
    ratio("on costs: pathfinding 4.16 astar / mpgaa", |row| {
        row.pathfinding_on_costs / row.ours_on_costs
    });
    ratio("change: grid_pathfinding 0.3 / jps", |row| {
        row.grid_pathfinding_told / row.told
    });
    Ok(rows.iter().map(|row| row.wrong).sum())
}

fn main() -> ExitCode {
    match run(&Flags::parse()) {
        Ok(0) => ExitCode::SUCCESS,
        Ok(wrong) => {
            println!("{wrong} costs differ");
            ExitCode::from(1)
        }
        Err(error) => {
            eprintln!("{error}");
            ExitCode::from(2)
        }
    }
}
