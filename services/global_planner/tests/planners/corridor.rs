//! The corridor of a path against plain geometry.

use crate::support::{Map, Rng, of_cost};
use proptest::prelude::*;
use zeronav_global_planner::moves::price;
use zeronav_global_planner::{
    CellPath, Control, CornerRule, Corridor, Legality, PlanQuery, PlannerOptions, Unknown, row_of,
};
use zeronav_msgs::Cell;
use zeronav_msgs::map::{COST_INSCRIBED, COST_LETHAL};

const RULES: [CornerRule; 3] = [
    CornerRule::Allow,
    CornerRule::ForbidAny,
    CornerRule::ForbidBoth,
];

fn corridor(map: &Map, corner_rule: CornerRule, cells: &[Cell]) -> Corridor {
    let mut corridor = Corridor::default();
    let legality = Legality {
        unknown: Unknown::Free,
        corner_rule,
        past_margin: false,
    };
    corridor.set(&map.view(), legality, cells);
    corridor
}

/// Length of the segment inside the closed square of `cell`; `None` when they do not meet.
/// Coordinates in cells, centres at whole numbers.
fn overlap(from: Cell, to: Cell, cell: Cell) -> Option<f64> {
    let (mut enter, mut leave) = (0.0_f64, 1.0_f64);
    for (from, to, at) in [(from.x, to.x, cell.x), (from.y, to.y, cell.y)] {
        let (from, way) = (f64::from(from), f64::from(to - from));
        let (low, high) = (f64::from(at) - 0.5, f64::from(at) + 0.5);
        if way == 0.0 {
            if from < low || from > high {
                return None;
            }
        } else {
            let (one, other) = ((low - from) / way, (high - from) / way);
            enter = enter.max(one.min(other));
            leave = leave.min(one.max(other));
        }
    }
    let length = f64::from(to.x - from.x).hypot(f64::from(to.y - from.y));
    (leave - enter > -1e-9).then_some((leave - enter).max(0.0) * length)
}

/// True when a blocked cell lies on the path from its `first` vertex on.
fn is_cut_by_geometry(map: &Map, cells: &[Cell], first: usize, touching: bool) -> bool {
    let (width, height) = map.geometry.size();
    let all = (0..height).flat_map(|y| (0..width).map(move |x| Cell::new(x, y)));
    all.filter(|cell| {
        map.view()
            .get(*cell)
            .is_some_and(zeronav_msgs::MapCell::blocks_centre)
    })
    .any(|blocked| {
        blocked == cells[first]
            || cells[first..].windows(2).any(|pair| {
                overlap(pair[0], pair[1], blocked).is_some_and(|length| touching || length > 1e-6)
            })
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1000))]

    #[test]
    fn is_cut_agrees_with_geometry(seed: u64, corners in 1_usize..6, rule in 0_usize..2) {
        let mut rng = Rng(seed);
        let mut map = Map::free(20, 15);
        let mut cells: Vec<Cell> = Vec::new();
        while cells.len() < corners {
            let cell = Cell::new(rng.below(20), rng.below(15));
            if cells.last() != Some(&cell) {
                cells.push(cell);
            }
        }
        let mut corridor = corridor(&map, RULES[rule], &cells);
        for _ in 0..rng.below(12) {
            let cost = if rng.below(2) == 0 { COST_LETHAL } else { COST_INSCRIBED };
            map.put(Cell::new(rng.below(20), rng.below(15)), of_cost(cost));
        }
        let touching = RULES[rule] == CornerRule::ForbidAny;
        let expected = is_cut_by_geometry(&map, &cells, 0, touching);
        prop_assert_eq!(corridor.is_cut(&map.view()).is_some(), expected);
        // At the first corner, what lies behind no longer counts.
        if cells.len() > 2 {
            corridor.advance(map.geometry.centre_of(cells[1]));
            let (from, to) = (cells[0], cells[1]);
            let arc_m = f64::from(to.x - from.x).hypot(f64::from(to.y - from.y)) * 0.05;
            // A path that comes by twice is met at the first place.
            if (corridor.progress_m() - arc_m).abs() < 1e-9 {
                let expected = is_cut_by_geometry(&map, &cells, 1, touching);
                prop_assert_eq!(corridor.is_cut(&map.view()).is_some(), expected);
            }
        }
    }

    /// What a planner finds is never cut on the map it was found on, whatever the rule, and also
    /// when the robot had to leave the inflation first.
    #[test]
    fn a_path_is_not_cut_on_its_own_map(seed: u64, rule in 0_usize..3) {
        let mut rng = Rng(seed);
        let mut map = Map::free(24, 24);
        for cell in &mut map.cells {
            *cell = of_cost(match rng.below(10) {
                0 => COST_LETHAL,
                1..3 => COST_INSCRIBED,
                cost => u8::try_from(cost * 20).unwrap(),
            });
        }
        let query = PlanQuery {
            map: map.view(),
            start: map.pose(Cell::new(rng.below(24), rng.below(24))),
            goal: map.pose(map.free_near(Cell::new(rng.below(24), rng.below(24)))),
            tolerance_m: 0.1,
            unknown: Unknown::Free,
            corner_rule: RULES[rule],
        };
        let mut planner = (row_of("c_astar").unwrap().build)(&PlannerOptions::default());
        let mut path = CellPath::default();
        if planner.plan(&query, &mut |_| Control::Go, &mut path).is_ok() {
            let corridor = corridor(&map, RULES[rule], &path.cells);
            prop_assert_eq!(corridor.is_cut(&map.view()), None);
            let length_m = path.length_cells() * 0.05;
            prop_assert!((corridor.length_m() - length_m).abs() < 1e-9);
            let cost_m = corridor.cost_ahead_m(&map.view(), 0.0);
            prop_assert!((cost_m - length_m).abs() < 1e-4);
        }
    }
}

#[test]
fn the_arc_to_the_block_is_that_from_the_robot() {
    let mut map = Map::free(40, 3);
    let cells = [Cell::new(0, 1), Cell::new(39, 1)];
    let mut corridor = corridor(&map, CornerRule::ForbidAny, &cells);
    map.put(Cell::new(20, 1), of_cost(COST_LETHAL));
    let arc_m = corridor.is_cut(&map.view()).unwrap();
    assert!((arc_m - 19.5 * 0.05).abs() < 1e-6, "{arc_m}");
    // The robot drives 0.5 m beside the path, then past the block.
    let at = |x| map.geometry.centre_of(Cell::new(x, 2));
    assert!((corridor.advance(at(10)) - 0.05).abs() < 1e-9);
    assert!((corridor.progress_m() - 0.5).abs() < 1e-9);
    let arc_m = corridor.is_cut(&map.view()).unwrap();
    assert!((arc_m - 9.5 * 0.05).abs() < 1e-6, "{arc_m}");
    corridor.advance(at(20));
    assert!(corridor.is_cut(&map.view()).unwrap().abs() < 1e-12);
    corridor.advance(at(21));
    assert_eq!(corridor.is_cut(&map.view()), None);
    // Never back.
    corridor.advance(at(3));
    assert!(corridor.progress_m() > 1.0);
}

#[test]
fn progress_does_not_jump_to_the_other_side_of_a_wall() {
    let map = Map::free(200, 20);
    // Out and back again, 0.4 m apart.
    let cells = [
        Cell::new(0, 2),
        Cell::new(199, 2),
        Cell::new(199, 10),
        Cell::new(0, 10),
    ];
    let mut corridor = corridor(&map, CornerRule::ForbidAny, &cells);
    let off_m = corridor.advance(map.geometry.centre_of(Cell::new(4, 9)));
    assert!((off_m - 0.35).abs() < 1e-9, "{off_m}");
    assert!(corridor.progress_m() < 0.3);
}

#[test]
fn the_corner_rule_says_what_a_touched_corner_means() {
    let diagonal = [Cell::new(0, 0), Cell::new(1, 1)];
    for (blocked, cut) in [
        (vec![], [false, false, false]),
        (vec![Cell::new(1, 0)], [false, true, false]),
        (vec![Cell::new(1, 0), Cell::new(0, 1)], [false, true, true]),
    ] {
        let mut map = Map::free(2, 2);
        let corridors = RULES.map(|rule| corridor(&map, rule, &diagonal));
        for cell in blocked {
            map.put(cell, of_cost(COST_INSCRIBED));
        }
        assert_eq!(
            corridors.map(|corridor| corridor.is_cut(&map.view()).is_some()),
            cut
        );
    }
}

#[test]
fn the_cost_ahead_is_length_times_price() {
    let (map, at) = Map::drawn("S.99.G");
    let mut corridor = corridor(&map, CornerRule::ForbidAny, &[at('S'), at('G')]);
    let dear = 2.0 * price(225, 3.0);
    let cost_m = corridor.cost_ahead_m(&map.view(), 3.0);
    assert!((cost_m - (3.0 + dear) * 0.05).abs() < 1e-6, "{cost_m}");
    corridor.advance(map.geometry.centre_of(Cell::new(3, 0)));
    let cost_m = corridor.cost_ahead_m(&map.view(), 3.0);
    assert!(
        (cost_m - (1.5 + 0.5 * price(225, 3.0)) * 0.05).abs() < 1e-6,
        "{cost_m}"
    );
}
