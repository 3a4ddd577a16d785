//! Maps by seed, PAPERS 0.7, and the cheapest ways on them by relaxing until nothing changes.

use crate::CornerRule;
use crate::moves::{STEPS, price};
use crate::support::{Map, Rng, of_cost};
use std::collections::VecDeque;
use zeronav_msgs::map::COST_LETHAL;
use zeronav_msgs::{Cell, MapCell};

/// Opposite corners.
pub(crate) fn corners(map: &Map) -> (Cell, Cell) {
    let (width, height) = map.geometry.size();
    (Cell::new(0, 0), Cell::new(width - 1, height - 1))
}

/// Random cells until `percent` of the map is blocked; the corners stay free.
pub(crate) fn iid(width: u32, height: u32, percent: i32, seed: u64) -> Map {
    blocky_of(width, height, percent, 1, seed)
}

/// Random rectangles with sides of 1 to 4 cells.
pub(crate) fn blocky(width: u32, height: u32, percent: i32, seed: u64) -> Map {
    blocky_of(width, height, percent, 4, seed)
}

fn blocky_of(width: u32, height: u32, percent: i32, side_max: i32, seed: u64) -> Map {
    let mut map = Map::free(width, height);
    let mut rng = Rng(seed);
    let (w, h) = map.geometry.size();
    let ends = corners(&map);
    let mut left = w * h * percent / 100;
    while left > 0 {
        let at = Cell::new(rng.below(w), rng.below(h));
        let (across, up) = (1 + rng.below(side_max), 1 + rng.below(side_max));
        for y in at.y..at.y + up {
            for x in at.x..at.x + across {
                let cell = Cell::new(x, y);
                let is_free = map.view().get(cell).is_some_and(|c| c.cost == 0);
                if is_free && left > 0 && cell != ends.0 && cell != ends.1 {
                    map.put(cell, of_cost(COST_LETHAL));
                    left -= 1;
                }
            }
        }
    }
    map
}

/// Gives every free cell a random cost.
pub(crate) fn with_costs(mut map: Map, seed: u64) -> Map {
    let mut rng = Rng(seed);
    for cell in &mut map.cells {
        if cell.cost == 0 {
            *cell = of_cost(u8::try_from(rng.below(253)).unwrap());
        }
    }
    map
}

/// One map of a family, by number: iid and blocky in turn, of growing density.
pub(crate) fn any(width: u32, height: u32, n: u64) -> Map {
    let percent = 5 + i32::try_from(n % 7).unwrap() * 5;
    if n.is_multiple_of(2) {
        iid(width, height, percent, n)
    } else {
        blocky(width, height, percent, n)
    }
}

/// Least cost between two cells, infinite when there is no way. [cells]
pub(crate) fn least_cost(map: &Map, rule: CornerRule, weight: f64, ends: (Cell, Cell)) -> f64 {
    let blocked = |cell: Cell| map.view().get(cell).is_none_or(MapCell::blocks_centre);
    let index = |cell: Cell| map.geometry.index_of(cell).unwrap();
    let mut cost = vec![f64::INFINITY; map.cells.len()];
    cost[index(ends.0)] = 0.0;
    let mut changed = VecDeque::from([ends.0]);
    while let Some(from) = changed.pop_front() {
        for (dx, dy) in STEPS {
            let to = Cell::new(from.x + dx, from.y + dy);
            let beside = [Cell::new(to.x, from.y), Cell::new(from.x, to.y)].map(blocked);
            if blocked(to) || (dx != 0 && dy != 0 && !rule.permits(beside[0], beside[1])) {
                continue;
            }
            let length = f64::from(dx * dx + dy * dy).sqrt();
            let through = cost[index(from)] + length * price(map.cells[index(to)].cost, weight);
            if through < cost[index(to)] - 1e-12 {
                cost[index(to)] = through;
                changed.push_back(to);
            }
        }
    }
    cost[index(ends.1)]
}
