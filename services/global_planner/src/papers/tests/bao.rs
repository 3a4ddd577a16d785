//! BAO-TAA, BAO-AAO, BAO-IAA, BAO-DIJ, BAO-FULL.

use super::generate::{any, blocky, corners, with_costs};
use super::{assert_close, plain, plan, query};
use crate::moves::Neighbours;
use crate::papers::bao_full::inflate;
use crate::papers::field::{Field, Prices};
use crate::papers::heuristic::Heuristic;
use crate::support::{Map, of_cost};
use crate::{CornerRule, PlanError};
use core::f64::consts::SQRT_2;
use zeronav_msgs::Cell;
use zeronav_msgs::map::COST_LETHAL;

#[test]
fn bao_iaa_costs_what_bao_dij_costs_on_1000_maps() {
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
                for found in [&iaa, &dij, &aao] {
                    assert_eq!(found.stats().remarks.corner_cuts, 0, "seed {seed}");
                }
            }
            (Err(one), Err(other), Err(third)) => {
                assert_eq!((one, one), (other, third), "seed {seed}");
            }
            _ => panic!("seed {seed}: they disagree about whether there is a way"),
        }
    }
}

#[test]
fn bao_taa_costs_no_less_than_a_star_and_cuts_corners() {
    let (mut cuts, mut dearer) = (0, 0);
    for seed in 0..300 {
        let map = any(30, 20, seed);
        let mut octile = plain();
        octile.papers.heuristic = Heuristic::Octile;
        let (Ok(taa), Ok(best)) = (
            plan("bao_taa", &plain(), &map, CornerRule::Allow, corners(&map)),
            plan("tn_a8", &octile, &map, CornerRule::Allow, corners(&map)),
        ) else {
            continue;
        };
        assert!(taa.cost >= best.cost - 1e-9, "seed {seed}");
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
    assert_eq!(result.map(|found| found.cost), Err(PlanError::DeadEnd));
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

#[test]
fn bao_full_fails_cleanly_where_obstacles_are_dense() {
    let mut found = 0;
    for seed in 0..40 {
        let map = blocky(50, 40, 38, seed);
        match plan(
            "bao_full",
            &plain(),
            &map,
            CornerRule::ForbidAny,
            corners(&map),
        ) {
            Ok(_) => found += 1,
            Err(PlanError::DeadEnd | PlanError::Unreachable { .. }) => {}
            Err(error) => panic!("seed {seed}: {error}"),
        }
    }
    assert_eq!(found, 0, "ways among obstacles that leave none");
}
