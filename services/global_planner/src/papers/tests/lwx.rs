//! LWX-OA, LWX-BI, LWX-ACO, LWX-RRT.

use super::generate::{any, blocky, corners};
use super::{Found, assert_close, assert_legal, plain, plan};
use crate::papers::lwx_bi::middle_of;
use crate::papers::lwx_oa::{ChildCost, DeadEndPolicy};
use crate::support::Map;
use crate::{CornerRule, Fallback, PlanError, PlannerOptions};
use core::f64::consts::SQRT_2;
use zeronav_casts::Cast;
use zeronav_msgs::{Cell, MapCell};

const RULE: CornerRule = CornerRule::ForbidAny;

fn policy(dead_end: DeadEndPolicy) -> PlannerOptions {
    let mut options = plain();
    options.papers.greedy.dead_end = dead_end;
    options
}

#[test]
fn lwx_oa_is_optimal_on_an_empty_map() {
    let map = Map::free(20, 20);
    for to in [(19, 19), (19, 0), (12, 19), (3, 17)] {
        let ends = (Cell::new(0, 0), Cell::new(to.0, to.1));
        let found = plan("lwx_oa", &plain(), &map, RULE, ends).unwrap();
        let best = plan("lwx_ta", &plain(), &map, RULE, ends).unwrap();
        assert_close(found.cost, best.cost, 1e-9, "empty map");
    }
}

#[test]
fn lwx_oa_a_pocket_under_three_policies() {
    let (map, at) = Map::drawn(
        "............
         .########...
         S.......#..G
         .########...
         ............",
    );
    let ends = (at('S'), at('G'));
    let result = plan("lwx_oa", &policy(DeadEndPolicy::Fail), &map, RULE, ends);
    assert_eq!(result.map(|found| found.cost), Err(PlanError::DeadEnd));
    let best = plan("lwx_ta", &plain(), &map, RULE, ends).unwrap();
    let back = plan(
        "lwx_oa",
        &policy(DeadEndPolicy::Backtrack),
        &map,
        RULE,
        ends,
    )
    .unwrap();
    assert!(back.cost >= best.cost - 1e-9);
    assert_eq!(back.stats().remarks.fallback, Fallback::None);
    let astar = plan(
        "lwx_oa",
        &policy(DeadEndPolicy::FallbackAstar),
        &map,
        RULE,
        ends,
    )
    .unwrap();
    assert_close(astar.cost, best.cost, 1e-9, "A*");
    assert_eq!(astar.stats().remarks.fallback, Fallback::Astar);
}

#[test]
fn lwx_oa_an_enclosed_goal_is_unreachable_under_every_policy() {
    let (map, at) = Map::drawn("......\n...###\nS..#G#\n...###");
    for dead_end in [
        DeadEndPolicy::Fail,
        DeadEndPolicy::Backtrack,
        DeadEndPolicy::FallbackAstar,
    ] {
        let result = plan("lwx_oa", &policy(dead_end), &map, RULE, (at('S'), at('G')));
        let blocked_by_corner = false;
        assert_eq!(
            result.map(|found| found.cost),
            Err(PlanError::Unreachable { blocked_by_corner })
        );
    }
}

#[test]
fn lwx_oa_expands_less_than_a_star_where_it_succeeds() {
    let (mut fewer, mut solved, mut solvable) = (0, 0, 0);
    for seed in 0..300 {
        let map = any(20, 20, seed);
        let Ok(best) = plan("lwx_ta", &plain(), &map, RULE, corners(&map)) else {
            continue;
        };
        solvable += 1;
        if let Ok(found) = plan(
            "lwx_oa",
            &policy(DeadEndPolicy::Fail),
            &map,
            RULE,
            corners(&map),
        ) {
            solved += 1;
            assert!(found.cost >= best.cost - 1e-9, "seed {seed}");
            assert_legal(&found, &map, RULE, &format!("seed {seed}"));
            fewer += u32::from(found.stats().expanded < best.stats().expanded);
        }
    }
    assert!(solved < solvable, "it never gave up");
    assert!(solved > solvable / 3, "{solved} of {solvable}");
    assert!(20 * fewer >= 19 * solved, "{fewer} of {solved}");
}

#[test]
fn lwx_oa_literal_is_said_and_succeeds_less() {
    let run = |literal, child_cost| {
        let mut options = policy(DeadEndPolicy::Fail);
        options.papers.literal = literal;
        options.papers.greedy.child_cost = child_cost;
        (0..200)
            .filter_map(|seed| {
                let map = blocky(20, 20, 20, seed);
                plan("lwx_oa", &options, &map, RULE, corners(&map)).ok()
            })
            .inspect(|found| assert_eq!(found.stats().remarks.literal, literal))
            .count()
    };
    let distance = run(false, ChildCost::Distance);
    let with_step = run(false, ChildCost::DistanceAndStep);
    let literal = run(true, ChildCost::Distance);
    assert!(literal < distance, "{literal} and {distance} of 200");
    assert!(with_step > 0, "{with_step} of 200");
}

#[test]
fn lwx_bi_passes_the_middle_and_is_never_cheaper_than_a_star() {
    for seed in 0..300 {
        let map = any(20, 20, seed);
        let ends = corners(&map);
        let (found, best) = match (
            plan("lwx_bi", &plain(), &map, RULE, ends),
            plan("lwx_ta", &plain(), &map, RULE, ends),
        ) {
            (Ok(found), Ok(best)) => (found, best),
            (Err(one), Err(other)) => {
                assert_eq!(one, other, "seed {seed}");
                continue;
            }
            _ => panic!("seed {seed}: they disagree about whether there is a way"),
        };
        assert!(found.cost >= best.cost - 1e-9, "seed {seed}");
        let middle = middle_of(ends.0, ends.1);
        if map.view().get(middle).unwrap().cost == 0
            && plan("lwx_ta", &plain(), &map, RULE, (ends.0, middle)).is_ok()
        {
            assert!(found.path.cells.contains(&middle), "seed {seed}");
        }
        assert_legal(&found, &map, RULE, &format!("seed {seed}"));
        for pair in found.path.cells.windows(2) {
            let apart = (pair[1].x - pair[0].x)
                .abs()
                .max((pair[1].y - pair[0].y).abs());
            assert_eq!(apart, 1, "seed {seed}: single steps");
        }
    }
}

#[test]
fn lwx_bi_takes_the_nearest_cell_to_a_blocked_middle_that_can_be_reached() {
    // The middle (5, 2) is blocked, the nearest free cells are walled in.
    let (map, at) = Map::drawn(
        "...........
         ...#####...
         S..#.#.#..G
         ...#####...
         ...........",
    );
    let found = plan("lwx_bi", &plain(), &map, RULE, (at('S'), at('G'))).unwrap();
    assert_eq!(found.stats().remarks.fallback, Fallback::None);
    // Of the eight nearest, two are walled in; the next lies above or below the block.
    assert!(found.path.cells.contains(&Cell::new(5, 0)));
    // The middle of [LWX]'s example.
    assert_eq!(
        middle_of(Cell::new(1, 1), Cell::new(19, 18)),
        Cell::new(10, 9)
    );
}

#[test]
fn lwx_bi_goes_without_a_middle_when_none_can_be_reached() {
    let (map, at) = Map::drawn(
        "...............
         ....#######....
         ....#.....#....
         S...#.....#...G
         ....#.....#....
         ....#######....
         ...............",
    );
    let ends = (at('S'), at('G'));
    let found = plan("lwx_bi", &plain(), &map, RULE, ends).unwrap();
    let best = plan("lwx_ta", &plain(), &map, RULE, ends).unwrap();
    assert_eq!(found.stats().remarks.fallback, Fallback::Astar);
    assert_close(found.cost, best.cost, 1e-9, "A*");
}

#[test]
fn lwx_aco_finds_ways_and_repeats_itself_by_seed() {
    let (mut solvable, mut solved, mut differing) = (0, 0, 0);
    for seed in 0..40 {
        let map = blocky(20, 20, 20, seed);
        let Ok(best) = plan("lwx_ta", &plain(), &map, RULE, corners(&map)) else {
            continue;
        };
        solvable += 1;
        let run = |seed| {
            let mut options = plain();
            options.papers.seed = seed;
            let found = plan("lwx_aco", &options, &map, RULE, corners(&map))?;
            assert_legal(&found, &map, RULE, &format!("seed {seed}"));
            Ok::<_, PlanError>(found.path)
        };
        let (one, again, other) = (run(seed), run(seed), run(seed + 1000));
        assert_eq!(one, again, "seed {seed}");
        differing += u32::from(one != other);
        if let Ok(path) = one {
            solved += 1;
            assert!(path.length_cells() >= best.cost - 1e-9, "seed {seed}");
        }
    }
    assert!(20 * solved >= 19 * solvable, "{solved} of {solvable}");
    assert!(differing > 0, "the seed does not matter");
}

#[test]
fn lwx_aco_finds_the_shortest_way_over_an_empty_map() {
    let map = Map::free(10, 10);
    let found = plan("lwx_aco", &plain(), &map, RULE, corners(&map)).unwrap();
    assert_close(found.cost, 9.0 * SQRT_2, 1e-9, "diagonal");
}

/// Asserts that a curve touches no obstacle's square, looking every hundredth of a cell.
fn assert_curve_free(found: &Found, map: &Map, what: &str) {
    let geometry = &map.geometry;
    let blocked = |cell| map.view().get(cell).is_none_or(MapCell::blocks_centre);
    for ends in found.path.curve.windows(2) {
        let n = ((ends[1] - ends[0]).norm() / geometry.resolution_m * 100.0).ceil();
        for i in 0..=n.to_u32() {
            let at = ends[0] + (ends[1] - ends[0]) * (f64::from(i) / n.max(1.0));
            let cell = geometry.cell_at(at).expect("on the map");
            assert!(!blocked(cell), "{what}: {cell:?}");
        }
    }
}

#[test]
fn lwx_rrt_finds_ways_in_99_of_100() {
    let (mut solvable, mut solved, mut shorter) = (0, 0, 0);
    for seed in 0..200 {
        let map = blocky(20, 20, 20, seed);
        let ends = corners(&map);
        let Ok(best) = plan("lwx_ta", &plain(), &map, RULE, ends) else {
            continue;
        };
        solvable += 1;
        let mut options = plain();
        options.papers.seed = seed;
        if let Ok(found) = plan("lwx_rrt", &options, &map, RULE, ends) {
            let what = format!("seed {seed}");
            solved += 1;
            assert_legal(&found, &map, RULE, &what);
            assert_curve_free(&found, &map, &what);
            let straight = f64::from(ends.1.x - ends.0.x).hypot(f64::from(ends.1.y - ends.0.y));
            assert!(found.cost >= straight - 1e-9, "{what}");
            // Its branches have any direction, so that it may be shorter than the grid allows.
            shorter += u32::from(found.cost < best.cost);
        }
    }
    assert!(solvable > 100);
    assert!(100 * solved >= 99 * solvable, "{solved} of {solvable}");
    assert!(
        10 * shorter < solved,
        "{shorter} of {solved} shorter than A*"
    );
}

#[test]
fn lwx_rrt_ends_in_the_region_and_at_the_limit_of_its_samples() {
    let map = Map::free(20, 20);
    let ends = (Cell::new(0, 0), Cell::new(19, 12));
    let mut options = plain();
    options.papers.tree.region_cells = 5.0;
    options.papers.tree.step_cells = 3.0;
    let found = plan("lwx_rrt", &options, &map, RULE, ends).unwrap();
    let curve = &found.path.curve;
    let goal = map.geometry.centre_of(ends.1);
    let cells_apart = |n: usize| (curve[n] - goal).norm() / map.geometry.resolution_m;
    assert_close(cells_apart(curve.len() - 1), 0.0, 1e-9, "the goal itself");
    let before = cells_apart(curve.len() - 2);
    assert!(
        (0.0..=5.0).contains(&before),
        "{before} cells from the goal"
    );
    // Branches of one length, but for the last and those that reached their sample.
    let branch = (curve[1] - curve[0]).norm() / map.geometry.resolution_m;
    assert_close(branch, 3.0, 1e-9, "a branch");
    assert_eq!(found.path.cells.first(), Some(&ends.0));
    assert_eq!(found.path.cells.last(), Some(&ends.1));
    options.papers.tree.samples = 2;
    let result = plan("lwx_rrt", &options, &map, RULE, ends).map(|found| found.cost);
    assert_eq!(result, Err(PlanError::OutOfBudget));
    // What the samples cannot prove a flood does.
    let (map, at) = Map::drawn("S..#G\n...##\n.....");
    let result = plan("lwx_rrt", &plain(), &map, RULE, (at('S'), at('G')));
    let blocked_by_corner = false;
    assert_eq!(
        result.map(|found| found.cost),
        Err(PlanError::Unreachable { blocked_by_corner })
    );
}
