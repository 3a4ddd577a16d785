//! The one reader of a stack: takes in what is sent, and keeps the feed up to date.
//!
//! It polls and rings no doorbell, with one exception: only mapping can give the whole map to a
//! reader that joined late or fell behind, so it is asked for it, at most once a second.

use crate::events::Events;
use crate::feed::Feed;
use crate::scene::{
    Control, FORMAT, Fixed, Frame, Grid, Robot, Rounded, SceneGoal, ScenePath, SceneRollout,
    SceneScan, SceneZone, Tile, Tracked, outline, pose, robot,
};
use crate::status::Seats;
use std::collections::BTreeSet;
use std::time::{Duration, Instant};
use zeronav_msgs::grid::{CellRect, GridGeometry};
use zeronav_msgs::header::Id;
use zeronav_msgs::map::{MapTile, MapView, TILE_CELLS};
use zeronav_msgs::role::Role;
use zeronav_msgs::task::TaskState;
use zeronav_msgs::time::seconds;
use zeronav_msgs::topics::{
    ControlRequest, DebugRollouts, EVENT_NEED_KEYFRAME, GroundTruth, MapObstacles, PlanPath,
    RobotCommand, RobotDescription, RobotScan, SimPlacement, TaskGoal, TaskState as TaskStateTopic,
    TaskZones,
};
use zeronav_shell::doorbell::Bells;
use zeronav_shell::records::SpanReader;
use zeronav_shell::roster_reader::RosterReader;
use zeronav_shell::{Latest, MapInput, OdometryReader, Peer, StartError, Stream};

/// Least time between two frames.
const FRAME_PAUSE: Duration = Duration::from_millis(45);

/// Longest time between two frames while nothing comes.
const FRAME_AT_LEAST: Duration = Duration::from_millis(250);

/// Time between two reports on services and latencies.
const STATUS_PAUSE: Duration = Duration::from_millis(250);

/// Least time between two requests for the whole map.
const ASK_PAUSE: Duration = Duration::from_secs(1);

/// How long the map may take to come by itself.
const MAP_PAUSE: Duration = Duration::from_millis(300);

/// Run time for which rollouts are shown when none come after them. [ns]
const ROLLOUTS_NS: u64 = 500_000_000;

/// Time between two looks. The shortest queue holds 32 messages: 0.6 s in real time.
const PAUSE: Duration = Duration::from_millis(8);

/// The same in lockstep, where run time is a hundred times as fast.
const LOCKSTEP_PAUSE: Duration = Duration::from_millis(2);

/// The ports.
#[derive(Debug)]
struct Ports {
    roster: RosterReader,
    description: Latest<RobotDescription>,
    odometry: OdometryReader,
    scan: Latest<RobotScan>,
    map: MapInput,
    obstacles: Latest<MapObstacles>,
    paths: Stream<PlanPath>,
    goals: Latest<TaskGoal>,
    task: Latest<TaskStateTopic>,
    requests: Latest<ControlRequest>,
    commands: Stream<RobotCommand>,
    truth: Latest<GroundTruth>,
    placed: Latest<SimPlacement>,
    zones: Latest<TaskZones>,
    /// Revision of the newest zones.
    zones_revision: u64,
    spans: SpanReader,
}

impl Ports {
    fn open(peer: &Peer) -> Result<Self, StartError> {
        let mut roster = RosterReader::open(peer)?;
        roster.await_known()?;
        Ok(Self {
            roster,
            description: peer.latest()?,
            odometry: OdometryReader::open(peer)?,
            scan: peer.latest()?,
            map: MapInput::open(peer)?,
            obstacles: peer.latest()?,
            paths: peer.stream()?,
            goals: peer.latest()?,
            task: peer.latest()?,
            requests: peer.latest()?,
            commands: peer.stream()?,
            truth: peer.latest()?,
            placed: peer.latest()?,
            zones: peer.latest()?,
            zones_revision: 0,
            spans: peer.span_reader()?,
        })
    }
}

/// Reads a stack into a feed.
#[derive(Debug)]
pub(crate) struct Tap {
    ports: Ports,
    seats: Seats,
    events: Events,
    scenario: String,
    is_fixed: bool,
    /// What changed since the last frame.
    changed: Changed,
    /// Grid of the map that clients have.
    grid: Option<GridGeometry>,
    /// Tiles that clients do not have in their newest state: column and row.
    dirty: BTreeSet<(u32, u32)>,
    path: Option<ScenePath>,
    /// Open only while somebody looks: the local planner keeps rollouts only while they are read.
    rollouts: Option<Latest<DebugRollouts>>,
    /// From when on that may be opened.
    may_open: Instant,
    /// Clients have been shown some.
    shows_rollouts: bool,
    last_frame: Instant,
    last_status: Instant,
    /// From when on the whole map may be asked for.
    may_ask: Instant,
}

#[derive(Debug, Default)]
#[allow(clippy::struct_excessive_bools, reason = "one for each input")]
struct Changed {
    scan: bool,
    obstacles: bool,
    goals: bool,
    control: bool,
    truth: bool,
    placed: bool,
    zones: bool,
    rollouts: bool,
}

impl Tap {
    /// Opens the topics of the stack that `peer` has joined.
    ///
    /// # Errors
    /// One line when a topic cannot be opened.
    pub(crate) fn open(peer: &Peer, scenario: String) -> Result<Self, StartError> {
        Ok(Self {
            ports: Ports::open(peer)?,
            seats: Seats::open(peer)?,
            events: Events::default(),
            scenario,
            is_fixed: false,
            changed: Changed::default(),
            grid: None,
            dirty: BTreeSet::new(),
            path: None,
            rollouts: None,
            may_open: Instant::now(),
            shows_rollouts: false,
            last_frame: Instant::now(),
            last_status: Instant::now(),
            may_ask: Instant::now() + MAP_PAUSE,
        })
    }

    /// Reads until `is_over` says so.
    pub(crate) fn run(&mut self, peer: &Peer, feed: &Feed, mut is_over: impl FnMut() -> bool) {
        while !is_over() {
            self.listen();
            self.update_map(peer);
            self.update_rollouts(peer, feed.watchers() > 0);
            self.publish(feed);
            std::thread::sleep(if self.ports.roster.roster().lockstep() {
                LOCKSTEP_PAUSE
            } else {
                PAUSE
            });
        }
    }

    /// Takes in what has come.
    fn listen(&mut self) {
        let Self {
            ports,
            events,
            changed,
            seats,
            rollouts,
            ..
        } = self;
        ports.roster.poll();
        let roster = ports.roster.roster();
        ports.description.poll(roster);
        // Before the others: it says what time it is.
        ports.odometry.poll(roster);
        events.at(ports.odometry.newest().map_or(0, |newest| newest.run_ns));
        events.seats(&roster.seats, roster.control.paused == 1);
        changed.scan |= ports.scan.poll(roster);
        ports.map.take_in(roster);
        if ports.map.view().is_some() {
            events.certainty(ports.map.info().certainty());
        }
        changed.obstacles |= ports.obstacles.poll(roster);
        changed.goals |= ports.goals.poll(roster);
        if let Some(task) = ports.goals.get() {
            events.task(task.header.id(), task.items);
        }
        if ports.task.poll(roster)
            && let Some(status) = ports.task.get()
        {
            changed.goals = true;
            events.status(status.meta, status.items);
        }
        changed.control |= ports.requests.poll(roster);
        changed.truth |= ports.truth.poll(roster);
        changed.placed |= ports.placed.poll(roster);
        if ports.zones.poll(roster)
            && let Some(zones) = ports.zones.get()
        {
            changed.zones |= zones.meta.revision != ports.zones_revision;
            ports.zones_revision = zones.meta.revision;
        }
        if let Some(rollouts) = rollouts {
            changed.rollouts |= rollouts.poll(roster);
        }
        ports.commands.drain(roster, |command| {
            events.command(command.meta.intervention(), command.header.run_ns);
            seats.command = Some(*command.meta);
        });
        let path = &mut self.path;
        ports.paths.drain(roster, |view| {
            if events.path(view.meta) {
                *path = Some(ScenePath::of(view.meta, view.items));
                seats.model.new_path(view.header.id());
            }
        });
        ports.spans.drain(|span| seats.model.record(span));
        seats.settle(events);
        seats.listen(roster, events);
    }

    /// Notes which tiles changed, and asks for the map when there is no other way to it.
    fn update_map(&mut self, peer: &Peer) {
        let map = &self.ports.map;
        for rect in map.changed() {
            self.dirty.extend(tiles_in(*rect));
        }
        if map.view().is_some() && self.grid != Some(map.info().geometry) {
            self.grid = None;
        }
        let is_lost = map.is_lost() && self.ports.roster.roster().has_clock();
        if is_lost && Instant::now() >= self.may_ask {
            self.may_ask = Instant::now() + ASK_PAUSE;
            if let Ok(bells) = Bells::open(peer) {
                bells.ring(Role::Mapping, EVENT_NEED_KEYFRAME);
            }
        }
    }

    /// Reads rollouts while somebody looks.
    fn update_rollouts(&mut self, peer: &Peer, is_watched: bool) {
        if !is_watched {
            self.rollouts = None;
        } else if self.rollouts.is_none() && Instant::now() >= self.may_open {
            // Without a place among the readers the page does without them, and tries again.
            self.may_open = Instant::now() + ASK_PAUSE;
            self.rollouts = peer.latest().ok();
        }
    }

    /// The newest rollouts at a run time [ns], if they are new; none once they are old.
    fn take_rollouts(&mut self, now_ns: u64, is_new: bool) -> Option<Vec<SceneRollout>> {
        let newest = self.rollouts.as_ref().and_then(Latest::get);
        match newest.filter(|view| view.header.run_ns.saturating_add(ROLLOUTS_NS) >= now_ns) {
            Some(view) if is_new => {
                self.shows_rollouts = true;
                Some(view.items.iter().map(SceneRollout::of).collect())
            }
            Some(_) => None,
            None => core::mem::take(&mut self.shows_rollouts).then(Vec::new),
        }
    }

    /// Tells the feed what is new, as often as is of use; frames only while somebody listens.
    fn publish(&mut self, feed: &Feed) {
        for event in self.events.take() {
            feed.event(&event);
        }
        self.fix(feed);
        if feed.watchers() == 0 {
            return;
        }
        let since = self.last_frame.elapsed();
        let is_due = self.changed.scan || self.changed.placed;
        if (is_due && since >= FRAME_PAUSE) || since >= FRAME_AT_LEAST {
            self.last_frame = Instant::now();
            self.send_map(feed);
            if let Some(frame) = self.frame() {
                feed.frame(&frame);
            }
        }
        if self.last_status.elapsed() >= STATUS_PAUSE {
            self.last_status = Instant::now();
            feed.status(
                &self
                    .seats
                    .report(self.ports.roster.roster(), feed.watchers()),
            );
        }
    }

    fn fix(&mut self, feed: &Feed) {
        let roster = self.ports.roster.roster();
        if let Some(description) = self.ports.description.get()
            && !self.is_fixed
        {
            self.is_fixed = true;
            feed.fix(&Fixed {
                format: FORMAT,
                scenario: self.scenario.clone(),
                mode: if roster.lockstep() {
                    "lockstep"
                } else {
                    "real_time"
                }
                .to_owned(),
                robot: Robot::of(description.meta, description.items),
            });
        }
    }

    fn send_map(&mut self, feed: &Feed) {
        let Some(view) = self.ports.map.view() else {
            return;
        };
        let grid = (self.grid != Some(*view.geometry)).then(|| Grid::of(view.geometry));
        if grid.is_some() {
            self.grid = Some(*view.geometry);
            let (width, height) = view.geometry.size();
            let all = CellRect {
                min: zeronav_msgs::grid::Cell::new(0, 0),
                max: zeronav_msgs::grid::Cell::new(width, height),
            };
            self.dirty.clear();
            self.dirty.extend(tiles_in(all));
        }
        if self.dirty.is_empty() {
            return;
        }
        let tiles = core::mem::take(&mut self.dirty).into_iter();
        let tiles: Vec<_> = tiles.map(|at| (at, tile_at(&view, at))).collect();
        feed.map(grid.as_ref(), &tiles);
    }

    /// The moment as it is; `None` before the robot has been heard.
    fn frame(&mut self) -> Option<Frame> {
        let newest = *self.ports.odometry.newest()?;
        let odometry = &newest.odometry;
        let changed = core::mem::take(&mut self.changed);
        let rollouts = self.take_rollouts(newest.run_ns, changed.rollouts);
        let ports = &self.ports;
        let scan = changed.scan.then(|| self.scan()).flatten();
        let control = changed.control.then(|| {
            let request = ports.requests.get()?;
            Some(Control::of(request.meta, &self.seats.command?))
        });
        let obstacles = changed.obstacles.then(|| ports.obstacles.get()).flatten();
        let zones = changed.zones.then(|| ports.zones.get()).flatten();
        let truth = changed.truth.then(|| ports.truth.get()).flatten();
        let task = ports.task.get();
        Some(Frame {
            time_s: Rounded::thousandths(seconds(newest.run_ns)),
            tick: newest.tick,
            robot: robot(
                &ports.map.map_from_base(&odometry.pose),
                odometry.v_mps,
                odometry.w_radps,
            ),
            truth: truth.map(|truth| pose(&truth.meta.pose)),
            scan,
            obstacles: obstacles.map(|all| all.items.iter().map(Tracked::of).collect()),
            bodies: changed.placed.then(|| self.placed(newest.run_ns)),
            path: self.path.take(),
            rollouts,
            goals: changed.goals.then(|| self.goals()),
            zones: zones.map(|all| all.items.iter().map(SceneZone::of).collect()),
            task: task.map(|task| task.meta.state().map_or("unknown", TaskState::label)),
            certainty: (ports.map.view()).map(|_| ports.map.info().certainty().label()),
            control: control.flatten(),
            map: None,
            events: Vec::new(),
        })
    }

    fn scan(&self) -> Option<SceneScan> {
        let ports = &self.ports;
        let (scan, description) = (ports.scan.get()?, ports.description.get()?);
        let at = ports.odometry.history().pose_at(scan.header.run_ns)?;
        let laser = ports
            .map
            .map_from_base(&at)
            .then(&description.meta.base_from_laser);
        Some(SceneScan::of(scan.meta, scan.items, &laser))
    }

    /// Outlines of the obstacles that were put into the simulated world and are there, seen or not.
    fn placed(&self, run_ns: u64) -> Vec<Vec<[Rounded; 2]>> {
        let Some(placed) = self.ports.placed.get() else {
            return Vec::new();
        };
        let is_there = |until_ns: u64| until_ns == 0 || until_ns > run_ns;
        let there = placed.items.iter();
        let there = there.filter(|it| is_there(it.until_run_ns));
        there.filter_map(outline).collect()
    }

    /// The goals of the task, each with what became of it.
    fn goals(&self) -> Vec<SceneGoal> {
        let Some(task) = self.ports.goals.get() else {
            return Vec::new();
        };
        let status = self.ports.task.get();
        let status = status.filter(|status| Id(status.meta.task) == task.header.id());
        let state = |id: u64| {
            let Some(status) = status else {
                return TaskState::Active.label();
            };
            let ended = status.items.iter().find(|end| end.goal == id);
            match ended.and_then(|end| TaskState::from_code(end.state)) {
                Some(state) => state.label(),
                None if status.meta.goal == id => TaskState::Active.label(),
                None => "waiting",
            }
        };
        let goal = |goal: &zeronav_msgs::task::Goal| {
            SceneGoal::new(&goal.pose, goal.tolerance_m, state(goal.id))
        };
        task.items.iter().map(goal).collect()
    }
}

/// Columns and rows of the tiles that a rectangle of cells touches.
fn tiles_in(rect: CellRect) -> impl Iterator<Item = (u32, u32)> {
    let tile = |cell: i32| u32::try_from(cell).unwrap_or(0) / 32;
    let columns = tile(rect.min.x)..=tile((rect.max.x - 1).max(0));
    let rows = tile(rect.min.y)..=tile((rect.max.y - 1).max(0));
    rows.flat_map(move |row| columns.clone().map(move |column| (column, row)))
}

fn tile_at(view: &MapView<'_>, (tile_x, tile_y): (u32, u32)) -> Tile {
    let mut tile = MapTile {
        tile_x,
        tile_y,
        ..MapTile::default()
    };
    debug_assert_eq!(TILE_CELLS, 32);
    tile.fill_from(view.geometry, view.cells);
    Tile::of(&tile)
}
