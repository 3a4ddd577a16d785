//! Listens to a running stack and keeps what the result needs.

use crate::film::{self, Film};
use std::collections::{BTreeSet, HashMap, VecDeque};
use std::time::{Duration, Instant};
use zeronav_measure::aside::{AHEAD_TICKS, Aside};
use zeronav_measure::index::{PathRecord, Sensed, Sighting};
use zeronav_measure::reasons::Reasons;
use zeronav_measure::result::moment::Task;
use zeronav_measure::seen::{Fact, Seen, TaskReport};
use zeronav_measure::{Records, RunHash};
use zeronav_msgs::grid::{Cell, GridGeometry};
use zeronav_msgs::header::Id;
use zeronav_msgs::map::{COST_LETHAL, FLAG_STATIC, MapView};
use zeronav_msgs::obstacles::Obstacle;
use zeronav_msgs::odometry::Odometry;
use zeronav_msgs::path::PathStatus;
use zeronav_msgs::pose::Pose;
use zeronav_msgs::replica::{MapReplica, Step};
use zeronav_msgs::role::Role;
use zeronav_msgs::span::{Span, SpanKind};
use zeronav_msgs::task::TaskState;
use zeronav_msgs::truth::Truth;
use zeronav_scenario::fault_plan::{Recoveries, Sight};
use zeronav_shell::Roster;
use zeronav_supervise::taps::Taps;
use zeronav_world::Convex;

/// Spans that are kept at most; the oldest go first.
const SPANS_MAX: usize = 200_000;

/// Least time between two requests for a keyframe.
const KEYFRAME_PAUSE: Duration = Duration::from_millis(200);

/// The form of a scripted obstacle at a pose.
pub(crate) type Placed<'a> = &'a dyn Fn(usize, &Pose) -> Option<Convex>;

/// Changes of what the map shows of one obstacle that are kept at most; the oldest go first.
const SENSED_MAX: usize = 1000;

/// Wheels that turn more slowly than that stand. [m/s], [rad/s]
const MOVING_MPS: f64 = 1.0e-3;
const MOVING_RADPS: f64 = 1.0e-3;

/// Places of the robot that nobody has looked at: more than come between two looks.
const SIGHTS_MAX: usize = 64;

/// Lists of tracked obstacles that are kept for the revisions of the map that go with them.
const TRACKED_MAX: usize = 32;

/// Everything that was heard.
#[derive(Debug, Default)]
pub(crate) struct Collector {
    /// For the measures.
    pub records: Records,
    /// For the run's hash.
    pub hash: RunHash,
    /// What counts of the run: everything up to its end.
    pub seen: Seen,
    /// What the stages say of why the robot does what it does.
    pub reasons: Reasons,
    /// The newest truth, also after the end.
    pub truth: Option<Truth>,
    /// Where the robot was since somebody looked, as the truth says.
    pub sights: Vec<Sight>,
    /// The newest odometry, also after the end.
    pub odometry: Option<Odometry>,
    /// Tick and `map_from_odom` of the newest map with a scan: before its first, a successor knows nothing.
    pub located: Option<(u64, Pose)>,
    /// Run time of the newest odometry or truth. [ns]
    pub run_ns: u64,
    /// First tick at which the wheels turned.
    pub first_motion_tick: Option<u64>,
    /// What is said of the task, also after the end.
    pub task: Option<TaskReport>,
    /// Goals that were reached, of any task.
    pub reached: BTreeSet<u64>,
    /// Highest tick that each role has answered.
    pub answered: HashMap<u16, u64>,
    /// Newest tick with a scan.
    pub scan_tick: u64,
    /// Scripted obstacles as they were seen last: index and pose.
    pub obstacles: HashMap<usize, Pose>,
    /// The map, with the dynamic obstacles of its scan on it.
    pub replica: MapReplica,
    /// Scan and tracked obstacles, newest last.
    tracked: VecDeque<(u64, Vec<Obstacle>)>,
    /// Updates of the map that a scan made, and the tiles in them.
    pub updates: (u64, u64),
    /// Spans that were dropped because there were too many.
    pub spans_dropped: u64,
    /// The last tick that an answer can have.
    last_tick: u64,
    /// Processes whose answers do not count.
    pub aside: Aside,
    /// Seats whose next answer is waited for.
    pub recoveries: Recoveries,
    /// What a player shows of the run.
    pub film: Film,
    keyframe_wanted: bool,
    keyframe_asked: Option<Instant>,
    /// A revision that came before the truth about its scan or the obstacles of its scan.
    unlooked: Option<(Id, u64)>,
}

impl Collector {
    /// Takes in whatever has come; true when mapping should be asked for a keyframe.
    pub(crate) fn listen(&mut self, taps: &mut Taps, roster: &Roster, placed: Placed<'_>) -> bool {
        let lease = roster.lockstep().then_some(roster.control.lease);
        taps.spans.drain(|span| self.span(span, lease));
        let robot_tick = self.robot_tick();
        // In lockstep the robot goes as far as it is leased, and records may be far apart.
        self.last_tick = lease.unwrap_or(robot_tick.saturating_add(AHEAD_TICKS));
        self.aside.settle(robot_tick, self.last_tick);
        if taps.description.poll(roster)
            && let Some(view) = taps.description.get()
        {
            self.film.description(view.meta, view.items);
            self.seen.lag.description(view.meta);
        }
        self.hear(taps, roster, placed);
        // In lockstep there are no latencies.
        let looks = !roster.lockstep();
        if let Some((revision, scan)) = self.unlooked.take() {
            self.look_for_obstacles(revision, scan, placed);
        }
        if taps.keyframe.poll(roster)
            && let Some(view) = taps.keyframe.get()
        {
            self.replica.keyframe(view.meta, view.items);
            self.film.written_all();
        }
        taps.keyframe.release();
        taps.updates.drain(roster, |view| {
            let scan = view.header.parents.scan;
            self.film.placed(view.meta.map_from_odom);
            self.film.written(view.items);
            if scan != 0 && view.meta.is_last_part() {
                self.located = Some((view.header.tick, view.meta.map_from_odom));
                let fact = Fact::Placed(scan, view.meta.map_from_odom);
                (self.seen).hear(view.header.tick, view.header.run_ns, fact);
            }
            if self.replica.update(view.header.id(), view.meta, view.items) != Step::Applied {
                return;
            }
            let (revision, scan) = (view.header.id(), view.header.parents.scan);
            if scan != 0 {
                self.updates.0 += 1;
                self.updates.1 += view.items.len() as u64;
            }
            if !looks {
                return;
            }
            let is_tracked = self.tracked.iter().any(|(of, _)| *of == scan);
            if is_tracked && self.truth.is_some_and(|truth| truth.scan >= scan) {
                self.look_for_obstacles(revision, scan, placed);
            } else {
                // The truth about the scan, or its obstacles, may still be on their way: look at the
                // next call.
                self.unlooked = Some((revision, scan));
            }
        });
        self.film.look_at_map(self.run_ns, &self.replica);
        self.hear_paths(taps, roster);
        self.hear_status(taps, roster);
        self.wants_keyframe()
    }

    /// Takes in new paths, without repeats of an unchanged one.
    fn hear_paths(&mut self, taps: &mut Taps, roster: &Roster) {
        taps.paths.drain(roster, |view| {
            if view.meta.status() == Some(PathStatus::Found) {
                self.recoveries.note_path(view.header);
            }
            if view.meta.geometry != view.header.id {
                return;
            }
            let Some((status, cause)) = view.meta.status().zip(view.meta.cause()) else {
                return;
            };
            self.film.path(view.header.run_ns, view.meta, view.items);
            (self.reasons).path(view.header.tick, view.header.run_ns, view.meta);
            self.records.paths.push(PathRecord {
                id: view.header.id,
                map: view.header.parents.map,
                run_ns: view.header.run_ns,
                status,
                cause,
                planner: view.meta.planner().to_owned(),
                length_m: view.meta.length_m,
                beside_goal_m: view.meta.beside_goal_m,
                expanded: view.meta.expanded,
                points_m: view
                    .items
                    .iter()
                    .map(|point| [point.x_m, point.y_m])
                    .collect(),
            });
        });
    }

    /// Takes in what the local planner reports about its task.
    fn hear_status(&mut self, taps: &mut Taps, roster: &Roster) {
        if taps.status.poll(roster)
            && let Some(view) = taps.status.get()
            && let Some(told) = Task::of(view.meta)
        {
            let state = told.state;
            let reached = view
                .items
                .iter()
                .filter(|end| end.state == TaskState::Reached.code());
            self.reached.extend(reached.map(|end| end.goal));
            // A task that has ended is said again and again; its end is the end of its last goal.
            let ended = view.items.last().map(|end| end.tick);
            let tick = match state {
                TaskState::Idle | TaskState::Active => view.header.tick,
                _ => ended.unwrap_or(view.header.tick),
            };
            let report = TaskReport {
                task: view.meta.task,
                state,
                reason: told.reason,
                tick,
                remaining_m: view.meta.remaining_m,
                recoveries: view.meta.recoveries,
                cause: told.stuck,
                blocked: told.blocked,
                waits_s: told.waits_s,
            };
            self.task = Some(report);
            (self.film).task(view.header.run_ns, state, &self.reached);
            // The end of a task may be heard with a later message.
            let is_then = tick == view.header.tick;
            let run_ns = if is_then { view.header.run_ns } else { 0 };
            self.reasons.task(tick, run_ns, told);
            self.seen.hear(tick, view.header.run_ns, Fact::Task(report));
        }
    }

    /// Takes in what is so, what the guard does, and what mapping sees moving.
    fn hear(&mut self, taps: &mut Taps, roster: &Roster, placed: Placed<'_>) {
        taps.truth.drain(roster, |view| {
            let (tick, run_ns) = (view.header.tick, view.header.run_ns);
            self.film.truth(run_ns, &view.meta.pose, || {
                let there = view.items.iter();
                let bodies = there.filter_map(|item| placed(item.index as usize, &item.pose));
                bodies.map(|body| film::outline(&body.outline())).collect()
            });
            self.truth(run_ns, view.meta, view.items);
            if self.sights.len() < SIGHTS_MAX {
                let pose = view.meta.pose;
                let centre_m = [pose.x_m, pose.y_m];
                self.sights.push(Sight { tick, centre_m });
            }
            let fact = Fact::Truth(*view.meta, view.items.to_vec());
            self.seen.hear(tick, run_ns, fact);
        });
        taps.requests.drain(roster, |view| {
            self.film.request(view.header.id, view.meta);
            (self.reasons).request(view.header.tick, view.header.run_ns, view.meta);
        });
        taps.commands.drain(roster, |view| {
            let (tick, run_ns) = (view.header.tick, view.header.run_ns);
            self.seen.lag.command(run_ns, view.meta);
            (self.film).command(run_ns, view.header.parents.request, view.meta);
            self.aside.command(tick, self.last_tick);
            self.reasons.command(tick, run_ns, view.meta);
            (self.seen).hear(tick, run_ns, Fact::Command(view.meta.intervention()));
        });
        taps.odometry.drain(roster, |view| {
            self.odometry = Some(*view.meta);
            self.seen.lag.odometry(view.header.run_ns, view.meta);
            if view.meta.v_mps.abs() > MOVING_MPS || view.meta.w_radps.abs() > MOVING_RADPS {
                self.first_motion_tick.get_or_insert(view.header.tick);
            }
            self.run_ns = self.run_ns.max(view.header.run_ns);
            (self.film).odometry(view.header.tick, view.header.run_ns, view.meta);
            if view.meta.scan_due() {
                let fact = Fact::Odometry(view.meta.pose);
                (self.seen).hear(view.header.tick, view.header.run_ns, fact);
            }
        });
        taps.scans.drain(roster, |view| {
            (self.film).scan(view.header.run_ns, view.meta, view.items);
        });
        taps.moving.drain(roster, |view| {
            self.film.tracked(view.header.run_ns, view.items);
            let scan = view.header.parents.scan;
            (self.reasons).obstacles(view.header.tick, view.header.run_ns, view.items);
            if self.tracked.len() == TRACKED_MAX {
                self.tracked.pop_front();
            }
            self.tracked.push_back((scan, view.items.to_vec()));
            let fact = Fact::Moving(scan, view.items.to_vec());
            (self.seen).hear(view.header.tick, view.header.run_ns, fact);
        });
    }

    /// Forgets what only the result of a run needs, so that a stack that stays up does not grow; of
    /// its records the newest stay ([`Records::keep_newest`]).
    pub(crate) fn forget(&mut self) {
        self.records.keep_newest();
        (self.hash, self.seen) = (RunHash::default(), Seen::default());
    }

    /// Another reader of the map needs a keyframe.
    pub(crate) fn ask_for_keyframe(&mut self) {
        self.keyframe_wanted = true;
    }

    fn wants_keyframe(&mut self) -> bool {
        let now = Instant::now();
        let pause = self
            .keyframe_asked
            .is_some_and(|asked| now - asked < KEYFRAME_PAUSE);
        if !(self.replica.needs_keyframe() || self.keyframe_wanted) || pause {
            return false;
        }
        self.keyframe_asked = Some(now);
        self.keyframe_wanted = false;
        true
    }

    /// Takes in a record; in lockstep no answer can be to a tick after the `lease`.
    fn span(&mut self, span: &Span, lease: Option<u64>) {
        let is_answer = span.kind() == Some(SpanKind::Answer);
        if is_answer && lease.is_some_and(|lease| span.tick > lease) {
            return;
        }
        self.aside.note(span);
        if !self.aside.counts(span) {
            return;
        }
        self.recoveries.note(span);
        self.hash.add(span);
        let scanned = span.role == Role::Robot.code() && span.scan != 0;
        if scanned && matches!(span.kind(), Some(SpanKind::Answer | SpanKind::Extra)) {
            self.scan_tick = self.scan_tick.max(span.tick);
        }
        if is_answer {
            let answered = self.answered.entry(span.role).or_default();
            *answered = (*answered).max(span.tick);
        }
        if self.records.spans.len() == SPANS_MAX {
            self.records.spans.drain(..SPANS_MAX / 4);
            self.spans_dropped += SPANS_MAX as u64 / 4;
        }
        self.records.spans.push(*span);
    }

    /// `map_from_base` as the stack takes it to be; `None` before the first map and odometry.
    #[must_use]
    pub(crate) fn estimate(&self) -> Option<Pose> {
        let ((_, map_from_odom), odometry) = self.located.zip(self.odometry)?;
        Some(map_from_odom.then(&odometry.pose))
    }

    /// Highest tick that the robot has begun.
    #[must_use]
    pub(crate) fn robot_tick(&self) -> u64 {
        self.answered_by(Role::Robot)
    }

    /// Newest tick that `role` has answered.
    #[must_use]
    pub(crate) fn answered_by(&self, role: Role) -> u64 {
        self.answered.get(&role.code()).copied().unwrap_or(0)
    }

    /// The first role in the flow of data that owes an answer to the robot's newest tick.
    #[must_use]
    pub(crate) fn owing(&self, roster: &Roster) -> Option<Role> {
        [
            Role::Mapping,
            Role::GlobalPlanner,
            Role::LocalPlanner,
            Role::CollisionGuard,
        ]
        .into_iter()
        .find(|role| self.owes(*role, roster))
    }

    /// True while the seat of `role` is not empty and its answer to the robot's newest tick, or
    /// newest scan, is missing.
    #[must_use]
    pub(crate) fn owes(&self, role: Role, roster: &Roster) -> bool {
        let due = match role {
            Role::Mapping | Role::GlobalPlanner => self.scan_tick,
            _ => self.robot_tick(),
        };
        self.answered_by(role) < due && roster.answers(role, due)
    }

    /// True when every role has answered every tick up to `tick`.
    #[must_use]
    pub(crate) fn all_answered(&self, tick: u64, roster: &Roster) -> bool {
        self.robot_tick() >= tick && self.owing(roster).is_none()
    }

    fn truth(
        &mut self,
        run_ns: u64,
        truth: &Truth,
        obstacles: &[zeronav_msgs::truth::TruthObstacle],
    ) {
        self.run_ns = self.run_ns.max(run_ns);
        self.truth = Some(*truth);
        for obstacle in obstacles {
            let index = obstacle.index as usize;
            self.obstacles.insert(index, obstacle.pose);
            let sightings = &mut self.records.sightings;
            let at = sightings.iter().position(|sighting| {
                sighting.index == index && sighting.appeared_run_ns == obstacle.appeared_run_ns
            });
            let at = at.unwrap_or_else(|| {
                sightings.push(Sighting {
                    index,
                    appeared_run_ns: obstacle.appeared_run_ns,
                    appeared_ns: obstacle.appeared_ns,
                    ..Sighting::default()
                });
                sightings.len() - 1
            });
            let sighting = &mut sightings[at];
            if obstacle.beams > 0 && truth.scan != 0 {
                sighting.first_beam_scan.get_or_insert(truth.scan);
            }
            if obstacle.beams >= 3 && truth.scan != 0 {
                sighting.first_scan.get_or_insert(truth.scan);
            }
        }
    }

    /// Notes what a revision shows of the obstacles that have been seen.
    fn look_for_obstacles(&mut self, revision: Id, scan: u64, placed: Placed<'_>) {
        let tracked = self.tracked.iter().rfind(|(of, _)| *of == scan);
        let obstacles = tracked.map_or(&[][..], |(_, obstacles)| obstacles);
        self.replica.stamp(obstacles);
        // Only readers that update something of their own need the list.
        self.replica.take_changed();
        let Some(map) = self.replica.view() else {
            return;
        };
        for sighting in &mut self.records.sightings {
            let seen = sighting.first_beam_scan.is_some_and(|first| scan >= first);
            let pose = self.obstacles.get(&sighting.index).filter(|_| seen);
            let Some(obstacle) = pose.and_then(|pose| placed(sighting.index, pose)) else {
                continue;
            };
            let cells_m = sensed_at(&map, &obstacle);
            let due = sighting.first_scan.is_some_and(|first| scan >= first);
            if due && !cells_m.is_empty() {
                sighting.first_map.get_or_insert(revision.0);
            }
            let before = sighting.sensed.last().map(|sensed| &sensed.cells_m[..]);
            if before.unwrap_or_default() != cells_m {
                if sighting.sensed.len() == SENSED_MAX {
                    sighting.sensed.remove(0);
                }
                let map = revision.0;
                sighting.sensed.push(Sensed { map, cells_m });
            }
        }
    }
}

/// Centres of the lethal cells that are not the static map's, within one cell of the outline of
/// `obstacle`. [m]
#[must_use]
pub(crate) fn sensed_at(map: &MapView<'_>, obstacle: &Convex) -> Vec<[f64; 2]> {
    let geometry: &GridGeometry = map.geometry;
    let margin = nalgebra::Vector2::repeat(2.0 * geometry.resolution_m);
    let corners = obstacle.outline();
    let Some(first) = corners.first() else {
        return Vec::new();
    };
    let (mut low, mut high) = (first.coords, first.coords);
    for corner in &corners {
        low = low.inf(&corner.coords);
        high = high.sup(&corner.coords);
    }
    let low = geometry.unbounded_cell_at((low - margin).into());
    let high = geometry.unbounded_cell_at((high + margin).into());
    let (width, height) = geometry.size();
    let mut cells_m = Vec::new();
    for y in low.y.max(0)..=high.y.min(height - 1) {
        for x in low.x.max(0)..=high.x.min(width - 1) {
            let cell = Cell::new(x, y);
            let sensed = map
                .get(cell)
                .is_some_and(|cell| cell.cost == COST_LETHAL && cell.flags & FLAG_STATIC == 0);
            let point = geometry.centre_of(cell);
            if sensed && obstacle.distance_to_point_m(point) <= geometry.resolution_m {
                cells_m.push([point.x, point.y]);
            }
        }
    }
    cells_m
}
