//! `DynaBARN`: cylinders that go round whatever the robot does.

use super::barn::TOLERANCE_SHARE;
use super::case::{Case, Manner, Rule, Sheet, Success};
use super::data::{self, WorldFile};
use super::plan::{Setup, SuitePlan};
use super::turns::OutlineWay;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use serde::Deserialize;
use std::collections::HashMap;
use toml::Table;
use zeronav_world_files::dynabarn::{GOAL, GOAL_TOLERANCE_M, START, TIME_LIMIT_S};

/// A row of the index.
#[derive(Debug, Clone, Deserialize)]
struct Entry {
    world: u32,
    difficulty: String,
}

/// Phases are drawn from this long: many rounds of every obstacle. [s]
const PHASE_S_MAX: f64 = 600.0;

/// The worlds that are there.
///
/// # Errors
/// One line when there are none.
pub(super) fn worlds(plan: &SuitePlan) -> Result<Vec<WorldFile>, String> {
    let folder = data::folder(plan, data::DYNABARN)?;
    data::worlds(plan, &folder, "world_", "csv")
}

/// Every world with every seed, each with a phase of its own.
///
/// # Errors
/// One line naming a file.
pub(super) fn cases(setup: &Setup<'_>, worlds: &[WorldFile]) -> Result<Vec<Case>, String> {
    let index = data::folder(setup.plan, data::DYNABARN)?.join("index.csv");
    let mut classes: HashMap<u32, String> = data::index(&index)?
        .into_iter()
        .map(|entry: Entry| (entry.world, entry.difficulty))
        .collect();
    let straight_m = START.distance_m(&GOAL);
    let mut cases = Vec::new();
    for world in worlds {
        let class = classes.remove(&world.number);
        for seed in 1..=setup.plan.seeds {
            let phase_s = phase_s(world.number, seed);
            let mut rounds = Table::new();
            rounds.insert("file".into(), world.file.display().to_string().into());
            rounds.insert("phase_s".into(), phase_s.into());
            let mut table = Table::new();
            table.insert("dynabarn".into(), rounds.into());
            let sheet = Sheet {
                name: format!("dynabarn_{}_{seed}", world.name),
                title: format!("DynaBARN {} from {phase_s:.2} s on", world.name),
                world: table,
                start: START,
                goal: GOAL,
                goal_tolerance_m: TOLERANCE_SHARE * GOAL_TOLERANCE_M,
                time_limit_s: TIME_LIMIT_S,
            };
            cases.push(Case {
                world: world.name.clone(),
                class: class.clone(),
                seed,
                scenario: sheet.write(setup)?,
                time_limit_s: TIME_LIMIT_S,
                rule: Rule {
                    success: Success::Arrival {
                        goal_m: [GOAL.x_m, GOAL.y_m],
                        tolerance_m: GOAL_TOLERANCE_M,
                        standing_counts: true,
                    },
                    optimal_time_s: None,
                    reference_m: Some(straight_m - GOAL_TOLERANCE_M),
                    future_is_known: true,
                    way: OutlineWay::NotSearched,
                },
                manner: Manner::default(),
            });
        }
    }
    Ok(cases)
}

/// Where in its rounds a world is when the run begins. [s]
fn phase_s(world: u32, seed: u64) -> f64 {
    let mut dice = Pcg64Mcg::seed_from_u64((u64::from(world) << 32) ^ seed);
    dice.random_range(0.0..PHASE_S_MAX)
}
