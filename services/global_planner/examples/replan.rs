//! What a local change of the map costs: the check of the path (filter), an incremental search
//! (`mpgaa`), a search from scratch (A*, and jumps where all cells cost the same), and the whole
//! cycle of the replanner with `policy`: map update taken in, filter, search, path.
//!
//! `cargo run --release -p zeronav-global-planner --no-default-features --example replan --
//! [--map FILE] [--events N]`
//!
//! Every event is repeated five times and counts with its median (A* from scratch: once); the table
//! shows the median, the 99th percentile and the worst over the events. Times in microseconds of
//! wall time, without the work ahead that is done between two updates, which has its own column. Ends with 1 when the
//! incremental search found another cost than the one from scratch, or took more than 1.3 times
//! its expansions.

#![allow(clippy::print_stdout, reason = "it is a table")]
#![allow(
    clippy::cast_possible_truncation,
    clippy::cast_precision_loss,
    reason = "indices and numbers of events"
)]

mod common;
#[path = "../tests/support/mod.rs"]
mod support;

use clap::Parser;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;
use support::{Map, Rng, of_cost};
use zeronav_global_planner::jps::{Choose, Jps};
use zeronav_global_planner::movingai::GridMap;
use zeronav_global_planner::mpgaa::Mpgaa;
use zeronav_global_planner::{
    CellPath, Control, CornerRule, Corridor, GlobalPlanner, GlobalPlannerConfig, Legality,
    PlanQuery, PlannerOptions, Replanner, Situation, Step, Target, Unknown, row_of,
};
use zeronav_msgs::map::{COST_INSCRIBED, COST_LETHAL};
use zeronav_msgs::{Cell, CellRect, MapCell};

/// Inscribed radius and end of the inflation. [m]
const INSCRIBED_M: f64 = 0.2;
const INFLATION_M: f64 = 0.6;
const INFLATION_FACTOR: f64 = 4.0;

const REPEATS: usize = 5;

#[derive(Parser)]
struct Flags {
    /// A `MovingAI` map in place of the generated offices.
    #[arg(long)]
    map: Option<PathBuf>,
    /// Events of each kind.
    #[arg(long, default_value_t = 40)]
    events: usize,
    /// Largest side of the generated offices. [cells]
    #[arg(long, default_value_t = 4000)]
    largest: u32,
}

/// What happens to the map.
#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Block { at: Place, side: i32 },
    Door,
    Removal,
}

#[derive(Clone, Copy, PartialEq)]
enum Place {
    Near,
    Mid,
    Goal,
    Off,
}

const KINDS: [(&str, Kind); 10] = [
    ("near 10", block(Place::Near, 10)),
    ("near 40", block(Place::Near, 40)),
    ("mid 10", block(Place::Mid, 10)),
    ("mid 40", block(Place::Mid, 40)),
    ("goal 10", block(Place::Goal, 10)),
    ("goal 40", block(Place::Goal, 40)),
    ("off 10", block(Place::Off, 10)),
    ("off 40", block(Place::Off, 40)),
    ("door", Kind::Door),
    ("removal", Kind::Removal),
];

const fn block(at: Place, side: i32) -> Kind {
    Kind::Block { at, side }
}

/// Times of one event, each the median of the repeats. [us]
#[derive(Default, Clone)]
struct Event {
    told: f64,
    filter: f64,
    incremental: f64,
    scratch: f64,
    jumps: f64,
    cycle: f64,
    ahead: f64,
    kept: bool,
    ratio: f64,
}

struct Bench {
    map: Map,
    uniform: bool,
    kept: Box<dyn GlobalPlanner>,
    anew: Box<dyn GlobalPlanner>,
    jumps: Box<dyn GlobalPlanner>,
    replanner: Replanner,
    revision: u64,
    task: u64,
    wrong: usize,
}

fn us(started: Instant) -> f64 {
    started.elapsed().as_secs_f64() * 1e6
}

fn median(mut numbers: Vec<f64>) -> f64 {
    numbers.sort_by(f64::total_cmp);
    common::quantile(&numbers, 0.5)
}

fn whole(map: &Map) -> CellRect {
    let (width, height) = map.geometry.size();
    CellRect {
        min: Cell::new(0, 0),
        max: Cell::new(width, height),
    }
}

impl Bench {
    fn new(map: Map, uniform: bool) -> Result<Self, String> {
        let cost_weight = if uniform { 0.0 } else { 3.0 };
        let options = PlannerOptions {
            cost_weight,
            ..PlannerOptions::default()
        };
        let build = |key: &str| {
            row_of(key)
                .map(|row| (row.build)(&options))
                .map_err(|error| error.to_string())
        };
        let config = GlobalPlannerConfig {
            planner: "policy".to_owned(),
            options,
            shortcut_every_revisions: 1,
            ..GlobalPlannerConfig::default()
        };
        let mut bench = Self {
            uniform,
            kept: build("mpgaa")?,
            anew: build("mpgaa")?,
            jumps: build("jps")?,
            replanner: Replanner::new(&config).map_err(|error| error.to_string())?,
            revision: 1,
            task: 0,
            wrong: 0,
            map,
        };
        let all = [whole(&bench.map)];
        for planner in [&mut bench.kept, &mut bench.anew, &mut bench.jumps] {
            planner.map_changed(&bench.map.view(), &all);
        }
        Ok(bench)
    }

    fn query(map: &Map, ends: (Cell, Cell)) -> PlanQuery<'_> {
        PlanQuery {
            map: map.view(),
            start: map.pose(ends.0),
            goal: map.pose(ends.1),
            tolerance_m: 0.3,
            unknown: Unknown::Free,
            corner_rule: CornerRule::ForbidAny,
        }
    }

    /// One cycle of the replanner; its time.
    fn cycle(&mut self, ends: (Cell, Cell), changed: &[CellRect]) -> f64 {
        self.revision += 1;
        let situation = Situation {
            robot: self.map.pose(ends.0),
            map: Some(self.map.view()),
            revision: self.revision,
            changed,
            target: Some(Target {
                task: self.task,
                goal: u64::from(ends.1.x.unsigned_abs()) << 32 | u64::from(ends.1.y.unsigned_abs()),
                pose: self.map.pose(ends.1),
                tolerance_m: 0.3,
            }),
            request: None,
        };
        let started = Instant::now();
        let mut step = self.replanner.begin(&situation);
        while let Step::Search(_) = step {
            self.replanner.search(&situation, &mut |_| Control::Go);
            let settled = Situation {
                changed: &[],
                ..situation
            };
            step = self.replanner.settle(&settled);
        }
        us(started)
    }

    fn ahead(&mut self) -> f64 {
        let started = Instant::now();
        while self.kept.prepare(4096) {}
        let time = us(started);
        while self.replanner.prepare(4096) {}
        time
    }

    /// Fills the block and what it inflates; gives what was there before.
    fn apply(&mut self, min: Cell, max: Cell) -> (CellRect, Vec<MapCell>) {
        let resolution_m = self.map.geometry.resolution_m;
        let margin = if self.uniform {
            0
        } else {
            (INFLATION_M / resolution_m).ceil() as i32 + 1
        };
        let rect = CellRect { min, max }.grown(margin, &self.map.geometry);
        let mut before = Vec::new();
        for y in rect.min.y..rect.max.y {
            for x in rect.min.x..rect.max.x {
                let cell = Cell::new(x, y);
                let Some(index) = self.map.geometry.index_of(cell) else {
                    continue;
                };
                let old = self.map.cells[index];
                before.push(old);
                let gap = |at: i32, min: i32, max: i32| {
                    f64::from((min - at).max(at - max + 1).max(0)).mul_add(resolution_m, 0.0)
                };
                let clearance_m = gap(x, min.x, max.x).hypot(gap(y, min.y, max.y));
                let cost = if clearance_m <= 0.0 {
                    COST_LETHAL
                } else if self.uniform || clearance_m > INFLATION_M {
                    0
                } else if clearance_m <= INSCRIBED_M {
                    COST_INSCRIBED
                } else {
                    #[allow(clippy::cast_sign_loss, reason = "between 0 and 252")]
                    let cost =
                        (252.0 * (-INFLATION_FACTOR * (clearance_m - INSCRIBED_M)).exp()) as u8;
                    cost
                };
                if cost > old.cost {
                    self.map.cells[index] = of_cost(cost);
                }
            }
        }
        (rect, before)
    }

    fn undo(&mut self, rect: CellRect, before: &[MapCell]) {
        let mut cells = before.iter();
        for y in rect.min.y..rect.max.y {
            for x in rect.min.x..rect.max.x {
                if let (Some(index), Some(cell)) =
                    (self.map.geometry.index_of(Cell::new(x, y)), cells.next())
                {
                    self.map.cells[index] = *cell;
                }
            }
        }
    }

    /// Where the block of an event lies; `None` where it would bury an end.
    fn place(&self, kind: Kind, way: &[Cell], rng: &mut Rng) -> Option<(Cell, Cell)> {
        let (at, width, height) = match kind {
            Kind::Block { at, side } => {
                let near = usize::try_from(30 + side / 2).ok()?;
                let cell = match at {
                    Place::Near => *way.get(near)?,
                    Place::Mid => *way.get(way.len() / 2)?,
                    Place::Goal => *way.get(way.len().checked_sub(near)?)?,
                    Place::Off => {
                        let (w, h) = self.map.geometry.size();
                        self.map.free_near(Cell::new(rng.below(w), rng.below(h)))
                    }
                };
                (cell, side, side)
            }
            Kind::Removal => (*way.get(way.len() / 3)?, 10, 10),
            // The narrowest place of the way, closed from side to side.
            Kind::Door => {
                let inner = way.get(60..way.len().checked_sub(60)?)?;
                let cell = inner
                    .iter()
                    .max_by_key(|cell| self.map.view().get(**cell).map_or(0, |c| c.cost))?;
                (*cell, 61, 61)
            }
        };
        let min = Cell::new(at.x - width / 2, at.y - height / 2);
        let max = Cell::new(min.x + width, min.y + height);
        let buries = |end: &Cell| {
            (min.x - 14..max.x + 14).contains(&end.x) && (min.y - 14..max.y + 14).contains(&end.y)
        };
        (!buries(way.first()?) && !buries(way.last()?)).then_some((min, max))
    }

    /// Tells the planners; the time for `kept`.
    fn tell(&mut self, rect: CellRect) -> f64 {
        let map = self.map.view();
        let started = Instant::now();
        self.kept.map_changed(&map, &[rect]);
        let time = us(started);
        self.anew.map_changed(&map, &[rect]);
        self.jumps.map_changed(&map, &[rect]);
        time
    }

    fn event(&mut self, kind: Kind, ends: (Cell, Cell), rng: &mut Rng) -> Option<Event> {
        let mut path = CellPath::default();
        // The way before the change, and everything that is known about it.
        self.kept
            .plan(
                &Self::query(&self.map, ends),
                &mut |_| Control::Go,
                &mut path,
            )
            .ok()?;
        self.task += 1;
        self.cycle(ends, &[]);
        self.ahead();
        let way = cell_by_cell(&self.replanner.plan().cells.cells);
        let (min, max) = self.place(kind, &way, rng)?;
        let legality = Legality {
            unknown: Unknown::Free,
            corner_rule: CornerRule::ForbidAny,
        };
        let mut runs = vec![Event::default(); REPEATS];
        let mut corridor = Corridor::default();
        let mut anew = None;
        for run in &mut runs {
            let (rect, before) = self.apply(min, max);
            if kind == Kind::Removal {
                // The block is there, everybody knows, and it goes.
                self.tell(rect);
                self.kept
                    .plan(
                        &Self::query(&self.map, ends),
                        &mut |_| Control::Go,
                        &mut path,
                    )
                    .ok()?;
                self.cycle(ends, &[rect]);
                self.ahead();
                self.undo(rect, &before);
            }
            corridor.set(&self.map.view(), legality, &path.cells);
            run.told = self.tell(rect);
            let started = Instant::now();
            run.kept = corridor.is_cut(&self.map.view()).is_none();
            run.filter = us(started);
            let query = Self::query(&self.map, ends);
            let mut found = CellPath::default();
            found.cells.reserve(20_000);
            let mut timed = |planner: &mut dyn GlobalPlanner| {
                let started = Instant::now();
                let result = planner.plan(&query, &mut |_| Control::Go, &mut found);
                (us(started), result, found.stats.expanded)
            };
            let incremental = timed(self.kept.as_mut());
            run.incremental = incremental.0;
            // A* takes seconds where the others take milliseconds: once is enough.
            let scratch = *anew.get_or_insert_with(|| timed(self.anew.as_mut()));
            run.scratch = scratch.0;
            if self.uniform {
                run.jumps = timed(self.jumps.as_mut()).0;
            }
            run.ratio = incremental.2 as f64 / scratch.2.max(1) as f64;
            let same = match (incremental.1, scratch.1) {
                (Ok(one), Ok(other)) => (one.cost - other.cost).abs() <= 1e-3 * other.cost,
                (one, other) => one.is_err() && other.is_err(),
            };
            run.cycle = self.cycle(ends, &[rect]);
            // The policy's own search, when the filter did not settle it.
            let plan = self.replanner.plan();
            let policy = if plan.searched_map == self.revision {
                plan.cells.stats.expanded
            } else {
                0
            };
            let most = scratch.2 + scratch.2 * 3 / 10 + 1;
            if !same || incremental.2.max(policy) > most {
                self.wrong += 1;
            }
            run.ahead = self.ahead();
            if kind != Kind::Removal {
                self.undo(rect, &before);
                self.tell(rect);
                self.kept
                    .plan(
                        &Self::query(&self.map, ends),
                        &mut |_| Control::Go,
                        &mut path,
                    )
                    .ok()?;
                // Another task of the same goal: back on the way before the change.
                self.task += 1;
                self.cycle(ends, &[rect]);
            }
            self.ahead();
        }
        let of = |field: fn(&Event) -> f64| median(runs.iter().map(field).collect());
        Some(Event {
            told: of(|event| event.told),
            filter: of(|event| event.filter),
            incremental: of(|event| event.incremental),
            scratch: of(|event| event.scratch),
            jumps: of(|event| event.jumps),
            cycle: of(|event| event.cycle),
            ahead: of(|event| event.ahead),
            kept: runs[0].kept,
            ratio: of(|event| event.ratio),
        })
    }
}

fn table(name: &str, map: &Map, uniform: bool, n_events: usize) -> Result<usize, String> {
    let mut bench = Bench::new(map.clone(), uniform)?;
    let costs = if uniform { "uniform" } else { "inflated" };
    println!("\n{name}, {costs}: p50 / p99 / worst [us]; ratio: expansions of incremental by A*'s");
    println!(
        "| event | n | kept | told | filter | incremental | A* from scratch | jps from scratch | \
         policy | ahead | ratio, median / worst |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|---|");
    let (width, height) = bench.map.geometry.size();
    for (name, kind) in KINDS {
        let mut rng = Rng(7);
        let mut events: Vec<Event> = Vec::new();
        let mut tries = 0;
        while events.len() < n_events && tries < 4 * n_events {
            // A new way every eight events.
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
            let query = Bench::query(&bench.map, (start, goal));
            if bench
                .anew
                .plan(&query, &mut |_| Control::Go, &mut path)
                .is_err()
            {
                continue;
            }
            start = path.cells.get((tries % 8) * 10).copied().unwrap_or(start);
            if let Some(event) = bench.event(kind, (start, goal), &mut rng) {
                events.push(event);
            }
        }
        let of = |field: fn(&Event) -> f64| {
            let mut numbers: Vec<f64> = events.iter().map(field).collect();
            numbers.sort_by(f64::total_cmp);
            let at = |share| common::quantile(&numbers, share);
            if at(0.5) < 10.0 {
                format!("{:.1} / {:.1} / {:.1}", at(0.5), at(0.99), at(1.0))
            } else {
                format!("{:.0} / {:.0} / {:.0}", at(0.5), at(0.99), at(1.0))
            }
        };
        let mid = |field: fn(&Event) -> f64| median(events.iter().map(field).collect());
        let worst_ratio = events.iter().map(|event| event.ratio).fold(0.0, f64::max);
        let jumps = if uniform {
            of(|event| event.jumps)
        } else {
            "-".to_owned()
        };
        println!(
            "| {name} | {} | {} | {:.1} | {} | {} | {} | {jumps} | {} | {:.0} | {:.2} / {worst_ratio:.2} |",
            events.len(),
            events.iter().filter(|event| event.kept).count(),
            mid(|event| event.told),
            of(|event| event.filter),
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

/// A way with every cell that it passes from one neighbour to the next.
fn cell_by_cell(corners: &[Cell]) -> Vec<Cell> {
    let mut cells: Vec<Cell> = corners.first().copied().into_iter().collect();
    for pair in corners.windows(2) {
        let mut at = pair[0];
        while at != pair[1] {
            at.x += (pair[1].x - at.x).signum();
            at.y += (pair[1].y - at.y).signum();
            cells.push(at);
        }
    }
    cells
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
        let query = Bench::query(map, ends);
        let _ = planner.plan(&query, &mut |_| Control::Go, &mut path);
        while planner.prepare(10_000) {}
    }
    let per_cell = |bytes: usize| bytes as f64 / map.cells.len() as f64;
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

fn run(flags: &Flags) -> Result<usize, String> {
    let maps: Vec<(String, Map)> = match &flags.map {
        Some(file) => {
            let text = std::fs::read_to_string(file).map_err(|error| error.to_string())?;
            let read = GridMap::parse(&text).map_err(|error| error.to_string())?;
            let mut map = Map::free(read.geometry.width, read.geometry.height);
            map.cells = read.cells;
            map.inflate(INSCRIBED_M, INFLATION_M, INFLATION_FACTOR);
            vec![(file.display().to_string(), map)]
        }
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
