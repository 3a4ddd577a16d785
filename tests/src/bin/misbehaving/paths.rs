//! Global planners that misbehave.

use std::process::ExitCode;
use zeronav_msgs::header::Parents;
use zeronav_msgs::path::{Path, PathCause, PathStatus, WAYPOINTS_MAX, Waypoint};
use zeronav_msgs::role::Role;
use zeronav_msgs::topics::PlanPath;
use zeronav_shell::doorbell::Rung;
use zeronav_shell::{CurrentGoal, MapInput, OdometryReader, Service, Shell, StartError, Writer};
use zeronav_tests::seats::{AnyConfig, is_obeyed};

/// What a global planner does beside the path of each answer.
pub(crate) trait Paths: Default {
    /// Waypoints for which it opens its topic.
    const WAYPOINTS_MAX: usize;

    /// Before the answers of a wake.
    fn before(&mut self, _seat: &Seat) {}

    /// The path of an answer.
    fn path(&mut self, seat: &Seat, shell: &Shell, tick: u64) -> Option<(Path, Vec<Waypoint>)>;
}

/// What it reads and writes.
pub(crate) struct Seat {
    odometry: OdometryReader,
    map: MapInput,
    goal: CurrentGoal,
    path: Writer<PlanPath>,
}

struct GlobalPlanner<P>(Seat, P);

impl<P: Paths> Service for GlobalPlanner<P> {
    const ROLE: Role = Role::GlobalPlanner;
    type Config = AnyConfig;

    fn open(shell: &mut Shell, _config: AnyConfig) -> Result<Self, StartError> {
        let peer = shell.peer();
        let seat = Seat {
            odometry: OdometryReader::open(peer)?,
            map: MapInput::open(peer)?,
            goal: CurrentGoal::open(peer)?,
            path: peer.writer(P::WAYPOINTS_MAX)?,
        };
        Ok(Self(seat, P::default()))
    }

    fn wake(&mut self, shell: &mut Shell, _rung: Rung) -> Result<(), StartError> {
        let Self(seat, planner) = self;
        seat.odometry.poll(shell.roster());
        let news = seat.map.poll(shell) | seat.goal.poll(shell.roster());
        let trigger = seat.map.trigger(shell.roster(), &seat.odometry, news);
        planner.before(seat);
        for due in shell.due(&trigger) {
            seat.goal.advance(shell.roster(), due.tick);
            let draft = seat.map.begin(shell, due, Parents::default());
            let (path, line) = planner.path(seat, shell, due.tick).unwrap_or_default();
            shell.answer(&draft, &mut seat.path, path, &line);
        }
        Ok(())
    }
}

pub(crate) fn run<P: Paths>() -> ExitCode {
    zeronav_shell::run::<GlobalPlanner<P>>()
}

/// Sends its idle output, reports that it is ready, and does not return from the first wake after
/// that in which it has a goal.
#[derive(Default)]
pub(crate) struct HangsAfterStart {
    /// It has answered, so that the heartbeat at the end of that wake says that it is ready.
    is_ready: bool,
}

impl Paths for HangsAfterStart {
    const WAYPOINTS_MAX: usize = WAYPOINTS_MAX;

    fn before(&mut self, seat: &Seat) {
        while self.is_ready && seat.goal.goal().is_some() {
            std::thread::park();
        }
    }

    fn path(&mut self, _seat: &Seat, _shell: &Shell, _tick: u64) -> Option<(Path, Vec<Waypoint>)> {
        self.is_ready = true;
        None
    }
}

/// Has no path until it is obeyed, and leads through obstacles from then on.
#[derive(Default)]
pub(crate) struct ThroughWalls;

/// How far to the side that path leads: across the shelves of a warehouse. [m]
const ASIDE_M: f64 = 3.0;

impl Paths for ThroughWalls {
    const WAYPOINTS_MAX: usize = 3;

    fn path(&mut self, seat: &Seat, shell: &Shell, tick: u64) -> Option<(Path, Vec<Waypoint>)> {
        let robot = seat.odometry.newest().filter(|_| is_obeyed(shell, tick))?;
        let from = seat.map.map_from_base(&robot.odometry.pose);
        let goal = seat.goal.goal()?;
        let to = goal.pose;
        let corners = [
            (from.x_m, from.y_m),
            (0.5 * (from.x_m + to.x_m), from.y_m + ASIDE_M),
            (to.x_m, to.y_m),
        ];
        let waypoint = |(x_m, y_m)| Waypoint {
            x_m,
            y_m,
            ..Waypoint::default()
        };
        let line = corners.map(waypoint).to_vec();
        let (status, cause) = (PathStatus::Found, PathCause::Goal);
        let path = Path::new("through_walls", status, cause, goal.id, &line);
        Some((path, line))
    }
}

/// Sends more waypoints than it has opened its topic for.
#[derive(Default)]
pub(crate) struct TooManyWaypoints;

impl Paths for TooManyWaypoints {
    const WAYPOINTS_MAX: usize = 2;

    fn path(&mut self, seat: &Seat, _shell: &Shell, _tick: u64) -> Option<(Path, Vec<Waypoint>)> {
        let goal = seat.goal.goal()?;
        let three = [Waypoint::default(); 3];
        let (status, cause) = (PathStatus::Found, PathCause::Goal);
        let path = Path {
            geometry: seat.path.next_id().0,
            ..Path::new("too_many", status, cause, goal.id, &three)
        };
        Some((path, three.to_vec()))
    }
}
