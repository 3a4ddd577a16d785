use super::*;
use zeronav_msgs::map::{MapInfo, MapTile, tiles_of};
use zeronav_msgs::path::PathCause;
use zeronav_msgs::truth::Truth;
use zeronav_world::spec::Trigger;
use zeronav_world::{ObstacleSpec, ShapeSpec, WorldSpec};

const PERIOD_NS: u64 = 100_000_000;

fn world() -> World {
    let shape = ShapeSpec::Box {
        centre_m: [1.0, 1.0],
        size_m: [0.5, 1.0],
        yaw_rad: 0.25,
    };
    let mut spec = WorldSpec::area([0.0, 0.0], [20.0, 4.0]);
    spec.resolution_m = 0.1;
    spec.obstacles.push(ObstacleSpec {
        appears: Some(Trigger {
            at_s: Some(1.0e6),
            robot_near: None,
        }),
        ..ObstacleSpec::standing("load", shape)
    });
    World::new(&spec, None).expect("a world")
}

fn spec() -> TrialsSpec {
    let goal = |x_m| GoalSpec {
        pose: Pose::new(x_m, 2.0, 0.0),
        tolerance_m: 0.5,
        yaw_tolerance_rad: 4.0,
    };
    TrialsSpec {
        obstacle: "load".to_owned(),
        goals: [goal(19.0), goal(1.0)],
        line_m: [[5.0, 2.0], [15.0, 2.0]],
        ahead_m: 3.0,
    }
}

fn trial_runner<'a>(world: &'a World, spec: &'a TrialsSpec) -> TrialRunner<'a> {
    let course = Course {
        spec,
        world,
        radius_m: 0.3,
        scan_period_ns: PERIOD_NS,
        deadline_ns: 5_000_000_000,
    };
    TrialRunner::new(course, 2, 7).expect("an obstacle of that name")
}

#[test]
fn the_obstacle_is_put_before_the_robot_on_the_line_and_nowhere_else() {
    let (world, spec) = (world(), spec());
    let mut trial_runner = trial_runner(&world, &spec);
    let at = |trial_runner: &TrialRunner<'_>, x_m, y_m| {
        let there = trial_runner.place_ahead(Point2::new(x_m, y_m));
        there.map(|pose| (pose.x_m, pose.y_m, pose.yaw_rad))
    };
    assert_eq!(at(&trial_runner, 6.0, 2.3), Some((9.0, 2.0, 0.25)));
    assert_eq!(at(&trial_runner, 2.0, 2.0), Some((5.0, 2.0, 0.25)));
    assert_eq!(at(&trial_runner, 1.9, 2.0), None, "before the line");
    assert_eq!(at(&trial_runner, 12.1, 2.0), None, "behind the line");
    assert_eq!(at(&trial_runner, 6.0, 2.7), None, "beside the line");
    trial_runner.turn();
    assert_eq!(at(&trial_runner, 14.0, 2.0), Some((11.0, 2.0, 0.25)));
    assert_eq!(at(&trial_runner, 7.9, 2.0), None);
}

/// Every tile of a free map.
fn tiles(info: &MapInfo) -> Vec<MapTile> {
    let (columns, rows) = tiles_of(&info.geometry);
    let all = (0..rows).flat_map(|tile_y| (0..columns).map(move |tile_x| (tile_x, tile_y)));
    all.map(|(tile_x, tile_y)| MapTile {
        tile_x,
        tile_y,
        ..MapTile::default()
    })
    .collect()
}

#[test]
fn a_trial_waits_for_the_path_and_its_phase_is_drawn_from_a_whole_period() {
    let (world, spec) = (world(), spec());
    let mut collector = Collector::default();
    let info = MapInfo {
        geometry: *world.geometry(),
        revision: 1,
        parts: 1,
        ..MapInfo::default()
    };
    collector.truth = Some(Truth {
        pose: Pose::new(6.0, 2.0, 0.0),
        ..Truth::default()
    });
    collector.replica.keyframe(&info, &tiles(&info));
    let path = |y_m| PathRecord {
        id: 5,
        map: 1,
        run_ns: 0,
        status: PathStatus::Found,
        cause: PathCause::Goal,
        planner: "c_astar".to_owned(),
        length_m: 13.0,
        beside_goal_m: 0.0,
        expanded: 1,
        points_m: vec![[6.0, y_m], [19.0, y_m]],
    };
    let run_ns = 1_000_000_000;
    let mut phases = Vec::new();
    for _ in 0..64 {
        let mut trial_runner = trial_runner(&world, &spec);
        trial_runner.random = Pcg64Mcg::seed_from_u64(phases.len() as u64);
        collector.records.paths.clear();
        assert_eq!(
            trial_runner.look(&mut collector, run_ns),
            Step::Wait,
            "no path"
        );
        collector.records.paths.push(path(3.9));
        assert_eq!(
            trial_runner.look(&mut collector, run_ns),
            Step::Wait,
            "a path around it"
        );
        collector.records.paths.push(path(2.0));
        let Step::Place(placement) = trial_runner.look(&mut collector, run_ns) else {
            panic!("nothing was placed");
        };
        assert_eq!(placement.until_run_ns, 0);
        phases.push(placement.from_run_ns - run_ns - LEAD_NS);
        // Nothing is seen of it: after the deadline it is taken away again, and not counted.
        let late_ns = placement.from_run_ns + 5_000_000_001;
        assert!(matches!(
            trial_runner.look(&mut collector, late_ns),
            Step::Place(ended) if ended.until_run_ns == late_ns
        ));
        assert_eq!(
            trial_runner.look(&mut collector, late_ns + SETTLE_NS),
            Step::Wait
        );
        assert_eq!((trial_runner.done(), trial_runner.missed), (0, 1));
    }
    assert!(phases.iter().all(|phase| *phase < PERIOD_NS));
    let (early, late) = (
        phases
            .iter()
            .filter(|phase| **phase < PERIOD_NS / 4)
            .count(),
        phases
            .iter()
            .filter(|phase| **phase >= 3 * PERIOD_NS / 4)
            .count(),
    );
    assert!(early > 4 && late > 4, "{phases:?}");
}
