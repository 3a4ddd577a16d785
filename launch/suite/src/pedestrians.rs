//! Recorded people: the robot crosses the scene, and they do not see it.

use super::barn::TOLERANCE_SHARE;
use super::case::{Case, Manner, Rule, Sheet, Success};
use super::data::{self, WorldFile};
use super::error::SuiteError;
use super::plan::{Setup, SuitePlan};
use super::rows::drive;
use super::runner::Runner;
use super::turns::OutlineWay;
use core::f64::consts::{FRAC_PI_2, PI};
use toml::Table;
use zeronav_casts::Cast;
use zeronav_msgs::Pose;
use zeronav_world_files::pedestrians::Scene;

/// Radius of a person. [m]
const PERSON_RADIUS_M: f64 = 0.3;

/// How far outside of everywhere that people walk the robot starts and ends: none is near
/// when the run begins. [m]
const OUTSIDE_M: f64 = 1.2;

/// How near the robot's centre must come to its goal. [m]
const GOAL_TOLERANCE_M: f64 = 1.0;

/// Run time for the empty scene. [s]
const EMPTY_LIMIT_S: f64 = 180.0;

/// How many times the time in the empty scene the robot has.
const TIMES_EMPTY: f64 = 3.0;

/// 1 over the golden ratio: its multiples cover a span evenly, however many are taken.
const GOLDEN: f64 = 0.618_033_988_749_894_8;

/// The four ways across.
const WAYS: [&str; 4] = ["east", "north", "west", "south"];

/// The scenes that are there.
///
/// # Errors
/// One line when there are none.
pub(super) fn worlds(plan: &SuitePlan) -> Result<Vec<WorldFile>, String> {
    let folder = data::folder(plan, data::PEDESTRIANS)?;
    data::worlds(plan, &folder, "", "csv")
}

/// Every scene from every start time. The empty scenes are crossed first: the time that it takes
/// is what the others are measured by.
///
/// # Errors
/// One line naming a file, or a scene that is not even crossed when it is empty.
pub(super) fn cases(
    setup: &Setup<'_>,
    worlds: &[WorldFile],
    runner: &Runner<'_>,
) -> Result<Vec<Case>, SuiteError> {
    let seeds = setup.plan.seeds;
    let mut scenes = Vec::new();
    let mut empty = Vec::new();
    for world in worlds {
        let scene = Scene::load(&world.file).map_err(|error| error.to_string())?;
        for way in WAYS
            .iter()
            .take(usize::try_from(seeds).unwrap_or(usize::MAX))
        {
            empty.push(empty_case(setup, world, &scene, way)?);
        }
        scenes.push(scene);
    }
    let rows = drive(runner, "empty scenes", &empty)?;
    if let Some(row) = rows.iter().find(|row| !row.success) {
        return Err(SuiteError::Usage(format!(
            "the empty scene of {} is not crossed ({}): there is no time to measure others by",
            row.world,
            row.cause.as_deref().unwrap_or("no cause")
        )));
    }
    let ways = WAYS.len().min(usize::try_from(seeds).unwrap_or(usize::MAX));
    let mut cases = Vec::new();
    for ((world, scene), rows) in worlds.iter().zip(&scenes).zip(rows.chunks(ways)) {
        for seed in 1..=seeds {
            let way = way_of(seed);
            let empty_s = rows.get(way).and_then(|row| row.time_s);
            let limit_s = TIMES_EMPTY * empty_s.unwrap_or(EMPTY_LIMIT_S / TIMES_EMPTY);
            cases.push(case(setup, world, scene, seed, limit_s)?);
        }
    }
    Ok(cases)
}

/// Index of the way that a seed goes.
fn way_of(seed: u64) -> usize {
    usize::try_from((seed - 1) % WAYS.len() as u64).unwrap_or(0)
}

/// The way across the scene without anybody.
fn empty_case(
    setup: &Setup<'_>,
    world: &WorldFile,
    scene: &Scene,
    way: &str,
) -> Result<Case, String> {
    let (start, goal) = across(scene, way);
    let mut table = Table::new();
    let area_m: Vec<Vec<f64>> = scene
        .area_m()
        .iter()
        .map(|corner| corner.to_vec())
        .collect();
    table.insert("area_m".into(), area_m.into());
    table.insert("resolution_m".into(), 0.05.into());
    let sheet = Sheet {
        name: format!("empty_{}_{way}", world.name),
        title: format!("{} without anybody, {way}", world.name),
        world: table,
        start,
        goal,
        goal_tolerance_m: TOLERANCE_SHARE * GOAL_TOLERANCE_M,
        time_limit_s: EMPTY_LIMIT_S,
    };
    Ok(Case {
        world: format!("{}_{way}", world.name),
        class: None,
        seed: 1,
        scenario: sheet.write(setup)?,
        time_limit_s: EMPTY_LIMIT_S,
        rule: rule(start, goal),
        manner: Manner::default(),
    })
}

fn case(
    setup: &Setup<'_>,
    world: &WorldFile,
    scene: &Scene,
    seed: u64,
    limit_s: f64,
) -> Result<Case, String> {
    let way = WAYS[way_of(seed)];
    let (start, goal) = across(scene, way);
    let from_s = from_s(scene, seed, limit_s);
    let mut people = Table::new();
    people.insert("file".into(), world.file.display().to_string().into());
    people.insert("from_s".into(), from_s.into());
    people.insert("duration_s".into(), limit_s.into());
    people.insert("radius_m".into(), PERSON_RADIUS_M.into());
    let mut table = Table::new();
    table.insert("pedestrians".into(), people.into());
    let sheet = Sheet {
        name: format!("{}_{seed}", world.name),
        title: format!("{} from {from_s:.1} s on, {way}", world.name),
        world: table,
        start,
        goal,
        goal_tolerance_m: TOLERANCE_SHARE * GOAL_TOLERANCE_M,
        time_limit_s: limit_s,
    };
    Ok(Case {
        world: world.name.clone(),
        class: Some(world.name.clone()),
        seed,
        scenario: sheet.write(setup)?,
        time_limit_s: limit_s,
        rule: rule(start, goal),
        manner: Manner::default(),
    })
}

/// People do not yield, so what touches a standing robot is not its fault.
fn rule(start: Pose, goal: Pose) -> Rule {
    Rule {
        success: Success::Arrival {
            goal_m: [goal.x_m, goal.y_m],
            tolerance_m: GOAL_TOLERANCE_M,
            standing_counts: false,
        },
        optimal_time_s: None,
        reference_m: Some(start.distance_m(&goal) - GOAL_TOLERANCE_M),
        future_is_known: true,
        way: OutlineWay::NotSearched,
    }
}

/// Moment of the recording at which the run begins; the robot's time fits into what is left. [s]
fn from_s(scene: &Scene, seed: u64, limit_s: f64) -> f64 {
    let (first_s, last_s) = scene.span_s();
    let share = (GOLDEN * seed.to_f64()).fract();
    first_s + share * (last_s - limit_s - first_s).max(0.0)
}

/// Start and goal of a way straight through the middle of the scene.
fn across(scene: &Scene, way: &str) -> (Pose, Pose) {
    let (lower, upper) = scene.bounds();
    let middle = nalgebra::center(&lower, &upper);
    let west = |yaw| Pose::new(lower.x - OUTSIDE_M, middle.y, yaw);
    let east = |yaw| Pose::new(upper.x + OUTSIDE_M, middle.y, yaw);
    let south = |yaw| Pose::new(middle.x, lower.y - OUTSIDE_M, yaw);
    let north = |yaw| Pose::new(middle.x, upper.y + OUTSIDE_M, yaw);
    match way {
        "north" => (south(FRAC_PI_2), north(FRAC_PI_2)),
        "west" => (east(PI), west(PI)),
        "south" => (north(-FRAC_PI_2), south(-FRAC_PI_2)),
        _ => (west(0.0), east(0.0)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scene() -> Scene {
        let walk = vec![[0.0, 0.0, 0.0], [100.0, 10.0, 4.0]];
        Scene {
            walkers: [(1, walk)].into(),
        }
    }

    #[test]
    fn start_times_cover_the_recording_and_leave_the_robot_its_time() {
        let scene = scene();
        let times: Vec<f64> = (1..=20).map(|seed| from_s(&scene, seed, 20.0)).collect();
        for eighth in 0..8 {
            let from = f64::from(eighth) * 10.0;
            assert!(times.iter().any(|time| (from..from + 10.0).contains(time)));
        }
        assert!(times.iter().all(|time| (0.0..=80.0).contains(time)));
        // A recording that is shorter than the limit is played from its beginning.
        assert!(from_s(&scene, 3, 200.0).abs() < 1e-12);
    }

    #[test]
    fn the_robot_starts_outside_and_goes_straight_through_the_middle() {
        let (start, goal) = across(&scene(), "west");
        assert_eq!(start, Pose::new(11.2, 2.0, PI));
        assert_eq!(goal, Pose::new(-1.2, 2.0, PI));
        for way in WAYS {
            let (start, goal) = across(&scene(), way);
            let along = (goal.point() - start.point()).normalize();
            assert!((along.x - start.yaw_rad.cos()).abs() < 1e-9, "{way}");
            assert!((along.y - start.yaw_rad.sin()).abs() < 1e-9, "{way}");
        }
        assert_eq!([1, 2, 5, 20].map(way_of), [0, 1, 0, 3]);
    }
}
