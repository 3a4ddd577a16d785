//! Robots that wake somewhere on a map: how many find themselves, how exactly, how fast, and what it costs.
//!
//! `cargo run --release -p zeronav-mapping --example kidnapped -- MAP.yaml... [--poses 20] [--seed 1] [--moved 0.3] [--wrong | --right]`
//!
//! From every pose, drawn in the largest room of a map, a standing robot looks around for 10 s with a lidar of 360 beams,
//! 12 m, noise of 1 cm and 1 % lost returns. With `--moved` boxes stand before so large a share of the beams that the map
//! does not hold; with `--wrong` the robot is told that it is 2 m ahead and turned by 180 degrees, with
//! `--right` where it is, instead of nothing.

#![allow(clippy::print_stdout, reason = "the figures are what it is for")]

#[path = "../tests/support/mod.rs"]
mod support;

use std::error::Error;
use std::path::{Path, PathBuf};
use support::{Rng, Room, description, observed, take_in_ms};
use zeronav_casts::Cast;
use zeronav_mapping::localisation::StartPose;
use zeronav_mapping::{Mapping, MappingConfig, Sought};
use zeronav_msgs::Pose;
use zeronav_msgs::pose::wrap_angle;
use zeronav_observe::statistics::percentile;
use zeronav_world::{Occupancy, StaticMap};

/// Scans of 0.1 s.
const SCANS: u32 = 100;

/// A pose farther off than this is wrong. [m, rad]
const WRONG: (f64, f64) = (0.5, 0.3);

/// Least distance from a wall. [m]
const ROOM_M: f64 = 0.3;

#[derive(Debug, Clone, Copy)]
struct Options {
    poses: u32,
    seed: u64,
    moved: f64,
    told: Told,
}

/// What a robot is told about its pose.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Told {
    Nothing,
    Wrong,
    Right,
}

/// What became of the robots of a map.
#[derive(Debug, Default)]
struct Tally {
    found: u32,
    ambiguous: u32,
    nowhere: u32,
    searching: u32,
    wrong: u32,
    not_lost: u32,
    after_s: Vec<f64>,
    off_m: Vec<f64>,
    off_rad: Vec<f64>,
    scan_ms: Vec<f64>,
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut options = Options {
        poses: 20,
        seed: 1,
        moved: 0.0,
        told: Told::Nothing,
    };
    let mut maps = Vec::new();
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        let mut value = || arguments.next().ok_or("a value is missing");
        match argument.as_str() {
            "--poses" => options.poses = value()?.parse()?,
            "--seed" => options.seed = value()?.parse()?,
            "--moved" => options.moved = value()?.parse()?,
            "--wrong" => options.told = Told::Wrong,
            "--right" => options.told = Told::Right,
            _ => maps.push(PathBuf::from(argument)),
        }
    }
    println!("{options:?}");
    for map in &maps {
        let tally = robots(map, options)?;
        println!(
            "{:24} {}",
            map.file_stem().unwrap_or_default().display(),
            tally.line()
        );
    }
    Ok(())
}

impl Tally {
    fn line(mut self) -> String {
        let percentile =
            |values: &mut Vec<f64>, share: f64| percentile(values, share).unwrap_or(f64::NAN);
        format!(
            "found {:3} ambiguous {:3} nowhere {:3} searching {:3} never lost {:3} WRONG {:3} | after s {:.1} max {:.1} \
             | off cm {:.1} max {:.1}, deg {:.2} max {:.2} | scan ms {:.2} p99 {:.2} max {:.2}",
            self.found,
            self.ambiguous,
            self.nowhere,
            self.searching,
            self.not_lost,
            self.wrong,
            percentile(&mut self.after_s, 0.5),
            percentile(&mut self.after_s, 1.0),
            100.0 * percentile(&mut self.off_m, 0.5),
            100.0 * percentile(&mut self.off_m, 1.0),
            percentile(&mut self.off_rad, 0.5).to_degrees(),
            percentile(&mut self.off_rad, 1.0).to_degrees(),
            percentile(&mut self.scan_ms, 0.5),
            percentile(&mut self.scan_ms, 0.99),
            percentile(&mut self.scan_ms, 1.0),
        )
    }
}

fn robots(file: &Path, options: Options) -> Result<Tally, Box<dyn Error>> {
    let map = zeronav_world_files::map_file::load(file)?.map;
    let standing = map.largest_room(ROOM_M);
    let mut rng = Rng(options.seed);
    let mut tally = Tally::default();
    for number in 0..options.poses {
        let cell = standing[usize::try_from(rng.draw())? % standing.len()];
        let at = map.geometry.centre_of(cell);
        let yaw_rad = wrap_angle(f64::from(rng.below(62832)) * 1.0e-4);
        let truth = Pose::new(at.x, at.y, yaw_rad);
        // How many scans it takes does not change the places of the others.
        let mut own = Rng(rng.draw());
        robot(&map, &truth, number, options, &mut own, &mut tally)?;
    }
    Ok(tally)
}

/// A robot looks around.
fn robot(
    map: &StaticMap,
    truth: &Pose,
    number: u32,
    options: Options,
    rng: &mut Rng,
    tally: &mut Tally,
) -> Result<(), Box<dyn Error>> {
    let room = changed(map, truth, options.moved, rng);
    let mut config = MappingConfig::default();
    if options.told == Told::Nothing {
        config.localisation.start = StartPose::Unknown;
    } else {
        let told = match options.told {
            Told::Wrong => truth.then(&Pose::new(2.0, 0.0, std::f64::consts::PI)),
            Told::Right | Told::Nothing => *truth,
        };
        config.localisation.map_from_odom = [told.x_m, told.y_m, told.yaw_rad];
    }
    let mut mapping = Mapping::new(&config, Some(map), &description(), &[])?;
    let mut was_lost = options.told == Told::Nothing;
    for n in 1..=SCANS {
        let (scan, mut ranges) = room.scan(truth);
        for range_m in &mut ranges {
            let noisy = (f64::from(*range_m) + 0.01 * rng.normal()).to_f32();
            *range_m = if rng.below(100) == 0 {
                f32::INFINITY
            } else {
                noisy
            };
        }
        let stands = Pose::default();
        let seen = observed((&scan, &ranges), u64::from(n), stands, [1.0e-4; 3]);
        let took_ms = take_in_ms(&mut mapping, &seen);
        if n > 1 {
            tally.scan_ms.push(took_ms);
        }
        was_lost |= mapping.is_uncertain();
        if was_lost && !mapping.is_uncertain() {
            tally.after_s.push(0.1 * f64::from(n));
            break;
        }
    }
    let pose = mapping.map_from_odom().0;
    let off_m = pose.distance_m(truth);
    let off_rad = wrap_angle(pose.yaw_rad - truth.yaw_rad).abs();
    if mapping.is_uncertain() {
        match mapping.sought() {
            Sought::Ambiguous(_) | Sought::TooMany => tally.ambiguous += 1,
            Sought::Nowhere => tally.nowhere += 1,
            Sought::Everywhere | Sought::Not => tally.searching += 1,
        }
    } else if !was_lost {
        tally.not_lost += 1;
        if off_m > WRONG.0 || off_rad > WRONG.1 {
            println!("  UNNOTICED: pose {number} at {truth:?} is taken for {pose:?}");
        }
    } else if off_m > WRONG.0 || off_rad > WRONG.1 {
        tally.wrong += 1;
        println!("  WRONG: pose {number} at {truth:?} is taken for {pose:?}");
    } else {
        tally.found += 1;
        tally.off_m.push(off_m);
        tally.off_rad.push(off_rad);
    }
    Ok(())
}

/// The world: the map, with boxes before about a share `moved` of the beams.
fn changed(map: &StaticMap, truth: &Pose, moved: f64, rng: &mut Rng) -> Room {
    let mut room = Room {
        geometry: map.geometry,
        solid: map
            .cells
            .iter()
            .map(|it| *it == Occupancy::Occupied)
            .collect(),
        n_beams: 360,
        range_m_max: 12.0,
    };
    let (_, before) = room.scan(truth);
    let most = (360.0 * moved).to_usize();
    let resolution_m = map.geometry.resolution_m;
    for _ in 0..200 {
        let (_, now) = room.scan(truth);
        let n_moved = before
            .iter()
            .zip(&now)
            .filter(|(a, b)| (**a - **b).abs() > 0.15);
        if n_moved.count() >= most {
            break;
        }
        let angle_rad = f64::from(rng.below(62832)) * 1.0e-4;
        let free_m = f64::from(room.range_m(truth, angle_rad)).min(6.0);
        if free_m < 1.0 {
            continue;
        }
        let range_m = 0.7 + (free_m - 0.9).max(0.0) * 1.0e-3 * f64::from(rng.below(1000));
        let at = truth.point() + range_m * nalgebra::Vector2::new(angle_rad.cos(), angle_rad.sin());
        let cell = map.geometry.unbounded_cell_at(at);
        let half = (0.2 / resolution_m).ceil().to_i32();
        room.fill(
            cell.x - half,
            cell.y - half,
            cell.x + half,
            cell.y + half,
            true,
        );
    }
    room
}
