//! The film of a run: what the renderer plays back, sampled a few times a second within a budget of
//! bytes. It is fed from what launch hears anyway, scans and velocity requests besides, and nothing
//! that is judged depends on it.
//!
//! Each kind of sample has a budget of its own. When that is used up, every second sample goes and
//! the rate is halved, so the film of an hour is as large as that of five minutes and coarser.
//!
//! Poses and scans are where mapping placed their own tick, so that those of a lockstep run are the same however
//! late anything was heard, and in whatever order a recording holds them.

mod cut;
mod held;
mod samples;
mod thinned;

pub(crate) use cut::{Cut, Rates};

use held::{Held, HeldOdometry};
use samples::{Moving, Patch, Planned, beams_kept};
use std::collections::{BTreeMap, BTreeSet, VecDeque};
use thinned::Thinned;
use zeronav_msgs::Pose;
use zeronav_msgs::certainty::PoseCertainty;
use zeronav_msgs::command::{Intervention, VelocityCommand, VelocityRequest};
use zeronav_msgs::description::{Corner, Description};
use zeronav_msgs::map::MapTile;
use zeronav_msgs::obstacles::Obstacle;
use zeronav_msgs::odometry::Odometry;
use zeronav_msgs::path::{Path, Waypoint};
use zeronav_msgs::replica::MapReplica;
use zeronav_msgs::scan::Scan;
use zeronav_msgs::task::{Goal, TaskState};
use zeronav_msgs::zones::ZonePart;
use zeronav_viewer::scene::{
    Control, Grid, Robot, Rounded, SceneGoal, SceneScan, SceneZone, Tile, Tracked, point, pose,
};

/// Between two poses, and two places of a scripted obstacle. [ns]
const POSE_NS: u64 = 100_000_000;
/// Between two scans, and two lists of tracked obstacles. [ns]
const SCAN_NS: u64 = 200_000_000;
/// Between two looks at what changed on the map. [ns]
const MAP_NS: u64 = 500_000_000;

/// Room for each kind of sample. [bytes] Together they leave half a megabyte of a report of 3 MB to
/// the page and its tables.
const POSES_BYTES: usize = 500_000;
const SCANS_BYTES: usize = 700_000;
const TRACKED_BYTES: usize = 200_000;
const BODIES_BYTES: usize = 150_000;
const PATHS_BYTES: usize = 250_000;
const MAP_BYTES: usize = 500_000;
const TASK_BYTES: usize = 20_000;
const ZONES_BYTES: usize = 200_000;

/// Interventions of the guard that are kept at most: the first ones.
const INTERVENTIONS_MAX: usize = 2000;

/// Requests that are remembered for the commands that refer to them.
const RECENT_MAX: usize = 64;

/// Commands that wait for their requests at most.
const EARLY_MAX: usize = 32;

/// Tiles that are remembered, so that one that comes again unchanged takes no room.
const TILES_MAX: usize = zeronav_msgs::map::TILES_PER_KEYFRAME_MAX;

/// See the module's description. Times are run times. [ns]
#[derive(Debug)]
pub(crate) struct Film {
    robot: Option<Robot>,
    base_from_laser: Pose,
    poses: Thinned<Moving>,
    truths: Thinned<[Rounded; 3]>,
    controls: Thinned<Control>,
    scans: Thinned<SceneScan>,
    tracked: Thinned<Vec<Tracked>>,
    bodies: Thinned<Vec<Vec<[Rounded; 2]>>>,
    paths: Thinned<Planned>,
    maps: Thinned<Patch>,
    goals: Thinned<Vec<SceneGoal>>,
    zones: Thinned<Vec<SceneZone>>,
    tasks: Thinned<&'static str>,
    certainties: Thinned<&'static str>,
    interventions: Vec<(u64, Intervention)>,
    interventions_left_out: u64,
    /// Why the guard steps in at the moment.
    stepping_in: Option<Intervention>,
    held: Held,
    requests: VecDeque<(u64, VelocityRequest)>,
    /// Commands that were heard before the request that they rest on, and those behind them.
    early: VecDeque<Early>,
    task: Vec<Goal>,
    tiles: BTreeMap<(u32, u32), Tile>,
    grid: Option<Grid>,
    dirty: BTreeSet<(u32, u32)>,
    all_dirty: bool,
    map_looked_ns: Option<u64>,
}

impl Default for Film {
    fn default() -> Self {
        Self {
            robot: None,
            base_from_laser: Pose::default(),
            poses: Thinned::new(POSE_NS, POSES_BYTES / 2),
            truths: Thinned::new(POSE_NS, POSES_BYTES / 5),
            controls: Thinned::new(POSE_NS, POSES_BYTES / 3),
            scans: Thinned::new(SCAN_NS, SCANS_BYTES),
            tracked: Thinned::new(SCAN_NS, TRACKED_BYTES),
            bodies: Thinned::new(POSE_NS, BODIES_BYTES),
            paths: Thinned::new(0, PATHS_BYTES),
            maps: Thinned::new(MAP_NS, MAP_BYTES),
            goals: Thinned::new(0, TASK_BYTES),
            zones: Thinned::new(0, ZONES_BYTES),
            tasks: Thinned::new(0, TASK_BYTES),
            certainties: Thinned::new(0, TASK_BYTES),
            interventions: Vec::new(),
            interventions_left_out: 0,
            stepping_in: None,
            held: Held::default(),
            requests: VecDeque::new(),
            early: VecDeque::new(),
            task: Vec::new(),
            tiles: BTreeMap::new(),
            grid: None,
            dirty: BTreeSet::new(),
            all_dirty: false,
            map_looked_ns: None,
        }
    }
}

impl Film {
    /// The robot says what it is.
    pub(crate) fn description(&mut self, description: &Description, corners: &[Corner]) {
        self.robot = Some(Robot::of(description, corners));
        self.base_from_laser = description.base_from_laser;
    }

    /// Where the robot really is, and the outlines of the scripted obstacles when asked for.
    pub(crate) fn truth(
        &mut self,
        run_ns: u64,
        map_from_base: &Pose,
        bodies: impl FnOnce() -> Vec<Vec<[Rounded; 2]>>,
    ) {
        if self.truths.is_due(run_ns) {
            self.truths.push(run_ns, pose(map_from_base));
        }
        if self.bodies.is_due(run_ns) {
            let outlines = bodies();
            let newest = self.bodies.samples().last();
            if newest.map_or(!outlines.is_empty(), |(_, before)| *before != outlines) {
                self.bodies.push(run_ns, outlines);
            }
        }
    }

    /// Where the wheels say it is.
    pub(crate) fn odometry(&mut self, tick: u64, run_ns: u64, odometry: &Odometry) {
        self.held.add(HeldOdometry {
            tick,
            run_ns,
            odometry: *odometry,
        });
        self.settle();
    }

    /// Nothing more comes.
    pub(crate) fn end(&mut self) {
        self.held.end();
        self.settle();
        self.show_early(0);
    }

    /// Takes in what was held back and has its place by now.
    fn settle(&mut self) {
        while let Some(next) = self.held.next() {
            if self.poses.is_due(next.run_ns)
                && let Some(map_from_odom) = self.held.place_at(next.tick)
            {
                let moving = Moving {
                    tick: next.tick,
                    pose: map_from_odom.then(&next.odometry.pose),
                    v_mps: next.odometry.v_mps,
                    w_radps: next.odometry.w_radps,
                };
                self.poses.push(next.run_ns, moving);
            }
            while let Some(scan) = self.held.next_scan(next.tick) {
                if self.scans.is_due(scan.run_ns)
                    && let Some(map_from_base) = self.held.place_of(&scan)
                {
                    let map_from_laser = map_from_base.then(&self.base_from_laser);
                    let sample = SceneScan::of(&scan.scan, &scan.ranges_m, &map_from_laser);
                    self.scans.push(scan.run_ns, sample);
                }
            }
        }
    }

    /// What the local planner asked for.
    pub(crate) fn request(&mut self, id: u64, request: &VelocityRequest) {
        remember(&mut self.requests, id, *request);
        for early in self.early.iter_mut().filter(|early| early.id == id) {
            early.request = Some(*request);
        }
        self.show_early(EARLY_MAX);
    }

    /// What the guard made of the request with this id.
    pub(crate) fn command(&mut self, run_ns: u64, request: u64, command: &VelocityCommand) {
        let intervention = command.intervention();
        if intervention != self.stepping_in {
            self.stepping_in = intervention;
            match intervention {
                None | Some(Intervention::None) => {}
                Some(why) if self.interventions.len() < INTERVENTIONS_MAX => {
                    self.interventions.push((run_ns, why));
                }
                Some(_) => self.interventions_left_out += 1,
            }
        }
        let heard = recalled(&self.requests, request);
        self.early.push_back(Early {
            run_ns,
            id: request,
            request: heard.or((request == 0).then(VelocityRequest::default)),
            command: *command,
        });
        self.show_early(EARLY_MAX);
    }

    /// Shows the commands of which the request has been heard, in their order; of those that wait for one, `kept` stay.
    fn show_early(&mut self, kept: usize) {
        while let Some(early) = self.early.front().copied() {
            if early.request.is_none() && self.early.len() <= kept {
                break;
            }
            self.early.pop_front();
            if self.controls.is_due(early.run_ns) {
                let control = Control::of(&early.request.unwrap_or_default(), &early.command);
                self.controls.push(early.run_ns, control);
            }
        }
    }

    /// A scan.
    pub(crate) fn scan(&mut self, tick: u64, run_ns: u64, scan: &Scan, ranges_m: &[f32]) {
        let (scan, ranges_m) = beams_kept(scan, ranges_m);
        (self.held).add_scan(tick, run_ns, scan, ranges_m.into_owned());
    }

    /// What mapping follows.
    pub(crate) fn tracked(&mut self, run_ns: u64, obstacles: &[Obstacle]) {
        if !self.tracked.is_due(run_ns) {
            return;
        }
        let newest = self.tracked.samples().last();
        let was_empty = newest.is_none_or(|(_, before)| before.is_empty());
        if !(was_empty && obstacles.is_empty()) {
            let tracked = obstacles.iter().map(Tracked::of).collect();
            self.tracked.push(run_ns, tracked);
        }
    }

    /// A new path.
    pub(crate) fn path(&mut self, run_ns: u64, path: &Path, waypoints: &[Waypoint]) {
        let (path, waypoints) = (*path, waypoints.to_vec());
        self.paths.push(run_ns, Planned { path, waypoints });
    }

    /// Goals were sent.
    pub(crate) fn goals(&mut self, run_ns: u64, goals: &[Goal], reached: &BTreeSet<u64>) {
        self.task = goals.to_vec();
        self.push_goals(run_ns, reached);
    }

    /// These zones hold.
    pub(crate) fn zones(&mut self, run_ns: u64, parts: &[ZonePart]) {
        let zones = parts.iter().map(SceneZone::of).collect();
        self.zones.push(run_ns, zones);
    }

    /// What became of them.
    pub(crate) fn task(&mut self, run_ns: u64, state: TaskState, reached: &BTreeSet<u64>) {
        let newest = self.tasks.samples().last();
        if newest.is_none_or(|(_, before)| *before != state.label()) {
            self.tasks.push(run_ns, state.label());
        }
        self.push_goals(run_ns, reached);
    }

    /// How far the robot knows where it is.
    pub(crate) fn certainty(&mut self, run_ns: u64, certainty: PoseCertainty) {
        let newest = self.certainties.samples().last();
        if newest.is_none_or(|(_, before)| *before != certainty.label()) {
            self.certainties.push(run_ns, certainty.label());
        }
    }

    fn push_goals(&mut self, run_ns: u64, reached: &BTreeSet<u64>) {
        let next = self
            .task
            .iter()
            .position(|goal| !reached.contains(&goal.id));
        let state = |at: usize, goal: &Goal| match next {
            _ if reached.contains(&goal.id) => "reached",
            Some(next) if next == at => "active",
            _ => "waiting",
        };
        let goals = self.task.iter().enumerate();
        let goals: Vec<SceneGoal> = goals
            .map(|(at, goal)| SceneGoal::new(&goal.pose, goal.tolerance_m, state(at, goal)))
            .collect();
        let newest = self.goals.samples().last();
        if newest.map_or(!goals.is_empty(), |(_, before)| *before != goals) {
            self.goals.push(run_ns, goals);
        }
    }

    /// Where mapping puts the odometry frame, from this tick on.
    pub(crate) fn placed(&mut self, tick: u64, map_from_odom: Pose) {
        self.held.place(tick, map_from_odom);
    }

    /// These tiles of the map were written.
    pub(crate) fn written(&mut self, tiles: &[MapTile]) {
        if self.dirty.len() + tiles.len() > TILES_MAX {
            self.all_dirty = true;
            self.dirty.clear();
        }
        if !self.all_dirty {
            (self.dirty).extend(tiles.iter().map(|tile| (tile.tile_x, tile.tile_y)));
        }
    }

    /// All of the map may be another one.
    pub(crate) fn written_all(&mut self) {
        self.all_dirty = true;
        self.dirty.clear();
    }

    /// Takes in what was written on the map since the last look.
    pub(crate) fn look_at_map(&mut self, run_ns: u64, replica: &MapReplica) {
        let period_ns = self.maps.period_ns();
        let is_due = (self.map_looked_ns)
            .is_none_or(|looked_ns| run_ns >= period_ns.saturating_add(looked_ns));
        let is_wanted = self.all_dirty || (is_due && !self.dirty.is_empty());
        if !is_wanted {
            return;
        }
        let Some(map) = replica.view() else {
            return;
        };
        self.map_looked_ns = Some(run_ns);
        let grid = Grid::of(map.geometry);
        let mut patch = Patch::default();
        if self.grid != Some(grid) {
            self.grid = Some(grid);
            self.tiles.clear();
            self.all_dirty = true;
            patch.grid = Some(grid);
        }
        if self.all_dirty {
            let (columns, rows) = zeronav_msgs::map::tiles_of(map.geometry);
            let all = (0..rows).flat_map(|y| (0..columns).map(move |x| (x, y)));
            self.dirty = all.take(TILES_MAX).collect();
            self.all_dirty = false;
        }
        for at in core::mem::take(&mut self.dirty) {
            let tile = samples::flags(&map, at);
            if self.tiles.get(&at) != Some(&tile) {
                self.tiles.insert(at, tile.clone());
                patch.tiles.insert(at, tile);
            }
        }
        if patch.grid.is_some() || !patch.tiles.is_empty() {
            self.maps.push(run_ns, patch);
        }
    }
}

/// A command, and the request that it rests on once that was heard.
#[derive(Debug, Clone, Copy)]
struct Early {
    run_ns: u64,
    /// Of the request; 0 = it rests on none.
    id: u64,
    request: Option<VelocityRequest>,
    command: VelocityCommand,
}

/// Adds the newest to what is remembered.
fn remember<T>(recent: &mut VecDeque<(u64, T)>, key: u64, value: T) {
    if recent.len() == RECENT_MAX {
        recent.pop_front();
    }
    recent.push_back((key, value));
}

/// What is remembered under `key`.
fn recalled<T: Copy>(recent: &VecDeque<(u64, T)>, key: u64) -> Option<T> {
    let found = recent.iter().rev().find(|(of, _)| *of == key);
    found.map(|(_, value)| *value)
}

/// The corners of an outline. [m]
pub(crate) fn outline(corners_m: &[nalgebra::Point2<f64>]) -> Vec<[Rounded; 2]> {
    corners_m.iter().map(|at| point(at.x, at.y)).collect()
}

#[cfg(test)]
pub(crate) mod tests;
