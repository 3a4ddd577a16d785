//! What every row of `PLANNERS` promises.
// long: one list of promises, which share what is counted as giving up

use crate::support::{Map, Rng, of_cost};
use proptest::prelude::*;
use zeronav_casts::Cast;
use zeronav_global_planner::{
    CellPath, Control, CornerRule, Expansions, GlobalPlanner, PLANNERS, PlanError, PlanQuery,
    PlanStats, PlannerOptions, PlannerRow, Unknown, supercover,
};
use zeronav_msgs::map::{COST_INSCRIBED, COST_LETHAL};
use zeronav_msgs::{Cell, MapCell, Pose};

const RULES: [CornerRule; 3] = [
    CornerRule::Allow,
    CornerRule::ForbidAny,
    CornerRule::ForbidBoth,
];

fn build(row: &PlannerRow) -> Box<dyn GlobalPlanner> {
    let mut options = PlannerOptions::default();
    // A small colony: what is promised here does not depend on its size.
    options.papers.ants.ants = 8;
    options.papers.ants.patience = 4;
    (row.build)(&options)
}

/// True when an incomplete planner gave up, which is no proof that there is no way.
fn gave_up(row: &PlannerRow, result: Result<PlanStats, PlanError>) -> bool {
    let way = match row.key {
        // What it inflates is its own.
        "bao_full" => PlanError::Unreachable {
            blocked_by_corner: false,
        },
        // Out of samples.
        "lwx_rrt" => PlanError::OutOfBudget,
        _ => PlanError::DeadEnd,
    };
    !row.complete && result == Err(way)
}

/// The corner rule that a planner keeps to.
fn rule_of(row: &PlannerRow, query: &PlanQuery<'_>) -> CornerRule {
    match row.key {
        "bao_taa" => CornerRule::Allow,
        _ => query.corner_rule,
    }
}

fn query(map: &Map, start: Cell, goal: Cell) -> PlanQuery<'_> {
    PlanQuery {
        map: map.view(),
        start: map.pose(start),
        goal: map.pose(goal),
        tolerance_m: 0.01,
        unknown: Unknown::Free,
        corner_rule: CornerRule::ForbidAny,
    }
}

fn go(_: Expansions) -> Control {
    Control::Go
}

/// Plans from S to G with every planner: the number of cells of the path, or the error.
fn check(text: &str, expected: Result<(), PlanError>) {
    let (map, at) = Map::drawn(text);
    for row in PLANNERS {
        let mut path = CellPath::default();
        let query = query(&map, at('S'), at('G'));
        let result = build(row).plan(&query, &mut go, &mut path);
        match expected {
            Ok(()) if gave_up(row, result) => {}
            Ok(()) => {
                assert!(result.is_ok(), "{}: {result:?}\n{text}", row.key);
                assert_legal(row, &query, &path);
            }
            // Its rule is its own: corners never block it.
            Err(PlanError::Unreachable {
                blocked_by_corner: true,
            }) if row.key == "bao_taa" => assert!(result.is_ok(), "{text}"),
            Err(error) if gave_up(row, result) => assert_ne!(error, PlanError::GoalBlocked),
            Err(error) => assert_eq!(result, Err(error), "{}\n{text}", row.key),
        }
        if result.is_err() {
            assert!(
                path.cells.is_empty(),
                "{}: a failure leaves no path",
                row.key
            );
        }
    }
}

/// From the robot's own cell to the goal's, every cell and corner free, no dearer than it says.
fn assert_legal(row: &PlannerRow, query: &PlanQuery<'_>, path: &CellPath) {
    let key = row.key;
    let geometry = query.map.geometry;
    assert_eq!(
        path.cells.first().copied(),
        geometry.cell_at(query.start.point()),
        "{key}"
    );
    assert_eq!(
        path.cells.last().copied(),
        geometry.cell_at(query.goal.point()),
        "{key}"
    );
    let blocked = |cell: Cell| {
        query
            .map
            .get(cell)
            .is_none_or(|cell| query.unknown.blocks(cell))
    };
    for pair in path.cells.windows(2) {
        assert_ne!(pair[0], pair[1], "{key}: no cell follows itself");
        supercover(pair[0], pair[1], |crossing| {
            assert!(!blocked(crossing.cell), "{key}: passes {:?}", crossing.cell);
            if let Some([one, other]) = crossing.touched {
                let legal = rule_of(row, query).permits(blocked(one), blocked(other));
                assert!(legal, "{key}: cuts a corner at {:?}", crossing.cell);
            }
        });
    }
    let (first, last) = (path.cells[0], path.cells[path.cells.len() - 1]);
    let straight = f64::from(last.x - first.x).hypot(f64::from(last.y - first.y));
    assert!(
        path.length_cells() >= straight - 1e-9,
        "{key}: shorter than straight"
    );
    // A curve that is no rounding of the cells is what the robot follows.
    let length_m = if key == "lwx_rrt" {
        let pairs = path.curve.windows(2);
        pairs.map(|pair| (pair[1] - pair[0]).norm()).sum()
    } else {
        path.length_cells() * geometry.resolution_m
    };
    assert!(
        path.stats.cost >= length_m - 1e-9,
        "{key}: cheaper than its length"
    );
}

#[test]
fn finds_the_way() {
    check("S....G", Ok(()));
    check("S#.\n.#.\n..G", Ok(()));
    check("S.#...\n..#.#.\n....#G", Ok(()));
    check("S12\n#93\n..G", Ok(()));
    check("S?\n#?\n#G", Ok(()));
}

#[test]
fn proves_that_there_is_none() {
    let nothing = |blocked_by_corner| Err(PlanError::Unreachable { blocked_by_corner });
    check("S#G", nothing(false));
    check("S+G", nothing(false));
    check("S.#..\n..#..\n..#.G", nothing(false));
    check("S#\n#G", nothing(true));
    check("..#..\nS.#..\n..#..\n##.#.\n....G", nothing(true));
}

#[test]
fn start_equal_to_goal_is_a_path_of_one_cell() {
    let map = Map::free(1, 1);
    for row in PLANNERS {
        let mut path = CellPath::default();
        let query = query(&map, Cell::new(0, 0), Cell::new(0, 0));
        let stats = build(row).plan(&query, &mut go, &mut path).unwrap();
        assert_eq!(path.cells, [Cell::new(0, 0)], "{}", row.key);
        assert!(stats.cost.abs() < 1e-12, "{}", row.key);
    }
}

#[test]
fn ends_beside_the_map_are_named() {
    let map = Map::free(4, 3);
    let (inside, outside) = (Cell::new(1, 1), Cell::new(4, 1));
    for row in PLANNERS {
        let mut path = CellPath::default();
        let mut plan = |from, to| build(row).plan(&query(&map, from, to), &mut go, &mut path);
        assert_eq!(
            plan(outside, inside),
            Err(PlanError::StartOutsideMap),
            "{}",
            row.key
        );
        assert_eq!(
            plan(inside, outside),
            Err(PlanError::GoalOutsideMap),
            "{}",
            row.key
        );
        let mut lost = query(&map, inside, inside);
        lost.start = Pose::new(f64::NAN, 0.0, 0.0);
        let result = build(row).plan(&lost, &mut go, &mut CellPath::default());
        assert_eq!(result, Err(PlanError::StartOutsideMap), "{}", row.key);
    }
}

#[test]
fn blocked_ends_are_named() {
    let mut map = Map::free(5, 1);
    map.put(Cell::new(0, 0), of_cost(COST_LETHAL));
    let (blocked, free) = (Cell::new(0, 0), Cell::new(4, 0));
    for row in PLANNERS {
        let plan =
            |from, to| build(row).plan(&query(&map, from, to), &mut go, &mut CellPath::default());
        assert_eq!(
            plan(blocked, free),
            Err(PlanError::StartBlocked),
            "{}",
            row.key
        );
        assert_eq!(
            plan(free, blocked),
            Err(PlanError::GoalBlocked),
            "{}",
            row.key
        );
    }
}

#[test]
fn a_start_too_close_to_an_obstacle_is_left_the_shortest_way() {
    let (map, at) = Map::drawn(
        "#+++....
         #+S+...G
         #+++....",
    );
    let mut map = map;
    map.put(at('S'), of_cost(COST_INSCRIBED));
    for row in PLANNERS {
        let mut path = CellPath::default();
        let result = build(row).plan(&query(&map, at('S'), at('G')), &mut go, &mut path);
        if gave_up(row, result) {
            continue;
        }
        result.unwrap();
        let out = [at('S'), Cell::new(3, 1), Cell::new(4, 1)];
        assert_eq!(path.cells[..3], out, "{}", row.key);
        assert_eq!(path.cells.last(), Some(&at('G')), "{}", row.key);
    }
    // Walled in by what is lethal: nothing within reach.
    for y in 0..3 {
        map.put(Cell::new(3, y), of_cost(COST_LETHAL));
    }
    for row in PLANNERS {
        let result = build(row).plan(
            &query(&map, at('S'), at('G')),
            &mut go,
            &mut CellPath::default(),
        );
        assert_eq!(result, Err(PlanError::StartBlocked), "{}", row.key);
    }
}

#[test]
fn a_start_too_close_to_an_obstacle_is_not_led_into_a_pocket() {
    // The nearest free cell is the lone one on the left.
    let (mut map, at) = Map::drawn(
        "###########
         #.+++++...#
         #++++++...#
         #+S+++++.G#
         ###########",
    );
    map.put(at('S'), of_cost(COST_INSCRIBED));
    for row in PLANNERS {
        let mut path = CellPath::default();
        let result = build(row).plan(&query(&map, at('S'), at('G')), &mut go, &mut path);
        if gave_up(row, result) {
            continue;
        }
        result.unwrap();
        assert_eq!(path.cells[0], at('S'), "{}", row.key);
        assert_eq!(path.cells.last(), Some(&at('G')), "{}", row.key);
    }
}

/// Two rooms with a wall in between that has a gap too narrow for the robot, and cells with their true
/// clearance: of 5 cm, the robot's inscribed radius is 0.12 m.
fn narrow_door() -> (Map, impl Fn(char) -> Cell) {
    let (mut map, at) = Map::drawn(
        "##################
         #.......##.......#
         #.......##.......#
         #.......##.......#
         #...F.N......G...#
         #................#
         #.......##.......#
         #.......##.......#
         #.......##.......#
         ##################",
    );
    // The gap is two cells high: 5 cm of room in the middle of either.
    let (width, height) = map.geometry.size();
    let all = || (0..height).flat_map(|y| (0..width).map(move |x| Cell::new(x, y)));
    let lethal: Vec<Cell> = all()
        .filter(|cell| map.view().get(*cell).unwrap().cost == COST_LETHAL)
        .collect();
    for cell in all() {
        let gap = |d: i32| (f64::from(d.abs()) - 0.5).max(0.0) * 50.0;
        let away_mm = lethal
            .iter()
            .map(|it| gap(it.x - cell.x).hypot(gap(it.y - cell.y)));
        let clearance_mm = away_mm.fold(1000.0, f64::min);
        let mut known = map.view().get(cell).unwrap();
        if known.cost != COST_LETHAL {
            let inscribed = clearance_mm <= 120.0;
            known = of_cost(if inscribed { COST_INSCRIBED } else { 0 });
        }
        let clearance_mm = clearance_mm.to_u16();
        map.put(
            cell,
            MapCell {
                clearance_mm,
                ..known
            },
        );
    }
    (map, at)
}

#[test]
fn a_gap_too_narrow_for_the_robot_is_none_for_one_right_before_it_either() {
    let (map, at) = narrow_door();
    let near = map.view().get(at('N')).unwrap();
    assert_eq!(near.cost, COST_INSCRIBED, "{near:?}");
    for row in PLANNERS {
        for start in ['F', 'N'] {
            let mut path = CellPath::default();
            let query = query(&map, at(start), at('G'));
            let result = build(row).plan(&query, &mut go, &mut path);
            let none = PlanError::Unreachable {
                blocked_by_corner: false,
            };
            if !gave_up(row, result) {
                assert_eq!(result, Err(none), "{} from {start}", row.key);
            }
        }
        // It is led out to its own side none the less.
        let mut path = CellPath::default();
        let result = build(row).plan(&query(&map, at('N'), at('F')), &mut go, &mut path);
        if !gave_up(row, result) {
            result.unwrap_or_else(|error| panic!("{}: {error}", row.key));
        }
    }
}

#[test]
fn a_free_goal_that_is_cut_off_gives_way_to_a_cell_that_can_be_reached() {
    let (map, at) = Map::drawn(
        "S....###
         .....#G#
         .....###
         ........",
    );
    for row in PLANNERS {
        let mut query = query(&map, at('S'), at('G'));
        query.tolerance_m = 0.101;
        let mut path = CellPath::default();
        let result = build(row).plan(&query, &mut go, &mut path);
        if gave_up(row, result) {
            continue;
        }
        result.unwrap_or_else(|error| panic!("{}: {error}", row.key));
        let last = *path.cells.last().unwrap();
        let apart = f64::from(last.x - at('G').x).hypot(f64::from(last.y - at('G').y));
        assert!((1.9..=2.01).contains(&apart), "{}: {last:?}", row.key);
        // Without such a tolerance there is no way.
        query.tolerance_m = 0.01;
        let result = build(row).plan(&query, &mut go, &mut path);
        if !gave_up(row, result) {
            assert!(
                matches!(result, Err(PlanError::Unreachable { .. })),
                "{}: {result:?}",
                row.key
            );
        }
    }
}

#[test]
fn a_blocked_goal_gives_way_within_the_tolerance() {
    let (map, at) = Map::drawn(
        "S.....
         ...##.
         ..#G#.
         ..####",
    );
    for row in PLANNERS {
        let mut map = map.clone();
        map.put(at('G'), of_cost(COST_LETHAL));
        let mut query = query(&map, at('S'), at('G'));
        let mut path = CellPath::default();
        let mut planner = build(row);
        assert_eq!(
            planner.plan(&query, &mut go, &mut path),
            Err(PlanError::GoalBlocked)
        );
        // The nearest free cell is one diagonal away, 0.0707 m.
        query.tolerance_m = 0.072;
        let result = planner.plan(&query, &mut go, &mut path);
        if gave_up(row, result) {
            continue;
        }
        result.unwrap();
        assert_eq!(path.cells.last(), Some(&Cell::new(2, 2)), "{}", row.key);
    }
}

#[test]
fn a_blocked_goal_gives_way_to_a_cell_that_can_be_reached() {
    // In the wall between a room and a box: the inside of the box is nearer.
    let (mut map, at) = Map::drawn(
        "S....####
         .....#..#
         ....#G..#
         .....#..#
         .....####",
    );
    map.put(at('G'), of_cost(COST_LETHAL));
    for row in PLANNERS {
        let mut query = query(&map, at('S'), at('G'));
        query.tolerance_m = 0.101;
        let mut path = CellPath::default();
        let result = build(row).plan(&query, &mut go, &mut path);
        if gave_up(row, result) {
            continue;
        }
        result.unwrap_or_else(|error| panic!("{}: {error}", row.key));
        let last = *path.cells.last().unwrap();
        assert!(last.x < 5, "{}: {last:?}", row.key);
        let apart = f64::from(last.x - at('G').x).hypot(f64::from(last.y - at('G').y));
        assert!((1.3..=2.01).contains(&apart), "{}: {last:?}", row.key);
        // With less tolerance only the box is left.
        query.tolerance_m = 0.06;
        let result = build(row).plan(&query, &mut go, &mut path);
        if !gave_up(row, result) {
            let none = PlanError::Unreachable {
                blocked_by_corner: false,
            };
            assert_eq!(result, Err(none), "{}", row.key);
        }
    }
}

#[test]
fn unknown_cells_are_what_the_query_says() {
    let (map, at) = Map::drawn("S?G");
    for row in PLANNERS {
        let mut query = query(&map, at('S'), at('G'));
        let mut path = CellPath::default();
        assert!(
            build(row).plan(&query, &mut go, &mut path).is_ok(),
            "{}",
            row.key
        );
        query.unknown = Unknown::Lethal;
        assert!(
            build(row).plan(&query, &mut go, &mut path).is_err(),
            "{}",
            row.key
        );
    }
}

#[test]
fn the_budget_is_asked_and_obeyed() {
    // A bag of clutter, open on the robot's side: every planner that is complete must look into
    // most of it.
    let mut map = Map::free(300, 300);
    let mut rng = Rng(17);
    for _ in 0..9000 {
        map.put(
            Cell::new(rng.below(300), rng.below(300)),
            of_cost(COST_LETHAL),
        );
    }
    map.block(Cell::new(270, 10), Cell::new(272, 290));
    map.block(Cell::new(20, 10), Cell::new(272, 12));
    map.block(Cell::new(20, 288), Cell::new(272, 290));
    let (start, goal) = (Cell::new(25, 150), Cell::new(290, 150));
    map.put(start, of_cost(0));
    map.put(goal, of_cost(0));
    let query = query(&map, start, goal);
    for row in PLANNERS.iter().filter(|row| row.complete) {
        let mut calls = Vec::new();
        let mut path = CellPath::default();
        let mut budget = |expansions: Expansions| {
            calls.push(expansions);
            if calls.len() == 3 {
                Control::Stop
            } else {
                Control::Go
            }
        };
        let result = build(row).plan(&query, &mut budget, &mut path);
        assert_eq!(result, Err(PlanError::OutOfBudget), "{}", row.key);
        assert_eq!(calls.len(), 3, "{}: stops when told", row.key);
        assert!(
            calls.is_sorted() && calls[0].0 > 0,
            "{}: {calls:?}",
            row.key
        );
        let steps = calls.windows(2).map(|pair| pair[1].0 - pair[0].0);
        assert!(steps.max() <= Some(4096), "{}: asked often enough", row.key);
        assert!(path.stats.expanded >= calls[2].0, "{}", row.key);
    }
}

#[test]
fn an_enclosed_goal_costs_no_more_than_the_map_twice() {
    let mut map = Map::free(40, 30);
    map.block(Cell::new(20, 10), Cell::new(26, 16));
    map.put(Cell::new(23, 13), of_cost(0));
    let query = query(&map, Cell::new(1, 1), Cell::new(23, 13));
    for row in PLANNERS.iter().filter(|row| row.complete) {
        let mut path = CellPath::default();
        assert!(build(row).plan(&query, &mut go, &mut path).is_err());
        assert!(path.stats.expanded <= 2 * 40 * 30, "{}", row.key);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    /// On maps of any shape and filling, thin ones included: no panic, legal paths, the same
    /// answer twice from one planner and from a fresh one, and a path wherever there is one.
    #[test]
    fn random_maps(
        width in 1_u32..24,
        height in 1_u32..24,
        seed: u64,
        percent in 0_i32..=100,
        rule in 0_usize..3,
    ) {
        let mut map = Map::free(width, height);
        let mut rng = Rng(seed);
        for cell in &mut map.cells {
            if rng.below(100) < percent {
                *cell = of_cost(u8::try_from(rng.below(255)).unwrap());
            } else if rng.below(3) == 0 {
                *cell = of_cost(COST_LETHAL);
            }
        }
        let (w, h) = map.geometry.size();
        let (from, to) = (
            Cell::new(rng.below(w), rng.below(h)),
            Cell::new(rng.below(w), rng.below(h)),
        );
        let mut query = query(&map, from, to);
        query.corner_rule = RULES[rule];
        let free = |cell| map.view().get(cell).is_some_and(|cell| !cell.blocks_centre());
        for row in PLANNERS {
            let mut planner = build(row);
            let (mut one, mut two, mut three) = Default::default();
            let first = planner.plan(&query, &mut go, &mut one);
            let second = planner.plan(&query, &mut go, &mut two);
            let third = build(row).plan(&query, &mut go, &mut three);
            prop_assert_eq!(first, second);
            prop_assert_eq!(first, third);
            prop_assert_eq!(&one, &two);
            prop_assert_eq!(&one, &three);
            // The one under which every planner searches the same graph.
            if RULES[rule] == CornerRule::ForbidAny {
                let reference = build(&PLANNERS[0]).plan(&query, &mut go, &mut two);
                let agrees = first.err() == reference.err() || row.key == "bao_taa";
                let fails = reference.is_ok() || row.key == "bao_full";
                prop_assert!(agrees || (fails && gave_up(row, first)), "{}", row.key);
            }
            if first.is_ok() && free(from) && free(to) {
                assert_legal(row, &query, &one);
            }
        }
    }
}
