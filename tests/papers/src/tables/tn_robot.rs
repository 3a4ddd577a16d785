//! [TN] table 3: a robot in a corridor of 5.5 m x 6 m on a map of 0.1 m, whose obstacles are not known.
//! Blocks stand for them, grown by a robot of two cells. The paper's figures are against A*; Dijkstra, which
//! its robot's planner was before, stands beside it.

use crate::maps::{Ends, MapFamily, MapSpec};
use crate::row::Figure;
use crate::solve::{Method, Way};
use crate::table::{Context, Outcome, TableError, change, draw, figure, paired, time};
use crate::timing;
use crate::verdict::{Printed, Standing};

/// Measures the table.
pub(super) fn run(context: &mut Context) -> Result<Outcome, TableError> {
    let mut outcome = Outcome::default();
    let spec = MapSpec {
        family: MapFamily::Blocky,
        size: [55, 60],
        ratio: 0.15,
        ends: Ends::Corners,
    };
    let (mazes, place) = draw(context, "TN", "3", &spec)?;
    let hybrid = Method::new("hybrid", "tn_hyb");
    let ours = hybrid.ways(&mazes.mazes)?;
    for (name, heuristic, is_printed) in [("A*", "euclid", true), ("Dijkstra", "zero", false)] {
        let base = Method::new(name, "tn_a8").with(serde_json::json!({ "heuristic": heuristic }));
        let algorithm = format!("hybrid with ladder vs {name}");
        let lengths = paired(&base.ways(&mazes.mazes)?, &ours, |way: &Way| way.length);
        let lengths = change(lengths);
        let printed = |value| {
            if is_printed {
                Printed::Change(value)
            } else {
                Printed::Nothing
            }
        };
        let mut put = |figure: Figure| {
            let figure = figure.standing(Standing::NotComparable);
            outcome.rows.push(place.row(figure));
        };
        put(
            figure("C5", "length", &algorithm, printed(-0.039_99), lengths)
                .noting("one drive of a real robot in a corridor that is not described"),
        );
        for changes in timing::changes(&base, &[&hybrid], &mazes.mazes)? {
            put(time("C5", &algorithm, printed(-0.113_04), changes));
        }
    }
    Ok(outcome)
}
