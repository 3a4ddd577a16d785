//! The questions of the `MovingAI` collection, when it is there: lengths as known, two-sided.
//!
//! A sample; all of them: `cargo run --release -p zeronav-global-planner --example movingai --
//! --data DIR`.

#![allow(clippy::print_stdout, reason = "a skip is said aloud")]

use std::path::{Path, PathBuf};
use zeronav_global_planner::movingai::{GridMap, Scenario};
use zeronav_global_planner::{
    CellPath, Control, CornerRule, EXACT, PlanQuery, PlannerOptions, Unknown, row_of,
};
use zeronav_msgs::{Cell, CellRect};

/// Questions per map: of the planners that need microseconds, and of the others.
const SAMPLES: [usize; 2] = [8, 1];

fn folder() -> Option<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let folders = [
        root.join("../shared/data/movingai"),
        root.join("../../shared/data/movingai"),
    ];
    let found = folders.into_iter().find(|folder| folder.is_dir());
    if found.is_none() {
        println!("SKIPPED: ../shared/data/movingai is not there");
    }
    found
}

#[test]
fn every_exact_planner_finds_the_known_lengths() {
    let Some(folder) = folder() else {
        return;
    };
    let mut asked = 0;
    for entry in std::fs::read_dir(&folder).unwrap().flatten() {
        let file = entry.path();
        if file.extension().is_none_or(|extension| extension != "map") {
            continue;
        }
        let name = file.display();
        let map = GridMap::parse(&std::fs::read_to_string(&file).unwrap())
            .unwrap_or_else(|error| panic!("{name}: {error}"));
        let questions = std::fs::read_to_string(format!("{name}.scen")).unwrap();
        let questions = Scenario::parse_all(&questions, &map.geometry)
            .unwrap_or_else(|error| panic!("{name}.scen: {error}"));
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
    assert!(asked >= 100, "{asked} questions");
}
