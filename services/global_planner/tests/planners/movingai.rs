//! Questions in the form of the `MovingAI` collection: lengths as known, two-sided.
//!
//! A sample; all of them: `cargo run --release -p zeronav-global-planner --example movingai --
//! --data DIR`.

#[path = "../../../../tests/data/folder.rs"]
mod data;
#[path = "../support/movingai.rs"]
mod reader;

use data::{external_data, files, shipped_data};
use reader::{GridMap, Scenario};
use std::collections::BTreeMap;
use std::path::Path;
use zeronav_global_planner::{
    CellPath, Control, CornerRule, EXACT, PlanQuery, PlannerOptions, Unknown, row_of,
};
use zeronav_msgs::map::COST_FREE;
use zeronav_msgs::{Cell, CellRect};

/// Questions per map: of the planners that need microseconds, and of the others.
const SAMPLES: [usize; 2] = [8, 1];

/// A map and its questions.
fn read(file: &Path) -> (GridMap, Vec<Scenario>) {
    let name = file.display();
    let map = GridMap::parse(&std::fs::read_to_string(file).unwrap())
        .unwrap_or_else(|error| panic!("{name}: {error}"));
    let questions = std::fs::read_to_string(format!("{name}.scen")).unwrap();
    let questions = Scenario::parse_all(&questions, &map.geometry)
        .unwrap_or_else(|error| panic!("{name}.scen: {error}"));
    assert!(!questions.is_empty(), "{name}.scen asks nothing");
    (map, questions)
}

/// Every exact planner answers a sample of the questions with the known lengths; how many were
/// asked.
fn every_exact_planner_finds_the_known_lengths(folder: &Path) -> usize {
    let mut asked = 0;
    for file in files(folder, "map") {
        let name = file.display();
        let (map, questions) = read(&file);
        let (width, height) = map.geometry.size();
        let whole = CellRect {
            min: Cell::new(0, 0),
            max: Cell::new(width, height),
        };
        for key in EXACT {
            let mut planner = (row_of(key).unwrap().build)(&PlannerOptions::default());
            planner.map_changed(&map.view(), &[whole]);
            let mut path = CellPath::default();
            let sample = SAMPLES[usize::from(!["jps", "canonical"].contains(key))];
            for n in 0..sample.min(questions.len()) {
                // From the middle of each part: neither the nearest nor the farthest of all.
                let question = questions[(2 * n + 1) * questions.len() / (2 * sample)];
                let query = PlanQuery {
                    map: map.view(),
                    start: map.pose(question.start),
                    goal: map.pose(question.goal),
                    tolerance_m: 0.1,
                    unknown: Unknown::Free,
                    corner_rule: CornerRule::ForbidAny,
                };
                planner
                    .plan(&query, &mut |_| Control::Go, &mut path)
                    .unwrap_or_else(|error| panic!("{key}, {name}: {error}"));
                let error = path.length_cells() - question.optimal_cells;
                assert!(
                    error.abs() <= 0.006,
                    "{key}, {name}, {question:?}: off by {error}"
                );
                asked += 1;
            }
        }
    }
    asked
}

/// Lengths from a cell to all others by sweeps over the whole map until nothing changes any more:
/// no queue, no heuristic, nothing in common with what made the files or with the planners.
/// Infinite where no way leads.
fn lengths_by_sweeps(map: &GridMap, from: Cell) -> Vec<f64> {
    let geometry = &map.geometry;
    let (width, height) = geometry.size();
    let free = |cell: Cell| {
        let index = geometry.index_of(cell);
        index.is_some_and(|index| map.cells[index].cost == COST_FREE)
    };
    let mut lengths = vec![f64::INFINITY; geometry.len()];
    lengths[geometry.index_of(from).unwrap()] = 0.0;
    loop {
        let mut changed = false;
        for y in 0..height {
            for x in (0..width).filter(|x| free(Cell::new(*x, y))) {
                let index = geometry.index_of(Cell::new(x, y)).unwrap();
                for (dx, dy) in (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| (dx, dy))) {
                    let beside = [
                        Cell::new(x + dx, y),
                        Cell::new(x, y + dy),
                        Cell::new(x + dx, y + dy),
                    ];
                    if beside.into_iter().all(free) {
                        let other = lengths[geometry.index_of(beside[2]).unwrap()];
                        let length = other + f64::from(dx).hypot(f64::from(dy));
                        if length < lengths[index] - 1.0e-9 {
                            lengths[index] = length;
                            changed = true;
                        }
                    }
                }
            }
        }
        if !changed {
            return lengths;
        }
    }
}

#[test]
fn the_shipped_lengths_are_those_of_a_search_by_sweeps() {
    let mut asked = 0;
    for file in files(&shipped_data("movingai"), "map") {
        let (map, questions) = read(&file);
        let mut by_start = BTreeMap::new();
        for question in questions {
            let lengths = by_start
                .entry((question.start.y, question.start.x))
                .or_insert_with(|| lengths_by_sweeps(&map, question.start));
            let length = lengths[map.geometry.index_of(question.goal).unwrap()];
            let error = length - question.optimal_cells;
            assert!(error.abs() < 1.0e-6, "{question:?}: {length}");
            asked += 1;
        }
    }
    assert_eq!(asked, 120);
}

#[test]
fn every_exact_planner_finds_the_shipped_lengths() {
    let asked = every_exact_planner_finds_the_known_lengths(&shipped_data("movingai"));
    assert!(asked >= 60, "{asked} questions");
}

#[test]
#[ignore = "needs movingai at $ZERONAV_DATA"]
fn every_exact_planner_finds_the_lengths_on_external_data() {
    let asked = every_exact_planner_finds_the_known_lengths(&external_data("movingai"));
    assert!(asked >= 100, "{asked} questions");
}
