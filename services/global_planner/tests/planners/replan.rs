//! The rules of replanning one by one: when to search.

use crate::support::cycle::{Bench, ROOM};
use zeronav_global_planner::{
    GlobalPlannerConfig, News, Replanner, Request, Situation, Step, Target,
};
use zeronav_msgs::map::{
    COST_INSCRIBED, COST_LETHAL, COST_UNKNOWN, FLAG_SENSED, FLAG_STATIC, ObstacleSource,
};
use zeronav_msgs::path::{Path, PathBlock, PathCause, PathStatus};
use zeronav_msgs::request::RequestReason;
use zeronav_msgs::{Cell, CellRect, MapCell, Pose};

const fn cell(cost: u8, flags: u8, clearance_mm: u16) -> MapCell {
    MapCell {
        cost,
        flags,
        clearance_mm,
    }
}

#[test]
fn rule_1_without_a_goal_or_a_map_there_is_no_path() {
    let (mut bench, _) = Bench::new(ROOM);
    let target = bench.target.take();
    bench.expect_unchanged();
    assert_eq!(bench.replanner.plan().status, PathStatus::NoGoal);
    bench.target = target;
    bench.expect_new(PathCause::Goal, PathStatus::Found);
    bench.target = None;
    assert_eq!(bench.cycle(), (vec![], News::New));
    assert_eq!(bench.replanner.plan().status, PathStatus::NoGoal);
    bench.expect_unchanged();
    let without_map = Situation {
        map: None,
        target,
        ..bench.situation()
    };
    let step = Replanner::new(&GlobalPlannerConfig::default())
        .unwrap()
        .begin(&without_map);
    assert_eq!(step, Step::Publish(News::Unchanged));
}

#[test]
fn rule_2_goals_and_tasks_are_told_apart() {
    let (mut bench, at) = Bench::new(ROOM);
    bench.expect_new(PathCause::Goal, PathStatus::Found);
    bench.expect_unchanged();
    let first = bench.target.unwrap();
    bench.target = Some(Target {
        goal: 2,
        pose: bench.map.pose(at('S')),
        ..first
    });
    bench.expect_new(PathCause::NextGoal, PathStatus::Found);
    bench.target = Some(Target { task: 8, ..first });
    bench.expect_new(PathCause::Goal, PathStatus::Found);
    bench.target = Some(Target {
        task: 8,
        pose: bench.map.pose(Cell::new(3, 3)),
        ..first
    });
    bench.expect_new(PathCause::Goal, PathStatus::Found);
    bench.expect_unchanged();
}

#[test]
fn rule_3_a_proof_is_doubted_only_when_a_cell_opened() {
    let (mut bench, _) = Bench::new("S.#..\n..#..\n..#.G");
    bench.expect_new(PathCause::Goal, PathStatus::Unreachable);
    bench.expect_unchanged();
    // A change that closes more, and one that only makes cells cheaper.
    bench.update(&[Cell::new(3, 1)], COST_LETHAL);
    bench.expect_unchanged();
    bench.update(&[Cell::new(0, 1)], 100);
    bench.expect_unchanged();
    bench.update(&[Cell::new(0, 1)], 0);
    bench.expect_unchanged();
    bench.update(&[Cell::new(2, 0)], 0);
    bench.expect_new(PathCause::Goal, PathStatus::Found);
}

#[test]
fn rule_3_what_opened_during_a_search_is_not_forgotten() {
    let (mut bench, _) = Bench::new("S.#..\n..#..\n..#.G");
    let (causes, news) = bench.cycle_with(|bench| bench.update(&[Cell::new(2, 0)], 0));
    assert_eq!((causes, news), (vec![PathCause::Goal], News::New));
    assert_eq!(bench.replanner.plan().status, PathStatus::Unreachable);
    // The next update opens nothing, the one before did.
    bench.update(&[Cell::new(3, 1)], COST_LETHAL);
    bench.expect_new(PathCause::Goal, PathStatus::Found);
}

#[test]
fn rule_3_a_proof_is_doubted_by_a_robot_that_stands_elsewhere() {
    let (mut bench, _) = Bench::new("S...............#..G");
    bench.expect_new(PathCause::Goal, PathStatus::Unreachable);
    bench.robot = bench.map.pose(Cell::new(8, 0));
    bench.expect_unchanged();
    bench.robot = bench.map.pose(Cell::new(12, 0));
    bench.expect_new(PathCause::Goal, PathStatus::Unreachable);
    bench.expect_unchanged();
}

#[test]
fn rule_3_the_cause_survives_a_failure() {
    let (mut bench, _) = Bench::new("S....G");
    bench.expect_new(PathCause::Goal, PathStatus::Found);
    bench.update(&[Cell::new(3, 0)], COST_LETHAL);
    bench.expect_new(PathCause::Obstacle, PathStatus::Unreachable);
    assert!(bench.replanner.plan().waypoints.is_empty());
    bench.update(&[Cell::new(3, 0)], 0);
    bench.expect_new(PathCause::Obstacle, PathStatus::Found);
}

/// A lidar that closes the only way from afar proves nothing: the robot drives there and looks.
#[test]
fn rule_3_what_was_seen_from_afar_counts_when_it_was_seen_from_near() {
    for closed in [Cell::new(15, 0), Cell::new(19, 0)] {
        let (mut bench, at) = Bench::new("S..................G");
        let config = GlobalPlannerConfig {
            look_from_m: 0.3,
            ..GlobalPlannerConfig::default()
        };
        bench.replanner = Replanner::new(&config).unwrap();
        let shut = if closed == at('G') {
            PathStatus::GoalBlocked
        } else {
            PathStatus::Unreachable
        };
        let put = |bench: &mut Bench, flags| {
            bench.update(&[closed], COST_LETHAL);
            bench.map.put(closed, cell(COST_LETHAL, flags, 0));
        };
        let block = |bench: &Bench| {
            let mut message = Path::default();
            bench.replanner.plan().fill(&mut message);
            let [x_m, y_m] = message.block_m;
            let cell = bench.map.geometry.cell_at(nalgebra::Point2::new(x_m, y_m));
            (message.block().unwrap(), cell.unwrap())
        };
        bench.expect_new(PathCause::Goal, PathStatus::Found);
        put(&mut bench, FLAG_SENSED);
        bench.expect_new(PathCause::Obstacle, PathStatus::Found);
        let before = Cell::new(closed.x - 1, 0);
        assert_eq!(bench.path().last(), Some(&before));
        assert_eq!(block(&bench), (PathBlock::Closed, closed));
        bench.expect_unchanged();
        // Still far; nor does a cell that opens elsewhere hurry.
        bench.robot = bench.map.pose(Cell::new(closed.x - 8, 0));
        bench.expect_unchanged();
        bench.update(&[Cell::new(2, 0)], COST_LETHAL);
        bench.expect_unchanged();
        bench.update(&[Cell::new(2, 0)], 0);
        bench.expect_unchanged();
        for _ in 3..config.shortcut_every_revisions {
            bench.update(&[], 0);
            bench.expect_unchanged();
        }
        bench.update(&[], 0);
        let again = (vec![PathCause::Obstacle], News::Unchanged);
        assert_eq!(bench.cycle(), again);
        // The local planner asks for another path.
        bench.request = Some(Request {
            id: 1,
            geometry: bench.replanner.plan().geometry,
            reason: RequestReason::Blocked,
        });
        bench.update(&[], 0);
        let asked = (vec![PathCause::Request], News::Unchanged);
        assert_eq!(bench.cycle(), asked);
        assert_eq!(block(&bench), (PathBlock::Closed, closed));
        // Near, and sure.
        bench.robot = bench.map.pose(Cell::new(closed.x - 5, 0));
        bench.expect_new(PathCause::Obstacle, shut);
        assert_eq!(block(&bench).1, closed);
        bench.expect_unchanged();
        bench.update(&[closed], 0);
        bench.expect_new(PathCause::Obstacle, PathStatus::Found);
        assert_eq!(bench.path().last(), Some(&at('G')));
        // The static map is sure from afar, and so is a track.
        bench.robot = bench.map.pose(at('S'));
        bench.target = bench.target.map(|target| Target { task: 8, ..target });
        for flags in [FLAG_STATIC, 0] {
            bench.update(&[closed], 0);
            let _ = bench.cycle();
            assert_eq!(bench.replanner.plan().status, PathStatus::Found);
            put(&mut bench, flags);
            bench.expect_new(PathCause::Obstacle, shut);
        }
    }
}

/// A path over what nobody has seen was a guess: a wall there is no door that may be open.
#[test]
fn rule_3_a_guess_that_was_wrong_is_not_looked_at() {
    let (mut bench, _) = Bench::new("S..................G");
    let config = GlobalPlannerConfig {
        look_from_m: 0.3,
        ..GlobalPlannerConfig::default()
    };
    bench.replanner = Replanner::new(&config).unwrap();
    bench.update(&[Cell::new(17, 0)], COST_UNKNOWN);
    bench.expect_new(PathCause::Goal, PathStatus::Found);
    bench.update(&[Cell::new(15, 0)], COST_LETHAL);
    bench
        .map
        .put(Cell::new(15, 0), cell(COST_LETHAL, FLAG_SENSED, 0));
    bench.expect_new(PathCause::Obstacle, PathStatus::Unreachable);
}

/// The update that closes the way comes during the search.
#[test]
fn rule_3_a_path_that_is_cut_before_it_is_told_is_looked_at_too() {
    let (mut bench, _) = Bench::new("S..................G");
    let config = GlobalPlannerConfig {
        look_from_m: 0.3,
        ..GlobalPlannerConfig::default()
    };
    bench.replanner = Replanner::new(&config).unwrap();
    let closed = Cell::new(15, 0);
    let (causes, _) = bench.cycle_with(|bench| {
        bench.update(&[closed], COST_LETHAL);
        bench.map.put(closed, cell(COST_LETHAL, FLAG_SENSED, 0));
    });
    assert_eq!(causes, [PathCause::Goal; 2]);
    assert_eq!(bench.replanner.plan().status, PathStatus::Found);
    assert_eq!(bench.path().last(), Some(&Cell::new(14, 0)));
}

#[test]
fn rule_3_blocked_ends_wait_for_what_can_help() {
    let (mut bench, at) = Bench::new("S....G");
    bench.update(&[at('G')], COST_LETHAL);
    bench.expect_new(PathCause::Goal, PathStatus::GoalBlocked);
    bench.expect_unchanged();
    bench.update(&[at('G')], 0);
    bench.expect_new(PathCause::Goal, PathStatus::Found);
    bench.update(&[Cell::new(0, 0)], COST_LETHAL);
    bench.expect_new(PathCause::Obstacle, PathStatus::StartBlocked);
    bench.expect_unchanged();
    bench.robot = bench.map.pose(Cell::new(1, 0));
    bench.expect_new(PathCause::Obstacle, PathStatus::Found);
    let home = bench.robot;
    bench.robot = Pose::new(-100.0, 0.0, 0.0);
    bench.expect_new(PathCause::Request, PathStatus::StartOutsideMap);
    bench.robot = home;
    bench.expect_new(PathCause::Request, PathStatus::Found);
    bench.target = bench.target.map(|target| Target {
        pose: Pose::new(90.0, 0.0, 0.0),
        ..target
    });
    bench.expect_new(PathCause::Goal, PathStatus::GoalOutsideMap);
    bench.update(&[at('G')], 50);
    bench.expect_unchanged();
}

#[test]
fn rule_3_a_blocked_robot_that_stands_still_is_freed_by_what_changes() {
    let (mut bench, at) = Bench::new("S....G");
    bench.update(&[at('S')], COST_LETHAL);
    bench.expect_new(PathCause::Goal, PathStatus::StartBlocked);
    bench.expect_unchanged();
    // Whatever changes: what becomes dearer, too.
    bench.update(&[Cell::new(3, 0)], 100);
    bench.expect_new(PathCause::Goal, PathStatus::StartBlocked);
    bench.update(&[at('S')], 0);
    bench.expect_new(PathCause::Goal, PathStatus::Found);
    // What changed during a search is not forgotten when the next update changes nothing.
    bench.update(&[at('S')], COST_LETHAL);
    let (causes, _) = bench.cycle_with(|bench| bench.update(&[at('S')], 0));
    assert_eq!(causes, [PathCause::Obstacle]);
    assert_eq!(bench.replanner.plan().status, PathStatus::StartBlocked);
    bench.update(&[], 0);
    bench.expect_new(PathCause::Obstacle, PathStatus::Found);
}

#[test]
fn rule_4_only_what_is_ahead_on_the_path_counts() {
    let (mut bench, at) = Bench::new(ROOM);
    bench.expect_new(PathCause::Goal, PathStatus::Found);
    let middle = bench.path()[4];
    let beside = Cell::new(0, 0);
    assert!(!bench.path().contains(&beside));
    bench.update(&[beside], COST_LETHAL);
    bench.expect_unchanged();
    // Behind the robot.
    let passed = bench.path()[1];
    bench.robot = bench.map.pose(bench.path()[3]);
    bench.update(&[passed], COST_LETHAL);
    bench.expect_unchanged();
    bench.update(&[middle], COST_LETHAL);
    bench.expect_new(PathCause::Obstacle, PathStatus::Found);
    assert!(!bench.path().contains(&middle));
    assert_eq!(bench.path().last(), Some(&at('G')));
    assert_eq!(bench.replanner.plan().searched_map, bench.revision);
    // The message names what cut it, until another cause counts.
    let mut message = Path::default();
    bench.replanner.plan().fill(&mut message);
    assert_eq!(message.block(), Some(PathBlock::PathBefore));
    let centre = bench.map.pose(middle);
    assert!(
        (message.block_m[0] - centre.x_m).abs() < 1e-9,
        "{message:?}"
    );
    assert!(
        (message.block_m[1] - centre.y_m).abs() < 1e-9,
        "{message:?}"
    );
    bench.target = bench.target.map(|target| Target { task: 8, ..target });
    bench.expect_new(PathCause::Goal, PathStatus::Found);
    bench.replanner.plan().fill(&mut message);
    assert_eq!(message.block(), Some(PathBlock::None));
}

#[test]
fn rule_4_a_corner_that_the_robot_has_passed_does_not_count() {
    let (mut bench, _) = Bench::new("S...\n....\n....\n...G");
    bench.expect_new(PathCause::Goal, PathStatus::Found);
    assert_eq!(bench.path()[..2], [Cell::new(0, 3), Cell::new(1, 2)]);
    bench.robot = bench.map.pose(bench.path()[1]);
    bench.expect_unchanged();
    bench.update(&[Cell::new(0, 2)], COST_LETHAL);
    bench.expect_unchanged();
    bench.update(&[Cell::new(2, 2)], COST_LETHAL);
    bench.expect_new(PathCause::Obstacle, PathStatus::Found);
}

#[test]
fn a_proof_that_no_way_is_left_names_where_the_last_one_was_cut() {
    let (mut bench, _) = Bench::new("S..G");
    bench.expect_new(PathCause::Goal, PathStatus::Found);
    let cut = Cell::new(2, 0);
    bench.update(&[cut], COST_LETHAL);
    bench.expect_new(PathCause::Obstacle, PathStatus::Unreachable);
    let mut message = Path::default();
    bench.replanner.plan().fill(&mut message);
    assert_eq!(message.block(), Some(PathBlock::PathBefore));
    assert!(
        (message.block_m[0] - bench.map.pose(cut).x_m).abs() < 1e-9,
        "{message:?}"
    );
}

#[test]
fn a_proof_without_a_path_before_names_what_would_have_to_open_and_where_it_comes_from() {
    // Two gaps of the wall: one that a box closes, one that is only too narrow for the robot.
    let (mut bench, at) = Bench::new(
        "S....#.....
         .....a.....
         .....b.....
         .....B.....
         .....b.....
         .....a....G
         .....#.....
         .....N.....
         .....#.....",
    );
    let wall = cell(COST_LETHAL, FLAG_STATIC, 0);
    for row in [0, 2, 8] {
        bench.map.put(Cell::new(5, row), wall);
    }
    // Beside the wall, and beside the box alone.
    for row in [3, 4, 6, 7] {
        bench
            .map
            .put(Cell::new(5, row), cell(COST_INSCRIBED, 0, 25));
    }
    bench.map.put(at('N'), cell(COST_INSCRIBED, 0, 25));
    let told = |bench: &mut Bench, in_gap: MapCell| {
        bench.map.put(at('B'), in_gap);
        bench.revision += 1;
        let task = bench.target.map_or(0, |target| target.task + 1);
        bench.target = bench.target.map(|target| Target { task, ..target });
        bench.expect_new(PathCause::Goal, PathStatus::Unreachable);
        let mut message = Path::default();
        bench.replanner.plan().fill(&mut message);
        assert_eq!(message.block(), Some(PathBlock::Closed), "{message:?}");
        let [x_m, y_m] = message.block_m;
        let at = bench.map.geometry.cell_at(nalgebra::Point2::new(x_m, y_m));
        (at.unwrap(), message.source().unwrap())
    };
    bench.changed = vec![CellRect {
        min: Cell::new(0, 0),
        max: Cell::new(11, 9),
    }];
    // What may go is told before what the static map closes by itself.
    let seen = cell(COST_LETHAL, FLAG_SENSED, 0);
    let (at_m, source) = told(&mut bench, seen);
    assert_eq!((at_m.x, source), (5, ObstacleSource::Lidar));
    assert!((at_m.y - at('B').y).abs() == 1, "{at_m:?}");
    // Stamped on the copy.
    let (_, source) = told(&mut bench, cell(COST_LETHAL, 0, 0));
    assert_eq!(source, ObstacleSource::Tracked);
    // The static map closes both: what is only too narrow is told before a wall.
    for row in [3, 4, 6, 7] {
        bench.map.put(Cell::new(5, row), wall);
    }
    let found = told(&mut bench, wall);
    assert_eq!(found, (at('N'), ObstacleSource::StaticMap));
}

#[test]
fn rule_4_another_grid_makes_another_path() {
    let (mut bench, _) = Bench::new(ROOM);
    let pose = bench.map.pose(Cell::new(5, 0));
    bench.target = bench.target.map(|target| Target { pose, ..target });
    bench.expect_new(PathCause::Goal, PathStatus::Found);
    bench.map.geometry.origin_x_m -= 0.05;
    bench.revision += 1;
    bench.expect_new(PathCause::Obstacle, PathStatus::Found);
}

#[test]
fn rule_5_a_robot_far_off_gets_another_path() {
    let (mut bench, _) = Bench::new(&format!("S{0}\n{0}G", ".".repeat(79)));
    bench.expect_new(PathCause::Goal, PathStatus::Found);
    bench.robot.y_m -= 1.0;
    bench.expect_unchanged();
    bench.robot.y_m -= 1.0;
    bench.expect_new(PathCause::Request, PathStatus::StartOutsideMap);
}

#[test]
fn rule_6_a_request_is_answered_once_and_only_about_this_path() {
    let (mut bench, _) = Bench::new(ROOM);
    bench.expect_new(PathCause::Goal, PathStatus::Found);
    let geometry = bench.replanner.plan().geometry;
    let ask = |id, geometry, reason| {
        Some(Request {
            id,
            geometry,
            reason,
        })
    };
    bench.request = ask(1, geometry, RequestReason::Blocked);
    // The same map and the same robot give the same path.
    bench.expect_unchanged();
    bench.update(&[], 0);
    bench.expect_new(PathCause::Request, PathStatus::Found);
    bench.update(&[], 0);
    bench.expect_unchanged();
    bench.request = ask(2, geometry, RequestReason::NoProgress);
    bench.expect_unchanged();
    let geometry = bench.replanner.plan().geometry;
    bench.request = ask(3, geometry, RequestReason::None);
    bench.expect_unchanged();
    bench.request = ask(4, geometry, RequestReason::NoProgress);
    bench.expect_new(PathCause::Request, PathStatus::Found);
    // A robot elsewhere is news, too, and ids start again with another local planner.
    let geometry = bench.replanner.plan().geometry;
    bench.robot = bench.map.pose(bench.path()[1]);
    bench.request = ask(2, geometry, RequestReason::Blocked);
    bench.expect_new(PathCause::Request, PathStatus::Found);
}
