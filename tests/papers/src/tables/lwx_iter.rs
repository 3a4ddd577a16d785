//! [LWX] figure 16: how many steps an interim goal may take.

use crate::maps::MapFamily;
use crate::rollout::{bodies, waypoints};
use crate::solve::Method;
use crate::stats;
use crate::table::{Context, Outcome, TableError, corners, draw, excluded, figure};
use crate::verdict::{Printed, Standing};
use serde_json::json;
use zeronav_local_planner::papers::lwx_loop::{Loop, Restart, run as iterate};
use zeronav_local_planner::papers::potential::Gains;
use zeronav_local_planner::papers::walk::{End, Trace, Walk};

/// Printed changes of time against L = 10.
const HUNDRED: f64 = 2.88;
const ONE: f64 = -0.30;

/// Measures the figure.
// long: the rows of one table, one after the other
pub(super) fn run(context: &mut Context) -> Result<Outcome, TableError> {
    let mut outcome = Outcome::default();
    let greedy = Method::new("greedy", "lwx_oa");
    let spec = corners(MapFamily::Blocky, [20, 20], 0.2);
    let (mazes, place) = draw(context, "LWX", "fig16", &spec)?;
    let ways = greedy.ways(&mazes.mazes)?;
    for (early_exit, standing, note) in [
        (
            false,
            Standing::Artefact,
            "a loop that does not stop on arrival",
        ),
        (true, Standing::Fair, "a loop that stops on arrival"),
    ] {
        let runs: Vec<[Trace; 3]> = mazes
            .mazes
            .iter()
            .zip(&ways)
            .filter_map(|(maze, way)| {
                let (around, route) = (bodies(maze), waypoints(maze, way.as_ref().ok()?));
                let run = |per_unit| {
                    let how = Loop {
                        walk: Walk {
                            limit: 1_000_000,
                            ..Walk::LWX
                        },
                        per_unit,
                        early_exit,
                        restart: Restart::Robot,
                        falls_back: false,
                    };
                    iterate(Gains::LWX, &around, &route, &how)
                };
                Some([1.0, 10.0, 100.0].map(run))
            })
            .collect();
        let steps = |trace: &Trace| crate::table::count(trace.steps as u64);
        let arrived = |trace: &Trace| trace.end == End::Reached;
        for (name, index, printed) in [
            ("L = 100 vs L = 10", 2, HUNDRED),
            ("L = 1 vs L = 10", 0, ONE),
        ] {
            let changes: Vec<f64> = runs
                .iter()
                // One that gives up is compared all the same, as in the paper.
                .filter(|run| arrived(&run[1]) && (index == 0 || arrived(&run[index])))
                .map(|run| steps(&run[index]) / steps(&run[1]) - 1.0)
                .collect();
            let left = excluded(changes.len(), mazes.mazes.len());
            outcome.rows.push(
                place.row(
                    figure(
                        "C6",
                        "steps",
                        name,
                        Printed::Change(printed),
                        (stats::mean(&changes), left),
                    )
                    .standing(if index == 2 { standing } else { Standing::Fair })
                    .noting(note)
                    .with(json!({ "early_exit": early_exit })),
                ),
            );
        }
        for (name, index, printed) in [("L = 1", 0, 0.0), ("L = 10", 1, 1.0), ("L = 100", 2, 1.0)] {
            let hits = runs.iter().filter(|run| arrived(&run[index])).count();
            let share = (
                stats::share(hits, runs.len()),
                excluded(runs.len(), mazes.mazes.len()),
            );
            outcome.rows.push(
                place.row(
                    figure(
                        "C6",
                        "arrives (share)",
                        name,
                        Printed::Share(printed),
                        share,
                    )
                    .noting(note)
                    .with(json!({ "early_exit": early_exit })),
                ),
            );
        }
    }
    Ok(outcome)
}
