//! From what was seen of a run to its recording.

use crate::drive::Driven;
use crate::film::Cut;
use crate::judge;
use crate::prepare::Prepared;
use crate::show::recording::{RecordedObstacle, RecordedPath, Recording};
use crate::subject::Subject;
use std::path::Path;
use zeronav_casts::Cast;
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
    let recording = of_run(&Subject::of(prepared, driven), &result.outcome, timings);
    Recording {
        reason: result.reason.clone(),
        driven_m: result.driven_m,
        contacts: result.contacts,
        command: command(),
        ..recording
    }
}

/// The recording of a stack that stayed up: what its film has kept.
#[must_use]
pub(crate) fn of_stay(prepared: &Prepared, driven: &Driven, outcome: &str) -> Recording {
    Recording {
        command: command(),
        ..of_film(&Subject::of(prepared, driven), outcome)
    }
}

/// The recording of a run with an end.
pub(crate) fn of_run(subject: &Subject<'_>, outcome: &str, timings: Option<Timings>) -> Recording {
    let collector = subject.collector;
    let truth = collector.totals.truth.unwrap_or_default();
    let moments = judge::moments(subject);
    let about = Recording {
        driven_m: truth.driven_m,
        contacts: truth.contacts_moving + truth.contacts_standing,
        robot: moments
            .iter()
            .map(|moment| pose(moment.run_ns, &moment.pose, subject))
            .collect(),
        paths: (collector.records.paths.iter())
            .filter(|path| path.status == PathStatus::Found && path.run_ns <= subject.end_run_ns)
            .map(|path| RecordedPath {
                time_s: since_goal_s(path.run_ns, subject),
                cause: path.cause.to_string(),
                length_m: path.length_m,
                points_m: path.points_m.iter().map(|at| at.map(thousandths)).collect(),
            })
            .collect(),
        time_s: seconds(subject.end_run_ns.saturating_sub(subject.goals_run_ns)),
        timings: timings.unwrap_or_else(|| timings_of(subject)),
        ..Recording::default()
    };
    complete(subject, outcome, about)
}

/// The recording of what has no end of its own: what the film has kept.
pub(crate) fn of_film(subject: &Subject<'_>, outcome: &str) -> Recording {
    let truth = subject.collector.truth.unwrap_or_default();
    let film = &subject.collector.film;
    let paths = film.paths().iter();
    let found = paths.filter(|(_, planned)| planned.path.status() == Some(PathStatus::Found));
    let about = Recording {
        driven_m: truth.driven_m,
        contacts: truth.contacts_moving + truth.contacts_standing,
        robot: (film.poses().iter())
            .filter(|(run_ns, _)| *run_ns >= subject.goals_run_ns)
            .map(|(run_ns, moving)| pose(*run_ns, &moving.pose, subject))
            .collect(),
        paths: found
            .map(|(run_ns, planned)| RecordedPath {
                time_s: since_goal_s(*run_ns, subject),
                cause: (planned.path.cause()).map_or_else(String::new, |cause| cause.to_string()),
                length_m: planned.path.length_m,
                points_m: (planned.waypoints.iter())
                    .map(|at| [at.x_m, at.y_m].map(thousandths))
                    .collect(),
            })
            .collect(),
        time_s: since_goal_s(subject.end_run_ns, subject),
        timings: timings_of(subject),
        ..Recording::default()
    };
    complete(subject, outcome, about)
}

/// Adds what all recordings have in common.
fn complete(subject: &Subject<'_>, outcome: &str, about: Recording) -> Recording {
    let scenario = subject.scenario;
    let map = subject.world.rasterise();
    let geometry = map.geometry;
    let origin_m = [geometry.origin_x_m, geometry.origin_y_m];
    let size_m = [geometry.width, geometry.height].map(|n| f64::from(n) * geometry.resolution_m);
    let base = subject.footprint.placed(&Pose::default());
    let film = &subject.collector.film;
    let mode = subject.mode.to_string();
    let cut = Cut {
        scenario: &scenario.name,
        mode: &mode,
        from_ns: subject.goals_run_ns,
        until_ns: subject.end_run_ns,
    };
    let scene = film.scene(&cut);
    let (interventions, interventions_left_out) = film.interventions();
    let counts = |run_ns: &u64| (subject.goals_run_ns..=subject.end_run_ns).contains(run_ns);
    Recording {
        scenario: scenario.name.clone(),
        title: scenario.title.clone(),
        outcome: outcome.to_owned(),
        reason: outcome.replace('_', " "),
        seed: subject.seed,
        area_m: [origin_m, [origin_m[0] + size_m[0], origin_m[1] + size_m[1]]],
        walls_m: rectangles(&map),
        footprint_m: base.outline().iter().map(|at| [at.x, at.y]).collect(),
        goals: (scenario.goals.iter())
            .map(|goal| [goal.pose.x_m, goal.pose.y_m, goal.pose.yaw_rad])
            .collect(),
        obstacles: obstacles(subject),
        first_goal_s: thousandths(seconds(subject.goals_run_ns)),
        tick_s: seconds(scenario.run.tick_ns()),
        interventions: interventions
            .iter()
            .filter(|(run_ns, _)| counts(run_ns))
            .map(|(run_ns, why)| (since_goal_s(*run_ns, subject), why.to_string()))
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
fn timings_of(subject: &Subject<'_>) -> Timings {
    let records = &subject.collector.records;
    let lockstep = subject.mode == RunMode::Lockstep;
    let mut gathering = Gathering::default();
    gathering.compute(records);
    if !lockstep {
        let (events, _) = judge::latency(subject);
        let drive = Drive {
            records,
            events: &events,
            round: None,
            tick_ns: subject.scenario.run.tick_ns(),
            from_ns: subject.goals_run_ns,
        };
        gathering.latencies(drive, DEADLINE_NS);
    }
    gathering.timings(lockstep)
}

/// Time since the first goal. [s]
fn since_goal_s(run_ns: u64, subject: &Subject<'_>) -> f64 {
    thousandths(seconds(run_ns.saturating_sub(subject.goals_run_ns)))
}

fn pose(run_ns: u64, pose: &Pose, subject: &Subject<'_>) -> [f64; 4] {
    let [x_m, y_m, yaw_rad] = [pose.x_m, pose.y_m, pose.yaw_rad].map(thousandths);
    [since_goal_s(run_ns, subject), x_m, y_m, yaw_rad]
}

fn obstacles(subject: &Subject<'_>) -> Vec<RecordedObstacle> {
    let seen = &subject.collector.totals.motion.obstacles;
    let recorded = |(index, poses): (&usize, &Vec<(u64, Pose)>)| {
        let obstacle = subject.world.obstacles().get(*index)?;
        let own_frame = obstacle.shape.placed_at(&Pose::default());
        let poses = poses
            .iter()
            .filter(|(run_ns, _)| *run_ns <= subject.end_run_ns);
        let row = |(run_ns, place): &(u64, Pose)| pose(*run_ns, place, subject);
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
            map.geometry.origin_x_m + column.to_f64() * resolution_m,
            map.geometry.origin_y_m + row.to_f64() * resolution_m,
            cells.to_f64() * resolution_m,
            rows.to_f64() * resolution_m,
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
