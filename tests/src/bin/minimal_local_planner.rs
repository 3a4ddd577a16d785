//! The least that can sit in the local planner's seat: it turns towards the next waypoint, drives
//! there as fast as the room ahead allows, and stops at the goal. It keeps the task.

use core::f64::consts::PI;
use serde::{Deserialize, Serialize};
use std::process::ExitCode;
use zeronav_msgs::command::{Validity, VelocityRequest};
use zeronav_msgs::header::Parents;
use zeronav_msgs::health::{REASON_PATH, REASON_SCAN};
use zeronav_msgs::path::PathStatus;
use zeronav_msgs::pose::{Pose, wrap_angle};
use zeronav_msgs::role::Role;
use zeronav_msgs::span::SpanKind;
use zeronav_msgs::task::{
    EndReason, GOALS_MAX, Goal, GoalEnd, TaskKind, TaskState as State, TaskStatus,
};
use zeronav_msgs::topics::{
    ControlRequest, MapUpdate, PlanPath, RobotDescription, RobotOdometry, RobotScan, TaskState,
};
use zeronav_shell::doorbell::Rung;
use zeronav_shell::{Cycle, Latest, Service, Shell, StartError, Stream, Tasks, Track, Writer};

/// Room that stays free in front of the robot, and at its sides. [m]
const ROOM_AHEAD_M: f64 = 0.25;
const ROOM_BESIDE_M: f64 = 0.05;
/// How near counts as at a waypoint. [m]
const AT_WAYPOINT_M: f64 = 0.15;
/// Heading error above which the robot turns on the spot. [rad]
const TURN_ABOVE_RAD: f64 = 0.3;
/// Speed below which the robot stands. [m/s] and [rad/s]
const STANDING: f64 = 0.02;
/// Run time for which scan, path, and a planning failure must last. [ns]
const SCAN_STALE_NS: u64 = 350_000_000;
const PATH_STALE_NS: u64 = 1_500_000_000;
const FAILURE_NS: u64 = 1_000_000_000;
/// Ticks between two statuses of an unchanged task.
const STATUS_TICKS: u64 = 10;

#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Config {}

struct MinimalPlanner {
    description: Latest<RobotDescription>,
    odometry: Stream<RobotOdometry>,
    scan: Latest<RobotScan>,
    updates: Stream<MapUpdate>,
    path: Latest<PlanPath>,
    tasks: Tasks,
    request: Writer<ControlRequest>,
    status_writer: Writer<TaskState>,
    track: Track,
    map_tick: u64,
    map: u64,
    map_from_odom: Pose,
    status: TaskStatus,
    ends: Vec<GoalEnd>,
    /// Geometry of the path that is followed, and the waypoint that comes next.
    geometry: u64,
    next: usize,
    /// Since when the robot stands without a path. [tick]
    failing_tick: Option<u64>,
    answered_tick: u64,
    status_tick: u64,
    idle_said: bool,
}

impl Service for MinimalPlanner {
    const ROLE: Role = Role::LocalPlanner;
    type Config = Config;

    fn open(shell: &mut Shell, _config: Config) -> Result<Self, StartError> {
        let peer = shell.peer();
        Ok(Self {
            description: peer.latest()?,
            odometry: peer.stream()?,
            scan: peer.latest()?,
            updates: peer.stream()?,
            path: peer.latest()?,
            tasks: Tasks::open(peer)?,
            request: peer.writer(1)?,
            status_writer: peer.writer(GOALS_MAX)?,
            track: Track::default(),
            map_tick: 0,
            map: 0,
            map_from_odom: Pose::default(),
            status: TaskStatus::default(),
            ends: Vec::with_capacity(GOALS_MAX),
            geometry: 0,
            next: 0,
            failing_tick: None,
            answered_tick: 0,
            status_tick: 0,
            idle_said: false,
        })
    }

    fn wake(&mut self, shell: &mut Shell, _rung: Rung) -> Result<Option<u64>, StartError> {
        self.status_writer.refresh();
        let roster = shell.roster();
        // Odometry first: in lockstep it carries the tick, and what belongs to it was sent before.
        let track = &mut self.track;
        self.odometry
            .drain(roster, |view| track.push(view.header, view.meta));
        self.updates.drain(roster, |view| {
            self.map_tick = view.header.tick;
            self.map = view.meta.revision;
            self.map_from_odom = view.meta.map_from_odom;
        });
        self.description.poll(roster);
        self.tasks.poll(roster);
        let news = self.scan.poll(roster) | self.path.poll(roster);
        let refused = self.odometry.refused() + self.scan.refused() + self.path.refused();
        shell.totals(refused, self.scan.superseded() + self.path.superseded());
        if !shell.roster().has_clock() {
            return Ok(None);
        }
        if !self.idle_said {
            self.idle_said = true;
            self.answer(shell, 0, SpanKind::Idle);
            shell.ready();
        }
        let Some(newest) = self.track.newest() else {
            return Ok(None);
        };
        let (tick, scan_due) = (newest.tick, newest.odometry.scan_due());
        let owes = tick > self.answered_tick;
        let roster = shell.roster();
        if roster.lockstep() {
            // Its scan, the map with it and the path on that come first.
            let waits = self.scan.tick() < tick
                || (roster.answers(Role::Mapping, tick) && self.map_tick < tick)
                || (roster.answers(Role::GlobalPlanner, tick) && self.path.tick() < tick);
            if owes && !(scan_due && waits) && roster.answers(Self::ROLE, tick) {
                self.answer(shell, tick, SpanKind::Answer);
            }
        } else if owes {
            self.answer(shell, tick, SpanKind::Answer);
        } else if news {
            self.answer(shell, tick, SpanKind::Extra);
        }
        Ok(None)
    }
}

impl MinimalPlanner {
    fn answer(&mut self, shell: &mut Shell, tick: u64, kind: SpanKind) {
        let tick_ns = shell.roster().clock.tick_ns;
        let capture_ns = self.scan.get().map_or(0, |view| view.header.capture_ns);
        let before = self.status;
        let goal = self.goal_at(tick);
        let parents = Parents {
            odometry: self.track.newest().map_or(0, |newest| newest.id.0),
            scan: self.scan.id().0,
            map: self.map,
            path: if self.path.tick() == 0 {
                0
            } else {
                self.path.id().0
            },
            goal: self.status.task,
            ..Parents::default()
        };
        let draft = shell.draft(tick, tick.saturating_mul(tick_ns), capture_ns, parents);
        let late =
            |from: u64, limit_ns: u64| (tick - tick.min(from)).saturating_mul(tick_ns) > limit_ns;
        let scan_stale = late(self.scan.tick(), SCAN_STALE_NS);
        let path_stale = late(self.path.tick(), PATH_STALE_NS);
        let failing_ns = self
            .failing_tick
            .map_or(0, |since| (tick - since).saturating_mul(tick_ns));
        let (validity, v_mps, w_radps) = if shell.roster().control.stopping == 1 {
            (Validity::Stopped, 0.0, 0.0)
        } else if scan_stale || path_stale {
            (Validity::Stale, 0.0, 0.0)
        } else {
            goal.map_or((Validity::NoPath, 0.0, 0.0), |goal| {
                self.follow(tick, &goal, failing_ns)
            })
        };
        let request = VelocityRequest {
            v_mps,
            w_radps,
            validity: validity.code(),
            braking_arc_m: self
                .description
                .get()
                .map_or(0.0, |view| view.meta.braking_distance_m(v_mps)),
            ..VelocityRequest::default()
        };
        let sent = self.request.publish(&draft, request, &[]);
        let output = shell.sent(&self.request, sent);
        let changed = (before.state, before.task, before.goal)
            != (self.status.state, self.status.task, self.status.goal);
        if changed || tick == 0 || tick >= self.status_tick + STATUS_TICKS {
            self.status_tick = tick;
            let sent = self.status_writer.publish(&draft, self.status, &self.ends);
            shell.sent(&self.status_writer, sent);
        }
        self.answered_tick = self.answered_tick.max(tick);
        shell.reason(REASON_SCAN, scan_stale);
        shell.reason(REASON_PATH, path_stale);
        shell.finish(&Cycle {
            kind,
            draft,
            output,
            work: 0,
        });
    }

    /// The goal at hand; begins a task that is new.
    fn goal_at(&mut self, tick: u64) -> Option<Goal> {
        let task = self.tasks.at(tick)?;
        if task.id.0 != self.status.task {
            let go = task.kind == TaskKind::Go;
            let state = if go { State::Active } else { State::Cancelled };
            self.ends.clear();
            self.failing_tick = None;
            self.status = TaskStatus {
                state: state.code(),
                task: task.id.0,
                ..TaskStatus::default()
            };
        }
        let active = self.status.state() == Some(State::Active);
        let goal = task.goals.get(self.ends.len()).filter(|_| active).copied();
        self.status.goal = goal.map_or(0, |goal| goal.id);
        goal
    }

    /// The goal at hand has ended, and with it the task, unless it was reached and more follow.
    fn end(&mut self, tick: u64, goal: &Goal, state: State, reason: EndReason) {
        self.ends.push(GoalEnd {
            goal: goal.id,
            tick,
            state: state.code(),
            reason: reason.code(),
            ..GoalEnd::default()
        });
        self.failing_tick = None;
        let n_goals = self.tasks.current().map_or(0, |task| task.goals.len());
        if state != State::Reached || self.ends.len() >= n_goals {
            (self.status.state, self.status.reason) = (state.code(), reason.code());
            self.status.goal = 0;
        }
        self.status.n_ended = u32::try_from(self.ends.len()).unwrap_or(u32::MAX);
        self.status.remaining_m = 0.0;
    }

    /// What to do on the way to `goal`: meaning, speed [m/s] and yaw rate [rad/s].
    fn follow(&mut self, tick: u64, goal: &Goal, failing_ns: u64) -> (Validity, f64, f64) {
        let (Some(newest), Some(robot), Some(path)) =
            (self.track.newest(), self.description.get(), self.path.get())
        else {
            return (Validity::Stale, 0.0, 0.0);
        };
        let robot = *robot.meta;
        let pose = self.map_from_odom.then(&newest.odometry.pose);
        let stands =
            newest.odometry.v_mps.abs() < STANDING && newest.odometry.w_radps.abs() < STANDING;
        let left_m = pose.distance_m(&goal.pose);
        self.status.remaining_m = left_m;
        let turn = |error_rad: f64| (2.0 * error_rad).clamp(-robot.w_radps_max, robot.w_radps_max);
        if left_m <= goal.tolerance_m {
            let error_rad = wrap_angle(goal.pose.yaw_rad - pose.yaw_rad);
            if goal.yaw_tolerance_rad < PI && error_rad.abs() > 0.5 * goal.yaw_tolerance_rad {
                return (Validity::Drive, 0.0, turn(error_rad));
            }
            if stands {
                self.end(tick, goal, State::Reached, EndReason::None);
            }
            return (Validity::AtGoal, 0.0, 0.0);
        }
        let status = path.meta.status().unwrap_or(PathStatus::NoGoal);
        if status != PathStatus::Found || path.meta.goal != goal.id {
            let reason = end_of(status).filter(|_| stands && path.meta.goal == goal.id);
            self.failing_tick = reason.map(|_| self.failing_tick.unwrap_or(tick));
            if let Some(reason) = reason.filter(|_| failing_ns >= FAILURE_NS) {
                self.end(tick, goal, State::Failed, reason);
            }
            return (Validity::NoPath, 0.0, 0.0);
        }
        self.failing_tick = None;
        if path.meta.geometry != self.geometry {
            // The first waypoint is where the robot was.
            (self.geometry, self.next) = (path.meta.geometry, 1);
        }
        let place = |index: usize| {
            path.items
                .get(index)
                .map(|to| Pose::new(to.x_m, to.y_m, 0.0))
        };
        while self.next + 1 < path.items.len()
            && place(self.next).is_some_and(|to| pose.distance_m(&to) < AT_WAYPOINT_M)
        {
            self.next += 1;
        }
        let to = place(self.next).unwrap_or(goal.pose);
        let error_rad = wrap_angle((to.y_m - pose.y_m).atan2(to.x_m - pose.x_m) - pose.yaw_rad);
        if error_rad.abs() > TURN_ABOVE_RAD {
            return (Validity::Drive, 0.0, turn(error_rad));
        }
        let room_m = self.room_ahead_m();
        if room_m <= 0.0 {
            return (Validity::Blocked, 0.0, 0.0);
        }
        // Half of the braking that can be relied on, and slow where the path turns.
        let v_mps = (robot.brake_mps2 * room_m)
            .sqrt()
            .min(0.1 + pose.distance_m(&to));
        (Validity::Drive, v_mps.min(robot.v_mps_max), turn(error_rad))
    }

    /// Way that the newest scan leaves in front of the robot; at most 10 m. [m]
    fn room_ahead_m(&self) -> f64 {
        let (Some(scan), Some(robot)) = (self.scan.get(), self.description.get()) else {
            return 0.0;
        };
        let radius_m = robot.meta.circumscribed_radius_m;
        let hits = scan
            .items
            .iter()
            .enumerate()
            .filter(|(_, range)| scan.meta.is_hit(**range));
        let points = hits.map(|(beam, range)| {
            let (sin, cos) = scan.meta.angle_of(beam).sin_cos();
            let in_laser = Pose::new(f64::from(*range) * cos, f64::from(*range) * sin, 0.0);
            robot.meta.base_from_laser.then(&in_laser)
        });
        points
            .filter(|point| point.x_m > 0.0 && point.y_m.abs() < radius_m + ROOM_BESIDE_M)
            .map(|point| point.x_m - radius_m - ROOM_AHEAD_M)
            .fold(10.0, f64::min)
    }
}

/// The end that a planning failure leads to when it lasts.
fn end_of(status: PathStatus) -> Option<EndReason> {
    match status {
        PathStatus::NoGoal | PathStatus::Found => None,
        PathStatus::Unreachable | PathStatus::UnreachableCorner => Some(EndReason::Unreachable),
        PathStatus::GoalBlocked => Some(EndReason::GoalBlocked),
        PathStatus::GoalOutsideMap => Some(EndReason::GoalOutsideMap),
        _ => Some(EndReason::NoPath),
    }
}

fn main() -> ExitCode {
    zeronav_shell::run::<MinimalPlanner>()
}
