//! [TN] table 1: the hybrid of three-neighbour walk and attraction against A* over eight neighbours.

use crate::figure::Drawing;
use crate::maps::{Ends, MapFamily, MapSpec};
use crate::row::{Place, Row};
use crate::solve::{Method, Way, Ways};
use crate::table::{
    Context, Outcome, TableError, change, count, draw, failures, figure, paired, safety, solved,
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

/// Measures the table.
pub(super) fn run(context: &mut Context) -> Result<Outcome, TableError> {
    let mut outcome = Outcome::default();
    let bare = Method::new("hybrid", "tn_hyb").with(json!({ "walk": { "ladder": false } }));
    let printed = Method::new("hybrid as printed", "tn_hyb")
        .with(json!({ "walk": { "ladder": false }, "literal": true }));
    let ladder = Method::new("hybrid with ladder", "tn_hyb");
    let astar = Method::new("A*", "tn_a8").under(CornerRule::Allow);
    let matched = Method::new("A*, same corners", "tn_a8").with(json!({ "heuristic": "octile" }));
    let pulled = Method::new("pulled A*", "c_los");
    for family in context.families.clone() {
        for ends in [Ends::Corners, Ends::Random(14)] {
            for ratio in RATIOS {
                let spec = MapSpec {
                    family,
                    size: [20, 20],
                    ratio,
                    ends,
                };
                let (mazes, place) = draw(context, "TN", "1", &spec)?;
                let ways = [
                    bare.ways(&mazes.mazes)?,
                    ladder.ways(&mazes.mazes)?,
                    astar.ways(&mazes.mazes)?,
                    matched.ways(&mazes.mazes)?,
                    pulled.ways(&mazes.mazes)?,
                    printed.ways(&mazes.mazes)?,
                ];
                rows(&mut outcome.rows, &place, &ways);
                let times = timing::changes(&astar, &[&bare, &ladder], &mazes.mazes)?;
                for (name, changes) in ["hybrid vs A*", "hybrid with ladder vs A*"]
                    .iter()
                    .zip(times)
                {
                    let ours = (stats::mean(&changes), 0.0);
                    let figure = figure("C2", "time", name, Printed::Change(TIME), ours);
                    let note = "ratio of medians of 31, interleaved";
                    outcome.rows.push(place.row(figure.noting(note)));
                }
                let is_drawn = family == MapFamily::Blocky && ends == Ends::Corners;
                if is_drawn && outcome.drawing.is_none() {
                    let named = [
                        ("hybrid", &ways[0]),
                        ("A*", &ways[2]),
                        ("A*, same corners", &ways[3]),
                        ("pulled A*", &ways[4]),
                    ];
                    outcome.drawing = Drawing::of(&mazes.mazes, &named);
                }
            }
        }
    }
    Ok(outcome)
}

fn rows(rows: &mut Vec<Row>, place: &Place, ways: &[Ways; 6]) {
    let [bare, ladder, astar, matched, pulled, memoryless] = ways;
    let evaluated = |way: &Way| count(way.stats.evaluated);
    let by_length = |way: &Way| way.length;
    for (name, ours) in [("hybrid vs A*", bare), ("hybrid with ladder vs A*", ladder)] {
        let changes = change(paired(astar, ours, evaluated));
        let printed = Printed::Change(EVALUATED);
        rows.push(place.row(figure("C1", "cells examined", name, printed, changes)));
        let aux = |way: &Way| evaluated(way) + count(way.stats.remarks.aux_cells);
        let changes = change(paired(astar, ours, aux));
        let metric = "cells examined, sight lines and floods counted";
        rows.push(
            place.row(
                figure("C1", metric, name, Printed::Nothing, changes)
                    .noting("the paper does not count them"),
            ),
        );
    }
    let printed = Printed::Change(LENGTH);
    for (name, base, note) in [
        (
            "hybrid vs A*",
            astar,
            "A* cuts corners, the hybrid does not",
        ),
        (
            "hybrid vs A*, same corners",
            matched,
            "optimal A*, same corner rule",
        ),
        ("hybrid vs pulled A*", pulled, "any angle"),
    ] {
        let changes = change(paired(base, bare, by_length));
        rows.push(place.row(figure("C3", "length", name, printed, changes).noting(note)));
    }
    let changes = change(paired(matched, pulled, by_length));
    let name = "pulled A* vs A*, same corners";
    rows.push(place.row(
        figure("C3", "length", name, Printed::Nothing, changes).noting("what any angle is worth"),
    ));
    for (name, ours) in [
        ("hybrid as printed", memoryless),
        ("hybrid", bare),
        ("hybrid with ladder", ladder),
    ] {
        let success = (solved(ours), 0.0);
        rows.push(place.row(
            figure("C4", "success (share)", name, Printed::Nothing, success).noting(failures(ours)),
        ));
    }
    let fallbacks: Vec<&Way> = ladder.iter().flatten().collect();
    let helped = fallbacks
        .iter()
        .filter(|way| way.stats.remarks.fallback != zeronav_global_planner::Fallback::None);
    let ours = (stats::share(helped.count(), fallbacks.len()), 0.0);
    let metric = "fallback (share)";
    rows.push(place.row(figure(
        "C4",
        metric,
        "hybrid with ladder",
        Printed::Nothing,
        ours,
    )));
    rows.extend(safety("safety", "hybrid", bare).map(|figure| place.row(figure)));
}
