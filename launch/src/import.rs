//! `zeronav import`: the log of another robot as a recording for `zeronav replay --open`, and the parameters of Nav2 as a
//! scenario.

mod nav2;

use crate::output_file::{self, Problem};
use clap::Args;
use serde_json::json;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use zeronav_console::exit::EXIT_PASS;
use zeronav_console::terminal::{say, say_json, usage};
use zeronav_files::{Folder, Replace};
use zeronav_import::recording::{Imported, WriteError, assumed};
use zeronav_import::{Log, LogMap, Topics};
use zeronav_msgs::grid::SIDE_CELLS_MAX;
use zeronav_shell::printable::printable;
use zeronav_world::static_map::{Occupancy, StaticMap, covering_geometry, upright};
use zeronav_world_files::map_file::save_in;

/// Cells of a log's map with at most, or at least, this are free, or occupied, as the map server of ROS has it. [percent]
const FREE_MAX: i8 = 25;
const OCCUPIED_MIN: i8 = 65;

/// Arguments of `zeronav import`.
#[derive(Debug, Clone, Args)]
pub struct ImportArgs {
    /// A bag of ROS 2 (an MCAP or .db3 file, or its folder), or a CARMEN log, which may be compressed by gzip; or a parameter
    /// file of Nav2 (.yaml).
    pub log: PathBuf,
    /// The recording, or the scenario; without, `NAME_imported.mcap`, or `NAME_imported.toml`, in this folder.
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
    /// Replace a file of the same name.
    #[arg(long)]
    pub force: bool,
    /// The topic of the scans, of a bag that has several.
    #[arg(long, value_name = "TOPIC")]
    pub scan: Option<String>,
    /// The topic of the odometry, of a bag that has several.
    #[arg(long, value_name = "TOPIC")]
    pub odometry: Option<String>,
    /// The topic of the map that the robot knew, of a bag that has several maps and none on /map; beside parameters of
    /// Nav2, the YAML file of the map of a `map_server`.
    #[arg(long, value_name = "TOPIC|MAP")]
    pub map: Option<String>,
    /// The URDF of the robot, beside parameters of Nav2: where its lidar is, and its outline if they have none.
    #[arg(long, value_name = "FILE")]
    pub urdf: Option<PathBuf>,
    /// Print one JSON object.
    #[arg(long)]
    pub json: bool,
}

/// `zeronav import`.
#[must_use]
pub fn import(arguments: &ImportArgs) -> ExitCode {
    if zeronav_import::nav2::is_parameter_file(&arguments.log) {
        if arguments.scan.is_some() || arguments.odometry.is_some() {
            return usage(
                "--scan and --odometry go with a bag: the parameters of Nav2 name topics themselves",
            );
        }
        return nav2::import(&nav2::Order {
            file: &arguments.log,
            urdf: arguments.urdf.as_deref(),
            map: arguments.map.as_deref().map(Path::new),
            out: arguments.out.as_deref(),
            force: arguments.force,
            json: arguments.json,
        });
    }
    if arguments.urdf.is_some() {
        return usage("--urdf goes with a parameter file of Nav2 (.yaml), not with a log");
    }
    let topics = Topics {
        scan: arguments.scan.clone(),
        odometry: arguments.odometry.clone(),
        map: arguments.map.clone(),
    };
    let log = match zeronav_import::log_in(&arguments.log, &topics) {
        Ok(log) => log,
        Err(error) => return usage(&printable(&error.to_string())),
    };
    let name = arguments.log.file_stem().unwrap_or_default();
    let name = name.to_string_lossy().into_owned();
    let out = arguments.out.clone();
    let out = out.unwrap_or_else(|| PathBuf::from(format!("{name}_imported.mcap")));
    match write(&log, &name, &out, arguments.force) {
        Ok(imported) => {
            if arguments.json {
                say_json(&to_json(&log, &imported, &out));
            } else {
                say(&to_text(&log, &imported, &out));
            }
            ExitCode::from(EXIT_PASS)
        }
        Err(problem) => problem.say(),
    }
}

fn write(log: &Log, name: &str, out: &Path, force: bool) -> Result<Imported, Problem> {
    let map = log
        .map
        .as_ref()
        .map(|map| static_map(map, name))
        .transpose()?;
    let map_name = map_file_of(out);
    output_file::made(out, force, |output| {
        let names = (name, map.is_some().then_some(&*map_name));
        let written = zeronav_import::recording::write(log, names, BufWriter::new(output));
        let (imported, mut output) = written.map_err(|error| match error {
            WriteError::Log(why) => Problem::Input(format!("{name}: {why}")),
            WriteError::Made(error) => Problem::writing(out, &error),
        })?;
        let flushed = output.flush();
        flushed.map_err(|error| Problem::writing(out, &error))?;
        if let Some(map) = &map {
            write_map(map, &out.with_file_name(&map_name), force)?;
        }
        Ok(imported)
    })
}

/// Name of the YAML file with the map of the recording `out`, which lies beside it.
fn map_file_of(out: &Path) -> String {
    let stem = out.file_stem().unwrap_or_default();
    format!("{}_map.yaml", stem.to_string_lossy())
}

/// A map of a log as that of a file.
fn static_map(map: &LogMap, name: &str) -> Result<StaticMap, Problem> {
    let geometry = covering_geometry(&map.corner, map.resolution_m, map.size)
        .filter(|geometry| geometry.check().is_ok());
    let geometry = geometry.ok_or_else(|| {
        Problem::Input(format!(
            "{name}: its map lies too far from the origin, or has more than {SIDE_CELLS_MAX} cells along a side when it is turned upright"
        ))
    })?;
    let cells = map.cells.iter().map(|percent| match percent {
        0..=FREE_MAX => Occupancy::Free,
        OCCUPIED_MIN..=100 => Occupancy::Occupied,
        _ => Occupancy::Unknown,
    });
    Ok(upright(geometry, &map.corner, map.size, cells.collect()))
}

/// Writes a map into `file` and the image beside it.
fn write_map(map: &StaticMap, file: &Path, force: bool) -> Result<(), Problem> {
    let failed = |error: &dyn core::fmt::Display| Problem::writing(file, error);
    let replace = if force { Replace::Yes } else { Replace::No };
    let folder = file.parent().unwrap_or(Path::new(""));
    let folder = Folder::open(folder).map_err(|error| failed(&error))?;
    let stem = file.file_stem().unwrap_or_default().to_string_lossy();
    for ending in ["yaml", "pgm"] {
        let free = folder.check_free(&format!("{stem}.{ending}"), replace);
        free.map_err(|error| {
            let file = file.with_extension(ending);
            Problem::Input(format!(
                "{} {error}; name another recording with --out, or --force to replace it",
                file.display()
            ))
        })?;
    }
    save_in(map, &folder, &stem, replace).map_err(|error| failed(&error))?;
    Ok(())
}

fn to_text(log: &Log, imported: &Imported, out: &Path) -> String {
    let Imported {
        ticks,
        scans,
        corrected,
        lasts_s,
    } = imported;
    let mut lines = vec![format!(
        "{}: {} log, {lasts_s:.1} s, {ticks} ticks, {scans} scans, {corrected} corrected poses",
        out.display(),
        log.format
    )];
    if let Some(map) = &log.map {
        let (columns, rows) = map.size;
        let file = out.with_file_name(map_file_of(out));
        lines.push(format!(
            "{}: its map, {columns} x {rows} cells",
            file.display()
        ));
    }
    let report = &log.report;
    lines.extend(report.missing.iter().map(|it| format!("missing: {it}")));
    lines.extend(assumed(log).iter().map(|it| format!("assumed: {it}")));
    let mended = report.mended.iter();
    lines.extend(mended.map(|(what, n)| format!("mended: {n} {what}")));
    lines.push(format!(
        "`zeronav replay {} --open mapping` plays it",
        out.display()
    ));
    let lines: Vec<_> = lines.iter().map(|line| printable(line)).collect();
    lines.join("\n") + "\n"
}

fn to_json(log: &Log, imported: &Imported, out: &Path) -> serde_json::Value {
    json!({
        "recording": out,
        "map": log.map.as_ref().map(|_| out.with_file_name(map_file_of(out))),
        "format": log.format,
        "lasts_s": imported.lasts_s,
        "ticks": imported.ticks,
        "scans": imported.scans,
        "corrected_poses": imported.corrected,
        "missing": log.report.missing,
        "assumed": assumed(log),
        "mended": log.report.mended,
    })
}
