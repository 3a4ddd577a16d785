//! Detours: ready before the path is cut, legal whatever closed, and followed by the best path.

use crate::fast_planners::{RULES, build, drawn_by, edit, plan, query, whole};
use crate::support::cycle::Bench;
use crate::support::{Map, Rng, of_cost};
use zeronav_global_planner::{CellPath, Control, CornerRule, News, PlanQuery};
use zeronav_msgs::map::COST_LETHAL;
use zeronav_msgs::path::{PathCause, PathStatus};
use zeronav_msgs::{Cell, CellRect, MapView};
use zeronav_observe::statistics::percentile;

/// The map's own word on a path, step by step.
fn assert_legal(what: &str, query: &PlanQuery<'_>, cells: &[Cell]) {
    let blocked = |cell: Cell| {
        let cell = query.map.get(cell);
        cell.is_none_or(|cell| query.unknown.blocks(cell))
    };
    let cell_of = |map: &MapView<'_>, pose: &zeronav_msgs::Pose| map.geometry.cell_at(pose.point());
    assert_eq!(
        cells.first().copied(),
        cell_of(&query.map, &query.start),
        "{what}"
    );
    assert_eq!(
        cells.last().copied(),
        cell_of(&query.map, &query.goal),
        "{what}"
    );
    for pair in cells.windows(2) {
        let (from, to) = (pair[0], pair[1]);
        assert_eq!(
            (to.x - from.x).abs().max((to.y - from.y).abs()),
            1,
            "{what}"
        );
        assert!(!blocked(to), "{what}: {to:?}");
        let beside = [Cell::new(to.x, from.y), Cell::new(from.x, to.y)];
        let legal = from.x == to.x
            || from.y == to.y
            || query
                .corner_rule
                .permits(blocked(beside[0]), blocked(beside[1]));
        assert!(legal, "{what}: {from:?} to {to:?}");
    }
}

/// How detours compare with the best path.
#[derive(Debug, Default)]
struct Tally {
    cut: usize,
    /// Of the region, without an expansion.
    ready: usize,
    /// By a search of bounded effort.
    searched: usize,
    ratios: Vec<f64>,
}

/// Edits `map` again and again. Where there is a detour it is legal, costs no less than the best path
/// and says so.
fn compare(seed: u64, mut map: Map, n_edits: u64, side: i32, tally: &mut Tally) {
    let mut rng = Rng(seed);
    let rule = RULES[usize::try_from(seed % 3).unwrap()];
    let (w, h) = map.geometry.size();
    let mut planner = build("mpgaa", 3.0);
    planner.map_changed(&map.view(), &[whole(&map)]);
    let goal = map.free_near(Cell::new(rng.below(w), rng.below(h)));
    let mut robot = goal;
    let (mut path, mut spare) = (CellPath::default(), CellPath::default());
    for n in 0..n_edits {
        if robot == goal {
            robot = map.free_near(Cell::new(rng.below(w), rng.below(h)));
        }
        let before = query(&map, robot, goal, rule);
        let had = plan(planner.as_mut(), &before, &mut path).is_ok();
        // Now and then the work ahead is not done, or rests on an older map.
        let is_fresh = had && rng.below(4) > 0;
        if is_fresh {
            for _ in 0..5 {
                planner.map_changed(&map.view(), &[]);
            }
        }
        if is_fresh || rng.below(2) > 0 {
            while planner.prepare(&before.start, 1000) {}
        }
        let next = path.cells.get(usize::try_from(rng.below(6)).unwrap());
        let rect = edit(&mut map, &mut rng, side);
        planner.map_changed(&map.view(), &[rect]);
        if let Some(next) = next.filter(|_| had) {
            robot = *next;
        }
        let query = query(&map, robot, goal, rule);
        let what = format!("seed {seed}, edit {n}, {robot:?} to {goal:?}, {rule:?}");
        let detour = planner.detour(&query, &mut |_| Control::Go, &mut path);
        let best = plan(build("c_astar", 3.0).as_mut(), &query, &mut spare);
        tally.cut += usize::from(is_fresh && best.is_ok());
        let Some(detour) = detour else {
            continue;
        };
        assert_legal(&what, &query, &path.cells);
        let best = best.unwrap_or_else(|error| panic!("{what}: a detour, but {error}"));
        let bend = 1e-3 * best.cost + 1e-9;
        assert!(
            detour.cost >= best.cost - bend,
            "{what}: {detour:?}, {best:?}"
        );
        assert!(
            detour.bound <= best.cost + bend,
            "{what}: {detour:?}, {best:?}"
        );
        assert!(detour.bound <= detour.cost, "{what}: {detour:?}");
        if is_fresh {
            let is_ready = path.stats.expanded == 0;
            tally.ready += usize::from(is_ready);
            tally.searched += usize::from(!is_ready);
            tally.ratios.push(detour.cost / best.cost);
        }
    }
}

#[test]
fn a_detour_is_legal_and_no_better_than_the_best_path() {
    let mut tally = Tally::default();
    for seed in 0..60 {
        compare(seed, drawn_by(seed, 40, 30, 25, 50), 60, 5, &mut tally);
    }
    for seed in 100..106 {
        compare(seed, Map::office(240, 160, seed), 30, 12, &mut tally);
    }
    let [median, p95] =
        [0.5, 0.95].map(|share| percentile(&mut tally.ratios, share).expect("ratios"));
    assert!(
        tally.ready * 10 >= tally.cut * 8,
        "{} of {}",
        tally.ready,
        tally.cut
    );
    assert!(tally.searched > 20, "{}", tally.searched);
    let some = tally.ready + tally.searched;
    assert!(some * 100 >= tally.cut * 95, "{some} of {}", tally.cut);
    assert!((0.999..1.001).contains(&median), "{median}");
    assert!((0.999..1.1).contains(&p95), "{p95}");
}

/// A map of two aisles: the way leads through the lower one.
fn two_aisles() -> Bench {
    let shelf = format!("....{}....", "#".repeat(52));
    let aisle = ".".repeat(60);
    let mut rows = vec![aisle.clone(); 3];
    rows.extend(vec![shelf; 6]);
    rows.extend(vec![aisle.clone(); 2]);
    rows.push(format!("S{}G", ".".repeat(58)));
    Bench::new(&rows.join("\n")).0
}

#[test]
fn a_closed_aisle_turns_the_robot_once() {
    for column in [12, 28, 29, 30, 31, 44] {
        let mut bench = two_aisles();
        bench.expect_new(PathCause::Goal, PathStatus::Found);
        while bench.replanner.prepare(1 << 20) {}
        let load: Vec<Cell> = (0..3).map(|y| Cell::new(column, y)).collect();
        bench.update(&load, COST_LETHAL);
        bench.expect_new(PathCause::Obstacle, PathStatus::Found);
        let plan = bench.replanner.plan();
        assert!(plan.is_detour, "{column}: no search was needed");
        assert_eq!(plan.cells.stats.expanded, 0);
        assert!(bench.path().iter().any(|cell| cell.y >= 9), "{column}");
        // The search that follows finds nothing better, and is made once.
        assert_eq!(bench.cycle(), (vec![PathCause::Improved], News::Unchanged));
        assert!(!bench.replanner.plan().is_detour);
        bench.expect_unchanged();
    }
}

#[test]
fn only_a_path_that_is_cut_is_replaced_by_a_detour() {
    let mut bench = two_aisles();
    bench.expect_new(PathCause::Goal, PathStatus::Found);
    while bench.replanner.prepare(1 << 20) {}
    let load: Vec<Cell> = (0..3).map(|y| Cell::new(30, y)).collect();
    bench.update(&load, COST_LETHAL);
    bench.target =
        (bench.target).map(|target| zeronav_global_planner::Target { task: 8, ..target });
    bench.expect_new(PathCause::Goal, PathStatus::Found);
    assert!(!bench.replanner.plan().is_detour);
}

/// Blocks before a robot in an office, until a detour is so dear that the path found after it counts.
#[test]
fn a_path_better_than_the_detour_follows_it() {
    for seed in 0..200 {
        let mut map = Map::office(240, 160, seed % 5);
        let mut rng = Rng(seed);
        let (mut bench, _) = Bench::new("S.G");
        let (start, goal) = (
            map.free_near(Cell::new(rng.below(80), rng.below(160))),
            map.free_near(Cell::new(160 + rng.below(80), rng.below(160))),
        );
        bench.robot = map.pose(start);
        bench.target = bench.target.map(|target| zeronav_global_planner::Target {
            pose: map.pose(goal),
            ..target
        });
        core::mem::swap(&mut bench.map, &mut map);
        bench.changed = vec![whole(&bench.map)];
        if bench.cycle().1 != News::New || bench.replanner.plan().status != PathStatus::Found {
            continue;
        }
        while bench.replanner.prepare(1 << 20) {}
        let Some(at) = bench.path().get(20).copied() else {
            continue;
        };
        let side = 4 + rng.below(20);
        let (min, max) = (
            Cell::new(at.x - side / 2, at.y - side / 2),
            Cell::new(at.x + side / 2 + 1, at.y + side / 2 + 1),
        );
        bench.revision += 1;
        bench.changed = vec![CellRect { min, max }];
        for y in min.y..max.y {
            for x in min.x..max.x {
                if Cell::new(x, y) != start {
                    bench.map.put(Cell::new(x, y), of_cost(COST_LETHAL));
                }
            }
        }
        let (causes, news) = bench.cycle();
        if news != News::New || !bench.replanner.plan().is_detour {
            continue;
        }
        assert_eq!(causes, [PathCause::Obstacle]);
        let detour_m = bench.replanner.plan().cells.stats.cost;
        let (causes, news) = bench.cycle();
        assert_eq!(causes, [PathCause::Improved]);
        if news == News::New {
            let plan = bench.replanner.plan();
            assert_eq!((plan.cause, plan.is_detour), (PathCause::Improved, false));
            assert!(plan.cells.stats.cost < 0.951 * detour_m, "seed {seed}");
            return;
        }
    }
    panic!("no detour was dear enough");
}

/// What closes while a region is found counts: work ahead in slices, edits between them.
#[test]
fn a_region_takes_in_what_changes_while_it_is_found() {
    let mut n_ready = 0;
    for seed in 0..40 {
        let mut map = Map::office(240, 160, seed % 4);
        let mut rng = Rng(seed);
        let mut planner = build("mpgaa", 3.0);
        planner.map_changed(&map.view(), &[whole(&map)]);
        let (start, goal) = (
            map.free_near(Cell::new(20, rng.below(160))),
            map.free_near(Cell::new(220, rng.below(160))),
        );
        let mut path = CellPath::default();
        let rule = CornerRule::ForbidAny;
        let first = query(&map, start, goal, rule);
        if plan(planner.as_mut(), &first, &mut path).is_err() {
            continue;
        }
        let robot = first.start;
        for n in 0..400 {
            let is_idle = !planner.prepare(&robot, u64::from(rng.below(4000).unsigned_abs()));
            if rng.below(20) == 0 {
                let rect = edit(&mut map, &mut rng, 6);
                map.put(start, of_cost(0));
                map.put(goal, of_cost(0));
                let ends = [start, goal].map(|cell| CellRect {
                    min: cell,
                    max: Cell::new(cell.x + 1, cell.y + 1),
                });
                planner.map_changed(&map.view(), &[rect, ends[0], ends[1]]);
            }
            let query = query(&map, start, goal, rule);
            // A search takes the place of the one that finds the region: now and then is enough.
            if !is_idle && n % 100 != 0 {
                continue;
            }
            let go = &mut |_| Control::Go;
            if planner.detour(&query, go, &mut path).is_some() {
                assert_legal(&format!("seed {seed}"), &query, &path.cells);
                n_ready += u32::from(path.stats.expanded == 0);
            }
        }
    }
    assert!(n_ready > 100, "{n_ready}");
}

/// A planner that is never told of changes reads the map of each query: what it prepared on another
/// map is not believed.
#[test]
fn without_word_of_changes_there_is_no_detour() {
    let mut map = Map::office(240, 160, 3);
    let mut planner = build("mpgaa", 3.0);
    let (start, goal) = (
        map.free_near(Cell::new(20, 80)),
        map.free_near(Cell::new(220, 80)),
    );
    let mut path = CellPath::default();
    let before = query(&map, start, goal, CornerRule::ForbidAny);
    plan(planner.as_mut(), &before, &mut path).unwrap();
    while planner.prepare(&before.start, 10_000) {}
    let middle = path.cells[path.cells.len() / 2];
    map.put(middle, of_cost(COST_LETHAL));
    let after = query(&map, start, goal, CornerRule::ForbidAny);
    let go = &mut |_| Control::Go;
    assert_eq!(planner.detour(&after, go, &mut path), None);
}
