//! Worlds of what real robots meet: rectangles beside walls, docks, aisles without room to turn, late
//! drives, slipping wheels, blind lidars, people in doors. Drawn from their numbers: no data is needed.
//!
//! Each kind is a row of [`kinds::KINDS`]. A search on the exact outline tells for each world whether
//! there is a way at all, and its time is what the drive is compared with.

mod kinds;
mod robots;
mod scene;

use super::case::{Case, Manner, Rule, Success, write};
use super::data::WorldFile;
use super::hindsight::Hindsight;
use super::noise;
use super::oracle::robot::Abilities;
use super::plan::{Setup, SuitePlan};
use super::turns::{self, OutlineWay, Turns};
use core::ops::Range;
use kinds::KINDS;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use std::path::PathBuf;
use toml::Table;
use zeronav_scenario::Scenario;

/// Worlds of each kind that are driven unless others are asked for.
const EACH: u32 = 36;

/// How far beside the goal's tolerance the robot may really stand: what it knows of its place is never
/// exact. [m]
const BESIDE_M: f64 = 0.15;

/// Run time of a drive beside what waiting takes: this much, and this many times the bound's. [s, -]
const TIME: (f64, f64) = (60.0, 4.0);

/// The kind of the world of this number, and which of its kind it is.
fn kind_of(number: u32) -> (usize, u32) {
    let n_kinds = u32::try_from(KINDS.len()).unwrap_or(1);
    ((number % n_kinds) as usize, number / n_kinds)
}

/// The worlds that are asked for.
pub(super) fn worlds(plan: &SuitePlan) -> Vec<WorldFile> {
    let n_kinds = u32::try_from(KINDS.len()).unwrap_or(1);
    let all: Range<u32> = 0..EACH * n_kinds;
    let numbers = plan.worlds.clone().unwrap_or(all);
    numbers
        .map(|number| WorldFile {
            name: format!("{}_{number:03}", KINDS[kind_of(number).0].label),
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
        let case = case(setup, world).map_err(|error| format!("{}: {error}", world.name))?;
        cases.extend((1..=setup.plan.seeds).map(|seed| Case {
            seed,
            ..case.clone()
        }));
    }
    Ok(cases)
}

/// The scenario of a world without its time limit, and the run time that it may take beside driving. [s]
fn drawn(world: &WorldFile) -> Result<(Table, f64), String> {
    let mut random = Pcg64Mcg::seed_from_u64(u64::from(world.number));
    let scene = (KINDS[kind_of(world.number).0].draw)(&mut random);
    // Half of the worlds lie askew to the cells of the map.
    let angle_rad = if random.random_bool(0.5) {
        random.random_range(-3.0..3.0)
    } else {
        0.0
    };
    let extra_s = scene.extra_s;
    Ok((scene.table(&world.name, angle_rad)?, extra_s))
}

fn case(setup: &Setup<'_>, world: &WorldFile) -> Result<Case, String> {
    let (mut sheet, extra_s) = drawn(world)?;
    let file = write(setup, &world.name, sheet.clone())?;
    let scenario =
        Scenario::load(&file.display().to_string()).map_err(|error| error.to_string())?;
    let checked = scenario.validate().map_err(|error| error.to_string())?;
    let abilities = Abilities::new(&scenario.robot, &checked.footprint);
    let mut way = Some(Turns::at(scenario.start));
    for goal in &scenario.goals {
        way = way.and_then(|before| {
            Some(before.and(&turns::find(&checked.world, &abilities, before.end, goal)?))
        });
    }
    let bound_s = way.map(|way| way.time_s);
    let time_limit_s = TIME.0 + TIME.1 * bound_s.unwrap_or(60.0) + extra_s;
    if let Some(run) = sheet
        .entry("run")
        .or_insert(Table::new().into())
        .as_table_mut()
    {
        run.insert("time_limit_s".into(), time_limit_s.into());
    }
    let noise = noise::robot(setup.plan.noise, &scenario.robot);
    if let Some(robot) = sheet
        .get_mut("robot")
        .and_then(|robot| robot.as_table_mut())
    {
        robot.extend(noise);
    }
    let goal = scenario.goals.last().ok_or("it has no goal")?;
    Ok(Case {
        world: world.name.clone(),
        class: Some(KINDS[kind_of(world.number).0].label.to_owned()),
        seed: 1,
        scenario: write(setup, &world.name, sheet)?,
        time_limit_s,
        rule: Rule {
            success: Success::Arrival {
                goal_m: [goal.pose.x_m, goal.pose.y_m],
                tolerance_m: goal.tolerance_m + BESIDE_M,
                // Nobody walks into a robot here: what it touches while it stands it has braked for too late.
                standing_counts: true,
            },
            optimal_time_s: None,
            reference_m: way
                .map(|way| way.length_m)
                .filter(|length_m| *length_m > 0.0),
            future_is_known: Hindsight::of(&file).is_some(),
            way: way.map_or(OutlineWay::NotFound, OutlineWay::Found),
        },
        manner: Manner::default(),
    })
}

#[cfg(test)]
mod tests;
