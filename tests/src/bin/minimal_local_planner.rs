//! A minimal local planner: turns towards the next waypoint, drives there as fast as the free
//! distance ahead allows, and stops at the goal. It keeps the state of the task.

use core::f64::consts::PI;
use std::process::ExitCode;
use zeronav_msgs::command::{Validity, VelocityRequest};
use zeronav_msgs::header::Parents;
use zeronav_msgs::health::{REASON_PATH, REASON_SCAN};
use zeronav_msgs::path::PathStatus;
use zeronav_msgs::pose::{Pose, wrap_angle};
use zeronav_msgs::role::Role;
use zeronav_msgs::task::{
    EndReason, GOALS_MAX, Goal, GoalEnd, TaskKind, TaskState as State, TaskStatus,
};
use zeronav_msgs::topics::{ControlRequest, PlanPath, RobotDescription, RobotScan, TaskState};
use zeronav_shell::doorbell::Rung;
use zeronav_shell::{
    Due, Latest, MapInput, NoConfig, OdometryReader, Service, Shell, StartError, Tasks, Trigger,
    Writer,
};

/// Distance kept free in front of the robot, and at its sides. [m]
const ROOM_AHEAD_M: f64 = 0.25;
const ROOM_BESIDE_M: f64 = 0.05;
/// How near counts as at a waypoint. [m]
const AT_WAYPOINT_M: f64 = 0.15;
/// Heading error above which the robot turns on the spot. [rad]
const TURN_ABOVE_RAD: f64 = 0.3;
/// Speed below which the robot counts as stopped. [m/s] and [rad/s]
const STOPPED: f64 = 0.02;
/// Run time for which scan, path, and a planning failure must last. [ns]
const SCAN_STALE_NS: u64 = 350_000_000;
const PATH_STALE_NS: u64 = 1_500_000_000;
const FAILURE_NS: u64 = 1_000_000_000;
/// Ticks between two statuses of an unchanged task.
const STATUS_TICKS: u64 = 10;

struct MinimalPlanner {
    description: Latest<RobotDescription>,
    odometry: OdometryReader,
    scan: Latest<RobotScan>,
    map: MapInput,
    path: Latest<PlanPath>,
    tasks: Tasks,
    request: Writer<ControlRequest>,
    status_writer: Writer<TaskState>,
    status: TaskStatus,
    ends: Vec<GoalEnd>,
    /// Geometry of the path that is followed, and the waypoint that comes next.
    geometry: u64,
    next: usize,
    /// Tick from which on the robot is stopped without a path.
    failing_tick: Option<u64>,
    status_tick: u64,
}

impl Service for MinimalPlanner {
    const ROLE: Role = Role::LocalPlanner;
    type Config = NoConfig;

    fn open(shell: &mut Shell, _config: NoConfig) -> Result<Self, StartError> {
        let peer = shell.peer();
        Ok(Self {
            description: peer.latest()?,
            odometry: OdometryReader::open(peer)?,
            scan: peer.latest()?,
            map: MapInput::open(peer)?,
            path: peer.latest()?,
            tasks: Tasks::open(peer)?,
            request: peer.writer(1)?,
            status_writer: peer.writer(GOALS_MAX)?,
            status: TaskStatus::default(),
            ends: Vec::with_capacity(GOALS_MAX),
            geometry: 0,
            next: 0,
            failing_tick: None,
            status_tick: 0,
        })
    }

    fn wake(&mut self, shell: &mut Shell, _rung: Rung) -> Result<(), StartError> {
        self.status_writer.refresh();
        self.odometry.poll(shell.roster());
        self.map.poll(shell);
        let roster = shell.roster();
        self.description.poll(roster);
        self.tasks.poll(roster);
        let news = self.scan.poll(roster) | self.path.poll(roster);
        shell.count(&[&self.odometry, &self.scan, &self.path]);
        let (roster, tick) = (shell.roster(), self.odometry.tick());
        // The scan of the tick, the map with it and the path on that map come first.
        let scan_waits = self.scan.tick() < tick
            || (roster.answers(Role::Mapping, tick) && !self.map.has(tick))
            || roster.awaits(Role::GlobalPlanner, tick, self.path.spoken_tick());
        let map_lost = roster.answers(Role::Mapping, tick) && self.map.is_lost();
        let waits = (self.odometry.scan_due() && scan_waits) || map_lost;
        let trigger = Trigger {
            tick,
            complete: !(roster.lockstep() && waits),
            deadline_ns: None,
            news,
        };
        for due in shell.due(&trigger) {
            self.answer(shell, due);
        }
        Ok(())
    }
}

impl MinimalPlanner {
    fn answer(&mut self, shell: &mut Shell, due: Due) {
        let tick = due.tick;
        let capture_ns = self.scan.received().map_or(0, |scan| scan.capture_ns);
        let before = self.status;
        let goal = self.goal_at(tick);
        let parents = Parents {
            odometry: self.odometry.id().0,
            scan: self.scan.id().0,
            map: self.map.revision().0,
            path: if self.path.tick() == 0 {
                0
            } else {
                self.path.id().0
            },
            goal: self.status.task,
            ..Parents::default()
        };
        let draft = shell.begin(due, shell.run_ns(tick), capture_ns, parents);
        let late = |from: u64, limit_ns: u64| shell.run_ns(tick.saturating_sub(from)) > limit_ns;
        let scan_stale = late(self.scan.tick(), SCAN_STALE_NS);
        let path_stale = late(self.path.tick(), PATH_STALE_NS);
        let failing_ns = self
            .failing_tick
            .map_or(0, |since| shell.run_ns(tick - since));
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
        let output = shell.send(&draft, &mut self.request, request, &[]);
        let changed = (before.state, before.task, before.goal)
            != (self.status.state, self.status.task, self.status.goal);
        if changed || tick == 0 || tick >= self.status_tick + STATUS_TICKS {
            self.status_tick = tick;
            shell.send(&draft, &mut self.status_writer, self.status, &self.ends);
        }
        shell.reason(REASON_SCAN, scan_stale);
        shell.reason(REASON_PATH, path_stale);
        shell.finish(&draft, output, 0);
    }

    /// The current goal; begins a new task.
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

    /// Ends the current goal, and the task with it, unless the goal was reached and more follow.
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
        let (Some(newest), Some(robot), Some(path)) = (
            self.odometry.history().newest(),
            self.description.get(),
            self.path.get(),
        ) else {
            return (Validity::Stale, 0.0, 0.0);
        };
        let robot = *robot.meta;
        let pose = self.map.map_from_base(&newest.odometry.pose);
        let stopped =
            newest.odometry.v_mps.abs() < STOPPED && newest.odometry.w_radps.abs() < STOPPED;
        let left_m = pose.distance_m(&goal.pose);
        self.status.remaining_m = left_m;
        let turn = |error_rad: f64| (2.0 * error_rad).clamp(-robot.w_radps_max, robot.w_radps_max);
        if left_m <= goal.tolerance_m {
            let error_rad = wrap_angle(goal.pose.yaw_rad - pose.yaw_rad);
            if goal.yaw_tolerance_rad < PI && error_rad.abs() > 0.5 * goal.yaw_tolerance_rad {
                return (Validity::Drive, 0.0, turn(error_rad));
            }
            if stopped {
                self.end(tick, goal, State::Reached, EndReason::None);
            }
            return (Validity::AtGoal, 0.0, 0.0);
        }
        let status = path.meta.status().unwrap_or(PathStatus::NoGoal);
        if status != PathStatus::Found || path.meta.goal != goal.id {
            let reason = end_of(status).filter(|_| stopped && path.meta.goal == goal.id);
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
