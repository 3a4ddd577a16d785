//! `c_astar` on maps of 600 x 400 cells: across an office, parts of it, no way at all; and the
//! check of a path against a map update.
//!
//! `cargo bench -p zeronav-global-planner --no-default-features`

#![allow(missing_docs, reason = "the macros of criterion make public functions")]

#[path = "../tests/support/mod.rs"]
mod support;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use std::hint::black_box;
use support::Map;
use zeronav_global_planner::{
    CellPath, Control, CornerRule, Corridor, Legality, PlanQuery, PlannerOptions, Unknown, row_of,
};
use zeronav_msgs::Cell;

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
    let mut group = c.benchmark_group("c_astar 600x400");
    for (name, map, from, to) in cases {
        let query = query(map, from, to);
        let mut planner = (row_of("c_astar").expect("a row").build)(&PlannerOptions::default());
        let mut path = CellPath::default();
        let _ = planner.plan(&query, &mut |_| Control::Go, &mut path);
        group.throughput(Throughput::Elements(path.stats.expanded));
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

    let query = query(&office, corner, opposite);
    let mut planner = (row_of("c_astar").expect("a row").build)(&PlannerOptions::default());
    let mut path = CellPath::default();
    planner
        .plan(&query, &mut |_| Control::Go, &mut path)
        .expect("a way");
    let legality = Legality {
        unknown: query.unknown,
        corner_rule: query.corner_rule,
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

criterion_group!(benches, astar);
criterion_main!(benches);
