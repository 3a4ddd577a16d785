//! The cost-to-go on small maps.

#![allow(clippy::print_stdout, reason = "the seed of a failed run")]

use super::*;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg32;
use zeronav_casts::Cast;
use zeronav_msgs::{Cell, GridGeometry, MapCell};

const GEOMETRY: GridGeometry = GridGeometry {
    origin_x_m: 0.0,
    origin_y_m: 0.0,
    resolution_m: 0.1,
    width: 80,
    height: 60,
};

/// A wall along x = 4 m from y = 0 to `top_m`; the path goes round its upper end.
fn world(top_m: f64) -> Vec<MapCell> {
    let mut cells = vec![MapCell::default(); GEOMETRY.len()];
    for (index, cell) in cells.iter_mut().enumerate() {
        let at = GEOMETRY.centre_of(Cell::new(index.to_i32() % 80, index.to_i32() / 80));
        let (dx, dy) = ((at.x - 4.0).abs() - 0.1, (at.y - top_m).max(0.0));
        cell.clearance_mm = (dx.max(0.0).hypot(dy).min(1.5) * 1000.0).to_u16();
    }
    cells
}

fn cost_to_go(cells: &[MapCell]) -> CostToGo {
    let corners = [(1.0, 1.0), (1.0, 5.5), (7.0, 5.5), (7.0, 1.0)];
    let path = corners.map(|(x_m, y_m)| Waypoint {
        x_m,
        y_m,
        ..Waypoint::default()
    });
    let mut tracker = PathTracker::new();
    let position = Point2::new(1.0, 1.0);
    let place = tracker.advance(1, &path, position).expect("a path");
    let mut cost_to_go = CostToGo::default();
    let inputs = CostToGoInputs {
        map: MapView {
            geometry: &GEOMETRY,
            cells,
        },
        map_cells: 1,
        path: &path,
        geometry: 1,
        place,
        position,
        reach_m: 5.0,
        inscribed_m: 0.25,
        soft_m: 0.2,
    };
    assert!(cost_to_go.update(&tracker, &inputs));
    assert!(!cost_to_go.update(&tracker, &inputs), "nothing changed");
    let elsewhere = CostToGoInputs {
        map_cells: 2,
        ..inputs
    };
    assert!(
        !cost_to_go.update(&tracker, &elsewhere),
        "nothing that matters"
    );
    let mut other = cells.to_vec();
    // Half a metre before the wall, on its soft side.
    other[35].clearance_mm -= 100;
    let view = |cells| MapView {
        geometry: &GEOMETRY,
        cells,
    };
    let moved = CostToGoInputs {
        map: view(&other),
        map_cells: 3,
        ..inputs
    };
    assert!(cost_to_go.update(&tracker, &moved), "the map changed");
    let back = CostToGoInputs {
        map_cells: 4,
        ..inputs
    };
    assert!(cost_to_go.update(&tracker, &back), "and changed back");
    cost_to_go
}

/// Relaxes every edge until nothing changes.
fn oracle(cost_to_go: &CostToGo, seeds: &[(u32, u32)]) -> Vec<u32> {
    let side = cost_to_go.side;
    let mut costs = vec![UNREACHED; cost_to_go.factors.len()];
    for (cost, index) in seeds {
        let known = &mut costs[*index as usize];
        *known = (*known).min(*cost);
    }
    loop {
        let before = costs.clone();
        for index in 0..side * side {
            let cost = costs[index.to_usize()];
            if cost == UNREACHED {
                continue;
            }
            for (dx, dy, length) in STEPS {
                let (x, y) = (index % side + dx, index / side + dy);
                if x < 0 || y < 0 || x >= side || y >= side {
                    continue;
                }
                let next = (y * side + x).to_usize();
                let factor = u32::from(cost_to_go.factors[next]);
                if factor > 0 {
                    costs[next] = costs[next].min(cost + length * factor / 256);
                }
            }
        }
        if costs == before {
            return costs;
        }
    }
}

#[test]
fn buckets_give_the_costs_of_full_relaxation() {
    for seed in 0..20 {
        println!("seed {seed}");
        let mut random = Pcg32::seed_from_u64(seed);
        let side = 24;
        let factors: Vec<u16> = (0..side * side)
            .map(|_| match random.random_range(0..4) {
                0 => 0,
                _ => random.random_range(256..=768),
            })
            .collect();
        let mut seeds: Vec<(u32, u32)> = (0..6)
            .map(|_| (random.random_range(0..40_000), random.random_range(0..576)))
            .collect();
        seeds.sort_unstable_by_key(|seed| core::cmp::Reverse(seed.0));
        let mut cost_to_go = CostToGo {
            side,
            cell_m: 1.0,
            costs: vec![UNREACHED; factors.len()],
            factors,
            seeds: seeds.clone(),
            ..CostToGo::default()
        };
        for (cost, index) in &seeds {
            let known = &mut cost_to_go.costs[*index as usize];
            *known = (*known).min(*cost);
        }
        let expected = oracle(&cost_to_go, &seeds);
        cost_to_go.spread();
        assert_eq!(cost_to_go.costs, expected);
    }
}

#[test]
fn on_the_path_the_way_is_what_is_left_of_it() {
    let cost_to_go = cost_to_go(&world(4.0));
    for (x, y, left_m) in [(7.0, 3.0, 2.0), (7.0, 4.5, 3.5)] {
        let to_go_m = f64::from(cost_to_go.at(Point2::new(x, y)).expect("on the path"));
        assert!((to_go_m - left_m).abs() < 0.1, "{to_go_m}");
    }
    // Corners may be cut, but never is the way longer than along the path.
    for (x, y, left_m) in [(1.0, 1.0, 15.0), (1.0, 3.0, 13.0), (2.5, 5.5, 9.0)] {
        let to_go_m = f64::from(cost_to_go.at(Point2::new(x, y)).expect("on the path"));
        assert!(
            to_go_m < left_m + 0.1 && to_go_m > 0.6 * left_m,
            "{to_go_m}"
        );
    }
}

#[test]
fn before_a_wall_the_way_leads_back_round_it() {
    let cost_to_go = cost_to_go(&world(4.0));
    // 1 m before the wall, 2 m from the path's last leg behind it.
    let far = cost_to_go.at(Point2::new(3.0, 1.5)).expect("free");
    let near = cost_to_go.at(Point2::new(3.5, 1.5)).expect("free");
    assert!(far > 6.0, "{far}");
    assert!(near > far - 0.3, "{near} {far}");
    assert_eq!(cost_to_go.at(Point2::new(4.0, 1.5)), None);
}
