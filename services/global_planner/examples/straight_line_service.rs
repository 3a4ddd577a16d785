//! How to swap a service: a global planner that knows nothing but the straight line.
//!
//! ```toml
//! [services.global_planner]
//! binary = "straight_line_service"
//! ```
//!
//! A service implements [`Service`]: `open` makes its ports, `wake` takes in what has come and
//! answers. The shell does the rest: flags, sleep, clock, heartbeat, records, exit codes. What is
//! left is the seat's contract. A global planner says something as soon as it can (the idle
//! output), answers every map and every task with a path, and in lockstep answers every tick with
//! a scan exactly once, after the map of that tick.

use nalgebra::Point2;
use serde::{Deserialize, Serialize};
use std::process::ExitCode;
use zeronav_msgs::header::Parents;
use zeronav_msgs::health::REASON_MAP;
use zeronav_msgs::path::{Path, PathCause, PathStatus, Waypoint};
use zeronav_msgs::pose::wrap_angle;
use zeronav_msgs::replica::MapReplica;
use zeronav_msgs::role::Role;
use zeronav_msgs::span::SpanKind;
use zeronav_msgs::task::{Goal, TaskKind, TaskState as State};
use zeronav_msgs::topics::{
    EVENT_NEED_KEYFRAME, MapKeyframe, MapUpdate, PlanPath, RobotOdometry, TaskState,
};
use zeronav_shell::doorbell::Rung;
use zeronav_shell::{Cycle, Latest, Service, Shell, StartError, Stream, Tasks, Track, Writer};

/// Nothing to set; an unknown key is refused.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Config {}

struct StraightLine {
    odometry: Stream<RobotOdometry>,
    updates: Stream<MapUpdate>,
    keyframe: Latest<MapKeyframe>,
    tasks: Tasks,
    status: Latest<TaskState>,
    writer: Writer<PlanPath>,
    track: Track,
    map: MapReplica,
    /// Tick of the newest map, and the capture of the newest scan in it. [ns]
    map_tick: u64,
    map_capture_ns: u64,
    /// What was said last, for which goal, and the line's two ends; none without a line.
    path: Path,
    goal: Option<Goal>,
    line: Vec<Waypoint>,
    answered_tick: u64,
    idle_said: bool,
}

impl Service for StraightLine {
    const ROLE: Role = Role::GlobalPlanner;
    type Config = Config;

    fn open(shell: &mut Shell, _config: Config) -> Result<Self, StartError> {
        let peer = shell.peer();
        Ok(Self {
            odometry: peer.stream()?,
            updates: peer.stream()?, // Before the keyframe: none is missed between the two.
            keyframe: peer.latest()?,
            tasks: Tasks::open(peer)?,
            status: peer.latest()?,
            writer: peer.writer(2)?,
            track: Track::default(),
            map: MapReplica::new(),
            map_tick: 0,
            map_capture_ns: 0,
            path: Path {
                planner: Path::planner_bytes("straight_line"),
                ..Path::default()
            },
            goal: None,
            line: Vec::with_capacity(2),
            answered_tick: 0,
            idle_said: false,
        })
    }

    fn wake(&mut self, shell: &mut Shell, _rung: Rung) -> Result<Option<u64>, StartError> {
        let news = self.take_in(shell);
        if !shell.roster().has_clock() {
            return Ok(None);
        }
        if !self.idle_said {
            self.idle_said = true;
            self.answer(shell, 0, SpanKind::Idle);
            shell.ready();
        }
        let roster = shell.roster();
        if roster.lockstep() {
            // Odometry carries the tick; mapping, if it has to answer it, comes before us.
            let newest = self.track.newest();
            let (tick, due) = newest.map_or((0, false), |m| (m.tick, m.odometry.scan_due()));
            let mapped = self.map_tick >= tick && !self.map.needs_keyframe();
            let waits = roster.answers(Role::Mapping, tick) && !mapped;
            let owes = due && tick > self.answered_tick && roster.answers(Self::ROLE, tick);
            if owes && !waits {
                self.answer(shell, tick, SpanKind::Answer);
            }
        } else if news && self.map_tick > 0 {
            let first = self.map_tick > self.answered_tick;
            let kind = if first {
                SpanKind::Answer
            } else {
                SpanKind::Extra
            };
            self.answer(shell, self.map_tick, kind);
        }
        Ok(None)
    }
}

impl StraightLine {
    /// Takes in what has come; true when it asks for an answer. Odometry first: whatever belongs
    /// to its tick was sent before it, so it is then found, too.
    fn take_in(&mut self, shell: &mut Shell) -> bool {
        let roster = shell.roster();
        let track = &mut self.track;
        self.odometry
            .drain(roster, |view| track.push(view.header, view.meta));
        let mut news = self.tasks.poll(roster) | self.status.poll(roster);
        self.updates.drain(roster, |view| {
            self.map.update(view.header.id(), view.meta, view.items);
            if view.meta.is_last_part() {
                (self.map_tick, self.map_capture_ns) = (view.header.tick, view.header.capture_ns);
                news = true;
            }
        });
        // Also when none is needed, and given back at once: there is room for few of them.
        if self.keyframe.poll(roster)
            && let Some(view) = self.keyframe.get()
        {
            self.map.keyframe(view.meta, view.items);
        }
        self.keyframe.release();
        self.map.take_changed();
        let lost = self.map.needs_keyframe();
        if lost && roster.has_clock() {
            shell.ring_event(Role::Mapping, EVENT_NEED_KEYFRAME);
        }
        shell.reason(REASON_MAP, lost);
        shell.totals(
            self.odometry.refused() + self.updates.refused() + self.tasks.refused(),
            0,
        );
        news
    }

    /// The goal at hand, from the task and how far the local planner has come with it.
    fn goal_at(&mut self, tick: u64) -> Option<Goal> {
        let task = self
            .tasks
            .at(tick)
            .filter(|task| task.kind == TaskKind::Go)?;
        let status = self
            .status
            .get()
            .filter(|status| status.meta.task == task.id.0);
        let state = status.map_or(Some(State::Idle), |status| status.meta.state());
        let at_hand = status.map_or(0, |status| status.meta.goal);
        let goal = task.goals.iter().find(|goal| goal.id == at_hand);
        let on = matches!(state, Some(State::Idle | State::Active));
        goal.or(task.goals.first()).filter(|_| on).copied()
    }

    /// True when the robot's centre may be everywhere on the line between two points. Looks four
    /// times per cell's width, so all that it can miss is a cut through a cell's corner.
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "float to int saturates, and the first look beside the map ends the search"
    )]
    fn is_free(&self, from: Point2<f64>, to: Point2<f64>) -> bool {
        let Some(map) = self.map.view() else {
            return false;
        };
        let way = to - from;
        let looks = (4.0 * way.norm() / map.geometry.resolution_m) as u32 + 1;
        (0..=looks).all(|look| {
            let point = from + way * (f64::from(look) / f64::from(looks));
            let cell = map.geometry.cell_at(point).and_then(|cell| map.get(cell));
            cell.is_some_and(|cell| !cell.blocks_centre())
        })
    }

    #[allow(clippy::cast_possible_truncation, reason = "radians and metres to f32")]
    fn waypoint(&self, at: Point2<f64>, yaw_rad: f64) -> Waypoint {
        let map = self.map.view();
        let cell = map.and_then(|map| map.get(map.geometry.cell_at(at)?));
        Waypoint {
            x_m: at.x,
            y_m: at.y,
            yaw_rad: wrap_angle(yaw_rad) as f32,
            clearance_m: cell.map_or(0.0, zeronav_msgs::MapCell::clearance_m) as f32,
        }
    }

    /// The plan. A line stays as long as it leads to the goal at hand and is free; otherwise the
    /// next one begins where the robot is now. True when something else is said than before.
    fn plan(&mut self, goal: Option<Goal>) -> bool {
        let before = (self.path.status, self.goal);
        let same_goal = goal == self.goal;
        if let ([start, end], true) = (self.line.as_slice(), same_goal)
            && self.is_free(point_of(start), point_of(end))
        {
            return false;
        }
        self.goal = goal;
        self.line.clear();
        let (status, cause) = match (goal, self.track.newest()) {
            (Some(goal), Some(newest)) => {
                let robot = self.map.info().map_from_odom.then(&newest.odometry.pose);
                let (start, end) = (robot.point(), goal.pose.point());
                let free = self.is_free(start, end);
                if free {
                    let way = end - start;
                    self.line.push(self.waypoint(start, way.y.atan2(way.x)));
                    self.line.push(self.waypoint(end, goal.pose.yaw_rad));
                }
                let again = same_goal.then_some(PathCause::Obstacle);
                let status = free.then_some(PathStatus::Found);
                (
                    status.unwrap_or(PathStatus::DeadEnd),
                    again.unwrap_or(PathCause::Goal),
                )
            }
            _ => (PathStatus::NoGoal, PathCause::None),
        };
        (self.path.status, self.path.cause) = (status.code(), cause.code());
        // A failure that goes on is no news.
        status == PathStatus::Found || before != (self.path.status, self.goal)
    }

    fn answer(&mut self, shell: &mut Shell, tick: u64, kind: SpanKind) {
        let goal = self.goal_at(tick);
        let parents = Parents {
            odometry: self.track.newest().map_or(0, |newest| newest.id.0),
            map: self.map.revision().0,
            goal: self.tasks.current().map_or(0, |task| task.id.0),
            ..Parents::default()
        };
        let run_ns = tick.saturating_mul(shell.roster().clock.tick_ns);
        let draft = shell.draft(tick, run_ns, self.map_capture_ns, parents);
        if self.plan(goal) || self.path.geometry == 0 {
            // Messages that repeat this line, or this failure, name it by this message.
            self.path.geometry = self.writer.next_id().0;
            self.path.searched_map = parents.map;
            self.path.goal = self.goal.map_or(0, |goal| goal.id);
            self.path.n_waypoints = if self.line.is_empty() { 0 } else { 2 };
            self.path.length_m = match self.line.as_slice() {
                [start, end] => (point_of(end) - point_of(start)).norm(),
                _ => 0.0,
            };
            self.path.cost = self.path.length_m;
        }
        let sent = self.writer.publish(&draft, self.path, &self.line);
        self.answered_tick = self.answered_tick.max(tick);
        let output = shell.sent(&self.writer, sent);
        shell.finish(&Cycle {
            kind,
            draft,
            output,
            work: 0,
        });
    }
}

fn point_of(waypoint: &Waypoint) -> Point2<f64> {
    Point2::new(waypoint.x_m, waypoint.y_m)
}

fn main() -> ExitCode {
    zeronav_shell::run::<StraightLine>()
}
