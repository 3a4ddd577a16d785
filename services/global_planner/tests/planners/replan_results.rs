//! The rules of replanning one by one: shortcuts, and when a result counts.

use crate::support::cycle::{Bench, ROOM};
use crate::support::{Map, of_cost};
use zeronav_global_planner::{
    Control, Expansions, GlobalPlannerConfig, News, Replanner, Request, Situation, Step, Target,
};
use zeronav_msgs::map::{COST_INSCRIBED, COST_LETHAL};
use zeronav_msgs::path::{Path, PathBlock, PathCause, PathStatus};
use zeronav_msgs::request::RequestReason;
use zeronav_msgs::{Cell, CellRect};

#[test]
fn rule_7_a_shortcut_must_be_worth_it_and_is_not_looked_for_too_often() {
    let wall = "S....#....G
                .....#.....
                .....#.....
                .....#.....
                .....#.....
                ...........";
    let (mut bench, _) = Bench::new(wall);
    bench.expect_new(PathCause::Goal, PathStatus::Found);
    let long_m = bench.replanner.plan().length_m;
    let door = Cell::new(5, 5);
    bench.update(&[door], 0);
    for _ in 0..3 {
        bench.expect_unchanged();
        bench.update(&[], 0);
    }
    bench.expect_unchanged();
    bench.update(&[], 0);
    bench.expect_new(PathCause::Shortcut, PathStatus::Found);
    assert!(bench.replanner.plan().length_m < 0.95 * long_m);
    // What eases where no shorter way can lead is not even looked at.
    bench.update(&[Cell::new(5, 1)], 0);
    for _ in 0..8 {
        bench.expect_unchanged();
        bench.update(&[], 0);
    }
}

#[test]
fn rule_10_a_shortcut_that_saves_nothing_changes_nothing() {
    let wall = "S....#....G
                .....#.....
                .....#.....
                .....#.....
                .....#.....
                ...........";
    let (mut bench, _) = Bench::new(wall);
    bench.expect_new(PathCause::Goal, PathStatus::Found);
    let geometry = bench.replanner.plan().geometry;
    // A niche in the wall that leads nowhere.
    bench.update(&[Cell::new(5, 4), Cell::new(6, 4)], 0);
    bench.map.put(Cell::new(6, 4), of_cost(COST_LETHAL));
    for y in 3..6 {
        bench.map.put(Cell::new(6, y), of_cost(COST_LETHAL));
        bench.changed.push(CellRect {
            min: Cell::new(6, y),
            max: Cell::new(7, y + 1),
        });
    }
    let mut searches = Vec::new();
    for _ in 0..12 {
        let (causes, news) = bench.cycle();
        assert_eq!(news, News::Unchanged);
        searches.extend(causes);
        bench.update(&[], 0);
    }
    assert_eq!(searches, [PathCause::Shortcut]);
    assert_eq!(bench.replanner.plan().geometry, geometry);
}

/// A wall with the way round its upper end.
fn with_a_wall() -> Bench {
    let row = |y: i32| match y {
        10 => ".".repeat(41),
        0 => format!("S{}#{}G", ".".repeat(19), ".".repeat(19)),
        _ => format!("{0}#{0}", ".".repeat(20)),
    };
    let drawing: Vec<String> = (0..=10).rev().map(row).collect();
    let (mut bench, _) = Bench::new(&drawing.join("\n"));
    bench.expect_new(PathCause::Goal, PathStatus::Found);
    bench
}

/// The same with a door that opens at `door`. A niche right before the robot opens, too, and promises
/// more than the door holds. The length of the way round, too.
fn with_a_door(door: i32) -> (Bench, f64) {
    let mut bench = with_a_wall();
    let long_m = bench.replanner.plan().length_m;
    bench.update(&[Cell::new(21, 0), Cell::new(21, 1)], COST_LETHAL);
    bench.expect_unchanged();
    bench.update(&[Cell::new(20, 0), Cell::new(20, door)], 0);
    (bench, long_m)
}

/// What comes of the door.
fn door_opens(door: i32) -> (Vec<PathCause>, News, f64) {
    let (mut bench, long_m) = with_a_door(door);
    let mut searches = Vec::new();
    for _ in 0..8 {
        let (causes, news) = bench.cycle();
        searches.extend(causes);
        if news == News::New {
            return (searches, news, bench.replanner.plan().length_m / long_m);
        }
        bench.update(&[], 0);
    }
    (searches, News::Unchanged, 1.0)
}

#[test]
fn rule_10_a_shortcut_must_save_what_it_must() {
    // The way through the lower door saves 7 % of the way round, through the upper one 3 %.
    let (searches, news, share) = door_opens(6);
    assert_eq!((searches, news), (vec![PathCause::Shortcut], News::New));
    assert!((0.9..0.95).contains(&share), "{share}");
    let (searches, news, _) = door_opens(8);
    assert_eq!(
        (searches, news),
        (vec![PathCause::Shortcut], News::Unchanged)
    );
}

#[test]
fn rule_8_what_cannot_save_enough_is_not_looked_for() {
    // The way over the corner of the wall is hardly shorter than the way round it.
    let mut bench = with_a_wall();
    bench.update(&[Cell::new(20, 9)], 0);
    for _ in 0..8 {
        bench.expect_unchanged();
        bench.update(&[], 0);
    }
    // Nor does what becomes dearer.
    bench.update(&[Cell::new(30, 0)], 100);
    for _ in 0..8 {
        bench.expect_unchanged();
        bench.update(&[], 0);
    }
}

#[test]
fn rule_8_what_promised_too_little_counts_when_the_robot_has_come_closer() {
    let (mut bench, _) = Bench::new(
        "S.........#.........G
         ..........#..........
         ..........#..........
         .....................",
    );
    bench.expect_new(PathCause::Goal, PathStatus::Found);
    // Right beside the way: from where the robot is it saves too little.
    bench.update(&[Cell::new(10, 1)], 0);
    for _ in 0..6 {
        bench.expect_unchanged();
        bench.update(&[], 0);
    }
    let (mut n, mut causes) = (1, Vec::new());
    while causes.is_empty() && bench.path()[n].x < 9 {
        bench.robot = bench.map.pose(bench.path()[n]);
        causes = bench.cycle().0;
        n += 1;
    }
    assert_eq!(causes, [PathCause::Shortcut]);
}

/// Cycles until a shortcut is searched for, with `meanwhile` in between.
fn shortcut_with(bench: &mut Bench, meanwhile: impl Fn(&mut Bench)) -> News {
    for _ in 0..8 {
        let mut searched = false;
        let (causes, news) = bench.cycle_with(|bench| {
            searched = true;
            meanwhile(bench);
        });
        if searched {
            assert_eq!(causes, [PathCause::Shortcut]);
            return news;
        }
        bench.update(&[], 0);
    }
    panic!("no shortcut was looked for");
}

#[test]
fn rule_11_a_shortcut_is_no_longer_one_for_a_robot_that_has_gone_on() {
    let (mut bench, _) = with_a_door(6);
    let further = bench.path()[8];
    let news = shortcut_with(&mut bench, |bench| bench.robot = bench.map.pose(further));
    assert_eq!(news, News::Unchanged);
}

#[test]
fn rule_11_a_shortcut_that_saves_little_counts_when_the_old_path_is_cut_by_now() {
    let (mut bench, _) = with_a_door(8);
    let cut = Cell::new(20, 10);
    assert!(bench.path().contains(&cut));
    let news = shortcut_with(&mut bench, |bench| bench.update(&[cut], COST_LETHAL));
    assert_eq!(news, News::New);
    let plan = bench.replanner.plan();
    assert_eq!(plan.cause, PathCause::Obstacle);
    let mut message = Path::default();
    plan.fill(&mut message);
    let centre = bench.map.pose(cut);
    assert_eq!(message.block(), Some(PathBlock::PathBefore));
    let off_m = (message.block_m[0] - centre.x_m).hypot(message.block_m[1] - centre.y_m);
    assert!(off_m < 1e-9, "{:?}", message.block_m);
}

#[test]
fn rule_9_a_result_is_held_against_newer_updates_once() {
    let (mut bench, _) = Bench::new(ROOM);
    // Every search is overtaken by an update that cuts what it found.
    let (causes, news) = bench.cycle_with(|bench| {
        // Walls across the room with a gap on the far side, one after the other.
        let column = i32::try_from(2 * bench.revision).unwrap();
        let gap = if bench.revision == 1 { 0 } else { 4 };
        bench.update(&[], 0);
        for y in (0..5).filter(|y| *y != gap) {
            bench.map.put(Cell::new(column, y), of_cost(COST_LETHAL));
        }
        let (min, max) = (Cell::new(column, 0), Cell::new(column + 1, 5));
        bench.changed.push(CellRect { min, max });
    });
    assert_eq!(causes, [PathCause::Goal, PathCause::Goal]);
    assert_eq!(news, News::New);
    // The next cycle sees that the second result is cut as well.
    bench.expect_new(PathCause::Obstacle, PathStatus::Found);
    bench.expect_unchanged();
}

#[test]
fn rule_9_a_goal_that_changed_meanwhile_is_searched_for() {
    let (mut bench, at) = Bench::new(ROOM);
    let mut searches = 0_i32;
    let (causes, news) = bench.cycle_with(|bench| {
        searches += 1;
        let pose = bench.map.pose(Cell::new(searches, 0));
        bench.target = Some(Target {
            task: 7 + u64::from(searches.unsigned_abs()),
            goal: 1,
            pose,
            tolerance_m: 0.1,
        });
    });
    assert_eq!(causes, [PathCause::Goal, PathCause::Goal]);
    assert_eq!(news, News::New);
    assert_eq!(bench.path().last(), Some(&Cell::new(1, 0)));
    bench.expect_new(PathCause::Goal, PathStatus::Found);
    assert_eq!(bench.path()[0], at('S'));
    // Cancelled while searching.
    bench.target = bench.target.map(|target| Target { task: 99, ..target });
    let (_, news) = bench.cycle_with(|bench| bench.target = None);
    assert_eq!(news, News::New);
    assert_eq!(bench.replanner.plan().status, PathStatus::NoGoal);
}

#[test]
fn rule_6_a_request_that_a_search_has_served_is_not_served_again() {
    let (mut bench, _) = Bench::new(
        "S....#....G
         .....#.....
         .....#.....
         .....#.....
         .....#.....
         ...........",
    );
    bench.expect_new(PathCause::Goal, PathStatus::Found);
    // A niche that leads nowhere is worth a search, and the path stays.
    bench.update(
        &[Cell::new(6, 3), Cell::new(6, 4), Cell::new(6, 5)],
        COST_LETHAL,
    );
    bench.expect_unchanged();
    bench.update(&[Cell::new(5, 4)], 0);
    for _ in 0..3 {
        bench.expect_unchanged();
        bench.update(&[], 0);
    }
    let geometry = bench.replanner.plan().geometry;
    let step = bench.replanner.begin(&Situation {
        robot: bench.robot,
        map: Some(bench.map.view()),
        revision: bench.revision,
        changed: &bench.changed,
        target: bench.target,
        request: None,
    });
    assert_eq!(step, Step::Search(PathCause::Shortcut));
    // The request comes in before the search, which serves it as well.
    bench.request = Some(Request {
        id: 9,
        geometry,
        reason: RequestReason::Blocked,
    });
    let newest = Situation {
        robot: bench.robot,
        map: Some(bench.map.view()),
        revision: bench.revision,
        changed: &[],
        target: bench.target,
        request: bench.request,
    };
    bench.replanner.search(&newest, &mut |_| Control::Go);
    let step = bench.replanner.settle(&newest);
    assert_eq!(step, Step::Publish(News::Unchanged));
    bench.update(&[], 0);
    bench.expect_unchanged();
    // The next one is another matter.
    bench.request = bench.request.map(|request| Request { id: 10, ..request });
    bench.expect_new(PathCause::Request, PathStatus::Found);
}

#[test]
fn the_budget_is_that_of_the_configuration_and_of_the_caller() {
    let map = Map::free(300, 300);
    let config = GlobalPlannerConfig {
        budget_expansions: Some(4000),
        ..GlobalPlannerConfig::default()
    };
    // A bag before the goal, open on the robot's side.
    let mut bag = map.clone();
    bag.block(Cell::new(200, 2), Cell::new(202, 298));
    bag.block(Cell::new(2, 296), Cell::new(202, 298));
    bag.block(Cell::new(4, 2), Cell::new(202, 4));
    for (config, stop) in [(config, false), (GlobalPlannerConfig::default(), true)] {
        let mut replanner = Replanner::new(&config).unwrap();
        let situation = Situation {
            robot: map.pose(Cell::new(60, 150)),
            map: Some(bag.view()),
            revision: 1,
            changed: &[],
            target: Some(Target {
                task: 1,
                goal: 1,
                pose: map.pose(Cell::new(290, 150)),
                tolerance_m: 0.1,
            }),
            request: None,
        };
        assert_eq!(replanner.begin(&situation), Step::Search(PathCause::Goal));
        let mut budget = |_: Expansions| if stop { Control::Stop } else { Control::Go };
        replanner.search(&situation, &mut budget);
        assert_eq!(replanner.settle(&situation), Step::Publish(News::New));
        assert_eq!(replanner.plan().status, PathStatus::OutOfBudget);
        assert!(replanner.plan().cells.stats.expanded < 7000);
    }
}

#[test]
fn corners_of_the_margin_are_passed_where_they_alone_close_the_way() {
    // An aisle askew to the cells: its free cells touch at corners alone.
    let aisle = "S+####
                 +.+###
                 #+.+##
                 ##+.+#
                 ###+.+
                 ####+G";
    let (mut bench, at) = Bench::new(aisle);
    bench.expect_new(PathCause::Goal, PathStatus::Found);
    let first = bench.target.unwrap();
    bench.target = Some(Target { task: 8, ..first });
    bench.expect_new(PathCause::Goal, PathStatus::Found);
    bench.update(&[], 0);
    bench.expect_unchanged();
    // With an obstacle at a corner, and where that is wanted, it is a proof.
    bench.update(&[Cell::new(3, 3)], COST_LETHAL);
    bench.expect_new(PathCause::Obstacle, PathStatus::UnreachableCorner);
    assert!(bench.path().is_empty());
    bench.update(&[Cell::new(3, 3)], COST_INSCRIBED);
    bench.robot = bench.map.pose(at('S'));
    let config = GlobalPlannerConfig {
        past_corners: false,
        ..GlobalPlannerConfig::default()
    };
    bench.replanner = Replanner::new(&config).unwrap();
    bench.expect_new(PathCause::Goal, PathStatus::UnreachableCorner);
}
