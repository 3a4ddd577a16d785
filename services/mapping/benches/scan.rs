//! A scan of 720 beams into a map of 600 x 400 cells: nothing changes, a box comes and goes, the
//! first scan of an unknown map.
//!
//! `cargo bench -p zeronav-mapping --no-default-features`

#![allow(missing_docs, reason = "the macros of criterion make public functions")]

#[path = "../tests/support/mod.rs"]
mod support;

use criterion::{BatchSize, Criterion, criterion_group, criterion_main};
use std::hint::black_box;
use support::{Room, config, description};
use zeronav_mapping::Mapper;

fn scan(c: &mut Criterion) {
    let mut room = Room::walled(600, 400, 3);
    for column in 1..4 {
        room.fill(150 * column, 0, 150 * column + 3, 150, true);
        room.fill(150 * column, 180, 150 * column + 3, 400, true);
    }
    let from = room.pose(230.0, 165.0, 0.3);
    let (scan, ranges) = room.scan(&from);
    let mut with_box = room.clone();
    with_box.fill(260, 160, 270, 170, true);
    let (_, box_ranges) = with_box.scan(&from);

    let mut group = c.benchmark_group("720 beams into 600x400");
    group.bench_function("nothing changes", |b| {
        let mut mapper = Mapper::new(&config(&room), Some(&room.as_static_map()), &description())
            .expect("a map");
        b.iter(|| mapper.integrate(black_box(&from), &scan, &ranges));
    });
    let fresh =
        || Mapper::new(&config(&room), Some(&room.as_static_map()), &description()).expect("a map");
    group.bench_function("a box of 10 x 10 cells appears", |b| {
        b.iter_batched_ref(
            fresh,
            |mapper| mapper.integrate(&from, &scan, &box_ranges),
            BatchSize::LargeInput,
        );
    });
    group.bench_function("a box of 10 x 10 cells is cleared", |b| {
        b.iter_batched_ref(
            || {
                let mut mapper = fresh();
                mapper.integrate(&from, &scan, &box_ranges);
                mapper.integrate(&from, &scan, &ranges);
                mapper
            },
            |mapper| assert!(mapper.integrate(&from, &scan, &ranges).cleared > 0),
            BatchSize::LargeInput,
        );
    });
    group.bench_function("first scan of an unknown map", |b| {
        b.iter_batched_ref(
            || Mapper::new(&config(&room), None, &description()).expect("a map"),
            |mapper| mapper.integrate(&from, &scan, &ranges),
            BatchSize::LargeInput,
        );
    });
    group.bench_function("the map is made", |b| {
        b.iter_with_large_drop(fresh);
    });
    group.finish();
}

criterion_group!(benches, scan);
criterion_main!(benches);
