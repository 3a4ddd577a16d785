//! C-ASTAR, C-LOS, TN-A8, JU-ASTAR, LWX-TA: the same search under plain recipes.

use super::generate::{any, blocky, corners, iid, least_cost, with_costs};
use super::{assert_close, plain, plan};
use crate::line::supercover;
use crate::papers::heuristic::Heuristic;
use crate::support::Map;
use crate::{CornerRule, PlanError};
use core::f64::consts::SQRT_2;
use zeronav_msgs::{Cell, MapCell};

const RULES: [CornerRule; 3] = [
    CornerRule::Allow,
    CornerRule::ForbidAny,
    CornerRule::ForbidBoth,
];

/// Runs a planner on `n` maps, with costs on every third, against relaxation.
fn check_optimal(key: &str, n: u64) {
    for seed in 0..n {
        let mut map = any(20, 16, seed);
        let mut options = plain();
        if seed.is_multiple_of(3) {
            map = with_costs(map, seed);
            options.cost_weight = 3.0;
        }
        let rule = RULES[usize::try_from(seed % 3).unwrap()];
        let least = least_cost(&map, rule, options.cost_weight, corners(&map));
        match plan(key, &options, &map, rule, corners(&map)) {
            Ok(found) => assert_close(found.cost, least, 1e-9, &format!("{key}, seed {seed}")),
            Err(error) => {
                assert!(least.is_infinite(), "{key}, seed {seed}: {error}");
                let with_corners =
                    least_cost(&map, CornerRule::Allow, 0.0, corners(&map)).is_finite();
                let blocked_by_corner = rule != CornerRule::Allow && with_corners;
                assert_eq!(error, PlanError::Unreachable { blocked_by_corner });
            }
        }
    }
}

#[test]
fn c_astar_costs_what_dijkstra_costs_on_1000_maps() {
    check_optimal("tn_a8", 1000);
}

#[test]
fn ju_astar_costs_what_dijkstra_costs_on_500_maps() {
    check_optimal("ju_astar", 500);
}

#[test]
fn zm_tra_costs_what_dijkstra_costs() {
    check_optimal("zm_tra", 200);
}

#[test]
fn lwx_ta_costs_what_dijkstra_costs_on_500_maps() {
    check_optimal("lwx_ta", 500);
}

#[test]
fn lwx_bi_true_costs_what_dijkstra_costs_on_500_maps() {
    check_optimal("lwx_bi_true", 500);
}

#[test]
fn tn_a8_looks_at_eight_cells_an_expansion() {
    let map = blocky(20, 20, 15, 4);
    let found = plan("tn_a8", &plain(), &map, CornerRule::Allow, corners(&map)).unwrap();
    let stats = found.stats();
    // The goal is closed but not looked around.
    assert_eq!(stats.evaluated, 8 * (stats.expanded - 1));
    assert!(stats.generated >= stats.expanded);
    assert!(stats.peak_open > 0 && stats.peak_open <= stats.generated);
}

#[test]
fn tn_a8_takes_three_estimates() {
    let mut dearer = 0;
    for seed in 0..100 {
        let map = blocky(20, 20, 20, seed);
        let run = |heuristic| {
            let mut options = plain();
            options.papers.heuristic = heuristic;
            plan("tn_a8", &options, &map, CornerRule::Allow, corners(&map))
        };
        let (Ok(euclid), Ok(octile), Ok(manhattan)) = (
            run(Heuristic::Euclid),
            run(Heuristic::Octile),
            run(Heuristic::Manhattan),
        ) else {
            continue;
        };
        assert_close(euclid.cost, octile.cost, 1e-9, "both are admissible");
        assert!(
            octile.stats().expanded <= euclid.stats().expanded,
            "seed {seed}"
        );
        assert!(manhattan.cost >= octile.cost - 1e-9, "seed {seed}");
        dearer += u32::from(manhattan.cost > octile.cost + 1e-9);
    }
    assert!(
        dearer > 0,
        "Manhattan never showed that it is not admissible"
    );
}

#[test]
fn ju_astar_finds_the_length_printed_for_an_empty_map() {
    // [JU]: from (1, 1) to (11, 11) on a map of 15 m and cells of 1 m.
    let map = Map::free(15, 15);
    let ends = (Cell::new(1, 1), Cell::new(11, 11));
    let found = plan("ju_astar", &plain(), &map, CornerRule::Allow, ends).unwrap();
    assert_close(found.cost, 10.0 * SQRT_2, 1e-12, "ten diagonal steps");
}

#[test]
fn lwx_ta_literal_is_said_and_is_not_a_star() {
    let mut options = plain();
    options.papers.literal = true;
    let mut dearer = 0;
    for seed in 0..200 {
        let map = any(20, 20, seed);
        let rule = CornerRule::ForbidAny;
        let literal = plan("lwx_ta", &options, &map, rule, corners(&map));
        let proper = plan("lwx_ta", &plain(), &map, rule, corners(&map));
        let (Ok(literal), Ok(proper)) = (literal, proper) else {
            continue;
        };
        assert!(literal.stats().remarks.literal && !proper.stats().remarks.literal);
        assert!(literal.cost >= proper.cost - 1e-9, "seed {seed}");
        dearer += u32::from(literal.cost > proper.cost + 1e-9);
    }
    assert!(dearer > 20, "only {dearer} dearer paths");
}

#[test]
fn c_los_is_legal_touches_nothing_and_is_no_longer_than_a_star() {
    let mut gains = Vec::new();
    for seed in 0..300 {
        let map = any(24, 24, seed);
        let rule = CornerRule::ForbidAny;
        let (Ok(pulled), Ok(grid)) = (
            plan("c_los", &plain(), &map, rule, corners(&map)),
            plan("tn_a8", &plain(), &map, rule, corners(&map)),
        ) else {
            continue;
        };
        assert!(pulled.cost <= grid.cost + 1e-9, "seed {seed}");
        let blocked = |cell| map.view().get(cell).is_none_or(MapCell::blocks_centre);
        for pair in pulled.path.cells.windows(2) {
            supercover(pair[0], pair[1], |crossing| {
                assert!(!blocked(crossing.cell), "seed {seed}");
                let touched = crossing.touched.unwrap_or([crossing.cell; 2]);
                assert!(!touched.into_iter().any(blocked), "seed {seed}: a corner");
            });
        }
        gains.push(1.0 - pulled.cost / grid.cost);
    }
    assert!(gains.len() > 100);
    // PAPERS 0.5: pulling may save more than 7.61 % where corners make the grid path zig-zag.
    let mean = gains.iter().sum::<f64>() / f64::from(u32::try_from(gains.len()).unwrap());
    assert!(mean > 0.01 && mean < 0.12, "mean gain {mean}");
}

#[test]
fn c_los_never_pays_more_among_costs() {
    for seed in 0..100 {
        let map = with_costs(iid(20, 20, 15, seed), seed);
        let options = crate::PlannerOptions::default();
        let rule = CornerRule::ForbidAny;
        let (Ok(pulled), Ok(grid)) = (
            plan("c_los", &options, &map, rule, corners(&map)),
            plan("tn_a8", &options, &map, rule, corners(&map)),
        ) else {
            continue;
        };
        assert!(pulled.cost <= grid.cost + 1e-9, "seed {seed}");
    }
}

#[test]
fn c_los_crosses_an_empty_map_in_one_line() {
    let map = Map::free(30, 20);
    let ends = (Cell::new(2, 3), Cell::new(27, 11));
    let found = plan("c_los", &plain(), &map, CornerRule::ForbidAny, ends).unwrap();
    assert_eq!(found.path.cells, [ends.0, ends.1]);
    assert_close(found.cost, 25_f64.hypot(8.0), 1e-9, "straight");
}
