//! What mapping costs by the size of the map: one table.
//!
//! `cargo run --release -p zeronav-mapping --example scale`
//!
//! The robot is in a room of 20 m x 20 m with a few columns, in the middle of maps of three
//! sizes; its lidar has 720 beams with 1 cm of noise. Times are medians; the machine should be
//! quiet.

#![allow(clippy::print_stdout, reason = "the table is what it is for")]

#[path = "../tests/support/mod.rs"]
mod support;

use std::time::Instant;
use support::{Rng, Room, config, description};
use zeronav_casts::Cast;
use zeronav_mapping::clearance::ClearanceField;
use zeronav_mapping::localiser::CorrectionMode;
use zeronav_mapping::{Mapper, Mapping, Observation};
use zeronav_msgs::map::MapTile;
use zeronav_msgs::scan::Scan;
use zeronav_msgs::{Cell, CellRect, Pose};
use zeronav_observe::statistics;

/// Side of the room that is seen, whatever the map. [cells]
const ROOM_CELLS: i32 = 400;

/// Times of one size. [us]
struct Row {
    side: i32,
    log_odds: f64,
    scan: f64,
    corrected: f64,
    patch: f64,
    added: f64,
    removed: f64,
    full: f64,
}

fn main() {
    println!(
        "{:>12} {:>10} {:>10} {:>12} {:>9} {:>9} {:>10} {:>10} {:>9} {:>9}",
        "map [cells]",
        "cells [us]",
        "scan [us]",
        "+ pose [us]",
        "tiles[us]",
        "add [us]",
        "remove[us]",
        "full [us]",
        "full/add",
        "full/rem"
    );
    let rows: Vec<Row> = [400, 1000, 4000].map(measure).into();
    for row in &rows {
        println!(
            "{:>5} x {:>4} {:>10.1} {:>10.1} {:>12.1} {:>9.1} {:>9.2} {:>10.2} {:>10.0} {:>9.0} {:>9.0}",
            row.side,
            row.side,
            row.log_odds,
            row.scan,
            row.corrected,
            row.patch,
            row.added,
            row.removed,
            row.full,
            row.full / row.added,
            row.full / row.removed
        );
    }
    if let (Some(small), Some(large)) = (rows.first(), rows.last()) {
        println!(
            "ratio {} : {}: cells {:.2}, scan {:.2}, with pose correction {:.2}",
            large.side,
            small.side,
            large.log_odds / small.log_odds,
            large.scan / small.scan,
            large.corrected / small.corrected
        );
    }
    println!(
        "cells: belief, clearance and costs; scan: the same with tracking, footprint and what \
         moves; tiles: filling those that changed"
    );
}

/// A room with columns in the middle of a map of `side` cells.
fn room_on(side: i32) -> (Room, i32) {
    let mut room = Room::empty(side.unsigned_abs(), side.unsigned_abs());
    let low = (side - ROOM_CELLS) / 2;
    let high = low + ROOM_CELLS;
    for (x0, y0, x1, y1) in [
        (low, low, high, low + 3),
        (low, high - 3, high, high),
        (low, low, low + 3, high),
        (high - 3, low, high, high),
    ] {
        room.fill(x0, y0, x1, y1, true);
    }
    for n in 0..5 {
        let (x, y) = (low + 60 + 65 * n, low + 90 + 45 * (n % 3));
        room.fill(x, y, x + 8, y + 8, true);
    }
    (room, low)
}

/// Median of times; nothing of none. [us]
fn median(times_us: Vec<f64>) -> f64 {
    statistics::median(times_us).unwrap_or(f64::NAN)
}

fn microseconds(since: Instant) -> f64 {
    since.elapsed().as_secs_f64() * 1.0e6
}

/// Scans with noise, drawn before the clock starts.
fn noisy_scans(room: &Room, from: &Pose, n: usize) -> Vec<(Scan, Vec<f32>)> {
    let mut rng = Rng(1);
    let (scan, exact) = room.scan(from);
    (0..n)
        .map(|_| {
            let noisy = exact.iter().map(|r| r + (0.01 * rng.normal()).to_f32());
            (scan, noisy.collect())
        })
        .collect()
}

fn measure(side: i32) -> Row {
    let (room, low) = room_on(side);
    let middle = f64::from(low) + 0.5 * f64::from(ROOM_CELLS);
    let from = room.pose(middle + 12.3, middle - 20.7, 0.3);
    let known = room.as_static_map();
    let mut boxed = room.clone();
    // Something that the map does not know: 2 m in front.
    let at = low + ROOM_CELLS / 2;
    boxed.fill(at + 50, at - 25, at + 60, at - 15, true);
    let scans = noisy_scans(&boxed, &from, 300);

    let mut mapper = Mapper::new(&config(&room), Some(&known), &description()).expect("a map");
    let mut tiles = Vec::new();
    let (mut cells_us, mut patch_us) = (Vec::new(), Vec::new());
    let mut tile = MapTile::default();
    for (scan, ranges) in &scans {
        let begin = Instant::now();
        mapper.integrate(&from, scan, ranges);
        cells_us.push(microseconds(begin));
        let begin = Instant::now();
        mapper.take_dirty_tiles(&mut tiles);
        for index in tiles.drain(..) {
            mapper.fill_tile(index, &mut tile);
        }
        patch_us.push(microseconds(begin));
    }
    drop(mapper);
    let whole = |mode: CorrectionMode| {
        let mut config = config(&room);
        config.pose_correction.mode = mode;
        let mut mapping = Mapping::new(&config, Some(&known), &description(), &[]).expect("a map");
        let mut times_us = Vec::new();
        for ((scan, ranges), n) in scans.iter().zip(1..) {
            let begin = Instant::now();
            mapping.take_in(&Observation {
                scan,
                ranges,
                run_ns: n * 100_000_000,
                odom_from_base_first: from,
                odom_from_base: from,
                odometry_variance: [0.0; 3],
                goal: None,
                told: None,
            });
            times_us.push(microseconds(begin));
        }
        median(times_us)
    };
    let (scan, corrected) = (whole(CorrectionMode::Off), whole(CorrectionMode::On));
    let (added, removed, full) = blocks(&room, at);
    Row {
        side,
        log_odds: median(cells_us),
        scan,
        corrected,
        patch: median(patch_us),
        added,
        removed,
        full,
    }
}

/// A block of 10 x 10 cells put into the clearance, taken out again, and everything recomputed, with a
/// limit of 1 m. [us]
fn blocks(room: &Room, at: i32) -> (f64, f64, f64) {
    let geometry = room.geometry;
    let mut field = ClearanceField::new(&geometry, 20.0);
    for (index, solid) in room.solid.iter().enumerate() {
        field.set(index, *solid);
    }
    let full: Vec<f64> = (0..3)
        .map(|_| {
            let begin = Instant::now();
            field.recompute_all();
            microseconds(begin)
        })
        .collect();
    let block = CellRect {
        min: Cell::new(at + 20, at + 20),
        max: Cell::new(at + 30, at + 30),
    };
    let (mut added, mut removed) = (Vec::new(), Vec::new());
    let cells: Vec<(Cell, usize)> = (block.min.y..block.max.y)
        .flat_map(|y| (block.min.x..block.max.x).map(move |x| Cell::new(x, y)))
        .filter_map(|cell| Some((cell, geometry.index_of(cell)?)))
        .collect();
    let around = block.grown(field.reach(), &geometry);
    for _ in 0..200 {
        let begin = Instant::now();
        for (cell, index) in &cells {
            field.set(*index, true);
            field.add(*cell);
        }
        added.push(microseconds(begin));
        let begin = Instant::now();
        for (_, index) in &cells {
            field.set(*index, false);
        }
        field.recompute(&around);
        removed.push(microseconds(begin));
    }
    (median(added), median(removed), median(full))
}
