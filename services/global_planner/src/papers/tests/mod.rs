//! Acceptance tests of the papers' planners: the name of a test begins with the key of its row in
//! the feature table.

mod astar;
mod bao;
mod edges;
mod generate;
mod lwx;
mod spline;
mod tn;
mod zm;

use crate::line::supercover;
use crate::support::Map;
use crate::{
    CellPath, Control, CornerRule, Expansions, GlobalPlanner, PlanError, PlanQuery, PlanStats,
    PlannerOptions, Unknown, row_of,
};
use zeronav_msgs::{Cell, MapCell};

/// All budget there is.
fn go(_: Expansions) -> Control {
    Control::Go
}

/// Options under which cost is length.
fn plain() -> PlannerOptions {
    PlannerOptions {
        cost_weight: 0.0,
        ..PlannerOptions::default()
    }
}

fn query(map: &Map, rule: CornerRule, from: Cell, to: Cell) -> PlanQuery<'_> {
    PlanQuery {
        map: map.view(),
        start: map.pose(from),
        goal: map.pose(to),
        tolerance_m: 0.01,
        unknown: Unknown::Free,
        corner_rule: rule,
    }
}

/// A path and its cost in cells.
struct Found {
    path: CellPath,
    cost: f64,
}

impl Found {
    fn stats(&self) -> &PlanStats {
        &self.path.stats
    }
}

/// Plans with a row of the table.
fn plan(
    key: &str,
    options: &PlannerOptions,
    map: &Map,
    rule: CornerRule,
    (from, to): (Cell, Cell),
) -> Result<Found, PlanError> {
    let mut planner = (row_of(key).expect("a row").build)(options);
    plan_with(planner.as_mut(), map, rule, (from, to))
}

fn plan_with(
    planner: &mut dyn GlobalPlanner,
    map: &Map,
    rule: CornerRule,
    (from, to): (Cell, Cell),
) -> Result<Found, PlanError> {
    let mut path = CellPath::default();
    let stats = planner.plan(&query(map, rule, from, to), &mut go, &mut path)?;
    Ok(Found {
        path,
        cost: stats.cost / map.geometry.resolution_m,
    })
}

/// Asserts that a way is legal: no line from entry to entry touches an obstacle's square, and where
/// one passes a corner, the rule permits it. Judged by the map alone.
#[track_caller]
fn assert_legal(found: &Found, map: &Map, rule: CornerRule, what: &str) {
    let blocked = |cell| map.view().get(cell).is_none_or(MapCell::blocks_centre);
    for pair in found.path.cells.windows(2) {
        supercover(pair[0], pair[1], |crossing| {
            assert!(!blocked(crossing.cell), "{what}: {:?}", crossing.cell);
            if let Some([one, other]) = crossing.touched {
                assert!(
                    rule.permits(blocked(one), blocked(other)),
                    "{what}: a corner"
                );
            }
        });
    }
}

/// A counter as a number to calculate with.
fn count(n: u64) -> f64 {
    f64::from(u32::try_from(n).expect("small maps"))
}

#[track_caller]
fn assert_close(value: f64, expected: f64, tolerance: f64, what: &str) {
    assert!(
        (value - expected).abs() <= tolerance,
        "{what}: {value} instead of {expected}"
    );
}
