//! Scenarios and goals that come from elsewhere than from a scenario's file.

use super::as_far::AsFar;
use super::document::{self, Document};
use super::library::{Library, Origin};
use super::{GoalSpec, RunSpec, Scenario, ScenarioError, absolute, binaries_of};
use core::f64::consts::PI;
use serde::{Deserialize, Serialize};
use std::path::Path;
use zeronav_msgs::Pose;
use zeronav_msgs::grid::Cell;
use zeronav_msgs::task::GOALS_MAX;
use zeronav_world_files as world_files;

/// Room around a robot that is put on a map: less would keep a large one from turning. [m]
const START_CLEARANCE_M: f64 = 0.3;

/// A file of goals.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct GoalsFile {
    goals: Vec<GoalSpec>,
}

/// The `[[goals]]` of a TOML file, as in a scenario.
///
/// # Errors
/// See [`ScenarioError`].
pub fn goals_in(file: &Path) -> Result<Vec<GoalSpec>, ScenarioError> {
    let origin = Origin::File(file.to_owned());
    let (read, document): (GoalsFile, Document) =
        document::read(&Library::of(""), origin, None)?.faultless()?;
    if read.goals.is_empty() {
        return Err(document.at_field("goals", "must not be empty"));
    }
    if read.goals.len() > GOALS_MAX {
        let why = format!("has {} goals, {GOALS_MAX} at most", read.goals.len());
        return Err(document.at_field("goals", &why));
    }
    Ok(read.goals)
}

impl Scenario {
    /// A robot on a map without goals. It starts at `start`, x [m], y [m] and yaw [rad]; without, at
    /// the free pose that is nearest to the map's middle.
    ///
    /// # Errors
    /// See [`ScenarioError`].
    pub fn of_map(map: &Path, robot: &str, start: Option<[f64; 3]>) -> Result<Self, ScenarioError> {
        let name = map.file_stem().unwrap_or_default().to_string_lossy();
        let file = absolute(map).to_string_lossy().into_owned();
        let table = serde_json::json!({
            "title": format!("{robot} on {name}"),
            "base": robot,
            "start": [0.0, 0.0, 0.0],
            "world": { "map": file },
        });
        let text = toml::to_string(&table).unwrap_or_default();
        let origin = Origin::Made(name.into_owned(), text);
        let mut scenario = Self::read(&Library::of(""), origin, None)?.whole()?;
        scenario.start = match start {
            Some([x_m, y_m, yaw_rad]) => Pose::new(x_m, y_m, yaw_rad),
            None => scenario.free_start()?,
        };
        Ok(scenario)
    }

    /// The scenario that [`Self::to_toml`] has written.
    ///
    /// # Errors
    /// See [`ScenarioError`].
    pub fn of_text(name: &str, text: &str) -> Result<AsFar, ScenarioError> {
        let origin = Origin::Made(name.to_owned(), text.to_owned());
        Self::read(&Library::of(""), origin, None)
    }

    /// The text of a scenario file that says the same with the seed `seed`, whatever this one builds on, and
    /// wherever it is read: files of its world and binaries that are named by a path are named by a whole one. A
    /// seed above 2^63 - 1, for which TOML has no number, is left out.
    ///
    /// # Errors
    /// One line when TOML has no number for another value.
    pub fn to_toml(&self, seed: u64) -> Result<String, String> {
        let failed = |why: &dyn core::fmt::Display| format!("scenario {}: {why}", self.name);
        let seed = i64::try_from(seed).map_or(self.run.seed, i64::unsigned_abs);
        let run = RunSpec {
            seed,
            ..self.run.clone()
        };
        let mut scenario = Self {
            run,
            ..self.clone()
        };
        for (_, binary) in binaries_of(&mut scenario) {
            if binary.components().count() > 1 {
                *binary = absolute(binary);
            }
        }
        let mut table = toml::Table::try_from(&scenario).map_err(|error| failed(&error))?;
        // It is that of the file.
        table.remove("name");
        toml::to_string(&table).map_err(|error| failed(&error))
    }

    /// The free pose that is nearest to the map's middle.
    fn free_start(&self) -> Result<Pose, ScenarioError> {
        let unusable = |why: String| self.error_at("world.map", &why);
        let (world, _) =
            world_files::load(&self.world).map_err(|error| unusable(error.to_string()))?;
        let footprint = (self.robot.footprint()).map_err(|error| unusable(error.to_string()))?;
        let (width, height) = world.geometry().size();
        let middle = world.geometry().centre_of(Cell::new(width / 2, height / 2));
        let middle = Pose::new(middle.x, middle.y, 0.0);
        world
            .nearest_free_pose(&footprint, &middle, PI, START_CLEARANCE_M, |_| true)
            .ok_or_else(|| {
                let why =
                    "no free pose is near its middle: say where the robot starts (--start-pose)";
                unusable(why.to_owned())
            })
    }
}
