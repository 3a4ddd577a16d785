//! The tables of the papers: one file and one row each.

mod bao;
mod bao_dyn;
mod ju;
mod ju_dyn;
mod lwx;
mod lwx_dyn;
mod lwx_fusion;
mod lwx_iter;
mod tn;
mod tn_robot;
mod zm;
mod zm_dyn;
mod zm_walk;

pub use lwx_fusion::plan as fusion_plan;

use crate::table::{Context, Outcome, TableError};

/// Measures a table.
type Run = fn(&mut Context) -> Result<Outcome, TableError>;

/// A table that can be measured.
#[derive(Debug, Clone, Copy)]
pub struct Table {
    /// Paper.
    pub paper: &'static str,
    /// Number, or name of a figure.
    pub number: &'static str,
    /// What it shows.
    pub title: &'static str,
    /// True when the real stack drives it.
    pub is_driven: bool,
    /// Measures it.
    pub run: Run,
}

/// A table of planners on maps.
const fn planned(
    paper: &'static str,
    number: &'static str,
    title: &'static str,
    run: Run,
) -> Table {
    Table {
        paper,
        number,
        title,
        is_driven: false,
        run,
    }
}

/// A table of drives of the real stack.
const fn driven(paper: &'static str, number: &'static str, title: &'static str, run: Run) -> Table {
    Table {
        is_driven: true,
        ..planned(paper, number, title, run)
    }
}

/// Every table.
pub const TABLES: &[Table] = &[
    planned("BAO", "1", "30 x 20 cells, 15.8 % obstacles", |it| {
        bao::run(it, 0)
    }),
    planned("BAO", "2", "50 x 40 cells, 14.1 % obstacles", |it| {
        bao::run(it, 1)
    }),
    planned("BAO", "3", "50 x 40 cells, 38.9 % obstacles", |it| {
        bao::run(it, 2)
    }),
    planned("BAO", "4", "100 x 100 cells, 30 % obstacles", |it| {
        bao::run(it, 3)
    }),
    planned("TN", "1", "the hybrid against A*, 20 x 20 cells", tn::run),
    planned(
        "TN",
        "3",
        "the robot's corridor, simulated on the grid",
        tn_robot::run,
    ),
    planned(
        "ZM",
        "1",
        "weighted searches against A*, 20 x 20 cells",
        zm::run,
    ),
    planned(
        "LWX",
        "1",
        "the greedy search against A*, 20 x 20 cells",
        |it| lwx::run(it, 0),
    ),
    planned("LWX", "2", "the same, another map", |it| lwx::run(it, 1)),
    planned("LWX", "3", "the same, 40 x 40 cells", |it| lwx::run(it, 2)),
    planned(
        "LWX",
        "4",
        "the greedy search against the bidirectional one",
        |it| lwx::run(it, 3),
    ),
    planned(
        "JU",
        "1",
        "lengths of potential-field paths, 15 x 15 cells",
        ju::lengths,
    ),
    planned("JU", "2", "their times", ju::times),
    planned("LWX", "5", "the fusion against the ant colony", |it| {
        lwx_fusion::run(it, "5")
    }),
    planned("LWX", "6", "the fusion against the random tree", |it| {
        lwx_fusion::run(it, "6")
    }),
    planned("LWX", "fig16", "steps per interim goal", lwx_iter::run),
    driven("ZM", "2", "an obstacle appears at (12, 7)", |it| {
        zm_dyn::run(it, "2")
    }),
    driven("ZM", "3", "an obstacle appears at (5, 5)", |it| {
        zm_dyn::run(it, "3")
    }),
    driven("JU", "dyn", "three discs cross the map", ju_dyn::run),
    driven(
        "LWX",
        "dyn",
        "twenty discs that appear or move",
        lwx_dyn::run,
    ),
    driven(
        "BAO",
        "dyn",
        "discs on the path and across it",
        bao_dyn::run,
    ),
];
