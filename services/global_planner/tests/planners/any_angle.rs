//! Ways at any angle against the shortest there are, and what pulling and time make of a way.

#![allow(clippy::print_stdout, reason = "the quality is worth a line")]

use crate::support::{Map, Rng};
use zeronav_global_planner::{
    CellPath, Control, CornerRule, GlobalPlanner, PlanQuery, PlannerOptions, Unknown, row_of,
    supercover,
};
use zeronav_msgs::Cell;

fn build(key: &str, cost_weight: f64) -> Box<dyn GlobalPlanner> {
    let options = PlannerOptions {
        cost_weight,
        ..PlannerOptions::default()
    };
    (row_of(key).unwrap().build)(&options)
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

fn is_free(map: &Map, cell: Cell) -> bool {
    map.view()
        .get(cell)
        .is_some_and(|cell| !cell.blocks_centre())
}

fn sees(map: &Map, from: Cell, to: Cell) -> bool {
    let mut free = true;
    supercover(from, to, |crossing| {
        free &= is_free(map, crossing.cell);
        if let Some([one, other]) = crossing.touched {
            free &= is_free(map, one) && is_free(map, other);
        }
    });
    free
}

/// Length of the shortest way between cell centres at any angle: Dijkstra over all pairs of free
/// cells that see each other. [cells]
fn shortest(map: &Map, start: Cell, goal: Cell) -> f64 {
    let (w, h) = map.geometry.size();
    let cells: Vec<Cell> = (0..h)
        .flat_map(|y| (0..w).map(move |x| Cell::new(x, y)))
        .filter(|cell| is_free(map, *cell))
        .collect();
    let mut length = vec![f64::INFINITY; cells.len()];
    let mut done = vec![false; cells.len()];
    length[cells.iter().position(|cell| *cell == start).unwrap()] = 0.0;
    loop {
        let next = (0..cells.len())
            .filter(|n| !done[*n] && length[*n].is_finite())
            .min_by(|a, b| length[*a].total_cmp(&length[*b]));
        let Some(n) = next else {
            return f64::INFINITY;
        };
        if cells[n] == goal {
            return length[n];
        }
        done[n] = true;
        for m in 0..cells.len() {
            let apart =
                f64::from(cells[m].x - cells[n].x).hypot(f64::from(cells[m].y - cells[n].y));
            if !done[m] && length[n] + apart < length[m] && sees(map, cells[n], cells[m]) {
                length[m] = length[n] + apart;
            }
        }
    }
}

#[test]
fn lazy_theta_and_pulled_ways_are_close_to_the_shortest() {
    let mut theta = build("lazy_theta", 0.0);
    let mut pulled = build("any_angle", 0.0);
    let mut grid = build("jps", 0.0);
    let (mut n_ways, mut sums, mut worst) = (0.0, [0.0; 3], [0.0_f64; 3]);
    for seed in 0..40 {
        let mut rng = Rng(seed);
        let mut map = Map::free(26, 20);
        for _ in 0..9 {
            let at = Cell::new(rng.below(26), rng.below(20));
            let size = (1 + rng.below(6), 1 + rng.below(6));
            map.block(at, Cell::new(at.x + size.0, at.y + size.1));
        }
        let start = map.free_near(Cell::new(rng.below(6), rng.below(20)));
        let goal = map.free_near(Cell::new(20 + rng.below(6), rng.below(20)));
        let optimum = shortest(&map, start, goal);
        if !optimum.is_finite() {
            continue;
        }
        n_ways += 1.0;
        let query = query(&map, start, goal);
        let mut path = CellPath::default();
        let planners = [&mut theta, &mut pulled, &mut grid];
        for ((planner, sum), worst) in planners.into_iter().zip(&mut sums).zip(&mut worst) {
            planner
                .plan(&query, &mut |_| Control::Go, &mut path)
                .unwrap();
            let ratio = path.length_cells() / optimum;
            assert!(
                ratio >= 1.0 - 1e-5,
                "seed {seed}: shorter than the shortest, {ratio}"
            );
            *sum += ratio;
            *worst = worst.max(ratio);
        }
    }
    let means = sums.map(|sum| sum / n_ways);
    println!(
        "{n_ways} ways; over the shortest: lazy_theta, any_angle, jps: mean {means:.4?}, worst {worst:.4?}"
    );
    assert!(n_ways > 25.0);
    assert!(means[0] < 1.01 && worst[0] < 1.06, "{means:?}, {worst:?}");
    assert!(means[1] < 1.04 && worst[1] < 1.0824, "{means:?}, {worst:?}");
    assert!(means[1] < means[2], "pulling gains: {means:?}");
}

#[test]
fn pulling_keeps_the_clearance_that_the_costs_asked_for() {
    let map = Map::office(300, 200, 5);
    let start = map.free_near(Cell::new(20, 20));
    let goal = map.free_near(Cell::new(280, 180));
    let query = query(&map, start, goal);
    let mut path = CellPath::default();
    let mut cells_and_dear = |key: &str| {
        build(key, 3.0)
            .plan(&query, &mut |_| Control::Go, &mut path)
            .unwrap();
        let mut dear = 0;
        for pair in path.cells.windows(2) {
            supercover(pair[0], pair[1], |crossing| {
                let cost = map.view().get(crossing.cell).unwrap().cost;
                assert!(cost < 253, "{key}: {:?} is blocked", crossing.cell);
                dear += u32::from(cost > 126);
            });
        }
        (path.cells.len(), dear, path.length_cells())
    };
    let (n_steps, dear_steps, length_of_steps) = cells_and_dear("mpgaa");
    let (n_pulled, dear_pulled, length_pulled) = cells_and_dear("any_angle");
    assert!(
        n_pulled * 3 < n_steps,
        "{n_pulled} corners of {n_steps} cells"
    );
    assert!(length_pulled <= length_of_steps + 1e-9);
    assert!(
        dear_pulled <= dear_steps + dear_steps / 4 + 2,
        "{dear_pulled} cells of more than half the largest cost, were {dear_steps}"
    );
}

#[test]
fn anytime_has_a_way_soon_and_the_cheapest_in_the_end() {
    let map = Map::office(300, 200, 5);
    let start = map.free_near(Cell::new(20, 20));
    let goal = map.free_near(Cell::new(280, 180));
    let query = query(&map, start, goal);
    let (mut path, mut best) = (CellPath::default(), CellPath::default());
    let optimum = build("c_astar", 3.0)
        .plan(&query, &mut |_| Control::Go, &mut best)
        .unwrap();
    let stats = build("anytime", 3.0)
        .plan(&query, &mut |_| Control::Go, &mut path)
        .unwrap();
    assert!((stats.cost - optimum.cost).abs() < 1e-3 * optimum.cost);
    let found: Vec<_> = stats
        .improved
        .iter()
        .filter(|improvement| improvement.expanded > 0)
        .collect();
    assert!(found.len() >= 2, "{stats:?}");
    assert!(
        found
            .windows(2)
            .all(|pair| pair[0].cost > pair[1].cost && pair[0].expanded < pair[1].expanded)
    );
    assert!(
        found[0].expanded * 2 < optimum.expanded,
        "{stats:?}, {optimum:?}"
    );
    // Stopped after the first way: that one is the answer.
    let first = found[0].expanded;
    let mut stopped = CellPath::default();
    let mut stop = |expansions: zeronav_global_planner::Expansions| {
        if expansions.0 > first {
            Control::Stop
        } else {
            Control::Go
        }
    };
    let result = build("anytime", 3.0)
        .plan(&query, &mut stop, &mut stopped)
        .unwrap();
    assert!(result.cost >= optimum.cost * (1.0 - 1e-3));
    assert!(result.cost <= found[0].cost + 1e-9);
    assert_eq!(stopped.cells.last(), Some(&goal));
}
