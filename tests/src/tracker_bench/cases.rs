//! Which worlds are played: scenes of recorded people and worlds of `DynaBARN`, each with a robot that
//! stands at the edge and looks in, and with one that drives through.

use core::f64::consts::{FRAC_PI_2, PI};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use zeronav_casts::Cast;
use zeronav_msgs::Pose;
use zeronav_world::WorldSpec;
use zeronav_world_files::dynabarn::{self, DynabarnWorld};
use zeronav_world_files::pedestrians::{Playback, Scene};

/// Radius of a person. [m]
const PERSON_RADIUS_M: f64 = 0.3;

/// How far outside of everywhere that people walk the robot starts. [m]
const OUTSIDE_M: f64 = 1.2;

/// Moments at which the cylinders' rounds are entered are drawn from this long. [s]
const PHASE_S_MAX: f64 = 600.0;

/// 1 over the golden ratio: its multiples cover a span evenly, however many are taken.
const GOLDEN: f64 = 0.618_033_988_749_894_8;

/// One run.
#[derive(Debug, Clone)]
pub struct Case {
    /// For messages.
    pub name: String,
    /// The data set.
    pub set: &'static str,
    /// What its worlds are sorted by: the difficulty, the scene.
    pub class: String,
    /// The world, with its files read.
    pub world: WorldSpec,
    /// `map_from_base` at the start.
    pub start: Pose,
    /// Where the robot drives to first.
    pub goal: Pose,
    /// It drives to and fro; otherwise it stands at the start.
    pub drives: bool,
    /// Radius of what moves. [m]
    pub radius_m: f64,
    /// Of all noise.
    pub seed: u64,
}

impl Case {
    /// The same world with a robot that stands and with one that drives.
    fn both(self) -> [Self; 2] {
        let named = |drives: bool| Self {
            name: format!(
                "{}, {}",
                self.name,
                if drives { "driving" } else { "standing" }
            ),
            drives,
            ..self.clone()
        };
        [named(false), named(true)]
    }
}

/// Every scene of a folder, on the four ways across it, with each of the seeds 1 to `seeds`; from
/// other moments each. `duration_s` is how long they are played. [s]
///
/// # Errors
/// One line naming a file.
pub fn pedestrians(folder: &Path, seeds: u64, duration_s: f64) -> Result<Vec<Case>, String> {
    let mut cases = Vec::new();
    for file in csv_files(folder, "")? {
        let scene = Scene::load(&file).map_err(|error| error.to_string())?;
        let (first_s, last_s) = scene.span_s();
        for seed in 1..=seeds {
            for (way, (start, goal)) in (0..).zip(ways(&scene)) {
                let share = fraction(4 * (seed - 1) + way + 1);
                let from_s = first_s + share * (last_s - duration_s - first_s).max(0.0);
                let playback = Playback {
                    from_s,
                    duration_s: Some(duration_s),
                    radius_m: PERSON_RADIUS_M,
                };
                let case = Case {
                    name: format!("{} from {from_s:.1} s on, way {way}", name_of(&file)),
                    set: "pedestrians",
                    class: name_of(&file),
                    world: scene.spec(&playback),
                    start,
                    goal,
                    drives: false,
                    radius_m: PERSON_RADIUS_M,
                    seed,
                };
                cases.extend(case.both());
            }
        }
    }
    Ok(cases)
}

/// Every world of a folder with each of the seeds 1 to `seeds`, with a phase of its own.
///
/// # Errors
/// One line naming a file.
pub fn dynabarn(folder: &Path, seeds: u64) -> Result<Vec<Case>, String> {
    let classes = classes(&folder.join("index.csv"))?;
    let mut cases = Vec::new();
    for (nth, file) in (0..).zip(csv_files(folder, "world_")?) {
        let world = DynabarnWorld::load(&file).map_err(|error| error.to_string())?;
        let name = name_of(&file);
        let number = name.trim_start_matches("world_").parse::<u32>().ok();
        let class = number.and_then(|number| classes.get(&number).cloned());
        for seed in 1..=seeds {
            let phase_s = PHASE_S_MAX * fraction(nth * seeds + seed);
            let case = Case {
                name: format!("{name} from {phase_s:.1} s on"),
                set: "dynabarn",
                class: class.clone().unwrap_or_default(),
                world: world.spec(phase_s),
                start: dynabarn::START,
                goal: dynabarn::GOAL,
                drives: false,
                radius_m: dynabarn::RADIUS_M,
                seed,
            };
            cases.extend(case.both());
        }
    }
    Ok(cases)
}

/// Start and goal of the four ways straight through the middle of a scene.
fn ways(scene: &Scene) -> [(Pose, Pose); 4] {
    let (lower, upper) = scene.bounds();
    let middle = nalgebra::center(&lower, &upper);
    let west = |yaw| Pose::new(lower.x - OUTSIDE_M, middle.y, yaw);
    let east = |yaw| Pose::new(upper.x + OUTSIDE_M, middle.y, yaw);
    let south = |yaw| Pose::new(middle.x, lower.y - OUTSIDE_M, yaw);
    let north = |yaw| Pose::new(middle.x, upper.y + OUTSIDE_M, yaw);
    [
        (west(0.0), east(0.0)),
        (south(FRAC_PI_2), north(FRAC_PI_2)),
        (east(PI), west(PI)),
        (north(-FRAC_PI_2), south(-FRAC_PI_2)),
    ]
}

/// The `n`-th place in a span, 0 to 1.
fn fraction(n: u64) -> f64 {
    (GOLDEN * n.to_f64()).fract()
}

/// The files `PREFIX*.csv` of a folder but its index, by name.
fn csv_files(folder: &Path, prefix: &str) -> Result<Vec<PathBuf>, String> {
    let entries = std::fs::read_dir(folder)
        .map_err(|error| format!("reading the folder {}: {error}", folder.display()))?;
    let mut files: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).collect();
    files.retain(|file| {
        let name = name_of(file);
        file.extension().is_some_and(|end| end == "csv")
            && name.starts_with(prefix)
            && name != "index"
    });
    files.sort();
    if files.is_empty() {
        return Err(format!("no file {prefix}*.csv in {}", folder.display()));
    }
    Ok(files)
}

/// Name of a file without its ending.
fn name_of(file: &Path) -> String {
    let name = file.file_stem().unwrap_or_default();
    name.to_string_lossy().into_owned()
}

/// The difficulty of every world, from the index with a header.
fn classes(index: &Path) -> Result<BTreeMap<u32, String>, String> {
    let name = |problem: &dyn core::fmt::Display| format!("{}: {problem}", index.display());
    let text = std::fs::read_to_string(index).map_err(|error| name(&error))?;
    let mut lines = text.lines().filter(|line| !line.starts_with('#'));
    let header: Vec<&str> = lines.next().unwrap_or_default().split(',').collect();
    let column = |wanted: &str| {
        let at = header.iter().position(|column| *column == wanted);
        at.ok_or_else(|| name(&format!("no column `{wanted}`")))
    };
    let (world, difficulty) = (column("world")?, column("difficulty")?);
    let row = |line: &str| {
        let cells: Vec<&str> = line.split(',').collect();
        let number = cells.get(world)?.trim().parse().ok()?;
        Some((number, cells.get(difficulty)?.trim().to_owned()))
    };
    lines
        .map(|line| row(line).ok_or_else(|| name(&format!("what is `{line}`?"))))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::shipped_data;

    #[test]
    fn every_world_is_played_standing_and_driving() {
        let cases = dynabarn(&shipped_data("dynabarn"), 2).expect("worlds");
        assert_eq!(cases.len(), 3 * 2 * 2);
        assert_eq!(cases.iter().filter(|case| case.drives).count(), 6);
        assert!(cases.iter().all(|case| !case.class.is_empty()), "{cases:?}");
        assert_ne!(cases[0].world, cases[2].world, "another phase");
        let cases = pedestrians(&shipped_data("pedestrians"), 1, 10.0).expect("scenes");
        assert_eq!(cases.len(), 8);
        let missing = dynabarn(Path::new("/nowhere"), 1).expect_err("no folder");
        assert!(missing.contains("/nowhere"), "{missing}");
    }
}
