//! The tables of five papers on A* combined with potential fields, virtual obstacles, B-splines and
//! the dynamic window, measured with the planners and controllers of this project.
//!
//! No paper gives its maps, so that no table can be repeated cell by cell. What can be tested is the
//! claim, on random maps of the printed size and share of obstacles ([`maps`]): a table ([`tables`], [`table`])
//! runs the algorithms on pairs of the same map and ends ([`solve`]), a row ([`row`]) holds the mean of
//! the paired differences with its interval ([`stats`]) against what is printed, and one function says
//! what that means ([`verdict`]). What each claim is, and why it comes out as it does, stands in one
//! registry ([`claims`]). Scenes with obstacles that move ([`scenes`]) are driven by the real stack
//! ([`stack`]).

pub mod claims;
pub mod drivers;
pub mod feature;
pub mod figure;
pub mod maps;
pub mod page;
pub mod report;
pub mod rollout;
pub mod row;
pub mod scenes;
pub mod solve;
pub mod stack;
pub mod stats;
pub mod table;
pub mod tables;
pub mod timing;
pub mod verdict;
