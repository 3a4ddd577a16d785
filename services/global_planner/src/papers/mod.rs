//! The global planners of five papers, restated and corrected.
//!
//! | key | paper |
//! |---|---|
//! | \[TN\] | three-neighbour search A* combined with artificial potential fields |
//! | \[JU\] | Ju, Luo, Yan: fusion of artificial potential fields and A* |
//! | \[ZM\] | Zhang, Meng, 2022: A* with an improved artificial potential field |
//! | \[LWX\] | Liu, Wang, Xu, 2022: optimised A*, artificial potential field, least squares |
//! | \[BAO\] | Bao et al., 2023: improved A* |
//!
//! A planner is a file here and a row of [`crate::PLANNERS`]. Those that are a best-first search
//! are a [`best_first::Recipe`] each; the others are a [`on_map::Solver`]. What all of them share
//! (ends, inflation at the start, proofs, cost) stands in [`on_map`].
//!
//! Where a map has costs beside free and blocked, a step costs as in [`crate::astar`]; the papers
//! know no costs, and on their maps every price is one.

pub mod bao_full;
pub mod best_first;
pub mod field;
pub mod flood;
pub mod heuristic;
pub mod lwx_aco;
pub mod lwx_bi;
pub mod lwx_bi_true;
pub mod lwx_oa;
pub mod lwx_rrt;
pub mod on_map;
pub mod options;
pub mod regularise;
pub mod sight;
pub mod spline;
pub mod tn_3n;
pub mod tn_apf;
pub mod tn_hyb;
pub mod variants;
pub mod weight;
