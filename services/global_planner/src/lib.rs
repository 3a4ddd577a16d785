//! The global planner: from a map and a goal to a path, and the decision when to replan.
//!
//! Everything here is pure: no clock, no files, no threads, no processes; the same sequence of
//! calls gives the same paths. Coordinates are those of the map: metres in the `map` frame, cells
//! as columns and rows.
//!
//! # From map and goal to path
//!
//! A cycle of the process reads from top to bottom:
//!
//! | step | file |
//! |---|---|
//! | decide whether to search, and why | `replan`: [`Replanner::begin`], ten rules |
//! | see what the map did since the last search | `change` |
//! | hold the current path against the map | `corridor` |
//! | ask the chosen planner | `replan`: [`Replanner::search`]; `table`: a row of [`PLANNERS`] |
//! | find both ends: out of the inflation, into the tolerance | `ends`, `goal_cell` |
//! | lead out of the inflation, prove that there is no path | `ground`: `reach` over `regions` |
//! | name the cell that would have to open, and what closes it | `barrier`, `blockers` |
//! | search | the planner's own file, below |
//! | round the path | `smooth` |
//! | turn cells into waypoints, an error into a status | `plan`, `waypoints` |
//! | accept the result, or search once more | `replan`: [`Replanner::settle`] |
//!
//! # The searches
//!
//! What a planner is, is defined in `planner`: [`GlobalPlanner`], its query, answer, budget and errors.
//!
//! - Over cell costs: `astar` (on `search`) from scratch; `mpgaa` (on `goal_field`) keeps the
//!   cost-to-go from search to search; `anytime` and `any_angle` build on the two.
//! - Over free cells alone, which `bits` holds 64 to a word: `jps` chooses between `jumps` (on
//!   `jump_map`) and `canonical`; `lazy_theta` goes by lines of sight (`sight`).
//! - `policy` chooses between `mpgaa` and `jps` by what the map is like.
//! - `papers`: the planners of five papers, each a method on `papers::on_map`.
//!
//! Shared ground: `moves` (steps, octile distance, price of cost), `node_pool`, `bucket_queue`
//! (open list), `limits` (budget), `line` (cells under a line). Parameters are declared beside what
//! they steer and collected in `options` and `config`.

#[cfg(test)]
extern crate self as zeronav_global_planner;
#[cfg(test)]
#[path = "../tests/support/mod.rs"]
mod support;

mod any_angle;
mod anytime;
mod astar;
mod barrier;
mod bits;
mod blockers;
mod bucket_queue;
mod canonical;
mod change;
mod config;
mod corridor;
mod ends;
mod goal_cell;
mod goal_field;
mod ground;
mod jps;
mod jump_map;
mod jumps;
mod lazy_theta;
mod limits;
mod line;
mod look;
mod map_options;
pub mod moves;
mod mpgaa;
mod node_pool;
mod options;
mod padded;
mod papers;
mod past_corners;
mod plan;
mod planner;
mod policy;
mod pull;
mod reach;
mod regions;
mod remarks;
mod replan;
mod search;
mod sight;
mod smooth;
mod table;
#[cfg(test)]
mod test_map;
mod waypoints;

pub use config::GlobalPlannerConfig;
pub use corridor::{Corridor, Legality};
pub use jps::{Choose, Jps};
pub use line::supercover;
pub use map_options::MapOptions;
pub use mpgaa::Mpgaa;
pub use options::PlannerOptions;
pub use papers::options::PaperOptions;
pub use plan::{Blocked, Plan, Target};
pub use planner::{
    CellPath, Control, CornerRule, Expansions, GlobalPlanner, Improvement, PlanError, PlanQuery,
    PlanStats, Unknown,
};
pub use remarks::{Fallback, Remarks};
pub use replan::{BuildError, News, Replanner, Request, Situation, Step};
pub use table::{EXACT, PLANNERS, PlannerRow, UnknownPlanner, row_of};
