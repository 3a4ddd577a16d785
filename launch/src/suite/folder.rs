//! A folder of scenarios, each judged by what it expects itself.

use super::case::{Case, Rule, Success, write};
use super::data::{self, WorldFile};
use super::noise;
use super::{Setup, SuiteArgs};
use crate::scenario::Scenario;
use std::path::Path;
use toml::Table;

/// The scenarios that are there.
///
/// # Errors
/// One line when there are none.
pub(super) fn worlds(arguments: &SuiteArgs) -> Result<Vec<WorldFile>, String> {
    let folder = Path::new(&arguments.suite);
    if !folder.is_dir() {
        return Err(format!(
            "a suite is barn, dynabarn, pedestrians or a folder of scenarios, and {} is none",
            folder.display()
        ));
    }
    data::worlds(arguments, folder, "", "toml")
}

/// Every scenario with every seed.
///
/// # Errors
/// What is wrong with a scenario, in one line.
pub(super) fn cases(setup: &Setup<'_>, worlds: &[WorldFile]) -> Result<Vec<Case>, String> {
    let mut cases = Vec::new();
    for world in worlds {
        let file = world.file.display().to_string();
        let own = Scenario::load(&file).map_err(|error| error.to_string())?;
        own.validate().map_err(|error| error.to_string())?;
        let mut sheet = Table::new();
        sheet.insert("base".into(), vec![file].into());
        let robot = noise::robot(setup.arguments.noise, &own.robot);
        if !robot.is_empty() {
            sheet.insert("robot".into(), robot.into());
        }
        let scenario = write(setup, &world.name, sheet)?;
        let time_limit_s = own.run.time_limit_s;
        for seed in 1..=setup.arguments.seeds {
            cases.push(Case {
                world: world.name.clone(),
                class: Some(world.name.clone()),
                seed,
                scenario: scenario.clone(),
                time_limit_s,
                rule: Rule {
                    success: Success::Expectations,
                    optimal_time_s: None,
                    reference_m: straight_m(&own),
                },
            });
        }
    }
    Ok(cases)
}

/// Length of the straight lines from start to goal to goal, up to the last one's tolerance; `None`
/// when that is nothing. [m]
fn straight_m(scenario: &Scenario) -> Option<f64> {
    let mut from = scenario.start;
    let mut length_m = 0.0;
    for goal in &scenario.goals {
        length_m += from.distance_m(&goal.pose);
        from = goal.pose;
    }
    let length_m = length_m - scenario.goals.last()?.tolerance_m;
    (length_m > 0.0).then_some(length_m)
}
