//! Worlds that are drawn from a seed: no data is needed.

use super::barn::TOLERANCE_SHARE;
use super::case::{Case, Manner, Rule, Sheet, Success};
use super::data::WorldFile;
use super::plan::{Setup, SuitePlan};
use super::turns::OutlineWay;
use core::ops::Range;
use std::path::PathBuf;
use toml::Table;
use zeronav_robot_description::RobotPreset;
use zeronav_world_files::synthetic::Robot;
use zeronav_world_files::synthetic::course::{self, Class, Course, Kind};

/// The worlds that are driven unless others are asked for: two of each class.
const WORLDS: Range<u32> = 0..2 * Class::COUNT;

/// The worlds that are asked for.
pub(super) fn worlds(plan: &SuitePlan) -> Vec<WorldFile> {
    let numbers = plan.worlds.clone().unwrap_or(WORLDS);
    numbers
        .map(|number| WorldFile {
            name: format!("{}_{number:03}", Class::of(number).label()),
            number,
            file: PathBuf::new(),
        })
        .collect()
}

/// Every world with every seed.
///
/// # Errors
/// One line naming a world that cannot be drawn, or a file.
pub(super) fn cases(setup: &Setup<'_>, worlds: &[WorldFile]) -> Result<Vec<Case>, String> {
    let mut cases = Vec::new();
    for world in worlds {
        for seed in 1..=setup.plan.seeds {
            cases.push(case(setup, world, seed)?);
        }
    }
    Ok(cases)
}

fn case(setup: &Setup<'_>, world: &WorldFile, seed: u64) -> Result<Case, String> {
    let class = Class::of(world.number);
    let name = format!("{}_{seed}", world.name);
    let (drawn, sheet) = sheet(name, &world.name, world.number, seed)?;
    Ok(Case {
        world: world.name.clone(),
        class: Some(class.label().to_owned()),
        seed,
        scenario: sheet.write(setup)?,
        time_limit_s: drawn.time_limit_s,
        rule: Rule {
            success: Success::Arrival {
                goal_m: [drawn.goal.x_m, drawn.goal.y_m],
                tolerance_m: drawn.goal_tolerance_m,
                // People do not see the robot: a contact while it is stopped is not its fault.
                standing_counts: class.kind != Kind::Walkers,
            },
            optimal_time_s: None,
            reference_m: Some(drawn.reference_m - drawn.goal_tolerance_m),
            future_is_known: drawn.moves,
            way: OutlineWay::NotSearched,
        },
        manner: Manner::default(),
    })
}

/// The world of this number as it is for a run with this seed, and the scenario `name` in it.
///
/// # Errors
/// One line naming the world, when it cannot be drawn.
pub(super) fn sheet(
    name: String,
    world: &str,
    number: u32,
    seed: u64,
) -> Result<(Course, Sheet), String> {
    let footprint = RobotPreset::Jackal
        .robot()
        .footprint()
        .map_err(|error| error.to_string())?;
    let robot = Robot {
        radius_m: footprint.circumscribed_radius_m(),
    };
    let drawn = course::draw(number, seed, robot).map_err(|error| format!("{world}: {error}"))?;
    let table = Table::try_from(&drawn.spec)
        .map_err(|error| format!("{world} has no TOML form: {error}"))?;
    let sheet = Sheet {
        name,
        title: format!("Generated world {world}, unknown to the robot"),
        world: table,
        start: drawn.start,
        goal: drawn.goal,
        goal_tolerance_m: TOLERANCE_SHARE * drawn.goal_tolerance_m,
        time_limit_s: drawn.time_limit_s,
    };
    Ok((drawn, sheet))
}
