//! The same aisle in a map of 4000 x 4000 cells: what the size of a map costs.

use super::bench::{Bench, Measured, on_shipped, write_scenario};
use super::extract::{list, memory, table};
use super::record::{Row, Table};
use super::spread::Figure;
use super::{rounds, trials};
use crate::workspace;
use core::fmt::Write;
use serde_json::Value;

/// Rounds; in each both maps have a start and trials, and each begins one in turn.
const ROUNDS: usize = 4;
const TRIALS: usize = 20;

/// The maps, and how many cells they have.
const MAPS: [&str; 2] = ["the warehouse", "the warehouse among rooms"];
const CELLS: [u32; 2] = [600 * 400, 4000 * 4000];

/// Rooms along a side of the large map, and their size from wall to wall. [m]
const ROOMS: i32 = 20;
const ROOM_M: f64 = 10.0;

/// The rooms in whose place the warehouse is, from the lower left corner.
const WAREHOUSE: [i32; 2] = [3, 2];

/// Walls, and the doors in those between two rooms. [m]
const WALL_M: f64 = 0.2;
const DOOR_M: f64 = 1.2;

/// Lines of the warehouse, and what takes their place: a larger area, and a door in the east wall. It
/// is the only one, so there is no further way round an aisle.
const CHANGES: [(&str, &str); 2] = [
    (
        "area_m = [[0.0, 0.0], [30.0, 20.0]]",
        "area_m = [[0.0, 0.0], [200.0, 200.0]]",
    ),
    (
        "    { kind = \"box\", centre_m = [29.9, 10.0], size_m = [0.2, 19.6] },\n",
        "    { kind = \"box\", centre_m = [29.9, 1.4], size_m = [0.2, 2.4] },\n    \
         { kind = \"box\", centre_m = [29.9, 11.8], size_m = [0.2, 16.0] },\n",
    ),
];

/// Ends the drive soon after the start, which is all that it is for.
const SHORT: &str = "goals = [{ pose = [4.0, 8.5, 0.0] }]\nexpect.obstacle_replans_min = 0\n";

/// Latencies, memory and start in both maps.
pub(super) fn make(bench: &mut Bench) -> Result<Measured, String> {
    let file = workspace().join("launch/worlds/warehouse.toml");
    let warehouse = std::fs::read_to_string(&file);
    let warehouse = warehouse.map_err(|error| format!("{}: {error}", file.display()))?;
    let big = write_scenario("big_map", &scenario(&warehouse)?)?;
    let big_start = format!("base = \"big_map.toml\"\n{SHORT}");
    let starts = [
        write_scenario("start", &(on_shipped("blocked_aisle") + SHORT))?,
        write_scenario("start_big_map", &big_start)?,
    ];
    let mut results: [Vec<Value>; 2] = Default::default();
    let mut started: [Vec<Value>; 2] = Default::default();
    let mut rows = rounds::in_turn(ROUNDS, &MAPS, |at| {
        started[at].push(bench.zeronav(&["run", &starts[at]])?);
        let result = bench.trials(["blocked_aisle", &big][at], TRIALS)?;
        results[at].push(result.clone());
        Ok(result)
    })?;
    for (row, results) in rows.iter_mut().zip(&results) {
        let p50_us = |hop| trials::hop_p50_us(results, hop);
        row.figures
            .extend([p50_us("global_planner"), p50_us("mapping")]);
    }
    let hops = ["`global_planner` p50 [us]", "`mapping` p50 [us]"];
    let columns = [&rounds::COLUMNS[..], &hops].concat();
    Ok(Measured::tables(vec![
        table("map", &columns, rows),
        memories(&results),
        sizes(&results, &started),
    ]))
}

/// The memory of every process in both maps.
fn memories(results: &[Vec<Value>; 2]) -> Table {
    let [mut rows, big] = results.each_ref().map(|results| memory(results).rows);
    for (row, big) in rows.iter_mut().zip(big) {
        row.figures.extend(big.figures);
    }
    table(
        "memory",
        &MAPS
            .map(|map| format!("{map} [MB]"))
            .each_ref()
            .map(String::as_str),
        rows,
    )
}

/// What a cell costs, and how long the start takes.
fn sizes(results: &[Vec<Value>; 2], started: &[Vec<Value>; 2]) -> Table {
    let sum = |result: &Value| -> Option<f64> {
        let services = list(result, "services").iter();
        let own: Option<f64> = services
            .map(|service| service["memory_peak_bytes"].as_f64())
            .sum();
        Some(own? + result["shared_memory_bytes"].as_f64()?)
    };
    let row = |at: usize| {
        let median = |results: &[Value], of: &dyn Fn(&Value) -> Option<f64>| {
            Figure::median(&results.iter().filter_map(of).collect::<Vec<f64>>())
        };
        let (results, started) = (&results[at], &started[at]);
        let cells = f64::from(CELLS[at]);
        Row {
            name: MAPS[at].to_owned(),
            n: started.len() as u64,
            figures: vec![
                Figure::plain(Some(cells)),
                median(results, &|result| Some(sum(result)? / 1e6)),
                median(results, &|result| Some(sum(result)? / cells)),
                median(started, &|result| done_ms(result, " ready")),
                median(started, &|result| done_ms(result, "first path")),
                median(started, &|result| done_ms(result, "first motion")),
            ],
        }
    };
    let columns = [
        "cells",
        "memory of the run [MB]",
        "of it per cell [bytes]",
        "all ready [ms]",
        "first path [ms]",
        "first motion [ms]",
    ];
    table("size and start", &columns, vec![row(0), row(1)])
}

/// From the command until the last stage of the start whose name ends so was done. [ms]
fn done_ms(result: &Value, end: &str) -> Option<f64> {
    let stages = list(&result["start_up"], "stages").iter();
    let such = stages.filter(|stage| {
        stage["name"]
            .as_str()
            .is_some_and(|name| name.ends_with(end))
    });
    such.filter_map(|stage| stage["to_ms"].as_f64())
        .reduce(f64::max)
}

/// What lies on one side of a wall.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Side {
    Nothing,
    Warehouse,
    Room,
}

impl Side {
    fn of([x, y]: [i32; 2]) -> Self {
        if ![x, y].iter().all(|place| (0..ROOMS).contains(place)) {
            Self::Nothing
        } else if x < WAREHOUSE[0] && y < WAREHOUSE[1] {
            Self::Warehouse
        } else {
            Self::Room
        }
    }
}

/// The aisle in the warehouse with a door in its east wall, behind which rooms fill the map.
fn scenario(warehouse: &str) -> Result<String, String> {
    let mut world = warehouse.to_owned();
    for (old, new) in CHANGES {
        if !world.contains(old) {
            return Err(format!("the warehouse has no line `{}`", old.trim()));
        }
        world = world.replacen(old, new, 1);
    }
    let world = world.trim_end().strip_suffix(']');
    let world = world.ok_or("the warehouse does not end with its shapes")?;
    Ok(format!(
        "{}{world}    # Rooms.\n{}]\n",
        on_shipped("blocked_aisle"),
        walls()
    ))
}

/// The walls of the rooms. The warehouse has its own.
fn walls() -> String {
    let mut text = String::new();
    let edge_m = f64::from(ROOMS) * ROOM_M - WALL_M / 2.0;
    let lines = (0..=ROOMS).flat_map(|line| (0..ROOMS).map(move |place| (line, place)));
    for (axis, (line, place)) in [0, 1]
        .into_iter()
        .flat_map(|axis| lines.clone().map(move |at| (axis, at)))
    {
        let side = |line| {
            Side::of(if axis == 0 {
                [line, place]
            } else {
                [place, line]
            })
        };
        let sides = [side(line - 1), side(line)];
        if sides.contains(&Side::Warehouse) || !sides.contains(&Side::Room) {
            continue;
        }
        let across_m = (f64::from(line) * ROOM_M).clamp(WALL_M / 2.0, edge_m);
        let from_m = f64::from(place) * ROOM_M;
        // Doors lie here and there, so that no line of sight leads through many rooms.
        let door_m = from_m + 3.0 + f64::from((3 * line + place) % 4);
        let pieces = if sides.contains(&Side::Nothing) {
            vec![[from_m, from_m + ROOM_M]]
        } else {
            vec![[from_m, door_m], [door_m + DOOR_M, from_m + ROOM_M]]
        };
        for [from_m, to_m] in pieces {
            let (mut centre_m, mut size_m) = (
                [across_m, f64::midpoint(from_m, to_m)],
                [WALL_M, to_m - from_m],
            );
            if axis == 1 {
                centre_m.reverse();
                size_m.reverse();
            }
            let _ = writeln!(
                text,
                "    {{ kind = \"box\", centre_m = {centre_m:?}, size_m = {size_m:?} }},"
            );
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use zeronav_msgs::{GridGeometry, Pose};
    use zeronav_scenario::Scenario;
    use zeronav_world::{Occupancy, StaticMap};

    /// The cell that holds a point.
    fn index(g: &GridGeometry, [x_m, y_m]: [f64; 2]) -> usize {
        let cell = g.cell_at(Pose::new(x_m, y_m, 0.0).point());
        cell.and_then(|cell| g.index_of(cell)).expect("a cell")
    }

    /// The cells that can be reached from a point without leaving free ones.
    fn reached(map: &StaticMap, from_m: [f64; 2]) -> Vec<bool> {
        let g = &map.geometry;
        let from = index(g, from_m);
        let width = g.width as usize;
        let mut reached = vec![false; map.cells.len()];
        reached[from] = true;
        let mut open = vec![from];
        while let Some(at) = open.pop() {
            // The map has walls all around, so nothing is left by its edge.
            for next in [at - 1, at + 1, at - width, at + width] {
                if map.cells[next] == Occupancy::Free && !reached[next] {
                    reached[next] = true;
                    open.push(next);
                }
            }
        }
        reached
    }

    #[test]
    fn one_door_leads_to_every_room_of_the_large_map() {
        let warehouse = std::fs::read_to_string(workspace().join("launch/worlds/warehouse.toml"));
        let text = scenario(&warehouse.expect("the warehouse")).expect("a scenario");
        let file = write_scenario("big_map_of_test", &text).expect("written");
        let file = workspace().join(file);
        let scenario = Scenario::load(&file.display().to_string()).expect("a scenario");
        let world = scenario.validate().expect("one that can work").world;
        let shipped = Scenario::load("blocked_aisle").expect("a scenario");
        assert_eq!(scenario.trials, shipped.trials);
        let small = shipped.validate().expect("one that can work").world;
        let cells = [&small, &world].map(|world| {
            let g = world.geometry();
            g.width * g.height
        });
        assert_eq!(cells, CELLS);

        let mut map = world.rasterise();
        let g = map.geometry;
        let rooms: Vec<usize> = (0..ROOMS)
            .flat_map(|x| (0..ROOMS).map(move |y| [x, y]))
            .filter(|at| Side::of(*at) == Side::Room)
            .map(|at| at.map(|place| (f64::from(place) + 0.5) * ROOM_M))
            .map(|at_m| index(&g, at_m))
            .collect();
        assert_eq!(rooms.len(), 394);
        let start = [scenario.start.x_m, scenario.start.y_m];
        let open = reached(&map, start);
        assert!(
            rooms.iter().all(|room| open[*room]),
            "a room without a door"
        );
        for row in 0..24 {
            map.cells[index(&g, [29.9, 2.625 + 0.05 * f64::from(row)])] = Occupancy::Occupied;
        }
        let closed = reached(&map, start);
        assert!(
            closed[index(&g, [27.0, 8.5])],
            "the goal is in the warehouse"
        );
        assert!(!rooms.iter().any(|room| closed[*room]), "a second door");
    }
}
