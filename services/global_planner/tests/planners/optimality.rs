//! `c_astar` costs what Dijkstra costs: a plain one, in floating point, over the whole map.

use crate::support::{Map, Rng, of_cost};
use zeronav_global_planner::moves::{STEPS, price};
use zeronav_global_planner::{
    CellPath, Control, CornerRule, PlanError, PlanQuery, PlannerOptions, Unknown, row_of,
};
use zeronav_msgs::map::COST_LETHAL;
use zeronav_msgs::{Cell, MapView};

/// Least cost from `start` to every cell by relaxing in order of cost. [cells]
fn dijkstra(map: MapView<'_>, start: Cell, rule: CornerRule, weight: f64) -> Vec<f64> {
    let blocked = |cell: Cell| {
        map.get(cell)
            .is_none_or(zeronav_msgs::MapCell::blocks_centre)
    };
    let mut cost = vec![f64::INFINITY; map.cells.len()];
    let mut done = vec![false; map.cells.len()];
    cost[map.geometry.index_of(start).unwrap()] = 0.0;
    let mut front = vec![start];
    while let Some(n) = (0..front.len()).min_by(|a, b| {
        let at = |n: usize| cost[map.geometry.index_of(front[n]).unwrap()];
        at(*a).total_cmp(&at(*b))
    }) {
        let from = front.swap_remove(n);
        let index = map.geometry.index_of(from).unwrap();
        if core::mem::replace(&mut done[index], true) {
            continue;
        }
        for (dx, dy) in STEPS {
            let to = Cell::new(from.x + dx, from.y + dy);
            let diagonal = dx != 0 && dy != 0;
            let corner = [Cell::new(to.x, from.y), Cell::new(from.x, to.y)].map(blocked);
            if blocked(to) || (diagonal && !rule.permits(corner[0], corner[1])) {
                continue;
            }
            let to_index = map.geometry.index_of(to).unwrap();
            let length = if diagonal {
                core::f64::consts::SQRT_2
            } else {
                1.0
            };
            let through = cost[index] + length * price(map.cells[to_index].cost, weight);
            if through < cost[to_index] {
                cost[to_index] = through;
                front.push(to);
            }
        }
    }
    cost
}

/// Compares on `n` random maps; `bend` is what integers may add, relative.
fn compare(n: u64, weight: f64, bend: f64, fill: impl Fn(&mut Rng) -> u8) {
    let options = PlannerOptions {
        cost_weight: weight,
        ..PlannerOptions::default()
    };
    // One planner for all: what it remembers of one map must not show on the next.
    let mut planner = (row_of("c_astar").unwrap().build)(&options);
    let mut path = CellPath::default();
    let mut found = 0;
    for seed in 0..n {
        let mut rng = Rng(seed);
        let (width, height) = (5 + rng.below(28), 5 + rng.below(28));
        let mut map = Map::free(width.cast_unsigned(), height.cast_unsigned());
        for cell in &mut map.cells {
            *cell = of_cost(fill(&mut rng));
        }
        let start = map.free_near(Cell::new(rng.below(width), rng.below(height)));
        let goal = map.free_near(Cell::new(rng.below(width), rng.below(height)));
        for rule in [
            CornerRule::Allow,
            CornerRule::ForbidAny,
            CornerRule::ForbidBoth,
        ] {
            let reference = dijkstra(map.view(), start, rule, weight)
                [map.geometry.index_of(goal).unwrap()]
                * map.geometry.resolution_m;
            let query = PlanQuery {
                map: map.view(),
                start: map.pose(start),
                goal: map.pose(goal),
                tolerance_m: 0.01,
                unknown: Unknown::Free,
                corner_rule: rule,
            };
            match planner.plan(&query, &mut |_| Control::Go, &mut path) {
                Ok(stats) => {
                    found += 1;
                    let (low, high) = (reference * (1.0 - 1e-9), reference * (1.0 + bend));
                    assert!(
                        (low - 1e-12..=high + 1e-12).contains(&stats.cost),
                        "seed {seed}, {rule:?}: {} is not {reference}",
                        stats.cost
                    );
                }
                Err(PlanError::Unreachable { .. }) => {
                    assert!(
                        reference.is_infinite(),
                        "seed {seed}, {rule:?}: there is a way"
                    );
                }
                Err(error) => panic!("seed {seed}, {rule:?}: {error}"),
            }
        }
    }
    assert!(
        found > n,
        "seeds 0 to {n}: too few maps have a way to say anything"
    );
}

#[test]
fn uniform_maps_cost_the_same() {
    compare(400, 3.0, 1e-6, |rng| {
        if rng.below(100) < 25 { COST_LETHAL } else { 0 }
    });
}

#[test]
fn cost_maps_cost_the_same() {
    let fill = |rng: &mut Rng| match rng.below(100) {
        0..20 => COST_LETHAL,
        20..60 => u8::try_from(rng.below(253)).unwrap(),
        _ => 0,
    };
    compare(400, 3.0, 1e-3, fill);
    compare(100, 20.0, 1e-3, fill);
    compare(100, 0.0, 1e-6, fill);
}

#[test]
fn a_weight_keeps_away_from_obstacles() {
    let (map, at) = Map::drawn(
        "..........
         ..........
         S.999999.G
         .########.",
    );
    let cells_in_cost = |weight| {
        let options = PlannerOptions {
            cost_weight: weight,
            ..PlannerOptions::default()
        };
        let query = PlanQuery {
            map: map.view(),
            start: map.pose(at('S')),
            goal: map.pose(at('G')),
            tolerance_m: 0.01,
            unknown: Unknown::Free,
            corner_rule: CornerRule::ForbidAny,
        };
        let mut path = CellPath::default();
        let mut planner = (row_of("c_astar").unwrap().build)(&options);
        planner
            .plan(&query, &mut |_| Control::Go, &mut path)
            .unwrap();
        let cost = |cell: &&Cell| map.view().get(**cell).unwrap().cost > 0;
        path.cells.iter().filter(cost).count()
    };
    assert_eq!(cells_in_cost(0.0), 6);
    assert_eq!(cells_in_cost(3.0), 0);
}

#[test]
fn ways_beyond_the_range_of_the_numbers_are_not_called_unreachable() {
    // A snake of 230 000 of the dearest cells at the largest weight.
    let (width, height) = (640_u32, 720_u32);
    let mut map = Map::free(width, height);
    for (index, cell) in map.cells.iter_mut().enumerate() {
        let (x, y) = (index % width as usize, index / width as usize);
        let gap = if y % 4 == 1 { width as usize - 1 } else { 0 };
        *cell = of_cost(if y % 2 == 1 && x != gap {
            COST_LETHAL
        } else {
            252
        });
    }
    let options = PlannerOptions {
        cost_weight: 20.0,
        ..PlannerOptions::default()
    };
    let query = PlanQuery {
        map: map.view(),
        start: map.pose(Cell::new(0, 0)),
        goal: map.pose(Cell::new(0, 718)),
        tolerance_m: 0.01,
        unknown: Unknown::Free,
        corner_rule: CornerRule::ForbidAny,
    };
    let mut path = CellPath::default();
    let mut planner = (row_of("c_astar").unwrap().build)(&options);
    let result = planner.plan(&query, &mut |_| Control::Go, &mut path);
    assert_eq!(result, Err(PlanError::OutOfBudget));
    let mut planner = (row_of("c_astar").unwrap().build)(&PlannerOptions::default());
    assert!(
        planner
            .plan(&query, &mut |_| Control::Go, &mut path)
            .is_ok()
    );
}
