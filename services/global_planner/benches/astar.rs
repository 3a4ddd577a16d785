//! Every exact planner on maps of 600 x 400 cells: across an office, parts of it, no way at all;
//! what a change of the map costs them; and the check of a path against a map update.
//!
//! `cargo bench -p zeronav-global-planner --no-default-features`

#![allow(missing_docs, reason = "the macros of criterion make public functions")]
#![allow(clippy::print_stdout, reason = "expansions beside the times")]

#[path = "../tests/support/mod.rs"]
mod support;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use std::hint::black_box;
use support::Map;
use zeronav_global_planner::{
    CellPath, Control, CornerRule, Corridor, EXACT, Legality, PlanQuery, PlannerOptions, Unknown,
    row_of,
};
use zeronav_msgs::{Cell, CellRect};

fn query(map: &Map, from: Cell, to: Cell) -> PlanQuery<'_> {
    PlanQuery {
        map: map.view(),
        start: map.pose(map.free_near(from)),
        goal: map.pose(map.free_near(to)),
        tolerance_m: 0.1,
        unknown: Unknown::Free,
        corner_rule: CornerRule::ForbidAny,
    }
}

fn whole(map: &Map) -> CellRect {
    let (width, height) = map.geometry.size();
    CellRect {
        min: Cell::new(0, 0),
        max: Cell::new(width, height),
    }
}

/// A block of 10 x 10 cells comes and goes before every answer; work ahead is not timed.
fn change(c: &mut Criterion) {
    let mut map = Map::office(600, 400, 7);
    let (from, to) = (Cell::new(20, 20), Cell::new(580, 380));
    let mut group = c.benchmark_group("block on the way, 600x400");
    for key in EXACT {
        let mut planner = (row_of(key).expect("a row").build)(&PlannerOptions::default());
        planner.map_changed(&map.view(), &[whole(&map)]);
        let mut path = CellPath::default();
        planner
            .plan(&query(&map, from, to), &mut |_| Control::Go, &mut path)
            .expect("a way");
        let robot = map.pose(from);
        while planner.prepare(&robot, 10_000) {}
        let middle = path.cells[path.cells.len() / 2];
        let rect = CellRect {
            min: Cell::new(middle.x - 5, middle.y - 5),
            max: Cell::new(middle.x + 5, middle.y + 5),
        };
        let free = map.clone();
        let mut blocked = map.clone();
        blocked.block(rect.min, rect.max);
        let ends = (map.free_near(from), map.free_near(to));
        let mut times = 0_u32;
        group.bench_function(*key, |b| {
            b.iter_custom(|n| {
                let mut sum = core::time::Duration::ZERO;
                for _ in 0..n {
                    times += 1;
                    let map = if times.is_multiple_of(2) {
                        &free
                    } else {
                        &blocked
                    };
                    let query = query(map, ends.0, ends.1);
                    let started = std::time::Instant::now();
                    planner.map_changed(&query.map, &[rect]);
                    let _ = planner.plan(black_box(&query), &mut |_| Control::Go, &mut path);
                    sum += started.elapsed();
                    while planner.prepare(&robot, 10_000) {}
                }
                sum
            });
        });
        map = free;
    }
    group.finish();
}

fn astar(c: &mut Criterion) {
    let office = Map::office(600, 400, 7);
    let mut uniform = office.clone();
    for cell in &mut uniform.cells {
        if !cell.blocks_centre() {
            cell.cost = 0;
        }
    }
    let empty = Map::free(600, 400);
    let mut closed = office.clone();
    closed.block(Cell::new(300, 0), Cell::new(303, 400));
    let (corner, opposite) = (Cell::new(20, 20), Cell::new(580, 380));
    let cases = [
        ("across office, costs", &office, corner, opposite),
        ("across office, uniform", &uniform, corner, opposite),
        ("across empty map", &empty, corner, opposite),
        (
            "10 m through office, costs",
            &office,
            Cell::new(120, 150),
            Cell::new(320, 150),
        ),
        (
            "3 m in office, costs",
            &office,
            Cell::new(210, 220),
            Cell::new(270, 240),
        ),
        ("no way through office", &closed, corner, opposite),
    ];
    for key in EXACT {
        let mut group = c.benchmark_group(format!("{key} 600x400"));
        for (name, map, from, to) in &cases {
            let query = query(map, *from, *to);
            let mut planner = (row_of(key).expect("a row").build)(&PlannerOptions::default());
            planner.map_changed(&map.view(), &[whole(map)]);
            let mut path = CellPath::default();
            let _ = planner.plan(&query, &mut |_| Control::Go, &mut path);
            group.throughput(Throughput::Elements(path.stats.expanded.max(1)));
            group.bench_function(
                format!(
                    "{name} ({} expanded, {} cells)",
                    path.stats.expanded,
                    path.cells.len()
                ),
                |b| {
                    b.iter(|| {
                        planner
                            .plan(black_box(&query), &mut |_| Control::Go, &mut path)
                            .is_ok()
                    });
                },
            );
        }
        group.finish();
    }

    let query = query(&office, corner, opposite);
    let mut planner = (row_of("c_astar").expect("a row").build)(&PlannerOptions::default());
    let mut path = CellPath::default();
    planner
        .plan(&query, &mut |_| Control::Go, &mut path)
        .expect("a way");
    let legality = Legality {
        unknown: query.unknown,
        corner_rule: query.corner_rule,
        past_margin: false,
    };
    let mut corridor = Corridor::default();
    corridor.set(&query.map, legality, &path.cells);
    c.bench_function(
        &format!("corridor of {} cells, is_cut", path.cells.len()),
        |b| {
            b.iter(|| corridor.is_cut(black_box(&query.map)));
        },
    );
}

/// A load fills the aisle before the robot, and the way round is the other aisle.
fn blocked_aisle(c: &mut Criterion) {
    let (free, from, to) = Map::warehouse();
    let mut blocked = free.clone();
    let rect = blocked.drop_load();
    let mut group = c.benchmark_group("load in the aisle, 600x400");
    for key in EXACT {
        let mut planner = (row_of(key).expect("a row").build)(&PlannerOptions::default());
        planner.map_changed(&free.view(), &[whole(&free)]);
        let mut path = CellPath::default();
        let mut expanded = 0;
        group.bench_function(*key, |b| {
            b.iter_custom(|n| {
                let mut sum = core::time::Duration::ZERO;
                for _ in 0..n {
                    planner.map_changed(&free.view(), &[rect]);
                    let _ = planner.plan(&query(&free, from, to), &mut |_| Control::Go, &mut path);
                    while planner.prepare(&free.pose(from), 10_000) {}
                    let query = query(&blocked, from, to);
                    let started = std::time::Instant::now();
                    planner.map_changed(&query.map, &[rect]);
                    let _ = planner.plan(black_box(&query), &mut |_| Control::Go, &mut path);
                    sum += started.elapsed();
                    expanded = path.stats.expanded;
                }
                sum
            });
        });
        println!("{key}: {expanded} expanded");
    }
    group.finish();
}

criterion_group!(benches, astar, change, blocked_aisle);
criterion_main!(benches);
