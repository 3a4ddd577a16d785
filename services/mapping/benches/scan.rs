//! A scan of 720 beams into a map of 600 x 400 cells: nothing changes, a box comes and goes, the
//! first scan of an unknown map; and everything that is done with a scan, with and without pose
//! correction, into 400 x 400 and 4000 x 4000 cells; and, of a drive through a warehouse, the stage that
//! looks where the robot is, alone.
//!
//! `cargo bench -p zeronav-mapping --no-default-features`

#![allow(missing_docs, reason = "the macros of criterion make public functions")]

#[path = "../tests/support/mod.rs"]
mod support;

use criterion::{BatchSize, Criterion, criterion_group, criterion_main};
use std::hint::black_box;
use std::sync::LazyLock;
use std::time::{Duration, Instant};
use support::{Rng, Room, config, description};
use zeronav_casts::Cast;
use zeronav_mapping::localiser::CorrectionMode;
use zeronav_mapping::{Mapper, Mapping, Observation};
use zeronav_msgs::Pose;
use zeronav_msgs::scan::Scan;
use zeronav_msgs::stages::{Stage, StageTimer};

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

/// Scans with 1 cm of noise of a room of 20 m x 20 m in the middle of maps of two sizes.
fn everything(c: &mut Criterion) {
    let mut group = c.benchmark_group("720 beams, everything");
    for side in [400_i32, 4000] {
        let mut room = Room::empty(side.unsigned_abs(), side.unsigned_abs());
        let low = (side - 400) / 2;
        let high = low + 400;
        for (x0, y0, x1, y1) in [
            (low, low, high, low + 3),
            (low, high - 3, high, high),
            (low, low, low + 3, high),
            (high - 3, low, high, high),
            (low + 130, low + 90, low + 140, low + 100),
        ] {
            room.fill(x0, y0, x1, y1, true);
        }
        let middle = 0.5 * f64::from(side);
        let from = room.pose(middle + 12.3, middle - 20.7, 0.3);
        let (scan, exact) = room.scan(&from);
        let mut rng = Rng(1);
        let scans: Vec<Vec<f32>> = (0..50)
            .map(|_| {
                let noisy = exact.iter().map(|r| r + (0.01 * rng.normal()).to_f32());
                noisy.collect()
            })
            .collect();
        for (name, mode) in [
            ("", CorrectionMode::Off),
            (", pose corrected", CorrectionMode::On),
        ] {
            let mut config = config(&room);
            config.pose_correction.mode = mode;
            let known = room.as_static_map();
            let mut mapping =
                Mapping::new(&config, Some(&known), &description(), &[]).expect("a map");
            let mut n = 0;
            group.bench_function(format!("{side} x {side}{name}"), |b| {
                b.iter(|| {
                    n += 1;
                    mapping.take_in(&Observation {
                        scan: &scan,
                        ranges: black_box(&scans[n % scans.len()]),
                        run_ns: n as u64 * 100_000_000,
                        odom_from_base_first: from,
                        odom_from_base: from,
                        odometry_variance: [0.0; 3],
                        goal: None,
                        told: None,
                    })
                });
            });
        }
    }
    group.finish();
}

/// An aisle of 2.05 m between racks of 3.9 m with gaps, in a hall of 30 m x 20 m.
fn aisle() -> Room {
    let mut room = Room::walled(600, 400, 4);
    room.n_beams = 360;
    for (low, high) in [(6, 108), (149, 251), (292, 394)] {
        for rack in 0..4 {
            room.fill(140 + 80 * rack, low, 218 + 80 * rack, high, true);
        }
    }
    room
}

/// A robot's pose at the first and the last beam of a scan, and the scan.
type Capture = (Pose, Pose, Scan, Vec<f32>);

/// To and fro through the aisle, 9 cm a scan, with 8 mm of noise: again and again. Beams are taken at once, or one
/// after the other.
fn drive(room: &Room, in_turn: bool) -> Vec<Capture> {
    let mut rng = Rng(1);
    let at = |n: f64| room.pose(120.0 + 1.8 * n, 128.5, 0.02 * (0.1 * n).sin());
    let ways = (0..180)
        .map(|n| (n, -1))
        .chain((1..181).rev().map(|n| (n - 1, 1)));
    ways.map(|(n, back)| {
        let last = at(f64::from(n));
        let first = if in_turn {
            at(f64::from(n + back))
        } else {
            last
        };
        let (mut scan, mut ranges) = room.scan(&last);
        scan.time_increment_s = if in_turn { 2.77e-4 } else { 0.0 };
        for (beam, range_m) in (0_u16..).zip(&mut ranges) {
            if in_turn {
                let share = f64::from(beam) / f64::from(room.n_beams - 1);
                let between = |a: f64, b: f64| a + share * (b - a);
                let from = Pose::new(
                    between(first.x_m, last.x_m),
                    between(first.y_m, last.y_m),
                    between(first.yaw_rad, last.yaw_rad),
                );
                *range_m = room.range_m(&from, from.yaw_rad + scan.angle_of(beam.into()));
            }
            *range_m += (0.008 * rng.normal()).to_f32();
        }
        (first, last, scan, ranges)
    })
    .collect()
}

/// The stage that looks where the robot is: odometry tells it, exact odometry that is watched, odometry that
/// is corrected; beams taken at once and one after the other.
fn localise(c: &mut Criterion) {
    static START: LazyLock<Instant> = LazyLock::new(Instant::now);
    let clock = || u64::try_from(START.elapsed().as_nanos()).unwrap_or(u64::MAX);
    let room = aisle();
    let known = room.as_static_map();
    let mut group = c.benchmark_group("360 beams, localise");
    for (name, mode, in_turn) in [
        ("told", CorrectionMode::Off, false),
        ("watched", CorrectionMode::Auto, false),
        ("watched, in turn", CorrectionMode::Auto, true),
        ("corrected", CorrectionMode::On, false),
    ] {
        let drive = drive(&room, in_turn);
        let mut config = config(&room);
        config.pose_correction.mode = mode;
        let mut mapping = Mapping::new(&config, Some(&known), &description(), &[]).expect("a map");
        let mut n = 0;
        group.bench_function(name, |b| {
            b.iter_custom(|times| {
                let mut took = Duration::ZERO;
                for _ in 0..times {
                    n += 1;
                    let (first, last, scan, ranges) = &drive[n % drive.len()];
                    *mapping.timer() = StageTimer::new(clock, clock());
                    mapping.take_in(&Observation {
                        scan,
                        ranges: black_box(ranges),
                        run_ns: n as u64 * 100_000_000,
                        odom_from_base_first: *first,
                        odom_from_base: *last,
                        odometry_variance: [0.0; 3],
                        goal: None,
                        told: None,
                    });
                    let stages_ns = mapping.timer().stages_ns();
                    took += Duration::from_nanos(stages_ns[Stage::Localise.place()].into());
                    // After the answer.
                    mapping.check();
                }
                took
            });
        });
        let is_exact = mapping.map_from_odom().0 == Pose::default();
        assert_eq!(is_exact, mode != CorrectionMode::On, "{name}");
    }
    group.finish();
}

criterion_group!(benches, scan, everything, localise);
criterion_main!(benches);
