//! Listens to a running stack and keeps what the result needs.

mod messages;
mod zones;

use crate::film::Film;
use std::collections::{BTreeSet, HashMap, VecDeque};
use std::time::{Duration, Instant};
use zeronav_measure::reasons::Reasons;
use zeronav_measure::run_totals::{RunTotals, TaskReport};
use zeronav_measure::shadow_answers::ShadowAnswers;
use zeronav_measure::{Records, RunHash};
use zeronav_msgs::ZoneSet;
use zeronav_msgs::certainty::PoseCertainty;
use zeronav_msgs::grid::{Cell, GridGeometry};
use zeronav_msgs::header::Id;
use zeronav_msgs::map::{COST_LETHAL, FLAG_STATIC, MapView, ObstacleSource};
use zeronav_msgs::obstacles::Obstacle;
use zeronav_msgs::odometry::Odometry;
use zeronav_msgs::pose::Pose;
use zeronav_msgs::replica::MapReplica;
use zeronav_msgs::role::Role;
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
    pub totals: RunTotals,
    /// What the stages say of why the robot does what it does.
    pub reasons: Reasons,
    /// The zones that hold, to say which one slows or stops the robot.
    pub zones: ZoneSet,
    /// The cell of a keepout zone that leaves no path. [m]
    closed_m: Option<[f64; 2]>,
    /// The robot's fastest speed. [m/s]
    v_mps_max: f64,
    /// The newest truth, also after the end.
    pub truth: Option<Truth>,
    /// Where the robot was since somebody looked, as the truth says.
    pub sights: Vec<Sight>,
    /// The newest odometry, also after the end.
    pub odometry: Option<Odometry>,
    /// Tick and `map_from_odom` of the newest map with a scan: before its first, a successor knows nothing.
    pub located: Option<(u64, Pose)>,
    /// How far mapping knew that.
    pub certainty: PoseCertainty,
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
    pub aside: ShadowAnswers,
    /// Seats whose next answer is waited for.
    pub recoveries: Recoveries,
    /// What a player shows of the run.
    pub film: Film,
    keyframe_wanted: bool,
    keyframe_asked: Option<Instant>,
    /// True when it is looked when the map shows an obstacle: latencies are measured.
    pub looks: bool,
    /// A revision that came before the truth about its scan or the obstacles of its scan.
    unlooked: Option<(Id, u64)>,
}

impl Collector {
    /// Takes in whatever has come; true when mapping should be asked for a keyframe.
    pub(crate) fn listen(&mut self, taps: &mut Taps, roster: &Roster, placed: Placed<'_>) -> bool {
        let lease = roster.lockstep().then_some(roster.control.lease);
        // In lockstep there are no latencies.
        self.looks = !roster.lockstep();
        taps.spans.drain(|span| self.span(span, lease));
        self.settle(lease);
        if taps.description.poll(roster)
            && let Some(view) = taps.description.get()
        {
            self.description(view);
        }
        taps.truth.drain(roster, |view| self.truth(view, placed));
        taps.requests.drain(roster, |view| self.request(view));
        taps.commands.drain(roster, |view| self.command(view));
        taps.odometry.drain(roster, |view| self.odometry(view));
        taps.scans.drain(roster, |view| self.scan(view));
        taps.moving.drain(roster, |view| self.moving(view));
        self.look_again(placed);
        if taps.keyframe.poll(roster)
            && let Some(view) = taps.keyframe.get()
        {
            self.keyframe(view);
        }
        taps.keyframe.release();
        (taps.updates).drain(roster, |view| self.update(view, placed));
        self.look_at_map();
        taps.paths.drain(roster, |view| self.path(view));
        if taps.status.poll(roster)
            && let Some(view) = taps.status.get()
        {
            self.status(view);
        }
        self.wants_keyframe()
    }

    /// Forgets what only the result of a run needs, so that a stack that stays up does not grow; of
    /// its records the newest stay ([`Records::keep_newest`]).
    pub(crate) fn forget(&mut self) {
        self.records.keep_newest();
        (self.hash, self.totals) = (RunHash::default(), RunTotals::default());
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

    /// True when the robot knows where it is, and that is confirmed.
    #[must_use]
    pub(crate) fn is_pose_confirmed(&self) -> bool {
        self.certainty.is_confirmed()
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
            let sensed = map.get(cell).is_some_and(|cell| {
                let is_world = cell.source() != ObstacleSource::Keepout;
                cell.cost == COST_LETHAL && cell.flags & FLAG_STATIC == 0 && is_world
            });
            let point = geometry.centre_of(cell);
            if sensed && obstacle.distance_to_point_m(point) <= geometry.resolution_m {
                cells_m.push([point.x, point.y]);
            }
        }
    }
    cells_m
}
