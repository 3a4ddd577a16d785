//! `recording.json` in the folder of a run: what a replay of the run shows, without the scenario,
//! the map files or the robot's description.

use crate::film::Rates;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use zeronav_measure::timings::Timings;

/// Its name in the folder of a run.
pub(crate) const FILE: &str = "recording.json";

/// A recorded run. Times are run time since the first goal [s]; everything lies in the `map` frame
/// unless it says otherwise.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Recording {
    /// Name of the scenario.
    pub scenario: String,
    /// Its title.
    #[serde(default)]
    pub title: String,
    /// `reached`, or why not.
    pub outcome: String,
    /// The verdict in words.
    #[serde(default)]
    pub reason: String,
    /// `real_time` or `lockstep`.
    #[serde(default)]
    pub mode: String,
    /// Seed.
    #[serde(default)]
    pub seed: u64,
    /// Duration. [s]
    pub time_s: f64,
    /// Distance driven. [m]
    pub driven_m: f64,
    /// Contacts with anything.
    pub contacts: u32,
    /// Lower-left and upper-right corner of the static map. [m]
    pub area_m: [[f64; 2]; 2],
    /// Occupied rectangles of the static map: x and y of the lower-left corner, width, height. [m]
    pub walls_m: Vec<[f64; 4]>,
    /// Outline of the robot, frame `base`. [m]
    pub footprint_m: Vec<[f64; 2]>,
    /// Goals: x [m], y [m], yaw [rad].
    pub goals: Vec<[f64; 3]>,
    /// True poses of the robot, ten a second: time [s], x [m], y [m], yaw [rad].
    pub robot: Vec<[f64; 4]>,
    /// Scripted obstacles that appeared.
    pub obstacles: Vec<RecordedObstacle>,
    /// Paths that were found, by time.
    pub paths: Vec<RecordedPath>,
    /// Run time of the first goal, which is 0 here. [s]
    #[serde(default)]
    pub first_goal_s: f64,
    /// Run time of a tick. [s]
    #[serde(default)]
    pub tick_s: f64,
    /// The command that made the run.
    #[serde(default)]
    pub command: Vec<String>,
    /// Beginnings of interventions of the guard: time [s] and reason.
    #[serde(default)]
    pub interventions: Vec<(f64, String)>,
    /// Interventions beyond those.
    #[serde(default)]
    pub interventions_left_out: u64,
    /// Histograms and the slowest answers.
    #[serde(default)]
    pub timings: Timings,
    /// How often the samples of the scene were taken.
    #[serde(default)]
    pub rates: Rates,
    /// What a player shows, in the format of `services/viewer/page/README.md`; null when nothing was
    /// seen, and for runs of a suite that passed.
    #[serde(default)]
    pub scene: Option<Value>,
}

/// A scripted obstacle of a recording.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct RecordedObstacle {
    /// Its name.
    pub name: String,
    /// Its outline in its own frame. [m]
    pub outline_m: Vec<[f64; 2]>,
    /// Its poses since it appeared: time [s], x [m], y [m], yaw [rad]. Each holds until the next.
    pub poses: Vec<[f64; 4]>,
}

/// A path of a recording; it holds until the next one.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct RecordedPath {
    /// Time. [s]
    pub time_s: f64,
    /// Why it was planned.
    pub cause: String,
    /// Length. [m]
    pub length_m: f64,
    /// Its corners. [m]
    pub points_m: Vec<[f64; 2]>,
}

impl Recording {
    /// Accepts a recording that can be drawn: an area, finite numbers, a pose of the robot, and poses
    /// of every obstacle.
    ///
    /// # Errors
    /// What is wrong, in a few words.
    pub(crate) fn check(&self) -> Result<(), &'static str> {
        let [low, high] = self.area_m;
        let poses = self.obstacles.iter().map(|obstacle| &obstacle.poses);
        let mut poses = poses.chain([&self.robot]);
        let numbers = self
            .area_m
            .as_flattened()
            .iter()
            .chain(self.walls_m.as_flattened());
        let numbers = numbers.chain(self.footprint_m.as_flattened());
        let numbers = numbers.chain(self.goals.as_flattened());
        let numbers = numbers.chain(self.robot.as_flattened());
        if !self.time_s.is_finite() || !numbers.copied().all(f64::is_finite) {
            return Err("a number is not finite");
        }
        if high[0] <= low[0] || high[1] <= low[1] {
            return Err("area_m is empty");
        }
        if poses.any(Vec::is_empty) {
            return Err("the robot or an obstacle has no pose");
        }
        Ok(())
    }
}

/// The first of `all` and the last ones, `most` together.
pub(super) fn first_and_last<T>(all: &[T], most: usize) -> Vec<&T> {
    let skipped = all.len().saturating_sub(most);
    let shown = all
        .iter()
        .enumerate()
        .filter(|(at, _)| *at == 0 || *at > skipped);
    shown.map(|(_, one)| one).collect()
}

/// `poses` with a yaw that does not jump by a turn.
pub(super) fn unwrapped(poses: &[[f64; 4]]) -> Vec<[f64; 4]> {
    use core::f64::consts::TAU;
    let mut poses = poses.to_vec();
    for at in 1..poses.len() {
        let before = poses[at - 1][3];
        poses[at][3] = before + (poses[at][3] - before + 0.5 * TAU).rem_euclid(TAU) - 0.5 * TAU;
    }
    poses
}
