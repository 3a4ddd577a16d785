//! The edge cases of PAPERS, Appendix C, that are not the same for every planner, and every planner
//! of the table as the stack runs it: by its key, on an inflated map.

use super::{assert_close, plain, plan};
use crate::support::Map;
use crate::{
    Control, CornerRule, Fallback, GlobalPlannerConfig, PLANNERS, PlanError, PlannerRow, Replanner,
    Situation, Step, Target,
};
use core::f64::consts::SQRT_2;
use zeronav_msgs::Cell;
use zeronav_msgs::path::{Path, PathStatus};

const RULE: CornerRule = CornerRule::ForbidAny;

/// The rows of the papers.
fn papers() -> impl Iterator<Item = &'static PlannerRow> {
    PLANNERS.iter().filter(|row| row.source.starts_with('['))
}

/// Those whose paths are straight between cells that are not neighbours.
const ANY_ANGLE: [&str; 2] = ["tn_apf", "tn_hyb"];

/// Those that draw lots.
const RANDOM: [&str; 2] = ["lwx_aco", "lwx_rrt"];

#[test]
fn an_empty_map_is_crossed_by_the_octile_or_the_straight_line() {
    let map = Map::free(40, 30);
    for to in [(39, 29), (39, 3), (17, 22)] {
        let ends = (Cell::new(0, 0), Cell::new(to.0, to.1));
        let (dx, dy) = (f64::from(to.0), f64::from(to.1));
        let octile = dx.max(dy) + (SQRT_2 - 1.0) * dx.min(dy);
        for row in papers().filter(|row| !RANDOM.contains(&row.key)) {
            let found = plan(row.key, &plain(), &map, RULE, ends).unwrap();
            if ANY_ANGLE.contains(&row.key) {
                assert_close(found.cost, dx.hypot(dy), 1e-9, row.key);
            } else if row.key == "lwx_bi" || row.key == "tn_3n" {
                // Forced through the middle, and led by the eight directions.
                assert!(
                    found.cost >= octile - 1e-9 && found.cost <= 1.09 * octile,
                    "{}",
                    row.key
                );
            } else {
                assert_close(found.cost, octile, 1e-6, row.key);
            }
        }
    }
}

#[test]
fn thin_and_full_maps() {
    for row in PLANNERS {
        for (width, height) in [(1, 12), (12, 1), (2, 12), (12, 2)] {
            let mut map = Map::free(width, height);
            let (w, h) = map.geometry.size();
            let ends = (Cell::new(0, 0), Cell::new(w - 1, h - 1));
            let result = plan(row.key, &plain(), &map, RULE, ends);
            assert!(result.is_ok(), "{} on {width} x {height}", row.key);
            // From edge to edge, half-way along.
            let (min, max) = if w > h {
                (Cell::new(w / 2, 0), Cell::new(w / 2 + 1, h))
            } else {
                (Cell::new(0, h / 2), Cell::new(w, h / 2 + 1))
            };
            map.block(min, max);
            let result = plan(row.key, &plain(), &map, RULE, ends).map(|found| found.cost);
            let blocked_by_corner = false;
            assert_eq!(
                result,
                Err(PlanError::Unreachable { blocked_by_corner }),
                "{}",
                row.key
            );
        }
        let mut full = Map::free(5, 4);
        full.block(Cell::new(0, 0), Cell::new(5, 4));
        let ends = (Cell::new(0, 0), Cell::new(4, 3));
        let result = plan(row.key, &plain(), &full, RULE, ends).map(|found| found.cost);
        assert_eq!(result, Err(PlanError::StartBlocked), "{}", row.key);
    }
}

#[test]
fn a_diagonal_gap_is_passed_when_the_rule_allows_it() {
    let (map, at) = Map::drawn("..#.\n..#G\nS#..\n.#..");
    let ends = (at('S'), at('G'));
    for row in papers() {
        let result = plan(row.key, &plain(), &map, CornerRule::Allow, ends);
        if row.key == "bao_taa" {
            // Its rule is its own.
            assert!(result.is_ok() && plan(row.key, &plain(), &map, RULE, ends).is_ok());
            continue;
        }
        let strict = plan(row.key, &plain(), &map, RULE, ends).map(|found| found.cost);
        // Inflation closes more than corners.
        let blocked_by_corner = row.key != "bao_full";
        assert_eq!(
            strict,
            Err(PlanError::Unreachable { blocked_by_corner }),
            "{}",
            row.key
        );
        let error = result.err();
        if row.key.starts_with("bao_") {
            let corner = Some(PlanError::Unreachable { blocked_by_corner });
            assert_eq!(error, corner, "{}", row.key);
        } else if row.complete {
            assert_eq!(error, None, "{}", row.key);
        }
    }
}

/// A map with rooms, doors, furniture and inflation, and a way through it.
fn office() -> (Map, Cell, Cell) {
    let map = Map::office(300, 200, 3);
    let start = map.free_near(Cell::new(20, 20));
    let goal = map.free_near(Cell::new(270, 170));
    (map, start, goal)
}

#[test]
fn every_planner_answers_by_its_key_on_an_inflated_map() {
    let (map, start, goal) = office();
    for row in PLANNERS {
        let key = row.key;
        let config = GlobalPlannerConfig {
            planner: key.to_owned(),
            ..GlobalPlannerConfig::default()
        };
        let mut replanner = Replanner::new(&config).unwrap();
        let situation = Situation {
            robot: map.pose(start),
            map: Some(map.view()),
            revision: 1,
            changed: &[],
            target: Some(Target {
                task: 1,
                goal: 1,
                pose: map.pose(goal),
                tolerance_m: 0.05,
            }),
            request: None,
        };
        assert!(
            matches!(replanner.begin(&situation), Step::Search(_)),
            "{key}"
        );
        replanner.search(&situation, &mut |_| Control::Go);
        assert!(
            matches!(replanner.settle(&situation), Step::Publish(_)),
            "{key}"
        );
        let plan = replanner.plan();
        let mut message = Path::default();
        plan.fill(&mut message);
        message.check(&plan.waypoints).unwrap();
        assert_eq!(message.planner(), key);
        assert!(!plan.is_cut(&map.view()), "{key}: its own path is cut");
        match plan.status {
            PathStatus::Found => {
                assert!(plan.length_m > 12.0, "{key}: {} m", plan.length_m);
                assert_eq!(plan.cells.stats.remarks.fallback, Fallback::None, "{key}");
            }
            PathStatus::DeadEnd => assert!(!row.complete, "{key} gave up"),
            status => panic!("{key}: {status:?}"),
        }
    }
}
