//! Planners: what every one of them keeps to, and what each is for.

#[path = "../support/mod.rs"]
mod support;

mod any_angle;
mod conformance;
mod corridor;
mod detours;
mod fast_planners;
mod movingai;
mod optimality;
mod readme;
mod replan;
mod replan_results;
mod smooth;
