//! The global planner: ways over the whole map, and the decision when to look for another.
//!
//! A cycle reads like this: [`replan::Replanner::begin`] says whether to search and why,
//! [`replan::Replanner::search`] asks the planner chosen from [`table::PLANNERS`],
//! [`replan::Replanner::settle`] holds the result against the newest map before it counts.
//! Everything here is pure: no clock, no files, no threads, no processes; the same sequence of
//! calls gives the same paths.
//!
//! Coordinates are those of the map: metres in the `map` frame, cells as columns and rows.

pub mod astar;
mod bucket_queue;
pub mod change;
pub mod config;
pub mod corridor;
pub mod ends;
pub mod line;
pub mod moves;
pub mod papers;
pub mod plan;
pub mod planner;
pub mod replan;
mod search;
pub mod table;
pub mod waypoints;

pub use config::{ConfigError, GlobalPlannerConfig};
pub use corridor::{Corridor, Legality};
pub use papers::{Fallback, PaperOptions, Remarks};
pub use plan::{Plan, Target};

pub use planner::{
    CellPath, Control, CornerRule, Expansions, GlobalPlanner, PlanError, PlanQuery, PlanStats,
    Unknown,
};
pub use replan::{News, Replanner, Request, Situation, Step};
pub use table::{PLANNERS, PlannerOptions, PlannerRow, UnknownPlanner, row_of};
