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
//! (ends, inflation at the start, proofs, cost) is in [`on_map`].
//!
//! Where a map has costs beside free and blocked, a step costs as in [`crate::astar`]; the papers
//! know no costs, and on their maps every price is one.

pub(crate) mod bao_full;
pub(crate) mod best_first;
pub(crate) mod field;
pub(crate) mod flood;
pub(crate) mod heuristic;
pub(crate) mod lwx_aco;
pub(crate) mod lwx_bi;
pub(crate) mod lwx_bi_true;
pub(crate) mod lwx_oa;
pub(crate) mod lwx_rrt;
pub(crate) mod on_map;
pub(crate) mod options;
pub(crate) mod regularise;
pub(crate) mod sight;
pub(crate) mod spline;
#[cfg(test)]
mod tests;
pub(crate) mod tn_3n;
pub(crate) mod tn_apf;
pub(crate) mod tn_hyb;
pub(crate) mod variants;
pub(crate) mod weight;
