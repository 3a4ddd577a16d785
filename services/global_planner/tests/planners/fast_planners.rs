//! The planners that are fast against the plain one: same costs, whatever happened to the map.

use crate::support::{Map, Rng, of_cost};
use proptest::prelude::*;
use zeronav_global_planner::{
    CellPath, Control, CornerRule, GlobalPlanner, PlanError, PlanQuery, PlanStats, PlannerOptions,
    Unknown, row_of,
};
use zeronav_msgs::map::COST_LETHAL;
use zeronav_msgs::{Cell, CellRect, MapCell};

pub(crate) const RULES: [CornerRule; 3] = [
    CornerRule::Allow,
    CornerRule::ForbidAny,
    CornerRule::ForbidBoth,
];

pub(crate) fn build(key: &str, cost_weight: f64) -> Box<dyn GlobalPlanner> {
    let options = PlannerOptions {
        cost_weight,
        ..PlannerOptions::default()
    };
    (row_of(key).unwrap().build)(&options)
}

pub(crate) fn query(map: &Map, start: Cell, goal: Cell, rule: CornerRule) -> PlanQuery<'_> {
    PlanQuery {
        map: map.view(),
        start: map.pose(start),
        goal: map.pose(goal),
        tolerance_m: 0.01,
        unknown: Unknown::Free,
        corner_rule: rule,
    }
}

pub(crate) fn plan(
    planner: &mut dyn GlobalPlanner,
    query: &PlanQuery<'_>,
    path: &mut CellPath,
) -> Result<PlanStats, PlanError> {
    planner.plan(query, &mut |_| Control::Go, path)
}

pub(crate) fn whole(map: &Map) -> CellRect {
    let (width, height) = map.geometry.size();
    CellRect {
        min: Cell::new(0, 0),
        max: Cell::new(width, height),
    }
}

/// Same outcome, costs within what integers bend.
fn assert_same(
    what: &str,
    one: Result<PlanStats, PlanError>,
    other: Result<PlanStats, PlanError>,
    bend: f64,
) {
    match (one, other) {
        (Ok(one), Ok(other)) => {
            let limit = bend * other.cost + 1e-9;
            let apart = (one.cost - other.cost).abs();
            assert!(apart <= limit, "{what}: {} is not {}", one.cost, other.cost);
        }
        (one, other) => {
            let (one, other) = (one.map(|_| ()), other.map(|_| ()));
            assert_eq!(one, other, "{what}");
        }
    }
}

pub(crate) fn drawn_by(
    seed: u64,
    width: u32,
    height: u32,
    blocked_percent: i32,
    cost_percent: i32,
) -> Map {
    let mut map = Map::free(width, height);
    let mut rng = Rng(seed);
    for cell in &mut map.cells {
        *cell = if rng.below(100) < blocked_percent {
            of_cost(COST_LETHAL)
        } else if rng.below(100) < cost_percent {
            of_cost(u8::try_from(rng.below(253)).unwrap())
        } else {
            of_cost(0)
        };
    }
    map
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1000))]

    /// Jumps, canonical steps and plain A* find ways of one length.
    #[test]
    fn jps_and_canonical_are_a_star(
        width in 1_u32..140,
        height in 1_u32..70,
        seed: u64,
        blocked_percent in 0_i32..55,
        rule in 0_usize..3,
    ) {
        let map = drawn_by(seed, width, height, blocked_percent, 0);
        let mut rng = Rng(!seed);
        let (w, h) = map.geometry.size();
        let mut planners = ["c_astar", "jps", "canonical", "mpgaa"].map(|key| build(key, 0.0));
        let mut path = CellPath::default();
        for _ in 0..4 {
            let start = Cell::new(rng.below(w), rng.below(h));
            let goal = Cell::new(rng.below(w), rng.below(h));
            let query = query(&map, start, goal, RULES[rule]);
            let [expected, rest @ ..] = &mut planners;
            let expected = plan(expected.as_mut(), &query, &mut path);
            for (key, planner) in ["jps", "canonical", "mpgaa"].iter().zip(rest) {
                let result = plan(planner.as_mut(), &query, &mut path);
                assert_same(key, result, expected, 1e-6);
            }
        }
    }
}

/// Edits of small maps: as many as `ZERONAV_EDITS` says.
fn edits() -> u64 {
    std::env::var("ZERONAV_EDITS")
        .ok()
        .and_then(|text| text.parse().ok())
        .unwrap_or(100_000)
}

/// One random edit; what it wrote.
pub(crate) fn edit(map: &mut Map, rng: &mut Rng, side: i32) -> CellRect {
    let (w, h) = map.geometry.size();
    let min = Cell::new(rng.below(w), rng.below(h));
    let max = Cell::new(
        (min.x + 1 + rng.below(side)).min(w),
        (min.y + 1 + rng.below(side)).min(h),
    );
    let kind = rng.below(4);
    let cost = u8::try_from(rng.below(253)).unwrap();
    for y in min.y..max.y {
        for x in min.x..max.x {
            let value = match kind {
                0 => COST_LETHAL,
                1 => 0,
                2 => cost,
                _ if rng.below(3) == 0 => COST_LETHAL,
                _ => u8::try_from(rng.below(253)).unwrap(),
            };
            map.put(Cell::new(x, y), of_cost(value));
        }
    }
    CellRect { min, max }
}

/// Runs planners that are told of every edit beside ones that start from scratch each time.
fn compare_under_edits(
    seed: u64,
    n_edits: u64,
    mut map: Map,
    side: i32,
    every: i32,
) -> (u64, u64, u64) {
    let mut rng = Rng(seed);
    let (w, h) = map.geometry.size();
    let rule = RULES[usize::try_from(seed % 3).unwrap()];
    let (mut kept, mut jumps) = (build("mpgaa", 3.0), build("jps", 3.0));
    for planner in [&mut kept, &mut jumps] {
        planner.map_changed(&map.view(), &[whole(&map)]);
    }
    let mut goal = map.free_near(Cell::new(rng.below(w), rng.below(h)));
    let mut robot = map.free_near(Cell::new(rng.below(w), rng.below(h)));
    let (mut path, mut spare) = (CellPath::default(), CellPath::default());
    let (mut found, mut total_kept, mut total_anew) = (0, 0, 0);
    for n in 0..n_edits {
        let rect = edit(&mut map, &mut rng, side);
        kept.map_changed(&map.view(), &[rect]);
        jumps.map_changed(&map.view(), &[rect]);
        if rng.below(every) > 0 {
            continue;
        }
        let query = query(&map, robot, goal, rule);
        let what = format!("seed {seed}, edit {n}, {robot:?} to {goal:?}, {rule:?}");
        let expected = plan(build("c_astar", 3.0).as_mut(), &query, &mut spare);
        let anew = spare.stats.expanded;
        let result = plan(kept.as_mut(), &query, &mut path);
        assert_same(&format!("mpgaa, {what}"), result, expected, 1e-3);
        assert!(
            path.stats.expanded <= anew + anew * 3 / 10 + 1,
            "{what}: {} expansions, from scratch {anew}",
            path.stats.expanded
        );
        total_kept += path.stats.expanded;
        total_anew += anew;
        found += u64::from(result.is_ok());
        let expected = plan(build("c_astar", 0.0).as_mut(), &query, &mut spare);
        let result = plan(jumps.as_mut(), &query, &mut spare);
        assert_same(&format!("jps, {what}"), result, expected, 1e-6);
        // The robot goes on, now and then far; goals come and go; work ahead is done or not.
        if let Some(cell) = path.cells.get(1 + usize::try_from(rng.below(4)).unwrap()) {
            robot = *cell;
        }
        match rng.below(40) {
            0 => goal = Cell::new(rng.below(w), rng.below(h)),
            1 => robot = Cell::new(rng.below(w), rng.below(h)),
            _ => {}
        }
        for _ in 0..rng.below(4) {
            let expansions = 64 + u64::from(rng.below(3).cast_unsigned()) * 100_000;
            kept.prepare(&map.pose(robot), expansions);
        }
    }
    (found, total_kept, total_anew)
}

#[test]
fn mpgaa_is_a_star_under_edits_of_small_maps() {
    let n_edits = edits();
    let (mut found, mut searches) = (0, 0);
    for seed in 0..n_edits / 100 {
        let mut rng = Rng(seed);
        let (w, h) = (3 + rng.below(22), 3 + rng.below(22));
        let map = drawn_by(seed, w.cast_unsigned(), h.cast_unsigned(), 15, 40);
        let (ways, _, _) = compare_under_edits(seed, 100, map, 4, 2);
        found += ways;
        searches += 50;
    }
    assert!(
        found * 3 > searches,
        "{found} of {searches} have a way: too few to say anything"
    );
}

#[test]
fn mpgaa_is_a_star_under_edits_of_a_large_map_and_expands_less() {
    let map = Map::office(600, 400, 3);
    let n_edits = (edits() / 100).max(60);
    let (found, kept, anew) = compare_under_edits(3, n_edits, map, 14, 1);
    assert!(found * 2 > n_edits, "{found} of {n_edits} have a way");
    assert!(kept * 2 < anew, "{kept} expansions, from scratch {anew}");
}

/// In clutter a weighted round may find nothing although there is something cheaper.
#[test]
fn anytime_ends_with_the_cost_of_a_star() {
    let (mut anytime, mut a_star) = (build("anytime", 0.0), build("c_astar", 0.0));
    let (mut path, mut spare) = (CellPath::default(), CellPath::default());
    let mut found = 0;
    for seed in 0..150 {
        let map = drawn_by(seed, 150, 150, 33, 0);
        let mut rng = Rng(!seed);
        for _ in 0..4 {
            let start = map.free_near(Cell::new(rng.below(150), rng.below(150)));
            let goal = map.free_near(Cell::new(rng.below(150), rng.below(150)));
            let query = query(&map, start, goal, CornerRule::ForbidAny);
            let expected = plan(a_star.as_mut(), &query, &mut spare);
            let result = plan(anytime.as_mut(), &query, &mut path);
            let what = format!("seed {seed}, {start:?} to {goal:?}");
            assert_same(&what, result, expected, 1e-6);
            found += u64::from(result.is_ok());
        }
    }
    assert!(found > 100, "{found} of 600 have a way");
}

/// The policy beside a plain A*: first nothing has a price, then something has.
#[test]
fn policy_is_a_star_on_maps_with_and_without_prices() {
    for seed in 0..150 {
        let mut rng = Rng(seed);
        let (w, h) = (3 + rng.below(30), 3 + rng.below(30));
        let mut map = drawn_by(seed, w.cast_unsigned(), h.cast_unsigned(), 20, 0);
        let rule = RULES[usize::try_from(seed % 3).unwrap()];
        let mut policy = build("policy", 3.0);
        policy.map_changed(&map.view(), &[whole(&map)]);
        let goal = map.free_near(Cell::new(rng.below(w), rng.below(h)));
        let start = map.free_near(Cell::new(rng.below(w), rng.below(h)));
        let (mut path, mut spare) = (CellPath::default(), CellPath::default());
        let mut priced = false;
        for n in 0..40 {
            let mut rect = edit(&mut map, &mut rng, 5);
            if n == 30 {
                rect = whole(&map);
            }
            if !(15..30).contains(&n) {
                for cell in &mut map.cells {
                    if !cell.blocks_centre() {
                        cell.cost = 0;
                    }
                }
            }
            policy.map_changed(&map.view(), &[rect]);
            let query = query(&map, start, goal, rule);
            let what = format!("seed {seed}, edit {n}, {start:?} to {goal:?}, {rule:?}");
            let expected = plan(build("c_astar", 3.0).as_mut(), &query, &mut spare);
            let result = plan(policy.as_mut(), &query, &mut path);
            assert_same(&what, result, expected, 1e-3);
            let is_priced = |cell: &MapCell| cell.cost > 0 && !cell.blocks_centre();
            priced = (priced && n != 30) || map.cells.iter().any(is_priced);
            if !priced && rule == CornerRule::ForbidAny {
                // From scratch is then the search by jumps.
                let result = plan(build("jps", 3.0).as_mut(), &query, &mut spare);
                assert_same(&what, result, expected, 1e-6);
            }
            let anew = spare.stats.expanded;
            assert!(
                path.stats.expanded <= anew + anew * 3 / 10 + 1,
                "{what}: {} expansions, from scratch {anew}",
                path.stats.expanded
            );
            policy.prepare(&map.pose(start), 1 << 20);
        }
    }
}

/// On a large map without prices the field answers what it can answer for less, jumps the rest.
#[test]
fn policy_takes_the_field_or_jumps_where_nothing_has_a_price() {
    let mut map = Map::office(2400, 1600, 11);
    for cell in &mut map.cells {
        *cell = of_cost(if cell.blocks_centre() { COST_LETHAL } else { 0 });
    }
    let mut policy = build("policy", 3.0);
    policy.map_changed(&map.view(), &[whole(&map)]);
    let goal = map.free_near(Cell::new(2380, 1580));
    let mut robot = map.free_near(Cell::new(20, 20));
    let (mut path, mut spare) = (CellPath::default(), CellPath::default());
    let (mut by_field, mut by_jumps) = (0, 0);
    let mut rng = Rng(5);
    for n in 0..60 {
        // A block near the robot, half way, or anywhere; some are cleared again.
        let next = path.cells.get(1).copied().unwrap_or(robot);
        let ahead = |at: i32, next: i32| at + 12 * (next - at).signum();
        let near = Cell::new(ahead(robot.x, next.x), ahead(robot.y, next.y));
        let half = path.cells.get(path.cells.len() / 2).copied();
        let at = match n % 3 {
            0 => near,
            1 => half.unwrap_or(robot),
            _ => Cell::new(rng.below(2400), rng.below(1600)),
        };
        let min = Cell::new(at.x - 3, at.y - 3);
        let max = Cell::new(at.x + 4, at.y + 4);
        let cost = if rng.below(3) == 0 { 0 } else { COST_LETHAL };
        for y in min.y..max.y {
            for x in min.x..max.x {
                if Cell::new(x, y) != robot && Cell::new(x, y) != goal {
                    map.put(Cell::new(x, y), of_cost(cost));
                }
            }
        }
        policy.map_changed(&map.view(), &[CellRect { min, max }]);
        let query = query(&map, robot, goal, CornerRule::ForbidAny);
        let expected = plan(build("c_astar", 0.0).as_mut(), &query, &mut spare);
        let result = plan(policy.as_mut(), &query, &mut path);
        let what = format!("edit {n}, {robot:?} to {goal:?}");
        assert_same(&what, result, expected, 1e-6);
        let (anew, expanded) = (spare.stats.expanded, path.stats.expanded);
        assert!(
            expanded <= anew + anew * 3 / 10 + 1,
            "{what}: {expanded} expansions, from scratch {anew}"
        );
        // The field's ways go from neighbour to neighbour, those of jumps from turn to turn.
        let is_step = |pair: &[Cell]| {
            (pair[1].x - pair[0].x).abs() <= 1 && (pair[1].y - pair[0].y).abs() <= 1
        };
        if path.cells.windows(2).all(is_step) {
            by_field += 1;
        } else {
            by_jumps += 1;
        }
        if let Some(next) = path.cells.get(1) {
            robot.x += (next.x - robot.x).signum();
            robot.y += (next.y - robot.y).signum();
        }
        while policy.prepare(&map.pose(robot), 1 << 20) {}
    }
    assert!(
        by_field >= 15,
        "{by_field} by the field, {by_jumps} by jumps"
    );
    assert!(
        by_jumps >= 2,
        "{by_field} by the field, {by_jumps} by jumps"
    );
}

/// A wall closes the straight way and opens again, with prices and without.
#[test]
fn policy_finds_the_way_that_a_cleared_obstacle_leaves() {
    for (cost_weight, cost) in [(0.0, 0), (3.0, 0), (3.0, 40)] {
        let mut map = Map::free(200, 120);
        for cell in &mut map.cells {
            *cell = of_cost(cost);
        }
        let mut policy = build("policy", cost_weight);
        policy.map_changed(&map.view(), &[whole(&map)]);
        let (start, goal) = (Cell::new(10, 60), Cell::new(190, 60));
        let mut path = CellPath::default();
        let mut lengths = Vec::new();
        for value in [cost, COST_LETHAL, cost] {
            let (min, max) = (Cell::new(100, 20), Cell::new(104, 110));
            for y in min.y..max.y {
                for x in min.x..max.x {
                    map.put(Cell::new(x, y), of_cost(value));
                }
            }
            policy.map_changed(&map.view(), &[CellRect { min, max }]);
            let query = query(&map, start, goal, CornerRule::ForbidAny);
            plan(policy.as_mut(), &query, &mut path).unwrap();
            lengths.push(path.length_cells());
            while policy.prepare(&map.pose(start), 1 << 20) {}
        }
        assert!((lengths[0] - 180.0).abs() < 1e-9, "{lengths:?}");
        assert!(lengths[1] > 190.0, "{lengths:?}");
        assert!((lengths[2] - 180.0).abs() < 1e-9, "{lengths:?}");
    }
}

#[test]
fn a_walled_in_goal_is_told_without_a_flood() {
    // A flood would look at 16 million cells.
    let mut map = Map::free(4000, 4000);
    map.block(Cell::new(600, 600), Cell::new(660, 660));
    for y in 610..650 {
        for x in 610..650 {
            map.put(Cell::new(x, y), of_cost(0));
        }
    }
    for key in ["jps", "canonical", "mpgaa", "policy"] {
        let mut planner = build(key, 3.0);
        planner.map_changed(&map.view(), &[whole(&map)]);
        let (start, goal) = (Cell::new(20, 30), Cell::new(630, 630));
        let query = query(&map, start, goal, CornerRule::ForbidAny);
        let mut path = CellPath::default();
        let none = Err(PlanError::Unreachable {
            blocked_by_corner: false,
        });
        assert_eq!(plan(planner.as_mut(), &query, &mut path), none, "{key}");
        assert!(path.stats.expanded <= 8192, "{key}: {:?}", path.stats);
        let first = path.stats.expanded;
        assert_eq!(plan(planner.as_mut(), &query, &mut path), none, "{key}");
        // Known by now, unless it was found out on the way.
        assert!(path.stats.expanded == 0 || first < 256, "{key}");
    }
}

#[test]
fn a_goal_that_is_walled_in_is_told_by_the_strips_that_changed() {
    let mut map = Map::free(1600, 1600);
    let (start, goal) = (Cell::new(20, 30), Cell::new(1000, 630));
    let mut planner = build("mpgaa", 3.0);
    planner.map_changed(&map.view(), &[whole(&map)]);
    let mut path = CellPath::default();
    let before = query(&map, start, goal, CornerRule::ForbidAny);
    plan(planner.as_mut(), &before, &mut path).unwrap();
    while planner.prepare(&before.start, 1 << 20) {}
    let (min, max) = (Cell::new(970, 600), Cell::new(1030, 660));
    map.block(min, max);
    for y in 610..650 {
        for x in 980..1020 {
            map.put(Cell::new(x, y), of_cost(0));
        }
    }
    planner.map_changed(&map.view(), &[CellRect { min, max }]);
    let query = query(&map, start, goal, CornerRule::ForbidAny);
    let none = Err(PlanError::Unreachable {
        blocked_by_corner: false,
    });
    assert_eq!(plan(planner.as_mut(), &query, &mut path), none);
    // Reading the whole map would be worth it after 900 expansions only.
    assert!(path.stats.expanded <= 600, "{:?}", path.stats);
}
