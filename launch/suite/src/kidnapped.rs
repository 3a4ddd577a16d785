//! Robots that do not know where on a map they are: a quarter of them is told nothing and shall stay where it is, a quarter is
//! told that it is 2 m ahead and faces the other way, and is sent elsewhere. Each has to find itself, and to arrive. The
//! third quarter is told the truth, to 1 cm, at the same places and sent to the same goals: none of them may take itself to be
//! lost. The last one, at these places with these goals, too, is told nothing and may look around
//! (`recovery.seek_pose`).

use super::case::{Case, Manner, Rule, Sheet, Success};
use super::data::{self, WorldFile};
use super::plan::{Setup, SuitePlan};
use super::turns::OutlineWay;
use core::f64::consts::PI;
use core::ops::Range;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use toml::{Table, Value};
use zeronav_msgs::{Cell, Pose};
use zeronav_world::StaticMap;
use zeronav_world_files::map_file;

/// Robots of each map and class, class by class.
const OF_CLASS: u32 = 20;
const EACH: u32 = 80;

/// Least distance of a robot's centre from a wall. [m]
const ROOM_M: f64 = 0.5;

/// What a robot of a class is told, seen from where it is. One that is told nothing has a wrong pose, too: without it
/// odometry, which begins at the true pose, would give that away.
const TOLD: [Pose; 4] = [WRONG, WRONG, RIGHTLY, WRONG];
const WRONG: Pose = Pose::new(2.0, 0.0, PI);

/// The truth to 1 cm: exactly where odometry begins it would be told nothing.
const RIGHTLY: Pose = Pose::new(0.01, 0.0, 0.0);

/// Run time of a robot that is told nothing, and of those that drive. [s]
const TIME_LIMIT_S: [f64; 4] = [10.0, 60.0, 60.0, 90.0];

/// How near to its goal it must think itself to be. [m]
const TOLERANCE_M: f64 = 0.25;

/// How far away the goal of a robot that drives is, so that one that is told something wrong has time to notice; the farthest
/// place that was drawn where none is so far. [m]
const AWAY_M: Range<f64> = 5.0..12.0;

/// A pose that is farther off is that of another place. [m, rad]
const OFF: (f64, f64) = (0.5, 0.3);

/// Places that are drawn to find such a one.
const TRIES: usize = 100;

/// What a robot is told.
const CLASSES: [&str; 4] = ["told_nothing", "told_wrong", "told_right", "looks_around"];
const NOTHING: usize = 0;
const RIGHT: usize = 2;
const LOOKS: usize = 3;

/// Every robot of every map that is asked for, numbered by map and robot.
///
/// # Errors
/// One line when there are no maps.
pub(super) fn worlds(plan: &SuitePlan) -> Result<Vec<WorldFile>, String> {
    let folder = data::folder(plan, data::ROSMAPS)?;
    let all = SuitePlan {
        worlds: None,
        ..plan.clone()
    };
    let mut worlds = Vec::new();
    for (map, place) in data::worlds(&all, &folder, "", "yaml")?
        .into_iter()
        .zip(0..)
    {
        worlds.extend((0..EACH).map(|robot| WorldFile {
            name: format!("{}_{robot:02}", map.name),
            number: EACH * place + robot,
            file: map.file.clone(),
        }));
    }
    let n = worlds.len();
    worlds
        .retain(|world| (plan.worlds.as_ref()).is_none_or(|wanted| wanted.contains(&world.number)));
    if worlds.is_empty() {
        return Err(format!(
            "the maps of {} have the worlds 0..{n}",
            folder.display()
        ));
    }
    Ok(worlds)
}

/// Every world with every seed.
///
/// # Errors
/// One line naming a file, or a map without room.
pub(super) fn cases(setup: &Setup<'_>, worlds: &[WorldFile]) -> Result<Vec<Case>, String> {
    let mut cases = Vec::new();
    for of_map in worlds.chunk_by(|one, other| one.file == other.file) {
        let Some(first) = of_map.first() else {
            continue;
        };
        let map = map_file::load(&first.file)
            .map_err(|error| error.to_string())?
            .map;
        let room = map.largest_room(ROOM_M);
        if room.is_empty() {
            return Err(format!(
                "{}: no place is {ROOM_M} m from everything",
                first.file.display()
            ));
        }
        for world in of_map {
            let case = case(setup, world, &drawn(world, &map, &room))?;
            cases.extend((1..=setup.plan.seeds).map(|seed| Case {
                seed,
                ..case.clone()
            }));
        }
    }
    Ok(cases)
}

/// The class of a world, and a number that the worlds of those that drive have in common.
fn class_of(world: &WorldFile) -> (usize, u32) {
    let (map, robot) = (world.number / EACH, world.number % EACH);
    let (class, n) = (robot / OF_CLASS, robot % OF_CLASS);
    let (class, drives) = match class {
        0 => (NOTHING, 0),
        1 => (1, 1),
        2 => (RIGHT, 1),
        _ => (LOOKS, 1),
    };
    (class, OF_CLASS * (2 * map + drives) + n)
}

/// Where the robot of a world wakes, and where it shall go.
fn drawn(world: &WorldFile, map: &StaticMap, room: &[Cell]) -> [Pose; 2] {
    let (class, seed) = class_of(world);
    let mut random = Pcg64Mcg::seed_from_u64(u64::from(seed));
    let mut place = || {
        let at = map
            .geometry
            .centre_of(room[random.random_range(0..room.len())]);
        Pose::new(at.x, at.y, random.random_range(-PI..PI))
    };
    let start = place();
    if class == NOTHING {
        return [start, start];
    }
    let others: Vec<Pose> = (0..TRIES).map(|_| place()).collect();
    let away_m = |other: &Pose| other.distance_m(&start);
    let goal = (others.iter())
        .find(|other| AWAY_M.contains(&away_m(other)))
        .or_else(|| (others.iter()).max_by(|one, other| away_m(one).total_cmp(&away_m(other))));
    [start, goal.copied().unwrap_or(start)]
}

fn case(setup: &Setup<'_>, world: &WorldFile, [start, goal]: &[Pose; 2]) -> Result<Case, String> {
    let (class, _) = class_of(world);
    let time_limit_s = TIME_LIMIT_S[class];
    let mut table = Table::new();
    table.insert("map".into(), world.file.display().to_string().into());
    let sheet = Sheet {
        name: world.name.clone(),
        title: format!(
            "{}: a robot that {}{}",
            world.name,
            if class == LOOKS { "" } else { "is " },
            CLASSES[class].replace('_', " ")
        ),
        world: table,
        start: *start,
        goal: *goal,
        goal_tolerance_m: TOLERANCE_M,
        time_limit_s,
    };
    let mut sheet = sheet.table(setup)?;
    // It has the map.
    sheet.remove("static_map");
    sheet.insert("services".into(), told(start, class).into());
    Ok(Case {
        world: world.name.clone(),
        class: Some(CLASSES[class].to_owned()),
        seed: 1,
        scenario: super::case::write(setup, &world.name, sheet)?,
        time_limit_s,
        rule: Rule {
            success: Success::Found {
                off_m: OFF.0,
                off_rad: OFF.1,
                may_be_lost: class != RIGHT,
            },
            optimal_time_s: None,
            reference_m: None,
            future_is_known: false,
            way: OutlineWay::NotSearched,
        },
        manner: Manner::default(),
    })
}

/// The services' configuration: what mapping is told of the pose, and whether the robot may look around. Odometry begins at
/// the true pose.
fn told(start: &Pose, class: usize) -> Table {
    let told = start.then(&TOLD[class]);
    let map_from_odom = Pose::from(told.isometry() * start.isometry().inverse());
    let from_odom = super::case::numbers(map_from_odom);
    let mut services = Table::new();
    let mut set = |service: &str, group: &str, key: &str, value: Value| {
        let mut at = &mut services;
        for name in [service, "config", group] {
            let inner = at.entry(name).or_insert_with(|| Table::new().into());
            let Some(inner) = inner.as_table_mut() else {
                return;
            };
            at = inner;
        }
        at.insert(key.into(), value);
    };
    set("mapping", "localisation", "map_from_odom", from_odom);
    if [NOTHING, LOOKS].contains(&class) {
        set("mapping", "localisation", "start", "unknown".into());
    }
    if class == LOOKS {
        set("local_planner", "recovery", "seek_pose", true.into());
    }
    services
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plan(worlds: Range<u32>) -> SuitePlan {
        let data = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/data");
        SuitePlan {
            worlds: Some(worlds),
            data: Some(data.into()),
            ..SuitePlan::of("kidnapped")
        }
    }

    #[test]
    fn worlds_are_numbered_by_map_and_robot_and_drawn_from_their_number() {
        let border = worlds(&plan(78..82)).unwrap();
        let names: Vec<&str> = border.iter().map(|world| world.name.as_str()).collect();
        let expected = [
            "rooms_negative_78",
            "rooms_negative_79",
            "rooms_p2_00",
            "rooms_p2_01",
        ];
        assert_eq!(names, expected);
        assert!(worlds(&plan(320..330)).is_err());
        let map = map_file::load(&border[0].file).unwrap().map;
        let room = map.largest_room(ROOM_M);
        let all = worlds(&plan(0..80)).unwrap();
        let drawn = |world: &WorldFile| super::drawn(world, &map, &room);
        for (n, world) in all.iter().enumerate() {
            let [start, goal] = drawn(world);
            assert_eq!(drawn(world), [start, goal]);
            assert_eq!(class_of(world).0, n / 20);
            let away_m = goal.distance_m(&start);
            if n < 20 {
                assert_eq!(goal, start);
            } else {
                assert!(AWAY_M.contains(&away_m), "{}: {away_m} m", world.name);
            }
        }
        // Those that drive differ in nothing else.
        for n in 20..40 {
            for other in [n + 20, n + 40] {
                assert_eq!(drawn(&all[n]), drawn(&all[other]));
            }
        }
        assert_ne!(drawn(&all[0]), drawn(&all[20]));
    }

    #[test]
    fn robots_are_told_the_truth_or_that_they_are_ahead_and_face_the_other_way() {
        let start = Pose::new(3.0, -2.0, 0.7);
        for (class, off_m) in [2.0, 2.0, 0.01, 2.0].into_iter().enumerate() {
            let services = told(&start, class);
            let localisation = &services["mapping"]["config"]["localisation"];
            let start_is = localisation.get("start").and_then(Value::as_str);
            assert_eq!(start_is, (class % 3 == 0).then_some("unknown"));
            let planner = services.get("local_planner").is_some();
            assert_eq!(planner, class == 3);
            let number = |n: usize| localisation["map_from_odom"][n].as_float().unwrap();
            let map_from_odom = Pose::new(number(0), number(1), number(2));
            let believed = map_from_odom.then(&start);
            assert!((believed.distance_m(&start) - off_m).abs() < 1.0e-9);
            assert!(believed.distance_m(&start.then(&TOLD[class])) < 1.0e-9);
        }
    }
}
