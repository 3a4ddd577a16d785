//! From what was seen of a run to its picture.

use crate::drive::Driven;
use crate::measure::index::PathRecord;
use crate::prepare::Prepared;
use crate::result::RunResult;
use crate::show::picture::{Area, Line, Picture};
use zeronav_msgs::path::PathStatus;
use zeronav_msgs::time::seconds;
use zeronav_world::static_map::Occupancy;

/// Colours of the last paths in the picture.
const COLOURS: [&str; 4] = ["#d95f02", "#7570b3", "#e7298a", "#66a61e"];

/// The picture of a run.
#[must_use]
pub(crate) fn picture(prepared: &Prepared, driven: &Driven, result: &RunResult) -> Picture {
    let map = prepared.world.rasterise();
    let start = prepared.scenario.start;
    Picture {
        title: format!("{}: {}", result.scenario, result.reason),
        subtitle: format!(
            "{}, {:.1} s of run time, {} contacts, seed {}",
            result.mode, result.time_s, result.contacts, result.seed
        ),
        geometry: map.geometry,
        occupied: map
            .cells
            .iter()
            .map(|cell| *cell == Occupancy::Occupied)
            .collect(),
        areas: result
            .obstacles
            .iter()
            .map(|obstacle| Area {
                name: obstacle.name.clone(),
                colour: "#e34a33",
                corners_m: obstacle.corners_m.clone(),
            })
            .collect(),
        lines: lines(driven, result),
        start_m: [start.x_m, start.y_m],
        goals_m: prepared
            .scenario
            .goals
            .iter()
            .map(|goal| [goal.pose.x_m, goal.pose.y_m])
            .collect(),
        robot_radius_m: prepared.footprint.circumscribed_radius_m(),
    }
}

/// The paths and the driven track.
fn lines(driven: &Driven, result: &RunResult) -> Vec<Line> {
    let paths: Vec<&PathRecord> = driven
        .collector
        .records
        .paths
        .iter()
        .filter(|path| path.status == PathStatus::Found && path.run_ns <= driven.end_run_ns)
        .collect();
    let mut lines = Vec::new();
    let mut line = |path: &PathRecord, colour, dashed| {
        lines.push(Line {
            name: format!(
                "path at {:.1} s ({}), {:.1} m",
                seconds(path.run_ns),
                path.cause,
                path.length_m
            ),
            colour,
            dashed,
            points_m: path.points_m.clone(),
        });
    };
    // The first path and the last ones; a run that replans all the time would hide the map.
    if let Some((first, rest)) = paths.split_first() {
        line(first, "#1f78b4", true);
        let skip = rest.len().saturating_sub(COLOURS.len());
        for (path, colour) in rest.iter().skip(skip).zip(COLOURS) {
            line(path, colour, true);
        }
    }
    lines.push(Line {
        name: format!("driven track, {:.1} m", result.driven_m),
        colour: "#1b9e3b",
        dashed: false,
        points_m: driven.collector.seen.track_m.clone(),
    });
    lines
}
