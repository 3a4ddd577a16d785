//! Mapping as a process: answers every scan with the tiles that changed.

mod told;

use nalgebra::Point2;
use std::process::ExitCode;
use zeronav_mapping::{Mapping, MappingConfig, MappingError, Observation, TileIndex, all_tiles};
use zeronav_msgs::grid::GridGeometry;
use zeronav_msgs::header::{Id, Parents};
use zeronav_msgs::health::{REASON_ODOMETRY, REASON_SCAN};
use zeronav_msgs::map::{MapInfo, TILES_PER_UPDATE_MAX, tiles_of};
use zeronav_msgs::obstacles::{OBSTACLES_MAX, Obstacle, Obstacles};
use zeronav_msgs::pose::Pose;
use zeronav_msgs::role::Role;
use zeronav_msgs::span::SpanKind;
use zeronav_msgs::task::{TaskKind, TaskState as State};
use zeronav_msgs::time::nanoseconds;
use zeronav_msgs::topics::{
    EVENT_NEED_KEYFRAME, MapKeyframe, MapObstacles, MapUpdate, RobotDescription, RobotOdometry,
    RobotScan, TaskState,
};
use zeronav_params::Parameter;
use zeronav_shell::clock::now_ns;
use zeronav_shell::doorbell::Rung;
use zeronav_shell::{
    Cycle, Draft, Latest, Sent, Service, Shell, StartError, Stream, Tasks, Track, Writer,
};
use zeronav_world::StaticMap;
use zeronav_world::map_file::{self, LoadedMap};

/// Least time between two keyframes. [ns]
const KEYFRAME_PAUSE_NS: u64 = 50_000_000;

/// Age of the newest scan from which the map is not current. [ns]
const STALE_NS: u64 = 500_000_000;

/// Where the robot is going: the task, and how far the local planner has come with it.
struct Going {
    tasks: Tasks,
    status: Stream<TaskState>,
    /// The last two, the newer one last.
    statuses: [Status; 2],
}

/// What counts of a message of `task/status`.
#[derive(Debug, Clone, Copy, Default)]
struct Status {
    tick: u64,
    task: u64,
    goal: u64,
    active: bool,
}

impl Going {
    fn open(shell: &Shell) -> Result<Self, StartError> {
        Ok(Self {
            tasks: Tasks::open(shell.peer())?,
            status: shell.peer().stream()?,
            statuses: [Status::default(); 2],
        })
    }

    fn poll(&mut self, shell: &Shell) {
        self.tasks.poll(shell.roster());
        let statuses = &mut self.statuses;
        self.status.drain(shell.roster(), |view| {
            let active = matches!(view.meta.state(), Some(State::Idle | State::Active));
            let news = Status {
                tick: view.header.tick,
                task: view.meta.task,
                goal: view.meta.goal,
                active,
            };
            *statuses = [statuses[1], news];
        });
    }

    /// The goal at hand at `tick`. In lockstep a status counts from the tick after its own on, so
    /// that it does not matter which of the two is faster.
    fn goal(&mut self, tick: u64, lockstep: bool) -> Option<Point2<f64>> {
        let task = self.tasks.at(tick)?;
        if task.kind != TaskKind::Go {
            return None;
        }
        let counts =
            |status: &&Status| status.task == task.id.0 && (!lockstep || status.tick < tick);
        let status = self.statuses.iter().rev().find(counts);
        let at_hand = status.map_or(0, |status| status.goal);
        if status.is_some_and(|status| !status.active) {
            return None;
        }
        let named = task.goals.iter().find(|goal| goal.id == at_hand);
        named.or(task.goals.first()).map(|goal| goal.pose.point())
    }
}

struct MappingService {
    config: MappingConfig,
    static_map: Option<StaticMap>,
    geometry: GridGeometry,
    mapping: Option<Mapping>,
    /// Read when somebody needs it: regularisation.
    going: Option<Going>,
    description: Latest<RobotDescription>,
    odometry: Stream<RobotOdometry>,
    scan: Latest<RobotScan>,
    update: Writer<MapUpdate>,
    keyframe: Writer<MapKeyframe>,
    moving: Writer<MapObstacles>,
    obstacles: Vec<Obstacle>,
    track: Track,
    /// Tiles that changed and are not out yet.
    tiles: Vec<TileIndex>,
    /// Revision that readers can have.
    revision: Id,
    answered_tick: u64,
    keyframe_wanted: bool,
    keyframe_ns: u64,
    scan_came_ns: u64,
    /// Scans keep coming.
    current: bool,
    told: told::Told,
}

/// The static map, if there is one, and the grid.
fn map_of(config: &MappingConfig) -> Result<(Option<LoadedMap>, GridGeometry), StartError> {
    let Some(file) = &config.static_map else {
        return Ok((None, config.geometry().map_err(unusable)?));
    };
    let loaded = map_file::load(file).map_err(|error| StartError::config("static_map", error))?;
    let geometry = loaded.map.geometry;
    geometry
        .check()
        .map_err(|refusal| StartError::config("static_map", refusal))?;
    Ok((Some(loaded), geometry))
}

fn unusable(error: MappingError) -> StartError {
    match error {
        MappingError::NoArea => StartError::config("area_m", "required without static_map"),
        MappingError::Geometry(_) => StartError::config("area_m", error),
        MappingError::StaticMap { .. } => StartError::config("static_map", error),
        MappingError::Parameter(error) => error.into(),
    }
}

impl Service for MappingService {
    const ROLE: Role = Role::Mapping;
    type Config = MappingConfig;

    fn parameters() -> Vec<Parameter> {
        zeronav_params::describe::<MappingConfig>()
    }

    fn check(config: &MappingConfig) -> Result<(), StartError> {
        let (_, geometry) = map_of(config)?;
        config.check(geometry.resolution_m)?;
        match &config.save_to {
            Some(folder) if !folder.is_dir() => {
                let why = format!("there is no folder {}", folder.display());
                Err(StartError::config("save_to", why))
            }
            _ => Ok(()),
        }
    }

    fn open(shell: &mut Shell, config: MappingConfig) -> Result<Self, StartError> {
        let (loaded, geometry) = map_of(&config)?;
        for warning in loaded.iter().flat_map(|loaded| &loaded.warnings) {
            tracing::warn!("{warning}");
        }
        let static_map = loaded.map(|loaded| loaded.map);
        let most_tiles = config.window.most_tiles(&geometry);
        let going = if config.regularisation.enabled {
            Some(Going::open(shell)?)
        } else {
            None
        };
        let peer = shell.peer();
        Ok(Self {
            config,
            going,
            static_map,
            geometry,
            mapping: None,
            description: peer.latest()?,
            odometry: peer.stream()?,
            scan: peer.latest()?,
            update: peer.writer(TILES_PER_UPDATE_MAX)?,
            keyframe: peer.writer(most_tiles)?,
            moving: peer.writer(OBSTACLES_MAX)?,
            obstacles: Vec::with_capacity(OBSTACLES_MAX),
            track: Track::default(),
            tiles: Vec::with_capacity(most_tiles),
            revision: Id::NONE,
            answered_tick: 0,
            keyframe_wanted: false,
            keyframe_ns: 0,
            scan_came_ns: 0,
            current: true,
            told: told::Told::default(),
        })
    }

    fn wake(&mut self, shell: &mut Shell, rung: Rung) -> Result<Option<u64>, StartError> {
        self.keyframe.refresh();
        let roster = shell.roster();
        self.description.poll(roster);
        // Odometry first: it is sent after the scan of its tick, so that the scan is there, too.
        let track = &mut self.track;
        self.odometry
            .drain(roster, |view| track.push(view.header, view.meta));
        if self.scan.poll(roster) {
            self.scan_came_ns = shell.woken_ns();
        }
        if let Some(going) = &mut self.going {
            going.poll(shell);
        }
        shell.totals(
            self.odometry.refused() + self.scan.refused() + self.description.refused(),
            self.scan.superseded(),
        );
        if !shell.roster().has_clock() || !self.start(shell)? {
            return Ok(None);
        }
        let tick = self.scan.tick();
        if tick > self.answered_tick {
            // Until the odometry around the capture is there, too.
            if let Some(poses) = self.poses_of_scan() {
                self.answer(shell, poses);
            }
        }
        let silent = shell.woken_ns().saturating_sub(self.scan_came_ns) > STALE_NS
            && !shell.roster().lockstep();
        shell.reason(REASON_SCAN, silent);
        if silent && self.current {
            self.say_not_current(shell);
        }
        shell.reason(REASON_ODOMETRY, tick > self.answered_tick);
        self.keyframe_wanted |= rung.has(EVENT_NEED_KEYFRAME);
        self.send_keyframe_if_due(shell);
        Ok(None)
    }
}

impl MappingService {
    /// Makes the map once the robot is known; true when there is one.
    fn start(&mut self, shell: &mut Shell) -> Result<bool, StartError> {
        if self.mapping.is_some() {
            return Ok(true);
        }
        let Some(description) = self.description.get() else {
            return Ok(false);
        };
        let mapping = Mapping::new(
            &self.config,
            self.static_map.take().as_ref(),
            description.meta,
            description.items,
        )
        .map_err(unusable)?;
        self.mapping = Some(mapping);
        let (width, height) = (self.geometry.width, self.geometry.height);
        let resolution_m = self.geometry.resolution_m;
        tracing::info!(width, height, resolution_m, "the map begins");
        // The first revision is the static map: an empty update, and a keyframe that holds it.
        let draft = shell.draft(0, 0, 0, Parents::default());
        let output = self.send_updates(shell, &draft);
        self.keyframe_wanted = true;
        self.send_keyframe_if_due(shell);
        shell.finish(&Cycle {
            kind: SpanKind::Idle,
            draft,
            output,
            work: 0,
        });
        shell.ready();
        Ok(true)
    }

    /// `odom_from_base` at the capture of the newest scan's first and last beam.
    fn poses_of_scan(&self) -> Option<(Pose, Pose)> {
        let scan = self.scan.get()?;
        let last_ns = scan.header.run_ns;
        let last = self.track.pose_at(last_ns)?;
        let steps = f64::from(scan.meta.n_beams.saturating_sub(1));
        let turn_ns = nanoseconds(steps * f64::from(scan.meta.time_increment_s));
        if turn_ns == 0 {
            return Some((last, last));
        }
        // The first turn began before the first odometry.
        let first = self.track.pose_at(last_ns.saturating_sub(turn_ns));
        Some((first.unwrap_or(last), last))
    }

    fn answer(&mut self, shell: &mut Shell, (first, last): (Pose, Pose)) {
        let (Some(scan), Some(mapping)) = (self.scan.get(), &mut self.mapping) else {
            return;
        };
        let header = scan.header;
        let tick = header.tick;
        let lockstep = shell.roster().lockstep();
        let newest = self.track.newest();
        let goal = self
            .going
            .as_mut()
            .and_then(|going| going.goal(tick, lockstep));
        let parents = Parents {
            odometry: newest.map_or(0, |moment| moment.id.0),
            scan: header.id,
            ..Parents::default()
        };
        let work = u64::from(scan.meta.n_beams);
        let draft = shell.draft(tick, header.run_ns, header.capture_ns, parents);
        mapping.take_in(&Observation {
            scan: scan.meta,
            ranges: scan.items,
            run_ns: header.run_ns,
            odom_from_base_first: first,
            odom_from_base: last,
            odometry_variance: newest.map_or([0.0; 3], |moment| moment.odometry.variance),
            goal,
        });
        mapping.mapper_mut().take_dirty_tiles(&mut self.tiles);
        self.obstacles.clear();
        self.obstacles.extend(mapping.obstacles());
        let (map_from_odom, _) = mapping.map_from_odom();
        (self.told).tell(tick, header.run_ns, &map_from_odom, self.obstacles.len());
        let moved = mapping.take_moved();
        self.current = true;
        self.send_obstacles(shell, &draft);
        if moved {
            self.move_map();
        }
        let output = self.send_updates(shell, &draft);
        if moved {
            // Readers are out of step until they have it.
            self.keyframe_ns = 0;
            self.keyframe_wanted = true;
            self.send_keyframe_if_due(shell);
        }
        self.answered_tick = tick;
        shell.finish(&Cycle {
            kind: SpanKind::Answer,
            draft,
            output,
            work,
        });
    }

    /// The map lies elsewhere: its tiles come with the keyframe, an update has none.
    fn move_map(&mut self) {
        self.tiles.clear();
        if let Some(mapping) = &self.mapping {
            self.geometry = *mapping.mapper().geometry();
            tracing::info!(
                width = self.geometry.width,
                height = self.geometry.height,
                "the map moves to the robot"
            );
        }
    }

    fn send_obstacles(&mut self, shell: &mut Shell, draft: &Draft) {
        let meta = Obstacles {
            n_obstacles: self.obstacles.len() as u64,
        };
        let sent = self.moving.publish(draft, meta, &self.obstacles);
        shell.sent(&self.moving, sent);
    }

    /// Scans have stopped coming: an empty revision that says so.
    fn say_not_current(&mut self, shell: &mut Shell) {
        self.current = false;
        tracing::warn!("scans have stopped coming, the map is not current");
        let (tick, run_ns, capture_ns) = self.scan.get().map_or((0, 0, 0), |scan| {
            let header = scan.header;
            (header.tick, header.run_ns, header.capture_ns)
        });
        let draft = shell.draft(tick, run_ns, capture_ns, Parents::default());
        let output = self.send_updates(shell, &draft);
        shell.finish(&Cycle {
            kind: SpanKind::Extra,
            draft,
            output,
            work: 0,
        });
    }

    fn info(&self, revision: Id) -> MapInfo {
        let mapping = self.mapping.as_ref();
        let (map_from_odom, covariance) =
            mapping.map_or_else(Default::default, Mapping::map_from_odom);
        MapInfo {
            geometry: self.geometry,
            revision: revision.0,
            map_from_odom,
            covariance,
            clearance_limit_mm: mapping.map_or(1, |mapping| {
                u32::from(mapping.mapper().clearance_limit_mm())
            }),
            parts: 1,
            current: u32::from(self.current),
            ..MapInfo::default()
        }
    }

    /// Sends the changed tiles as one revision, in as many parts as it takes. What could not be
    /// sent for lack of memory goes out with the next revision.
    fn send_updates(&mut self, shell: &mut Shell, draft: &Draft) -> Option<Sent> {
        let parts = self.tiles.len().div_ceil(TILES_PER_UPDATE_MAX).max(1);
        let last_id = Id(self.update.next_id().0 + parts as u64 - 1);
        let info = self.info(last_id);
        let mapper = self.mapping.as_ref()?.mapper();
        let mut sent = None;
        for part in 0..parts {
            let from = part * TILES_PER_UPDATE_MAX;
            let until = (from + TILES_PER_UPDATE_MAX).min(self.tiles.len());
            let tiles = &self.tiles[from..until];
            let published = self.update.publish_with(draft, tiles.len(), |slot| {
                for (tile, index) in slot.iter_mut().zip(tiles) {
                    mapper.fill_tile(*index, tile);
                }
                MapInfo {
                    part: u16::try_from(part).unwrap_or(u16::MAX),
                    parts: u16::try_from(parts).unwrap_or(u16::MAX),
                    n_tiles: u32::try_from(tiles.len()).unwrap_or(u32::MAX),
                    ..info
                }
            });
            sent = shell.sent(&self.update, published);
            sent?;
        }
        self.tiles.clear();
        self.revision = last_id;
        sent
    }

    fn send_keyframe_if_due(&mut self, shell: &mut Shell) {
        let now = now_ns();
        let due = self.keyframe_ns == 0 || now - self.keyframe_ns >= KEYFRAME_PAUSE_NS;
        // Tiles that wait for memory are in the map but not in the revision.
        let (Some(mapper), true, true, true) = (
            self.mapping.as_ref().map(Mapping::mapper),
            self.keyframe_wanted,
            due,
            self.tiles.is_empty(),
        ) else {
            return;
        };
        let (columns, rows) = tiles_of(mapper.geometry());
        let info = self.info(self.revision);
        let draft = shell.draft(0, 0, 0, Parents::default());
        let n_tiles = columns * rows;
        let published = self
            .keyframe
            .publish_with(&draft, n_tiles as usize, |slot| {
                for (tile, index) in slot.iter_mut().zip(all_tiles(mapper.geometry())) {
                    mapper.fill_tile(index, tile);
                }
                MapInfo { n_tiles, ..info }
            });
        if shell.sent(&self.keyframe, published).is_some() {
            self.keyframe_wanted = false;
            self.keyframe_ns = now;
        }
    }
}

impl Drop for MappingService {
    /// The process was asked to stop: what it has learned is written where the user wants it.
    fn drop(&mut self) {
        let (Some(folder), Some(mapping)) = (&self.config.save_to, &self.mapping) else {
            return;
        };
        let map = mapping.mapper().as_static_map();
        match map_file::save(&map, folder, "map") {
            Ok(file) => tracing::info!(file = %file.display(), "map saved"),
            Err(error) => tracing::error!("the map could not be saved: {error}"),
        }
    }
}

fn main() -> ExitCode {
    zeronav_shell::run::<MappingService>()
}
