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
    pub run: fn(&mut Context) -> Result<Outcome, TableError>,
}

/// Every table.
pub const TABLES: &[Table] = &[
    Table {
        paper: "BAO",
        number: "1",
        title: "30 x 20 cells, 15.8 % obstacles",
        is_driven: false,
        run: |context| bao::run(context, 0),
    },
    Table {
        paper: "BAO",
        number: "2",
        title: "50 x 40 cells, 14.1 % obstacles",
        is_driven: false,
        run: |context| bao::run(context, 1),
    },
    Table {
        paper: "BAO",
        number: "3",
        title: "50 x 40 cells, 38.9 % obstacles",
        is_driven: false,
        run: |context| bao::run(context, 2),
    },
    Table {
        paper: "BAO",
        number: "4",
        title: "100 x 100 cells, 30 % obstacles",
        is_driven: false,
        run: |context| bao::run(context, 3),
    },
    Table {
        paper: "TN",
        number: "1",
        title: "the hybrid against A*, 20 x 20 cells",
        is_driven: false,
        run: tn::run,
    },
    Table {
        paper: "TN",
        number: "3",
        title: "the robot's corridor, simulated on the grid",
        is_driven: false,
        run: tn_robot::run,
    },
    Table {
        paper: "ZM",
        number: "1",
        title: "weighted searches against A*, 20 x 20 cells",
        is_driven: false,
        run: zm::run,
    },
    Table {
        paper: "LWX",
        number: "1",
        title: "the greedy search against A*, 20 x 20 cells",
        is_driven: false,
        run: |context| lwx::run(context, 0),
    },
    Table {
        paper: "LWX",
        number: "2",
        title: "the same, another map",
        is_driven: false,
        run: |context| lwx::run(context, 1),
    },
    Table {
        paper: "LWX",
        number: "3",
        title: "the same, 40 x 40 cells",
        is_driven: false,
        run: |context| lwx::run(context, 2),
    },
    Table {
        paper: "LWX",
        number: "4",
        title: "the greedy search against the bidirectional one",
        is_driven: false,
        run: |context| lwx::run(context, 3),
    },
    Table {
        paper: "JU",
        number: "1",
        title: "lengths of potential-field paths, 15 x 15 cells",
        is_driven: false,
        run: ju::lengths,
    },
    Table {
        paper: "JU",
        number: "2",
        title: "their times",
        is_driven: false,
        run: ju::times,
    },
    Table {
        paper: "LWX",
        number: "5",
        title: "the fusion against the ant colony",
        is_driven: false,
        run: |context| lwx_fusion::run(context, "5"),
    },
    Table {
        paper: "LWX",
        number: "6",
        title: "the fusion against the random tree",
        is_driven: false,
        run: |context| lwx_fusion::run(context, "6"),
    },
    Table {
        paper: "LWX",
        number: "fig16",
        title: "steps per interim goal",
        is_driven: false,
        run: lwx_iter::run,
    },
    Table {
        paper: "ZM",
        number: "2",
        title: "an obstacle appears at (12, 7)",
        is_driven: true,
        run: |context| zm_dyn::run(context, "2"),
    },
    Table {
        paper: "ZM",
        number: "3",
        title: "an obstacle appears at (5, 5)",
        is_driven: true,
        run: |context| zm_dyn::run(context, "3"),
    },
    Table {
        paper: "JU",
        number: "dyn",
        title: "three discs cross the map",
        is_driven: true,
        run: ju_dyn::run,
    },
    Table {
        paper: "LWX",
        number: "dyn",
        title: "twenty discs that appear or move",
        is_driven: true,
        run: lwx_dyn::run,
    },
    Table {
        paper: "BAO",
        number: "dyn",
        title: "discs on the path and across it",
        is_driven: true,
        run: bao_dyn::run,
    },
];
