//! What results and recordings are made of, whether this process has driven the run or reads it.

use crate::collect::Collector;
use crate::drive::Driven;
use crate::prepare::Prepared;
use zeronav_msgs::run::RunMode;
use zeronav_scenario::Scenario;
use zeronav_world::{Footprint, World};

/// What was heard of a run, and what is known of it besides.
#[derive(Debug)]
pub(crate) struct Subject<'a> {
    /// What was driven.
    pub scenario: &'a Scenario,
    /// Its world.
    pub world: &'a World,
    /// The robot's outline.
    pub footprint: &'a Footprint,
    /// Real time or lockstep.
    pub mode: RunMode,
    /// Seed of everything random.
    pub seed: u64,
    /// What was heard.
    pub collector: &'a Collector,
    /// Run time of the first goal. [ns]
    pub goals_run_ns: u64,
    /// Run time of the end. [ns]
    pub end_run_ns: u64,
}

impl<'a> Subject<'a> {
    /// A run that this process has driven.
    pub(crate) fn of(prepared: &'a Prepared, driven: &'a Driven) -> Self {
        Self {
            scenario: &prepared.scenario,
            world: &prepared.world,
            footprint: &prepared.footprint,
            mode: prepared.mode,
            seed: prepared.seed,
            collector: &driven.collector,
            goals_run_ns: driven.goals_run_ns,
            end_run_ns: driven.end_run_ns,
        }
    }
}
