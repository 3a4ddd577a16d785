//! BAO-TAA, BAO-AAO, BAO-IAA, BAO-DIJ, BAO-FULL.

use super::generate::{any, blocky, corners, least_cost, with_costs};
use super::{assert_close, assert_legal, plain, plan, query};
use crate::moves::Neighbours;
use crate::papers::bao_full::inflate;
use crate::papers::best_first::PastCorner;
use crate::papers::field::{Field, Prices};
use crate::papers::heuristic::Heuristic;
use crate::support::{Map, of_cost};
use crate::{CornerRule, PlanError, PlannerOptions};
use core::f64::consts::SQRT_2;
use zeronav_msgs::Cell;
use zeronav_msgs::map::{COST_LETHAL, FLAG_VIRTUAL};

#[test]
fn bao_iaa_costs_what_bao_dij_costs_on_1000_maps() {
    let (mut both, mut fewer, mut dearer) = (0, 0, 0);
    for seed in 0..1000 {
        let mut map = any(20, 16, seed);
        let mut options = plain();
        if seed.is_multiple_of(4) {
            map = with_costs(map, seed);
            options.cost_weight = 3.0;
        }
        let run = |key| plan(key, &options, &map, CornerRule::Allow, corners(&map));
        match (run("bao_iaa"), run("bao_dij"), run("bao_aao")) {
            (Ok(iaa), Ok(dij), Ok(aao)) => {
                assert_close(iaa.cost, dij.cost, 1e-9, &format!("seed {seed}"));
                assert!(iaa.stats().expanded <= dij.stats().expanded, "seed {seed}");
                assert!(aao.cost >= iaa.cost - 1e-9, "seed {seed}");
                both += 1;
                fewer += u32::from(iaa.stats().expanded < dij.stats().expanded);
                dearer += u32::from(aao.cost > iaa.cost + 1e-9);
                for found in [&iaa, &dij, &aao] {
                    assert_eq!(found.stats().remarks.corner_cuts, 0, "seed {seed}");
                    let what = format!("seed {seed}");
                    assert_legal(found, &map, CornerRule::ForbidAny, &what);
                }
            }
            (Err(one), Err(other), Err(third)) => {
                assert_eq!((one, one), (other, third), "seed {seed}");
            }
            _ => panic!("seed {seed}: they disagree about whether there is a way"),
        }
    }
    // Strictly fewer on nearly every map, and Manhattan's ways are strictly longer on many.
    eprintln!("{fewer} fewer, {dearer} dearer of {both}");
    assert!(100 * fewer >= 99 * both, "{fewer} of {both}");
    assert!(
        (both / 10..both / 2).contains(&dearer),
        "{dearer} of {both}"
    );
}

#[test]
fn bao_aao_takes_the_longer_way_that_manhattan_makes_it_believe_in() {
    let (mut solved, mut dearer, mut change) = (0_u32, 0_u32, 0.0);
    for seed in 0..200 {
        let map = blocky(30, 20, 16, seed);
        let run = |key| plan(key, &plain(), &map, CornerRule::ForbidAny, corners(&map));
        if let (Ok(aao), Ok(dij)) = (run("bao_aao"), run("bao_dij")) {
            assert_legal(&aao, &map, CornerRule::ForbidAny, &format!("seed {seed}"));
            solved += 1;
            dearer += u32::from(aao.cost > dij.cost + 1e-9);
            change += aao.cost / dij.cost - 1.0;
        }
    }
    let mean = change / f64::from(solved);
    assert!(5 * dearer > solved, "{dearer} of {solved} dearer");
    assert!((0.005..0.06).contains(&mean), "mean change of cost {mean}");
}

#[test]
fn bao_dij_is_the_cheapest_and_looks_at_most() {
    for seed in 0..100 {
        let map = any(20, 16, seed);
        let ends = corners(&map);
        let least = least_cost(&map, CornerRule::ForbidAny, 0.0, ends);
        match plan("bao_dij", &plain(), &map, CornerRule::Allow, ends) {
            Ok(found) => assert_close(found.cost, least, 1e-9, &format!("seed {seed}")),
            Err(error) => assert!(least.is_infinite(), "seed {seed}: {error}"),
        }
    }
    // Without an estimate every cell nearer than the goal is closed first.
    let map = Map::free(9, 9);
    let ends = (Cell::new(4, 4), Cell::new(8, 4));
    let run = |key| plan(key, &plain(), &map, CornerRule::ForbidAny, ends).unwrap();
    assert_eq!(run("bao_iaa").stats().expanded, 5);
    assert!(run("bao_dij").stats().expanded > 40);
}

#[test]
fn bao_taa_costs_no_less_than_a_star_and_cuts_corners() {
    let (mut cuts, mut dearer) = (0, 0);
    for seed in 0..300 {
        let map = any(30, 20, seed);
        let mut octile = plain();
        octile.papers.heuristic = Heuristic::Octile;
        let (Ok(taa), Ok(best)) = (
            // Its rule is its own.
            plan(
                "bao_taa",
                &plain(),
                &map,
                CornerRule::ForbidAny,
                corners(&map),
            ),
            plan("tn_a8", &octile, &map, CornerRule::Allow, corners(&map)),
        ) else {
            continue;
        };
        assert!(taa.cost >= best.cost - 1e-9, "seed {seed}");
        assert_legal(&taa, &map, CornerRule::Allow, &format!("seed {seed}"));
        dearer += u32::from(taa.cost > best.cost + 1e-9);
        cuts += taa.stats().remarks.corner_cuts;
    }
    assert!(
        cuts > 0 && dearer > 0,
        "{cuts} corners cut, {dearer} paths dearer"
    );
}

#[test]
fn bao_taa_counts_the_corner_that_it_cuts() {
    let (map, at) = Map::drawn("..G\n.#.\nS..");
    let ends = (at('S'), at('G'));
    let found = plan("bao_taa", &plain(), &map, CornerRule::Allow, ends).unwrap();
    assert_close(found.cost, 2.0 + SQRT_2, 1e-12, "past the block");
    assert_eq!(found.stats().remarks.corner_cuts, 1);
    let strict = plan("bao_aao", &plain(), &map, CornerRule::Allow, ends).unwrap();
    assert_close(strict.cost, 4.0, 1e-12, "around the block");
    assert_eq!(strict.stats().remarks.corner_cuts, 0);
}

#[test]
fn bao_iaa_counts_virtual_obstacles_along_the_path() {
    // From the lower row the only cells past a corner are those diagonally above the ends of the
    // block, seen from beside it.
    let (map, at) = Map::drawn(
        ".......
         ..###..
         S.....G",
    );
    let rule = CornerRule::ForbidAny;
    let found = plan("bao_iaa", &plain(), &map, rule, (at('S'), at('G'))).unwrap();
    assert_close(found.cost, 6.0, 1e-12, "straight");
    // (1, 1) past (2, 1) from (2, 0), and (5, 1) past (4, 1) from (4, 0).
    assert_eq!(found.stats().remarks.virtual_on_path, 2);
    assert!(found.stats().remarks.virtual_total >= 2);
    let dij = plan("bao_dij", &plain(), &map, rule, (at('S'), at('G'))).unwrap();
    assert!(dij.stats().remarks.virtual_total >= found.stats().remarks.virtual_total);
}

#[test]
fn bao_iaa_says_when_only_a_corner_is_in_the_way() {
    let (map, at) = Map::drawn("S#\n#G");
    let ends = (at('S'), at('G'));
    for key in ["bao_aao", "bao_iaa", "bao_dij"] {
        for rule in [CornerRule::Allow, CornerRule::ForbidAny] {
            let result = plan(key, &plain(), &map, rule, ends).map(|found| found.cost);
            let blocked_by_corner = true;
            assert_eq!(result, Err(PlanError::Unreachable { blocked_by_corner }));
        }
    }
    // Blocks of 2 x 2 cells that touch at corners.
    let (map, at) = Map::drawn("S.##\n..##\n##..\n##.G");
    let result = plan(
        "bao_iaa",
        &plain(),
        &map,
        CornerRule::Allow,
        (at('S'), at('G')),
    );
    let blocked_by_corner = true;
    assert_eq!(
        result.map(|found| found.cost),
        Err(PlanError::Unreachable { blocked_by_corner })
    );
}

#[test]
fn bao_iaa_literal_is_said_and_fails_where_there_is_a_way() {
    let mut literal = plain();
    literal.papers.literal = true;
    let (mut failed, mut dearer, mut solvable) = (0, 0, 0);
    for seed in 0..200 {
        let map = blocky(30, 20, 25, seed);
        let rule = CornerRule::ForbidAny;
        let Ok(proper) = plan("bao_iaa", &plain(), &map, rule, corners(&map)) else {
            continue;
        };
        solvable += 1;
        match plan("bao_iaa", &literal, &map, rule, corners(&map)) {
            Ok(found) => {
                assert!(found.stats().remarks.literal);
                assert!(found.cost >= proper.cost - 1e-9, "seed {seed}");
                dearer += u32::from(found.cost > proper.cost + 1e-9);
            }
            Err(error) => {
                // Cells that were closed for good prove nothing.
                assert_eq!(error, PlanError::DeadEnd, "seed {seed}");
                failed += 1;
            }
        }
    }
    assert!(failed > 0, "{failed} of {solvable} failed, {dearer} dearer");
    assert!(failed < solvable, "{failed} of {solvable} failed");
}

#[test]
fn bao_iaa_marks_that_persist_and_closed_nodes_that_stay_closed_are_two_options() {
    let (mut persistent, mut closed) = (plain(), plain());
    persistent.papers.past_corner = PastCorner::Persistent;
    closed.papers.reopen = false;
    let (mut failed, mut solvable) = (0, 0);
    for seed in 0..100 {
        let map = blocky(30, 20, 25, seed);
        let run = |options: &PlannerOptions| {
            plan(
                "bao_iaa",
                options,
                &map,
                CornerRule::ForbidAny,
                corners(&map),
            )
        };
        let Ok(proper) = run(&plain()) else {
            continue;
        };
        solvable += 1;
        // The octile distance is consistent: no closed node would be opened again anyway.
        let found = run(&closed).unwrap();
        assert_close(found.cost, proper.cost, 1e-9, &format!("seed {seed}"));
        assert!(found.stats().remarks.literal && !proper.stats().remarks.literal);
        failed += u32::from(run(&persistent).is_err());
    }
    assert!((1..solvable).contains(&failed), "{failed} of {solvable}");
}

#[test]
fn bao_full_inflates_by_one_cell() {
    let mut map = Map::free(6, 5);
    map.put(Cell::new(2, 2), of_cost(COST_LETHAL));
    map.put(Cell::new(5, 4), of_cost(COST_LETHAL));
    let prices = Prices::new(0.0);
    let query = query(
        &map,
        CornerRule::ForbidAny,
        Cell::new(0, 0),
        Cell::new(0, 4),
    );
    let field = Field {
        map: query.map,
        unknown: query.unknown,
        corner_rule: query.corner_rule,
        prices: &prices,
        walls: &[],
        layers: 0,
        spared: [Cell::new(0, 0); 2],
    };
    let mut walls = Vec::new();
    assert_eq!(inflate(&field, Neighbours::Eight, &mut walls), 8 + 3);
    assert!(!walls[0] && walls[map.geometry.index_of(Cell::new(1, 1)).unwrap()]);
    assert_eq!(inflate(&field, Neighbours::Four, &mut walls), 4 + 2);
    assert!(!walls[map.geometry.index_of(Cell::new(1, 1)).unwrap()]);
}

#[test]
fn bao_full_closes_gaps_of_one_cell() {
    let (map, at) = Map::drawn(
        ".....#.....
         .....#.....
         S.........G
         .....#.....
         .....#.....",
    );
    let ends = (at('S'), at('G'));
    let result = plan("bao_full", &plain(), &map, CornerRule::ForbidAny, ends);
    let blocked_by_corner = false;
    assert_eq!(
        result.map(|found| found.cost),
        Err(PlanError::Unreachable { blocked_by_corner })
    );
    let (map, at) = Map::drawn(
        ".....#.....
         ...........
         S.........G
         ...........
         .....#.....",
    );
    let ends = (at('S'), at('G'));
    let found = plan("bao_full", &plain(), &map, CornerRule::ForbidAny, ends).unwrap();
    assert_close(found.cost, 10.0, 1e-12, "through the middle");
}

/// Of the maps that have a way, how many `bao_full` finds one on.
fn found_among_inflated(size: (u32, u32), percent: i32, seeds: u64) -> (u32, u32) {
    let (mut found, mut solvable) = (0, 0);
    for seed in 0..seeds {
        let map = blocky(size.0, size.1, percent, seed);
        let rule = CornerRule::ForbidAny;
        let Ok(best) = plan("bao_iaa", &plain(), &map, rule, corners(&map)) else {
            continue;
        };
        solvable += 1;
        match plan("bao_full", &plain(), &map, rule, corners(&map)) {
            Ok(way) => {
                assert!(way.cost >= best.cost - 1e-9, "seed {seed}");
                assert!(way.stats().remarks.virtual_total > 0, "seed {seed}");
                found += 1;
            }
            Err(error) => {
                let blocked_by_corner = false;
                let expected = PlanError::Unreachable { blocked_by_corner };
                assert_eq!(error, expected, "seed {seed}");
            }
        }
    }
    (found, solvable)
}

#[test]
fn bao_full_fails_on_half_of_the_sparse_maps_and_on_all_dense_ones() {
    let (found, solvable) = found_among_inflated((30, 20), 16, 200);
    assert!(solvable > 120, "{solvable}");
    let share = f64::from(found) / f64::from(solvable);
    assert!((0.3..0.7).contains(&share), "{found} of {solvable}");
    let (found, solvable) = found_among_inflated((50, 40), 38, 60);
    assert!(solvable > 10, "{solvable}");
    assert_eq!(found, 0, "ways among obstacles that leave none");
}

#[test]
fn bao_full_keeps_clear_of_the_virtual_obstacles_of_mapping() {
    let (mut map, at) = Map::drawn(
        ".........
         .........
         S.......G
         .........
         .........",
    );
    let ends = (at('S'), at('G'));
    let straight = plan("bao_full", &plain(), &map, CornerRule::ForbidAny, ends).unwrap();
    assert_close(straight.cost, 8.0, 1e-12, "nothing in the way");
    // Start and goal are exempt.
    for x in [0, 3, 4, 5, 8] {
        let mut cell = map.view().get(Cell::new(x, 2)).unwrap();
        cell.flags |= FLAG_VIRTUAL;
        map.put(Cell::new(x, 2), cell);
    }
    let around = plan("bao_full", &plain(), &map, CornerRule::ForbidAny, ends).unwrap();
    assert_close(around.cost, 6.0 + 2.0 * SQRT_2, 1e-12, "beside them");
    // No other planner's row says that it honours them.
    let other = plan("bao_iaa", &plain(), &map, CornerRule::ForbidAny, ends).unwrap();
    assert_close(other.cost, 8.0, 1e-12, "through them");
}
