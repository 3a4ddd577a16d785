//! [LWX] tables 1 to 4: the "optimised A*", which is a greedy search without an open list, against A*
//! (1 to 3) and against the bidirectional search to the middle (4).

use crate::figure::Drawing;
use crate::maps::MapFamily;
use crate::solve::{Method, Way, Ways};
use crate::table::{
    Context, Outcome, TableError, change, corners, count, draw, excluded, failures, figure, paired,
    safety, solved,
};
use crate::verdict::Printed;
use crate::{stats, timing};
use serde_json::json;

struct Printout {
    table: &'static str,
    side: u32,
    time: f64,
    /// Searched nodes, where they are printed.
    nodes: Option<f64>,
}

const PRINTED: [Printout; 4] = [
    Printout {
        table: "1",
        side: 20,
        time: -0.655,
        nodes: None,
    },
    Printout {
        table: "2",
        side: 20,
        time: -0.548,
        nodes: None,
    },
    Printout {
        table: "3",
        side: 40,
        time: -0.706,
        nodes: None,
    },
    Printout {
        table: "4",
        side: 20,
        time: -0.652,
        nodes: Some(70.0 / 103.0 - 1.0),
    },
];

/// Measures a table.
pub(super) fn run(context: &mut Context, index: usize) -> Result<Outcome, TableError> {
    let printed = &PRINTED[index];
    let mut outcome = Outcome::default();
    let greedy = Method::new("greedy", "lwx_oa").with(json!({ "greedy": { "dead_end": "fail" } }));
    let back = Method::new("greedy with backtracking", "lwx_oa")
        .with(json!({ "greedy": { "dead_end": "backtrack" } }));
    let base = match printed.table {
        "4" => Method::new("bidirectional", "lwx_bi"),
        _ => Method::new("A*", "lwx_ta"),
    };
    let optimum = Method::new("A*", "tn_a8").with(json!({ "heuristic": "octile" }));
    for family in context.families.clone() {
        for ratio in [0.1, 0.2, 0.3] {
            let spec = corners(family, [printed.side; 2], ratio);
            let (mazes, place) = draw(context, "LWX", printed.table, &spec)?;
            let mazes = &mazes.mazes;
            let (of_greedy, of_back) = (greedy.ways(mazes)?, back.ways(mazes)?);
            let (of_base, of_best) = (base.ways(mazes)?, optimum.ways(mazes)?);
            let rows = &mut outcome.rows;
            let claim = if printed.table == "4" { "C4" } else { "C1" };
            let name = format!("greedy vs {}", base.name);
            let nodes = |way: &Way| count(way.stats.expanded);
            let changes = change(paired(&of_base, &of_greedy, nodes));
            let of_nodes = Printed::Change(printed.nodes.unwrap_or(printed.time));
            let note = if printed.nodes.is_none() {
                "printed is time"
            } else {
                ""
            };
            rows.push(place.row(figure(claim, "expanded", &name, of_nodes, changes).noting(note)));
            let times = timing::changes(&base, &[&greedy], mazes)?;
            let time = (times.first().and_then(|changes| stats::mean(changes)), 0.0);
            rows.push(
                place.row(
                    figure(claim, "time", &name, Printed::Change(printed.time), time)
                        .noting("ratio of medians of 31, interleaved"),
                ),
            );
            let name = "greedy vs optimal A*";
            let changes = change(paired(&of_best, &of_greedy, |way: &Way| way.length));
            rows.push(place.row(figure("C2", "length", name, Printed::Nothing, changes)));
            rows.push(place.row(figure(
                "C2",
                "same length as A* (share)",
                "greedy, where it arrives",
                Printed::Share(1.0),
                same(&of_best, &of_greedy),
            )));
            let success = (solved(&of_greedy), 0.0);
            rows.push(
                place.row(
                    figure(
                        "C3",
                        "success (share)",
                        "greedy",
                        Printed::Share(1.0),
                        success,
                    )
                    .noting(failures(&of_greedy)),
                ),
            );
            let name = "greedy with backtracking vs optimal A*";
            let changes = change(paired(&of_best, &of_back, |way: &Way| way.length));
            rows.push(place.row(figure("C3", "length", name, Printed::Nothing, changes)));
            rows.extend(safety("safety", "greedy", &of_greedy).map(|figure| place.row(figure)));
            if family == MapFamily::Blocky && outcome.drawing.is_none() {
                let named = [
                    ("greedy", &of_greedy),
                    ("greedy with backtracking", &of_back),
                    (base.name, &of_base),
                ];
                outcome.drawing = Drawing::of(mazes, &named);
            }
        }
    }
    Ok(outcome)
}

/// Share of the maps that both solve on which both ways are equally long.
fn same(best: &Ways, ours: &Ways) -> (Option<stats::Estimate>, f64) {
    let pairs: Vec<bool> = best
        .iter()
        .zip(ours)
        .filter_map(|pair| match pair {
            (Ok(best), Ok(ours)) => Some((best.length - ours.length).abs() < 1.0e-6),
            _ => None,
        })
        .collect();
    let equal = pairs.iter().filter(|equal| **equal).count();
    (
        stats::share(equal, pairs.len()),
        excluded(pairs.len(), best.len()),
    )
}
