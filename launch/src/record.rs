//! From what was seen of a run to its recording.

use crate::drive::Driven;
use crate::prepare::Prepared;
use crate::result::RunResult;
use crate::show::recording::{RecordedObstacle, RecordedPath, Recording};
use zeronav_msgs::path::PathStatus;
use zeronav_msgs::pose::Pose;
use zeronav_msgs::time::seconds;
use zeronav_world::static_map::{Occupancy, StaticMap};

/// The recording of a run.
#[must_use]
pub(crate) fn recording(prepared: &Prepared, driven: &Driven, result: &RunResult) -> Recording {
    let map = prepared.world.rasterise();
    let geometry = map.geometry;
    let origin_m = [geometry.origin_x_m, geometry.origin_y_m];
    let size_m = [geometry.width, geometry.height].map(|n| f64::from(n) * geometry.resolution_m);
    let base = prepared.footprint.placed(&Pose::default());
    Recording {
        scenario: result.scenario.clone(),
        outcome: result.outcome.clone(),
        time_s: result.time_s,
        driven_m: result.driven_m,
        contacts: result.contacts,
        area_m: [origin_m, [origin_m[0] + size_m[0], origin_m[1] + size_m[1]]],
        walls_m: rectangles(&map),
        footprint_m: base.outline().iter().map(|at| [at.x, at.y]).collect(),
        goals: prepared
            .scenario
            .goals
            .iter()
            .map(|goal| [goal.pose.x_m, goal.pose.y_m, goal.pose.yaw_rad])
            .collect(),
        robot: result
            .motion
            .iter()
            .map(|row| [row[0], row[1], row[2], row[3]].map(thousandths))
            .collect(),
        obstacles: obstacles(prepared, driven),
        paths: result
            .plans
            .iter()
            .filter(|plan| plan.status == PathStatus::Found.label())
            .map(|plan| RecordedPath {
                time_s: plan.time_s,
                cause: plan.cause.clone(),
                length_m: plan.length_m,
                points_m: plan.points_m.iter().map(|at| at.map(thousandths)).collect(),
            })
            .collect(),
    }
}

fn obstacles(prepared: &Prepared, driven: &Driven) -> Vec<RecordedObstacle> {
    let seen = &driven.collector.seen.motion.obstacles;
    let recorded = |(index, poses): (&usize, &Vec<(u64, Pose)>)| {
        let obstacle = prepared.world.obstacles().get(*index)?;
        let own_frame = obstacle.shape.placed_at(&Pose::default());
        let poses = poses
            .iter()
            .filter(|(run_ns, _)| *run_ns <= driven.end_run_ns);
        let row = |(run_ns, pose): &(u64, Pose)| {
            let since_goal_ns = run_ns.saturating_sub(driven.goals_run_ns);
            let time_s = seconds(since_goal_ns);
            [time_s, pose.x_m, pose.y_m, pose.yaw_rad].map(thousandths)
        };
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
