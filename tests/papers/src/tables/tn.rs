//! [TN] table 1: the hybrid of three-neighbour walk and attraction against A* over eight neighbours.
//!
//! The text leaves open what a walk knows of the cells that it has searched. All three readings are
//! measured, each as the paper says its method is better: cells, time and length; and how often it arrives.

use crate::figure::Drawing;
use crate::maps::{Ends, MapFamily, MapSpec, Maze};
use crate::row::{Place, Row};
use crate::solve::{Fault, Method, Way, Ways};
use crate::table::{
    Context, Outcome, TableError, change, count, draw, excluded, failures, figure, paired, safety,
    solved, time,
};
use crate::verdict::Printed;
use crate::{stats, timing};
use serde_json::json;
use zeronav_global_planner::CornerRule;

/// Shares of obstacles in the paper.
const RATIOS: [f64; 3] = [0.15, 0.25, 0.35];

/// Means of the printed ranges.
const EVALUATED: f64 = -0.8885;
const TIME: f64 = -0.7705;
const LENGTH: f64 = -0.0558;

/// The readings of "grids that have been searched" by their names in the rows and in the options.
const READINGS: [(&str, &str); 3] = [
    ("hybrid, memoryless", "none"),
    ("hybrid, visited", "visited"),
    ("hybrid, backtracking", "backtracking"),
];

/// Name of the last reading where other methods step in when it fails.
const LADDER: &str = "hybrid with ladder";

/// What the readings are compared with.
struct Bases {
    /// A* of the paper, which cuts corners.
    astar: Method,
    /// Optimal A* under the rule of the hybrid.
    matched: Method,
    /// The same, pulled taut.
    pulled: Method,
}

/// The ways of everything on the maps of a kind.
struct Found {
    /// Of every reading and of the ladder, by name.
    hybrids: Vec<(&'static str, Ways)>,
    astar: Ways,
    matched: Ways,
    pulled: Ways,
}

fn hybrids() -> Vec<Method> {
    let reading = |(name, memory): (&'static str, &str)| {
        Method::new(name, "tn_hyb").with(json!({ "walk": { "ladder": false, "memory": memory } }))
    };
    let ladder = Method::new(LADDER, "tn_hyb");
    READINGS.into_iter().map(reading).chain([ladder]).collect()
}

/// Measures the table.
pub(super) fn run(context: &mut Context) -> Result<Outcome, TableError> {
    let mut outcome = Outcome::default();
    let hybrids = hybrids();
    let bases = Bases {
        astar: Method::new("A*", "tn_a8").under(CornerRule::Allow),
        matched: Method::new("A*, same corners", "tn_a8").with(json!({ "heuristic": "octile" })),
        pulled: Method::new("pulled A*", "c_los"),
    };
    let families = context.families.clone();
    for family in families.iter().copied().chain([MapFamily::Concave]) {
        for ends in [Ends::Corners, Ends::Random(14)] {
            for ratio in RATIOS {
                let spec = MapSpec {
                    family,
                    size: [20, 20],
                    ratio,
                    ends,
                };
                // Traps of up to eight cells leave no room for as many of them.
                let is_concave = family == MapFamily::Concave;
                if is_concave && (ends != Ends::Corners || ratio > 0.15) {
                    continue;
                }
                let (mazes, place) = draw(context, "TN", "1", &spec)?;
                let found = ways(&hybrids, &bases, &mazes.mazes)?;
                if is_concave {
                    traps(&mut outcome.rows, &place, &found);
                    continue;
                }
                rows(&mut outcome.rows, &place, &found);
                times(
                    &mut outcome.rows,
                    &place,
                    (&bases, &hybrids[..]),
                    &mazes.mazes,
                )?;
                let is_drawn = family == MapFamily::Blocky && ends == Ends::Corners;
                if is_drawn && outcome.drawing.is_none() {
                    let mut named: Vec<(&str, &Ways)> = found
                        .hybrids
                        .iter()
                        .map(|(name, ways)| (*name, ways))
                        .collect();
                    named.extend([("A*", &found.astar), ("pulled A*", &found.pulled)]);
                    outcome.drawing = Drawing::of(&mazes.mazes, &named);
                }
            }
        }
    }
    Ok(outcome)
}

fn ways(hybrids: &[Method], bases: &Bases, mazes: &[Maze]) -> Result<Found, Fault> {
    let of = |method: &Method| Ok((method.name, method.ways(mazes)?));
    Ok(Found {
        hybrids: hybrids.iter().map(of).collect::<Result<_, Fault>>()?,
        astar: bases.astar.ways(mazes)?,
        matched: bases.matched.ways(mazes)?,
        pulled: bases.pulled.ways(mazes)?,
    })
}

fn times(
    rows: &mut Vec<Row>,
    place: &Place,
    (bases, hybrids): (&Bases, &[Method]),
    mazes: &[Maze],
) -> Result<(), Fault> {
    let methods: Vec<&Method> = hybrids.iter().collect();
    let changes = timing::changes(&bases.astar, &methods, mazes)?;
    for (method, changes) in hybrids.iter().zip(changes) {
        let name = format!("{} vs A*", method.name);
        rows.push(place.row(time("C2", &name, Printed::Change(TIME), changes)));
    }
    Ok(())
}

/// What the paper says of concave obstacles: the hybrid does not fall into them.
fn traps(rows: &mut Vec<Row>, place: &Place, found: &Found) {
    for (name, ways) in &found.hybrids {
        let success = (solved(ways), 0.0);
        rows.push(place.row(
            figure("C7", "success (share)", name, Printed::Always, success).noting(failures(ways)),
        ));
    }
}

fn rows(rows: &mut Vec<Row>, place: &Place, found: &Found) {
    for (name, ways) in &found.hybrids {
        effort(rows, place, name, (ways, &found.astar));
        lengths(rows, place, name, (ways, found));
        let success = (solved(ways), 0.0);
        rows.push(place.row(
            figure("C4", "success (share)", name, Printed::Nothing, success).noting(failures(ways)),
        ));
        let algorithm = format!("{name} vs A*");
        let turns = change(paired(&found.astar, ways, |way| 1.0 + count(way.turns())));
        rows.push(
            place.row(
                figure("C6", "turning points", &algorithm, Printed::Less, turns)
                    .noting("fewer are claimed, no number is printed; the end is counted"),
            ),
        );
        rows.extend(safety("safety", name, ways).map(|figure| place.row(figure)));
    }
    let name = "pulled A* vs A*, same corners";
    let changes = change(paired(&found.matched, &found.pulled, |way| way.length));
    rows.push(place.row(
        figure("C3", "length", name, Printed::Nothing, changes).noting("what any angle is worth"),
    ));
    let ladder = found.hybrids.iter().filter(|(name, _)| *name == LADDER);
    let fallbacks: Vec<&Way> = ladder.flat_map(|(_, ways)| ways.iter().flatten()).collect();
    let left = excluded(fallbacks.len(), found.astar.len());
    let helped = fallbacks
        .iter()
        .filter(|way| way.stats.remarks.fallback != zeronav_global_planner::Fallback::None);
    let ours = (stats::share(helped.count(), fallbacks.len()), left);
    let metric = "fallback (share)";
    rows.push(place.row(figure("C4", metric, LADDER, Printed::Nothing, ours)));
}

/// Cells examined by a hybrid against those of A*.
fn effort(rows: &mut Vec<Row>, place: &Place, name: &str, (ours, astar): (&Ways, &Ways)) {
    let algorithm = format!("{name} vs A*");
    let evaluated = |way: &Way| count(way.stats.evaluated);
    let changes = change(paired(astar, ours, evaluated));
    let printed = Printed::Change(EVALUATED);
    rows.push(place.row(figure("C1", "cells examined", &algorithm, printed, changes)));
    let aux = |way: &Way| evaluated(way) + count(way.stats.remarks.aux_cells);
    let changes = change(paired(astar, ours, aux));
    let metric = "cells examined, sight lines and floods counted";
    rows.push(
        place.row(
            figure("C1", metric, &algorithm, Printed::Nothing, changes)
                .noting("the paper does not count them"),
        ),
    );
}

/// Its length against each of the bases.
fn lengths(rows: &mut Vec<Row>, place: &Place, name: &str, (ours, found): (&Ways, &Found)) {
    let printed = Printed::Change(LENGTH);
    for (base, ways, printed, note) in [
        (
            "A*",
            &found.astar,
            printed,
            "A* cuts corners, the hybrid does not",
        ),
        (
            "A*, same corners",
            &found.matched,
            printed,
            "optimal A*, same corner rule",
        ),
        ("pulled A*", &found.pulled, Printed::Nothing, "any angle"),
    ] {
        let algorithm = format!("{name} vs {base}");
        let changes = change(paired(ways, ours, |way: &Way| way.length));
        rows.push(place.row(figure("C3", "length", &algorithm, printed, changes).noting(note)));
    }
}
