//! From what was seen of a run to its recording.

use crate::drive::Driven;
use crate::film::Cut;
use crate::judge;
use crate::prepare::Prepared;
use crate::show::recording::{RecordedObstacle, RecordedPath, Recording};
use std::path::Path;
use zeronav_measure::DEADLINE_NS;
use zeronav_measure::result::RunResult;
use zeronav_measure::timings::{Drive, Gathering, Timings};
use zeronav_msgs::path::PathStatus;
use zeronav_msgs::pose::Pose;
use zeronav_msgs::run::RunMode;
use zeronav_msgs::time::seconds;
use zeronav_world::static_map::{Occupancy, StaticMap};

/// The recording of a run. Of trials, it is that of the last drive, and `timings` are those of all.
#[must_use]
pub(crate) fn recording(
    prepared: &Prepared,
    driven: &Driven,
    result: &RunResult,
    timings: Option<Timings>,
) -> Recording {
    let about = Recording {
        outcome: result.outcome.clone(),
        reason: result.reason.clone(),
        time_s: seconds(driven.end_run_ns.saturating_sub(driven.goals_run_ns)),
        driven_m: result.driven_m,
        contacts: result.contacts,
        robot: judge::moments(driven)
            .iter()
            .map(|moment| pose(moment.run_ns, &moment.pose, driven))
            .collect(),
        paths: (driven.collector.records.paths.iter())
            .filter(|path| path.status == PathStatus::Found && path.run_ns <= driven.end_run_ns)
            .map(|path| RecordedPath {
                time_s: since_goal_s(path.run_ns, driven),
                cause: path.cause.to_string(),
                length_m: path.length_m,
                points_m: path.points_m.iter().map(|at| at.map(thousandths)).collect(),
            })
            .collect(),
        timings: timings.unwrap_or_else(|| timings_of(prepared, driven)),
        ..Recording::default()
    };
    complete(prepared, driven, about)
}

/// The recording of a stack that stayed up: what its film has kept.
#[must_use]
pub(crate) fn of_stay(prepared: &Prepared, driven: &Driven, outcome: &str) -> Recording {
    let truth = driven.collector.truth.unwrap_or_default();
    let film = &driven.collector.film;
    let paths = film.paths().iter();
    let found = paths.filter(|(_, planned)| planned.path.status() == Some(PathStatus::Found));
    let about = Recording {
        outcome: outcome.to_owned(),
        reason: outcome.replace('_', " "),
        time_s: since_goal_s(driven.end_run_ns, driven),
        driven_m: truth.driven_m,
        contacts: truth.contacts_moving + truth.contacts_standing,
        robot: (film.poses().iter())
            .filter(|(run_ns, _)| *run_ns >= driven.goals_run_ns)
            .map(|(run_ns, moving)| pose(*run_ns, &moving.pose, driven))
            .collect(),
        paths: found
            .map(|(run_ns, planned)| RecordedPath {
                time_s: since_goal_s(*run_ns, driven),
                cause: (planned.path.cause()).map_or_else(String::new, |cause| cause.to_string()),
                length_m: planned.path.length_m,
                points_m: (planned.waypoints.iter())
                    .map(|at| [at.x_m, at.y_m].map(thousandths))
                    .collect(),
            })
            .collect(),
        timings: timings_of(prepared, driven),
        ..Recording::default()
    };
    complete(prepared, driven, about)
}

/// Adds what all recordings have in common.
fn complete(prepared: &Prepared, driven: &Driven, about: Recording) -> Recording {
    let map = prepared.world.rasterise();
    let geometry = map.geometry;
    let origin_m = [geometry.origin_x_m, geometry.origin_y_m];
    let size_m = [geometry.width, geometry.height].map(|n| f64::from(n) * geometry.resolution_m);
    let base = prepared.footprint.placed(&Pose::default());
    let film = &driven.collector.film;
    let mode = prepared.mode.to_string();
    let cut = Cut {
        scenario: &prepared.scenario.name,
        mode: &mode,
        from_ns: driven.goals_run_ns,
        until_ns: driven.end_run_ns,
    };
    let scene = film.scene(&cut);
    let (interventions, interventions_left_out) = film.interventions();
    let counts = |run_ns: &u64| (driven.goals_run_ns..=driven.end_run_ns).contains(run_ns);
    Recording {
        scenario: prepared.scenario.name.clone(),
        title: prepared.scenario.title.clone(),
        seed: prepared.seed,
        area_m: [origin_m, [origin_m[0] + size_m[0], origin_m[1] + size_m[1]]],
        walls_m: rectangles(&map),
        footprint_m: base.outline().iter().map(|at| [at.x, at.y]).collect(),
        goals: prepared
            .scenario
            .goals
            .iter()
            .map(|goal| [goal.pose.x_m, goal.pose.y_m, goal.pose.yaw_rad])
            .collect(),
        obstacles: obstacles(prepared, driven),
        first_goal_s: thousandths(seconds(driven.goals_run_ns)),
        tick_s: seconds(prepared.scenario.run.tick_ns()),
        command: command(),
        interventions: interventions
            .iter()
            .filter(|(run_ns, _)| counts(run_ns))
            .map(|(run_ns, why)| (since_goal_s(*run_ns, driven), why.to_string()))
            .collect(),
        interventions_left_out,
        rates: film.rates(),
        scene: scene.and_then(|scene| serde_json::to_value(scene).ok()),
        mode,
        ..about
    }
}

/// The command line of this process, with the name of the program alone.
fn command() -> Vec<String> {
    let name = |path: String| {
        let name = Path::new(&path).file_name();
        name.map_or_else(|| path.clone(), |name| name.to_string_lossy().into_owned())
    };
    // Arguments need not be text.
    let mut words = std::env::args_os().map(|word| word.to_string_lossy().into_owned());
    let program = words.next().map(name);
    program.into_iter().chain(words).collect()
}

/// The times of a drive.
fn timings_of(prepared: &Prepared, driven: &Driven) -> Timings {
    let records = &driven.collector.records;
    let lockstep = prepared.mode == RunMode::Lockstep;
    let mut gathering = Gathering::default();
    gathering.compute(records);
    if !lockstep {
        let (events, _) = judge::latency(prepared, driven);
        let drive = Drive {
            records,
            events: &events,
            round: None,
            tick_ns: prepared.scenario.run.tick_ns(),
            from_ns: driven.goals_run_ns,
        };
        gathering.latencies(drive, DEADLINE_NS);
    }
    gathering.timings(lockstep)
}

/// Time since the first goal. [s]
fn since_goal_s(run_ns: u64, driven: &Driven) -> f64 {
    thousandths(seconds(run_ns.saturating_sub(driven.goals_run_ns)))
}

fn pose(run_ns: u64, pose: &Pose, driven: &Driven) -> [f64; 4] {
    let [x_m, y_m, yaw_rad] = [pose.x_m, pose.y_m, pose.yaw_rad].map(thousandths);
    [since_goal_s(run_ns, driven), x_m, y_m, yaw_rad]
}

fn obstacles(prepared: &Prepared, driven: &Driven) -> Vec<RecordedObstacle> {
    let seen = &driven.collector.seen.motion.obstacles;
    let recorded = |(index, poses): (&usize, &Vec<(u64, Pose)>)| {
        let obstacle = prepared.world.obstacles().get(*index)?;
        let own_frame = obstacle.shape.placed_at(&Pose::default());
        let poses = poses
            .iter()
            .filter(|(run_ns, _)| *run_ns <= driven.end_run_ns);
        let row = |(run_ns, place): &(u64, Pose)| pose(*run_ns, place, driven);
        Some(RecordedObstacle {
            name: obstacle.spec.name.clone(),
            outline_m: own_frame.outline().iter().map(|at| [at.x, at.y]).collect(),
            poses: poses.map(row).collect(),
        })
    };
    let mut all: Vec<RecordedObstacle> = seen.iter().filter_map(recorded).collect();
    all.retain(|obstacle| !obstacle.poses.is_empty());
    all
}

/// Occupied cells as rectangles: runs of a row, joined with equal runs of the rows below.
#[allow(clippy::cast_precision_loss, reason = "columns and rows of a map")]
fn rectangles(map: &StaticMap) -> Vec<[f64; 4]> {
    let (width, resolution_m) = (map.geometry.width as usize, map.geometry.resolution_m);
    // First column, cells, first row, rows.
    let mut found: Vec<[usize; 4]> = Vec::new();
    let mut open: Vec<usize> = Vec::new();
    for (row, cells) in map.cells.chunks(width.max(1)).enumerate() {
        let mut next = Vec::new();
        let mut column = 0;
        for run in cells.chunk_by(|a, b| a == b) {
            if run[0] == Occupancy::Occupied {
                let same = |index: &&usize| found[**index][..2] == [column, run.len()];
                if let Some(&index) = open.iter().find(same) {
                    found[index][3] += 1;
                    next.push(index);
                } else {
                    next.push(found.len());
                    found.push([column, run.len(), row, 1]);
                }
            }
            column += run.len();
        }
        open = next;
    }
    let metres = |[column, cells, row, rows]: [usize; 4]| {
        [
            map.geometry.origin_x_m + column as f64 * resolution_m,
            map.geometry.origin_y_m + row as f64 * resolution_m,
            cells as f64 * resolution_m,
            rows as f64 * resolution_m,
        ]
        .map(thousandths)
    };
    found.into_iter().map(metres).collect()
}

/// Rounded to a thousandth, which is finer than anything that is drawn.
fn thousandths(value: f64) -> f64 {
    (value * 1.0e3).round() / 1.0e3
}

#[cfg(test)]
mod tests {
    use super::*;
    use zeronav_msgs::grid::GridGeometry;

    #[test]
    fn rectangles_cover_exactly_the_occupied_cells() {
        let rows = ["##..#", "##..#", ".###.", "....#"];
        let mut map = StaticMap::free(GridGeometry {
            origin_x_m: -1.0,
            origin_y_m: 2.0,
            resolution_m: 0.5,
            width: 5,
            height: 4,
        });
        let occupied = rows
            .concat()
            .bytes()
            .map(|cell| cell == b'#')
            .collect::<Vec<_>>();
        for (cell, occupied) in map.cells.iter_mut().zip(&occupied) {
            if *occupied {
                *cell = Occupancy::Occupied;
            }
        }
        let found = rectangles(&map);
        let expected = [
            [-1.0, 2.0, 1.0, 1.0],
            [1.0, 2.0, 0.5, 1.0],
            [-0.5, 3.0, 1.5, 0.5],
            [1.0, 3.5, 0.5, 0.5],
        ];
        assert_eq!(found, expected);
    }
}
