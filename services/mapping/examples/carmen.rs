//! A real lidar log becomes a map.
//!
//! `cargo run --release -p zeronav-mapping --example carmen -- LOG [--out map.png] [--lost 50]`
//!
//! LOG, or `intel.gfs.log.gz` in the folder that `--data` names, is a CARMEN log, packed with gzip or not, whose `FLASER` lines carry corrected poses. Every
//! other scan makes the map; how well it explains the scans in between, which it has not seen, is
//! printed: the share of beam end points on or next to occupied cells, and the share of the
//! crossed cells that are not occupied. The picture goes to `--out`, `target/carmen.png` without.
//! With `--lost` so many of the scans in between, evenly spread over the log, are those of a robot that stands there and may be
//! anywhere on the map: how many of them find the corrected pose again within 20 s, and what a scan costs meanwhile.

#![allow(clippy::print_stdout, reason = "the figures are what it is for")]

#[path = "../tests/support/mod.rs"]
mod support;

use nalgebra::{Point2, Vector2};
use std::error::Error;
use std::io::Read;
use std::path::{Path, PathBuf};
use support::{observed, take_in_ms};
use zeronav_casts::Cast;
use zeronav_mapping::beams::{Beam, Beams, End, Sweep};
use zeronav_mapping::localisation::StartPose;
use zeronav_mapping::ray::{Passing, Ray};
use zeronav_mapping::{Mapper, Mapping, MappingConfig, Sought};
use zeronav_msgs::description::Description;
use zeronav_msgs::map::COST_LETHAL;
use zeronav_msgs::pose::wrap_angle;
use zeronav_msgs::scan::Scan;
use zeronav_msgs::{Cell, Pose};
use zeronav_observe::statistics::percentile;
use zeronav_world::Occupancy;

/// Side of a cell. [m]
const RESOLUTION_M: f64 = 0.1;

/// Readings from here on are "no return". [m]
const RANGE_M_MAX: f32 = 80.0;

/// Beams are used up to here: beyond, 1 degree between beams is wide and the poses' yaw counts.
const USED_M_MAX: f64 = 20.0;

/// Scans, ten a second, in which a lost robot must find itself.
const SCANS: u32 = 200;

/// A pose that is farther off is that of another place. [m, rad]
const WRONG: (f64, f64) = (0.5, 0.3);

/// One `FLASER` line.
struct Laser {
    pose: Pose,
    ranges: Vec<f32>,
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut log = None;
    let mut out = PathBuf::from("target/carmen.png");
    let mut n_lost = 0;
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        if argument == "--out" {
            out = arguments.next().ok_or("--out needs a file")?.into();
        } else if argument == "--lost" {
            n_lost = arguments.next().ok_or("--lost needs a number")?.parse()?;
        } else if argument == "--data" {
            let folder: PathBuf = arguments.next().ok_or("--data needs a folder")?.into();
            log = Some(folder.join("intel.gfs.log.gz"));
        } else {
            log = Some(PathBuf::from(argument));
        }
    }
    let log = log.ok_or("usage: carmen LOG [--out map.png]")?;
    let lasers = read(&log)?;
    let (making, judging): (Vec<_>, Vec<_>) =
        lasers.iter().enumerate().partition(|(n, _)| n % 2 == 0);
    let mut mapper = make_map(&lasers, making.iter().map(|(_, laser)| *laser))?;
    let judged = judge(&mapper, judging.iter().map(|(_, laser)| *laser));
    if let Some(every) = judging.len().checked_div(n_lost) {
        let lost = judging.iter().step_by(every.max(1)).take(n_lost);
        let lost = lost.map(|(_, laser)| *laser);
        println!("{}", relocalise(&mapper, lost)?);
    }
    // The picture is of all that is known.
    for (_, laser) in &judging {
        let (scan, ranges) = scan_of(laser);
        mapper.integrate(&laser.pose, &scan, &ranges);
    }
    let geometry = mapper.geometry();
    println!(
        "{} scans, map of {} x {} cells of {RESOLUTION_M} m",
        lasers.len(),
        geometry.width,
        geometry.height
    );
    println!(
        "{:.1} % of {} beam end points on or next to occupied cells",
        100.0 * judged.ends_explained(),
        judged.ends
    );
    println!(
        "{:.1} % of {} crossed cells not occupied",
        100.0 * judged.crossings_free(),
        judged.crossed
    );
    paint(&mapper, &out)?;
    println!("{}", out.display());
    Ok(())
}

fn read(file: &Path) -> Result<Vec<Laser>, Box<dyn Error>> {
    let bytes = std::fs::read(file).map_err(|error| format!("{}: {error}", file.display()))?;
    let mut text = String::new();
    if bytes.starts_with(&[0x1f, 0x8b]) {
        flate2::read::GzDecoder::new(bytes.as_slice()).read_to_string(&mut text)?;
    } else {
        text = String::from_utf8(bytes)?;
    }
    let lasers: Vec<Laser> = text.lines().filter_map(laser_of).collect();
    if lasers.is_empty() {
        return Err(format!("{}: no FLASER line", file.display()).into());
    }
    Ok(lasers)
}

/// `FLASER n r1..rn x y theta odom_x odom_y odom_theta ...`
fn laser_of(line: &str) -> Option<Laser> {
    let mut words = line.strip_prefix("FLASER ")?.split_whitespace();
    let n: usize = words.next()?.parse().ok()?;
    let ranges: Vec<f32> = words
        .by_ref()
        .take(n)
        .map(|word| word.parse().ok())
        .collect::<Option<_>>()?;
    let mut number = || words.next()?.parse::<f64>().ok();
    let pose = Pose::new(number()?, number()?, number()?);
    (ranges.len() == n).then_some(Laser { pose, ranges })
}

/// Half a turn from right to left: an odd number of readings, 181 or 361, has one at either end, an
/// even one begins and ends half a step inside. Readings without a return say nothing.
fn scan_of(laser: &Laser) -> (Scan, Vec<f32>) {
    let steps = (laser.ranges.len() / 2 * 2).max(1).to_f32();
    let step = std::f32::consts::PI / steps;
    let inside = if laser.ranges.len().is_multiple_of(2) {
        0.5
    } else {
        0.0
    };
    let scan = Scan {
        n_beams: u32::try_from(laser.ranges.len()).unwrap_or(0),
        angle_min_rad: -std::f32::consts::FRAC_PI_2 + inside * step,
        angle_increment_rad: step,
        range_m_min: 0.05,
        range_m_max: RANGE_M_MAX,
        ..Scan::default()
    };
    let range = |range_m: &f32| {
        if *range_m >= RANGE_M_MAX {
            f32::NAN
        } else {
            *range_m
        }
    };
    (scan, laser.ranges.iter().map(range).collect())
}

fn make_map<'a>(
    all: &[Laser],
    lasers: impl Iterator<Item = &'a Laser>,
) -> Result<Mapper, Box<dyn Error>> {
    let mut low = Point2::new(f64::INFINITY, f64::INFINITY);
    let mut high = Point2::new(f64::NEG_INFINITY, f64::NEG_INFINITY);
    for laser in all {
        let at = laser.pose.point();
        low = Point2::new(low.x.min(at.x), low.y.min(at.y));
        high = Point2::new(high.x.max(at.x), high.y.max(at.y));
    }
    let config = MappingConfig {
        area_m: Some([
            [low.x - USED_M_MAX, low.y - USED_M_MAX],
            [high.x + USED_M_MAX, high.y + USED_M_MAX],
        ]),
        resolution_m: RESOLUTION_M,
        obstacle_range_m: USED_M_MAX,
        raytrace_range_m: USED_M_MAX,
        ..MappingConfig::default()
    };
    let description = Description {
        inscribed_radius_m: 0.2,
        circumscribed_radius_m: 0.2,
        ..Description::default()
    };
    let mut mapper = Mapper::new(&config, None, &description)?;
    for laser in lasers {
        let (scan, ranges) = scan_of(laser);
        scan.check(&ranges)
            .map_err(|refusal| format!("a scan is {refusal}"))?;
        mapper.integrate(&laser.pose, &scan, &ranges);
    }
    Ok(mapper)
}

/// Puts a robot that may be anywhere where each scan was taken; what became of them.
fn relocalise<'a>(
    mapper: &Mapper,
    lasers: impl Iterator<Item = &'a Laser>,
) -> Result<String, Box<dyn Error>> {
    let map = mapper.as_static_map();
    let description = Description {
        inscribed_radius_m: 0.2,
        circumscribed_radius_m: 0.2,
        ..Description::default()
    };
    let mut config = MappingConfig {
        obstacle_range_m: USED_M_MAX,
        raytrace_range_m: USED_M_MAX,
        ..MappingConfig::default()
    };
    config.localisation.start = StartPose::Unknown;
    let (mut n, mut wrong, mut several, mut none) = (0, 0, 0, 0);
    let (mut off_m, mut off_rad, mut scan_ms) = (Vec::new(), Vec::new(), Vec::new());
    for laser in lasers {
        n += 1;
        let mut mapping = Mapping::new(&config, Some(&map), &description, &[])?;
        let (scan, ranges) = scan_of(laser);
        let found = (1..=SCANS).any(|n| {
            let stands = Pose::default();
            let seen = observed((&scan, &ranges), u64::from(n), stands, [1.0e-4; 3]);
            scan_ms.push(take_in_ms(&mut mapping, &seen));
            !mapping.is_uncertain()
        });
        let pose = mapping.map_from_odom().0;
        let off = (
            pose.distance_m(&laser.pose),
            wrap_angle(pose.yaw_rad - laser.pose.yaw_rad).abs(),
        );
        if found && (off.0 > WRONG.0 || off.1 > WRONG.1) {
            wrong += 1;
        } else if found {
            off_m.push(off.0);
            off_rad.push(off.1);
        }
        match mapping.sought() {
            Sought::Ambiguous(_) | Sought::TooMany => several += 1,
            Sought::Nowhere => none += 1,
            Sought::Everywhere | Sought::Not => {}
        }
    }
    let n_found = off_m.len();
    let of = |values: &mut Vec<f64>, share| percentile(values, share).unwrap_or(f64::NAN);
    Ok(format!(
        "{n_found} of {n} robots that may be anywhere found, {wrong} at a wrong place; several places fit for {several}, none for {none}; off by {:.3} m and {:.2} degrees in the \
         median, {:.3} m and {:.2} degrees at most; a scan takes {:.2} ms in the median, {:.2} ms at 99 %",
        of(&mut off_m, 0.5),
        of(&mut off_rad, 0.5).to_degrees(),
        of(&mut off_m, 1.0),
        of(&mut off_rad, 1.0).to_degrees(),
        of(&mut scan_ms, 0.5),
        of(&mut scan_ms, 0.99),
    ))
}

/// How well a map explains scans that did not make it.
#[derive(Default)]
struct Judged {
    ends: u64,
    ends_near: u64,
    crossed: u64,
    crossed_occupied: u64,
}

impl Judged {
    fn ends_explained(&self) -> f64 {
        share(self.ends_near, self.ends)
    }

    fn crossings_free(&self) -> f64 {
        1.0 - share(self.crossed_occupied, self.crossed)
    }
}

fn share(part: u64, whole: u64) -> f64 {
    part.to_f64() / whole.max(1).to_f64()
}

/// Counts the occupied among the cells that a beam crosses.
struct Crossing<'a> {
    mapper: &'a Mapper,
    judged: &'a mut Judged,
}

impl Passing for Crossing<'_> {
    fn leaps(&self, _x: i32, _y: i32) -> bool {
        false
    }

    fn passed(&mut self, index: usize) {
        self.judged.crossed += 1;
        let occupied = self.mapper.cells()[index].cost == COST_LETHAL;
        self.judged.crossed_occupied += u64::from(occupied);
    }
}

fn judge<'a>(mapper: &Mapper, lasers: impl Iterator<Item = &'a Laser>) -> Judged {
    let mut judged = Judged::default();
    let mut beams = Beams::default();
    let geometry = mapper.geometry();
    let (width, height) = geometry.size();
    let in_cells = |point: Point2<f64>| {
        Point2::new(
            (point.x - geometry.origin_x_m) / geometry.resolution_m,
            (point.y - geometry.origin_y_m) / geometry.resolution_m,
        )
    };
    for laser in lasers {
        let (scan, ranges) = scan_of(laser);
        beams.cast(&scan, &ranges, &Sweep::still(laser.pose));
        let hits = beams.as_slice().iter().filter_map(|beam| match beam.end {
            End::Hit(range_m) if range_m <= USED_M_MAX => Some((beam, range_m)),
            _ => None,
        });
        for (beam, range_m) in hits {
            judged.ends += 1;
            judged.ends_near += u64::from(is_near_occupied(mapper, beam));
            let ray = Ray {
                origin: in_cells(beam.origin),
                direction: Vector2::new(beam.direction.x, beam.direction.y),
            };
            let mut crossing = Crossing {
                mapper,
                judged: &mut judged,
            };
            ray.left_cells(width, height, range_m / RESOLUTION_M, &mut crossing);
        }
    }
    judged
}

/// True when a cell at or around the beam's end is occupied.
fn is_near_occupied(mapper: &Mapper, beam: &Beam) -> bool {
    let Some(at) = beam.point().and_then(|end| mapper.geometry().cell_at(end)) else {
        return false;
    };
    (-1..=1).any(|dy| {
        (-1..=1).any(|dx| {
            let cell = mapper.view().get(Cell::new(at.x + dx, at.y + dy));
            cell.is_some_and(|cell| cell.cost == COST_LETHAL)
        })
    })
}

/// Black is occupied, white free, grey unknown; the first row has the largest y.
fn paint(mapper: &Mapper, out: &Path) -> Result<(), Box<dyn Error>> {
    let map = mapper.as_static_map();
    let (width, height) = (map.geometry.width, map.geometry.height);
    let cells = (0..height)
        .rev()
        .flat_map(|y| (0..width).map(move |x| Cell::new(x.cast_signed(), y.cast_signed())));
    let pixels: Vec<u8> = cells
        .map(|cell| match map.get(cell) {
            Some(Occupancy::Occupied) => 0,
            Some(Occupancy::Free) => 254,
            Some(Occupancy::Unknown) | None => 205,
        })
        .collect();
    if let Some(folder) = out.parent() {
        std::fs::create_dir_all(folder)?;
    }
    let mut encoder = png::Encoder::new(std::fs::File::create(out)?, width, height);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.write_header()?.write_image_data(&pixels)?;
    Ok(())
}
