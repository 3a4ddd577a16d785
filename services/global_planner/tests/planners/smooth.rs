//! Rounded paths: they touch nothing, keep both ends, turn less sharply, and pass no dearer cells.

#![allow(clippy::print_stdout, reason = "the quality is worth a line")]

use crate::support::{Map, Rng};
use nalgebra::Point2;
use zeronav_casts::Cast;
use zeronav_global_planner::{
    Control, CornerRule, GlobalPlannerConfig, Replanner, Situation, Step, Target,
};
use zeronav_msgs::path::PathStatus;
use zeronav_msgs::{Cell, Pose};

struct Made {
    points: Vec<Point2<f64>>,
    cells: Vec<Cell>,
    status: PathStatus,
    cut: bool,
}

fn make(map: &Map, key: &str, rule: CornerRule, smooth_m: f64, robot: Pose, goal: Pose) -> Made {
    let config = GlobalPlannerConfig {
        planner: key.to_owned(),
        corner_rule: rule,
        smooth_m,
        ..GlobalPlannerConfig::default()
    };
    let mut replanner = Replanner::new(&config).unwrap();
    let situation = Situation {
        robot,
        map: Some(map.view()),
        revision: 1,
        changed: &[],
        target: Some(Target {
            task: 1,
            goal: 1,
            pose: goal,
            tolerance_m: 0.1,
        }),
        request: None,
    };
    assert!(matches!(replanner.begin(&situation), Step::Search(_)));
    replanner.search(&situation, &mut |_| Control::Go);
    replanner.settle(&situation);
    let plan = replanner.plan();
    Made {
        points: plan
            .waypoints
            .iter()
            .map(|waypoint| Point2::new(waypoint.x_m, waypoint.y_m))
            .collect(),
        cells: plan.cells.cells.clone(),
        status: plan.status,
        cut: plan.is_cut(&map.view()),
    }
}

/// The cells along the lines between points, looked at every fortieth of a cell. What is seen only
/// once is a corner that is touched.
fn passed(map: &Map, points: &[Point2<f64>]) -> Vec<Cell> {
    let mut cells = Vec::new();
    let mut before = None;
    for pair in points.windows(2) {
        let n = ((pair[1] - pair[0]).norm() / map.geometry.resolution_m * 40.0)
            .ceil()
            .to_u32();
        for k in 0..=n.max(1) {
            let at = pair[0] + (pair[1] - pair[0]) * (f64::from(k) / f64::from(n.max(1)));
            let cell = map.geometry.cell_at(at).expect("on the map");
            if before == Some(cell) && cells.last() != Some(&cell) {
                cells.push(cell);
            }
            before = Some(cell);
        }
    }
    cells
}

/// How much the way bends: squares of the turns, each over half the length of the lines beside it,
/// summed up. [rad^2/m]
fn bending(points: &[Point2<f64>]) -> f64 {
    points
        .windows(3)
        .map(|three| {
            let (one, other) = (three[1] - three[0], three[2] - three[1]);
            let turn = one.perp(&other).atan2(one.dot(&other));
            // A path of long lines bends at its corners, not along them.
            turn * turn / (0.5 * (one.norm() + other.norm())).min(0.05)
        })
        .sum()
}

#[test]
fn rounded_paths_touch_nothing_and_turn_less_sharply() {
    let mut sums = [[0.0; 2]; 4];
    let mut n_paths = 0.0;
    for seed in 0..12 {
        let map = Map::office(300, 200, seed);
        let mut rng = Rng(seed);
        let mut end = |x: i32| map.free_near(Cell::new(x + rng.below(60), rng.below(200)));
        let (robot, mut goal) = (map.pose(end(0)), map.pose(end(240)));
        goal.x_m += 0.012;
        goal.y_m -= 0.017;
        let rule = [
            CornerRule::Allow,
            CornerRule::ForbidAny,
            CornerRule::ForbidBoth,
        ][usize::try_from(seed % 3).unwrap()];
        let mut counted = false;
        for (n, key) in ["mpgaa", "any_angle", "lazy_theta", "c_astar"]
            .iter()
            .enumerate()
        {
            let raw = make(&map, key, rule, 0.0, robot, goal);
            let round = make(&map, key, rule, 0.3, robot, goal);
            assert_eq!(raw.status, round.status, "{key}, seed {seed}");
            if raw.status != PathStatus::Found {
                continue;
            }
            counted = true;
            assert!(
                !round.cut,
                "{key}, seed {seed}: cut by the map it was made on"
            );
            let (Some(first), Some(last)) = (round.points.first(), round.points.last()) else {
                panic!("{key}, seed {seed}: no points");
            };
            assert!((first - raw.points[0]).norm() < 1e-6, "{key}, seed {seed}");
            assert!((last - goal.point()).norm() < 1e-6, "{key}, seed {seed}");
            assert_eq!(round.cells.first(), raw.cells.first());
            assert_eq!(round.cells.last(), raw.cells.last());
            let dearest = |cells: &[Cell]| {
                let costs = cells.iter().map(|cell| map.view().get(*cell).unwrap().cost);
                costs.max().unwrap()
            };
            let cells = passed(&map, &round.points);
            for cell in &cells {
                let free = !map.view().get(*cell).unwrap().blocks_centre();
                assert!(free, "{key}, seed {seed}: passes {cell:?}");
            }
            let raw_cells = passed(&map, &raw.points);
            assert!(
                dearest(&cells) <= dearest(&raw_cells).saturating_add(25),
                "{key}, seed {seed}"
            );
            let [before, after] = [&raw, &round].map(|made| bending(&made.points));
            sums[n][0] += before;
            sums[n][1] += after;
        }
        n_paths += f64::from(u8::from(counted));
    }
    assert!(n_paths > 8.0);
    for (key, [before, after]) in ["mpgaa", "any_angle", "lazy_theta", "c_astar"]
        .iter()
        .zip(sums)
    {
        println!(
            "{key}: bending, mean of {n_paths} paths: {:.1} rad^2/m, rounded {:.1} rad^2/m",
            before / n_paths,
            after / n_paths
        );
        // Ways of Lazy Theta* touch obstacles at their corners: there nothing can be rounded.
        let limit = if *key == "lazy_theta" { 0.8 } else { 0.6 };
        assert!(after < limit * before, "{key}: {after} of {before}");
    }
}

#[test]
fn what_cannot_be_rounded_stays_as_it_is() {
    // A passage of one cell with two right turns: no curve fits.
    let (map, at) = Map::drawn(
        "#########
         #S......#
         #######.#
         #G......#
         #########",
    );
    let ends = (map.pose(at('S')), map.pose(at('G')));
    let raw = make(&map, "mpgaa", CornerRule::ForbidAny, 0.0, ends.0, ends.1);
    let round = make(&map, "mpgaa", CornerRule::ForbidAny, 0.3, ends.0, ends.1);
    assert_eq!(round.status, PathStatus::Found);
    assert!(!round.cut);
    for cell in passed(&map, &round.points) {
        assert!(!map.view().get(cell).unwrap().blocks_centre(), "{cell:?}");
    }
    assert_eq!(raw.cells, round.cells);
    // The cells that are held against later maps are those of the curve.
    let mut open = Map::free(60, 60);
    open.block(Cell::new(20, 0), Cell::new(23, 40));
    let (robot, goal) = (open.pose(Cell::new(5, 5)), open.pose(Cell::new(50, 5)));
    let round = make(&open, "any_angle", CornerRule::ForbidAny, 0.3, robot, goal);
    for cell in passed(&open, &round.points) {
        let beside = |other: &Cell| (other.x - cell.x).abs() <= 1 && (other.y - cell.y).abs() <= 1;
        assert!(round.cells.iter().any(beside), "{cell:?} is not watched");
    }
}
