//! BARN: static worlds, a score by time.

use super::case::{Case, Manner, Rule, Sheet, Success};
use super::data::{self, WorldFile};
use super::plan::{Setup, SuitePlan};
use super::turns::OutlineWay;
use serde::Deserialize;
use std::collections::HashMap;
use toml::Table;
use zeronav_world_files::barn::{GOAL, GOAL_TOLERANCE_M, START, TIME_LIMIT_S};

/// A row of the index.
#[derive(Debug, Clone, Copy, Deserialize)]
struct Entry {
    world: u32,
    path_length_m: f64,
    ot_s: f64,
}

/// Share of the benchmark's tolerance that the robot is asked to keep: what its odometry errs shall
/// not decide whether it has arrived.
pub(super) const TOLERANCE_SHARE: f64 = 0.25;

/// The worlds that are there.
///
/// # Errors
/// One line when there are none.
pub(super) fn worlds(plan: &SuitePlan) -> Result<Vec<WorldFile>, String> {
    let folder = data::folder(plan, data::BARN)?.join("worlds");
    data::worlds(plan, &folder, "world_", "csv")
}

/// Every world with every seed.
///
/// # Errors
/// One line naming a file.
pub(super) fn cases(setup: &Setup<'_>, worlds: &[WorldFile]) -> Result<Vec<Case>, String> {
    let index = data::folder(setup.plan, data::BARN)?.join("index.csv");
    let entries: HashMap<u32, Entry> = data::index(&index)?
        .into_iter()
        .map(|entry: Entry| (entry.world, entry))
        .collect();
    let mut cases = Vec::new();
    for world in worlds {
        let entry = entries
            .get(&world.number)
            .ok_or_else(|| format!("{} has no row for {}", index.display(), world.name))?;
        let mut table = Table::new();
        table.insert("barn".into(), world.file.display().to_string().into());
        let sheet = Sheet {
            name: format!("barn_{}", world.name),
            title: format!("BARN {}, unknown to the robot", world.name),
            world: table,
            start: START,
            goal: GOAL,
            goal_tolerance_m: TOLERANCE_SHARE * GOAL_TOLERANCE_M,
            time_limit_s: TIME_LIMIT_S,
        };
        let scenario = sheet.write(setup)?;
        for seed in 1..=setup.plan.seeds {
            cases.push(Case {
                world: world.name.clone(),
                class: None,
                seed,
                scenario: scenario.clone(),
                time_limit_s: TIME_LIMIT_S,
                rule: Rule {
                    success: Success::Arrival {
                        goal_m: [GOAL.x_m, GOAL.y_m],
                        tolerance_m: GOAL_TOLERANCE_M,
                        standing_counts: true,
                    },
                    optimal_time_s: Some(entry.ot_s),
                    reference_m: Some(entry.path_length_m - GOAL_TOLERANCE_M),
                    future_is_known: false,
                    way: OutlineWay::NotSearched,
                },
                manner: Manner::default(),
            });
        }
    }
    Ok(cases)
}
