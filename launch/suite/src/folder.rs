//! A folder of scenarios, each judged by what it expects itself.

use super::case::{Case, Manner, Rule, Success, write};
use super::data::{self, WorldFile};
use super::noise;
use super::plan::{Setup, SuitePlan};
use super::turns::OutlineWay;
use std::path::Path;
use toml::Table;
use zeronav_scenario::Scenario;
use zeronav_shell::nearest::unknown;

/// The scenarios that are there.
///
/// # Errors
/// One line when there are none.
pub(super) fn worlds(plan: &SuitePlan) -> Result<Vec<WorldFile>, String> {
    let folder = Path::new(&plan.suite);
    if !folder.is_dir() {
        let known = [
            "generated",
            "barn",
            "dynabarn",
            "pedestrians",
            "field",
            "kidnapped",
            "soak",
        ];
        let why = unknown("suite", &plan.suite, known);
        return Err(format!("{why} (no folder of scenarios is called so)"));
    }
    data::worlds(plan, folder, "", "toml")
}

/// Every scenario with every seed.
///
/// # Errors
/// What is wrong with a scenario, in one line.
pub(super) fn cases(setup: &Setup<'_>, worlds: &[WorldFile]) -> Result<Vec<Case>, String> {
    let mut cases = Vec::new();
    for world in worlds {
        let variants = Scenario::variants(&world.file);
        let variants: Vec<Option<&str>> = match &variants[..] {
            [] => vec![None],
            some => some.iter().map(|name| Some(name.as_str())).collect(),
        };
        for variant in variants {
            cases.extend(of_scenario(setup, world, variant)?);
        }
    }
    Ok(cases)
}

/// A scenario with every seed.
fn of_scenario(
    setup: &Setup<'_>,
    world: &WorldFile,
    variant: Option<&str>,
) -> Result<Vec<Case>, String> {
    let mut sheet = Table::new();
    let file = world.file.display().to_string();
    sheet.insert("base".into(), vec![file].into());
    let mut name = world.name.clone();
    if let Some(variant) = variant {
        sheet.insert("variant".into(), variant.into());
        name = format!("{name}_{variant}");
    }
    // What the noise makes of the robot depends on the robot, so the scenario is read first.
    let scenario = write(setup, &name, sheet.clone())?;
    let own = Scenario::load(&scenario.display().to_string()).map_err(|error| error.to_string())?;
    own.validate().map_err(|error| error.to_string())?;
    let robot = noise::robot(setup.plan.noise, &own.robot);
    if !robot.is_empty() {
        sheet.insert("robot".into(), robot.into());
        write(setup, &name, sheet)?;
    }
    let time_limit_s = own.run.time_limit_s;
    let case = |seed| Case {
        world: name.clone(),
        class: Some(name.clone()),
        seed,
        scenario: scenario.clone(),
        time_limit_s,
        rule: Rule {
            success: Success::Expectations,
            optimal_time_s: None,
            reference_m: straight_m(&own),
            future_is_known: false,
            way: OutlineWay::NotSearched,
        },
        manner: Manner::default(),
    };
    Ok((1..=setup.plan.seeds).map(case).collect())
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
