//! Controllers, recovery and tasks of the local planner.

#[path = "../support/mod.rs"]
mod support;

mod attempts;
mod beam;
mod braking;
mod closed_loop;
mod delay;
mod dwa_t;
mod laws;
mod mppi;
mod oncoming;
mod papers;
mod periods;
mod recovery;
mod rollouts;
mod shut_in;
mod tasks;
mod tight;
mod waiting;
