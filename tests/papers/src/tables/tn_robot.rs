//! [TN] table 3: a robot in a corridor of 5.5 m x 6 m on a map of 0.1 m, whose obstacles are not known.
//! Blocks stand for them, grown by a robot of two cells.

use crate::maps::{Ends, MapFamily, MapSpec};
use crate::solve::{Method, Way};
use crate::table::{Context, Outcome, TableError, change, draw, figure, paired};
use crate::verdict::{Printed, Standing};
use crate::{stats, timing};

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
    let dijkstra =
        Method::new("Dijkstra", "tn_a8").with(serde_json::json!({ "heuristic": "zero" }));
    let (ours, base) = (hybrid.ways(&mazes.mazes)?, dijkstra.ways(&mazes.mazes)?);
    let lengths = change(paired(&base, &ours, |way: &Way| way.length));
    let name = "hybrid with ladder vs Dijkstra";
    let times = timing::changes(&dijkstra, &[&hybrid], &mazes.mazes)?;
    let time = (times.first().and_then(|changes| stats::mean(changes)), 0.0);
    for (metric, printed, ours) in [("length", -0.039_99, lengths), ("time", -0.113_04, time)] {
        outcome.rows.push(
            place.row(
                figure("C5", metric, name, Printed::Change(printed), ours)
                    .standing(Standing::NotComparable)
                    .noting("one drive of a real robot in a corridor that is not described"),
            ),
        );
    }
    Ok(outcome)
}
