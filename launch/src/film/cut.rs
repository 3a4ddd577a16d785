//! From a film to the scene that the renderer plays: one list of frames over the time of a run.

use super::Film;
use super::samples::{Moving, Planned};
use super::thinned::{Sample, Thinned};
use serde::{Deserialize, Serialize};
use zeronav_msgs::command::Intervention;
use zeronav_msgs::time::seconds;
use zeronav_viewer::scene::{FORMAT, Fixed, Frame, MapPatch, Robot, Rounded};

/// What is shown of the film.
#[derive(Debug, Clone)]
pub(crate) struct Cut<'a> {
    /// Name of the scenario.
    pub scenario: &'a str,
    /// `real_time` or `lockstep`.
    pub mode: &'a str,
    /// Run time that is 0 on the page. [ns]
    pub from_ns: u64,
    /// Run time of the end. [ns]
    pub until_ns: u64,
}

/// A scene in the format of the renderer.
#[derive(Debug, Serialize)]
pub(crate) struct Scene {
    fixed: Fixed,
    frames: Vec<Frame>,
}

/// Time from sample to sample. [s]
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub(crate) struct Rates {
    /// Of poses.
    pub pose_s: f64,
    /// Of scans.
    pub scan_s: f64,
    /// Of the map, at least.
    pub map_s: f64,
    /// True when the drive was so long that samples were left out.
    pub thinned: bool,
}

/// The samples of one kind that have not been put into a frame.
struct Rest<'a, T> {
    samples: &'a [(u64, T)],
}

impl<'a, T: Sample> Rest<'a, T> {
    fn of(all: &'a Thinned<T>) -> Self {
        Self {
            samples: all.samples(),
        }
    }

    /// All up to this run time. [ns]
    fn until(&mut self, run_ns: u64) -> &'a [(u64, T)] {
        let n = self.samples.partition_point(|(at, _)| *at <= run_ns);
        let (taken, rest) = self.samples.split_at(n);
        self.samples = rest;
        taken
    }

    /// The newest up to this run time, when it is a new one. [ns]
    fn newest(&mut self, run_ns: u64) -> Option<T>
    where
        T: Clone,
    {
        self.until(run_ns).last().map(|(_, sample)| sample.clone())
    }
}

impl Film {
    /// The scene of a run; `None` when nothing was seen of the robot.
    pub(crate) fn scene(&self, cut: &Cut<'_>) -> Option<Scene> {
        let robot: Robot = self.robot.clone()?;
        let poses = self.poses.samples();
        let shown = |at: &u64| (cut.from_ns..=cut.until_ns).contains(at);
        let mut truths = Rest::of(&self.truths);
        let mut controls = Rest::of(&self.controls);
        let mut scans = Rest::of(&self.scans);
        let mut tracked = Rest::of(&self.tracked);
        let mut bodies = Rest::of(&self.bodies);
        let mut paths = Rest::of(&self.paths);
        let mut goals = Rest::of(&self.goals);
        let mut zones = Rest::of(&self.zones);
        let mut tasks = Rest::of(&self.tasks);
        let mut certainties = Rest::of(&self.certainties);
        let mut maps = Rest::of(&self.maps);
        let mut frames = Vec::new();
        for (at, moving) in poses.iter().filter(|(at, _)| shown(at)) {
            let at = *at;
            frames.push(Frame {
                time_s: Rounded::thousandths(seconds(at - cut.from_ns)),
                tick: moving.tick,
                robot: moving.robot(),
                truth: truths.newest(at),
                scan: scans.newest(at),
                obstacles: tracked.newest(at),
                bodies: bodies.newest(at),
                path: paths.newest(at).map(|planned| planned.scene()),
                rollouts: None,
                goals: goals.newest(at),
                zones: zones.newest(at),
                task: tasks.newest(at),
                certainty: certainties.newest(at),
                control: controls.newest(at),
                map: patch(maps.until(at)),
                events: Vec::new(),
            });
        }
        let fixed = Fixed {
            format: FORMAT,
            scenario: cut.scenario.to_owned(),
            mode: cut.mode.to_owned(),
            robot,
        };
        (!frames.is_empty()).then_some(Scene { fixed, frames })
    }

    /// How often samples were taken in the end.
    pub(crate) fn rates(&self) -> Rates {
        let thinned = self.poses.period_ns() > super::POSE_NS
            || self.scans.period_ns() > super::SCAN_NS
            || self.maps.period_ns() > super::MAP_NS;
        Rates {
            pose_s: seconds(self.poses.period_ns()),
            scan_s: seconds(self.scans.period_ns()),
            map_s: seconds(self.maps.period_ns()),
            thinned,
        }
    }

    /// When the guard began to step in [ns], and why; and how often beyond what is kept.
    pub(crate) fn interventions(&self) -> (&[(u64, Intervention)], u64) {
        (&self.interventions, self.interventions_left_out)
    }

    /// Where the robot was, by run time. [ns]
    pub(crate) fn poses(&self) -> &[(u64, Moving)] {
        self.poses.samples()
    }

    /// The paths, by run time. [ns]
    pub(crate) fn paths(&self) -> &[(u64, Planned)] {
        self.paths.samples()
    }
}

/// Several patches as one.
fn patch(patches: &[(u64, super::Patch)]) -> Option<MapPatch> {
    let mut tiles = std::collections::BTreeMap::new();
    let mut grid = None;
    for (_, patch) in patches {
        if patch.grid.is_some() {
            grid = patch.grid;
            tiles.clear();
        }
        tiles.extend(patch.tiles.iter().map(|(at, tile)| (*at, tile.clone())));
    }
    (!patches.is_empty()).then(|| MapPatch {
        grid,
        tiles: tiles.into_values().collect(),
    })
}
