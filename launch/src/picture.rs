//! `zeronav picture` and `zeronav draw`: a recorded run as a picture, still or animated.

use crate::show::picture::{Area, Line, Picture};
use crate::show::recording::{FILE, RecordedPath, Recording};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use zeronav_console::artifacts;
use zeronav_console::terminal::{lose, say, usage};
use zeronav_files::read;
use zeronav_msgs::Pose;

/// Name of the still in the folder of a run.
pub(crate) const STILL: &str = "run.svg";

/// Colours of the last paths in the picture.
const COLOURS: [&str; 4] = ["#d95f02", "#7570b3", "#e7298a", "#66a61e"];

/// Draws the run in folder `run` into the file `out`; without, into `run.svg` or `animation.svg` in
/// that folder.
#[must_use]
pub fn picture(run: &Path, out: Option<&Path>, animated: bool) -> ExitCode {
    let recording = match read(run) {
        Ok(recording) => recording,
        Err(problem) => return usage(&problem),
    };
    let name = if animated { "animation.svg" } else { STILL };
    let out = out.map_or_else(|| run.join(name), Path::to_owned);
    let svg = if animated {
        recording.to_animation()
    } else {
        still(&recording)
    };
    match artifacts::write(&out, &svg) {
        Ok(()) => say(&format!("{}\n", out.display())),
        Err(problem) => lose(&problem),
    }
    ExitCode::SUCCESS
}

/// The recording in the folder of a run.
///
/// # Errors
/// One line that names the file.
pub(crate) fn read(run: &Path) -> Result<Recording, String> {
    let file: PathBuf = run.join(FILE);
    let name = file.display();
    let text =
        read::text(&file, read::RESULT_BYTES_MAX).map_err(|error| format!("{name}: {error}"))?;
    let recording: Recording =
        serde_json::from_str(&text).map_err(|error| format!("{name}: {error}"))?;
    recording
        .check()
        .map_err(|problem| format!("{name}: {problem}"))?;
    Ok(recording)
}

/// The still picture of a run.
pub(crate) fn still(run: &Recording) -> String {
    let reach_m = |at: &[f64; 2]| at[0].hypot(at[1]);
    let outcome = run.outcome.replace('_', " ");
    let reason = if run.reason.is_empty() {
        &outcome
    } else {
        &run.reason
    };
    let picture = Picture {
        title: format!("{}: {reason}", run.scenario),
        subtitle: format!(
            "{}, {:.1} s of run time, {} contacts, seed {}",
            run.mode, run.time_s, run.contacts, run.seed
        ),
        area_m: run.area_m,
        walls_m: run.walls_m.clone(),
        areas: zones(run).into_iter().chain(areas(run)).collect(),
        lines: lines(run),
        start_m: run.robot.first().map_or(run.area_m[0], |at| [at[1], at[2]]),
        goals_m: run.goals.iter().map(|goal| [goal[0], goal[1]]).collect(),
        robot_radius_m: run.footprint_m.iter().map(reach_m).fold(0.0, f64::max),
    };
    picture.to_svg()
}

/// The zones that held last.
fn zones(run: &Recording) -> Vec<Area> {
    let frames = run
        .scene
        .as_ref()
        .and_then(|scene| scene["frames"].as_array());
    let newest = frames.and_then(|frames| {
        let mut zones = frames.iter().rev().map(|frame| &frame["zones"]);
        zones.find_map(|zones| serde_json::from_value(zones.clone()).ok())
    });
    let zones: Vec<(String, String, f64, Vec<[f64; 2]>)> = newest.unwrap_or_default();
    let area = |(name, kind, _, corners_m): (String, String, f64, _)| Area {
        name: format!("zone {name}, {}", kind.replace('_', " ")),
        colour: match kind.as_str() {
            "keepout" => "#f4b6b6",
            "lane" => "#c6e2f2",
            "cost" => "#dccbe8",
            _ => "#fbe3a6",
        },
        corners_m,
    };
    zones.into_iter().map(area).collect()
}

/// The scripted obstacles where they were last.
fn areas(run: &Recording) -> Vec<Area> {
    let last = run.obstacles.iter().filter_map(|obstacle| {
        let [_, x_m, y_m, yaw_rad] = *obstacle.poses.last()?;
        let pose = Pose::new(x_m, y_m, yaw_rad);
        let placed = |at: &[f64; 2]| pose.transform(nalgebra::Point2::new(at[0], at[1]));
        let corners = obstacle.outline_m.iter().map(placed);
        Some(Area {
            name: obstacle.name.clone(),
            colour: "#e34a33",
            corners_m: corners.map(|at| [at.x, at.y]).collect(),
        })
    });
    last.collect()
}

/// The paths and the driven track.
fn lines(run: &Recording) -> Vec<Line> {
    let line = |path: &RecordedPath, colour| Line {
        name: format!(
            "path at {:.1} s ({}), {:.1} m",
            path.time_s, path.cause, path.length_m
        ),
        colour,
        dashed: true,
        points_m: path.points_m.clone(),
    };
    let mut lines = Vec::new();
    // The first path and the last ones; a run that replans all the time would hide the map.
    if let Some((first, rest)) = run.paths.split_first() {
        lines.push(line(first, "#1f78b4"));
        let skip = rest.len().saturating_sub(COLOURS.len());
        let last = rest.iter().skip(skip).zip(COLOURS);
        lines.extend(last.map(|(path, colour)| line(path, colour)));
    }
    lines.push(Line {
        name: format!("driven track, {:.1} m", run.driven_m),
        colour: "#1b9e3b",
        dashed: false,
        points_m: run.robot.iter().map(|at| [at[1], at[2]]).collect(),
    });
    lines
}
