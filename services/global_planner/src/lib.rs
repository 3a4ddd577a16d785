//! The global planner: ways over the whole map, and the decision when to look for another.
//!
//! A cycle reads like this: [`replan::Replanner::begin`] says whether to search and why,
//! [`replan::Replanner::search`] asks the planner chosen from [`table::PLANNERS`],
//! [`replan::Replanner::settle`] holds the result against the newest map before it counts.
//! Everything here is pure: no clock, no files, no threads, no processes; the same sequence of
//! calls gives the same paths.
//!
//! Coordinates are those of the map: metres in the `map` frame, cells as columns and rows.

pub mod any_angle;
pub mod anytime;
pub mod astar;
mod bits;
mod bucket_queue;
mod canonical;
pub mod change;
pub mod config;
pub mod corridor;
pub mod ends;
mod goal_cell;
mod goal_field;
mod ground;
pub mod jps;
mod jump_map;
mod jumps;
pub mod lazy_theta;
mod limits;
pub mod line;
mod map_options;
pub mod moves;
pub mod movingai;
pub mod mpgaa;
mod node_pool;
mod options;
mod padded;
pub mod papers;
pub mod plan;
pub mod planner;
pub mod policy;
mod pull;
mod reach;
mod regions;
mod remarks;
pub mod replan;
mod search;
mod sight;
mod smooth;
pub mod table;
pub mod waypoints;
mod window;

pub use config::GlobalPlannerConfig;
pub use corridor::{Corridor, Legality};
pub use map_options::MapOptions;
pub use options::PlannerOptions;
pub use papers::options::PaperOptions;
pub use plan::{Plan, Target};

pub use planner::{
    CellPath, Control, CornerRule, Expansions, GlobalPlanner, Improvement, PlanError, PlanQuery,
    PlanStats, Unknown,
};
pub use remarks::{Fallback, Remarks};
pub use replan::{News, Replanner, Request, Situation, Step};
pub use table::{EXACT, PLANNERS, PlannerRow, UnknownPlanner, row_of};
