//! The local planner as a process: answers every odometry, scan and path with a velocity request.

use std::process::ExitCode;
use zeronav_local_planner::period::BuildError;
use zeronav_local_planner::recovery::Behaviour;
use zeronav_local_planner::scan_points::ScanPoints;
use zeronav_local_planner::staleness::{Ages, StaleInput};
use zeronav_local_planner::table::{CONTROLLERS, ControllerRow, UnknownController};
use zeronav_local_planner::{Inputs, LocalPlanner, LocalPlannerConfig, Outputs, PathInput};
use zeronav_motion::Twist;
use zeronav_msgs::header::Parents;
use zeronav_msgs::health::{REASON_MAP, REASON_ODOMETRY, REASON_PATH, REASON_SCAN};
use zeronav_msgs::pose::Pose;
use zeronav_msgs::role::Role;
use zeronav_msgs::span::SpanKind;
use zeronav_msgs::task::{EndReason, GOALS_MAX, TaskState as State};
use zeronav_msgs::topics::{
    ControlRequest, MapObstacles, PlanPath, PlanRequests, RobotDescription, RobotOdometry,
    RobotScan, TaskGoal, TaskState,
};
use zeronav_params::Parameter;
use zeronav_shell::clock::now_ns;
use zeronav_shell::doorbell::Rung;
use zeronav_shell::nearest::unknown;
use zeronav_shell::{
    Cycle, Latest, MapInput, Roster, Service, Shell, Stamp, StartError, Stream, Track, Writer,
};

/// Ticks between two statuses of an unchanged task.
const STATUS_TICKS: u64 = 10;

/// Age beyond which tracked obstacles are forgotten. [s]
const OBSTACLES_AGE_S_MAX: f64 = 0.5;

/// Shortest period that the controller is told of, in real time. [s]
const PERIOD_S_MIN: f64 = 1.0e-3;

/// What the planner reads, and how old it is.
struct Readings {
    description: Latest<RobotDescription>,
    odometry: Stream<RobotOdometry>,
    scan: Latest<RobotScan>,
    map: MapInput,
    obstacles: Latest<MapObstacles>,
    path: Latest<PlanPath>,
    goal: Latest<TaskGoal>,
    track: Track,
    /// Grows when cells of the map change.
    map_cells: u64,
    points: ScanPoints,
    /// `odom_from_base` at the capture of the scan whose points are held.
    scan_pose: Option<Pose>,
    /// The points of the newest scan are still to be taken.
    scan_fresh: bool,
    odometry_stamp: Option<Stamp>,
    scan_stamp: Option<Stamp>,
    path_stamp: Option<Stamp>,
}

/// What came in with a wake.
#[derive(Debug, Clone, Copy, Default)]
struct News {
    scan: bool,
    path: bool,
    goal: bool,
}

struct PlannerService {
    planner: LocalPlanner,
    readings: Readings,
    request: Writer<ControlRequest>,
    plan_request: Writer<PlanRequests>,
    status: Writer<TaskState>,
    answered_tick: u64,
    answered_ns: u64,
    status_tick: u64,
    idle_said: bool,
    /// Task and goal at hand, as the log has them.
    told_goal: (u64, u64),
    /// Ends of goals of that task that the log has.
    told_ended: usize,
}

impl Readings {
    /// Takes in what has come, odometry first: in lockstep it carries the tick, and whatever was
    /// sent before it (goals, idle outputs, its scan) is then surely found by the others.
    fn poll(&mut self, shell: &Shell) -> News {
        let (roster, now_ns) = (shell.roster(), shell.woken_ns());
        let mut news = News::default();
        let (track, odometry_stamp) = (&mut self.track, &mut self.odometry_stamp);
        self.odometry.drain(roster, |view| {
            track.push(view.header, view.meta);
            *odometry_stamp = Some(Stamp::of(view.header, now_ns));
        });
        self.description.poll(roster);
        news.goal = self.goal.poll(roster);
        news.path = self.path.poll(roster);
        if let Some(view) = self.path.get().filter(|_| news.path) {
            self.path_stamp = Some(Stamp::of(view.header, now_ns));
        }
        self.map.poll(shell);
        self.map_cells += u64::from(!self.map.changed().is_empty());
        self.obstacles.poll(roster);
        news.scan = self.scan.poll(roster);
        if let Some(view) = self.scan.get().filter(|_| news.scan) {
            self.scan_stamp = Some(Stamp::of(view.header, now_ns));
        }
        self.scan_fresh |= news.scan;
        self.take_points();
        news
    }

    /// Takes the points of a new scan, once odometry tells where it was captured.
    fn take_points(&mut self) {
        if !self.scan_fresh {
            return;
        }
        let (Some(scan), Some(description)) = (self.scan.get(), self.description.get()) else {
            return;
        };
        let Some(pose) = self.track.pose_at(scan.header.run_ns) else {
            return;
        };
        let twist = self.track.newest().map_or(Twist::REST, |moment| {
            Twist::new(moment.odometry.v_mps, moment.odometry.w_radps)
        });
        let base_from_laser = &description.meta.base_from_laser;
        self.points
            .take(scan.meta, scan.items, base_from_laser, &pose, twist);
        self.scan_pose = Some(pose);
        self.scan_fresh = false;
    }

    fn ages(&self, lockstep: bool, run_ns: u64, now_ns: u64) -> Ages {
        let age_ns = |stamp: Stamp| stamp.age_ns(lockstep, run_ns, now_ns);
        Ages {
            scan_ns: self.scan_stamp.map(age_ns),
            odometry_ns: self.odometry_stamp.map(age_ns),
            map_ns: self.map.stamp().map(age_ns),
            path_ns: self.path_stamp.map(age_ns),
        }
    }

    fn parents(&self) -> Parents {
        Parents {
            odometry: self.track.newest().map_or(0, |moment| moment.id.0),
            // The scan whose points are looked at, not one that still waits for its odometry.
            scan: if self.scan_fresh { 0 } else { self.scan.id().0 },
            map: self.map.revision().0,
            // An idle output is no path; whether it was heard depends on who started first.
            path: if self.path.tick() == 0 {
                0
            } else {
                self.path.id().0
            },
            goal: self.goal.id().0,
            ..Parents::default()
        }
    }

    fn refused(&self) -> u64 {
        self.odometry.refused()
            + self.scan.refused()
            + self.map.refused()
            + self.obstacles.refused()
            + self.path.refused()
            + self.goal.refused()
    }
}

fn unusable(error: BuildError) -> StartError {
    match error {
        BuildError::Controller(UnknownController { key }) => {
            let known = CONTROLLERS.iter().map(|row| row.key);
            StartError::config("controller", unknown("controller", &key, known))
        }
        BuildError::Config(error) => error.into(),
    }
}

impl Service for PlannerService {
    const ROLE: Role = Role::LocalPlanner;
    type Config = LocalPlannerConfig;

    fn algorithms() -> Vec<(&'static str, String)> {
        let line = |row: &ControllerRow| (row.key, format!("{} ({})", row.title, row.source));
        CONTROLLERS.iter().map(line).collect()
    }

    fn parameters() -> Vec<Parameter> {
        zeronav_params::describe::<LocalPlannerConfig>()
    }

    fn check(config: &LocalPlannerConfig) -> Result<(), StartError> {
        LocalPlanner::new(config).map(|_| ()).map_err(unusable)
    }

    fn open(shell: &mut Shell, config: LocalPlannerConfig) -> Result<Self, StartError> {
        let planner = LocalPlanner::new(&config).map_err(unusable)?;
        let peer = shell.peer();
        Ok(Self {
            planner,
            readings: Readings {
                description: peer.latest()?,
                odometry: peer.stream()?,
                scan: peer.latest()?,
                map: MapInput::open(peer)?,
                obstacles: peer.latest()?,
                path: peer.latest()?,
                goal: peer.latest()?,
                track: Track::default(),
                map_cells: 0,
                points: ScanPoints::default(),
                scan_pose: None,
                scan_fresh: false,
                odometry_stamp: None,
                scan_stamp: None,
                path_stamp: None,
            },
            request: peer.writer(1)?,
            plan_request: peer.writer(1)?,
            status: peer.writer(GOALS_MAX)?,
            answered_tick: 0,
            answered_ns: 0,
            status_tick: 0,
            idle_said: false,
            told_goal: (0, 0),
            told_ended: 0,
        })
    }

    fn wake(&mut self, shell: &mut Shell, _rung: Rung) -> Result<Option<u64>, StartError> {
        self.status.refresh();
        let news = self.readings.poll(shell);
        shell.totals(
            self.readings.refused(),
            self.readings.scan.superseded() + self.readings.path.superseded(),
        );
        if !shell.roster().has_clock() {
            return Ok(None);
        }
        if news.goal
            && let Some(view) = self.readings.goal.get()
        {
            self.planner
                .accept_task(view.header.id, view.meta, view.items);
        }
        if !self.idle_said {
            self.idle_said = true;
            self.answer(shell, 0, SpanKind::Idle);
            shell.ready();
        }
        let Some(newest) = self.readings.track.newest() else {
            return Ok(None);
        };
        let (tick, due) = (newest.tick, newest.odometry.scan_due());
        if shell.roster().lockstep() {
            let owes =
                tick > self.answered_tick && shell.roster().answers(Role::LocalPlanner, tick);
            if owes && !self.waits(shell.roster(), tick, due) {
                self.answer(shell, tick, SpanKind::Answer);
            }
        } else if tick > self.answered_tick {
            self.answer(shell, tick, SpanKind::Answer);
        } else if news.scan || news.path {
            self.answer(shell, tick, SpanKind::Extra);
        }
        Ok(None)
    }

    fn is_at_rest(&self) -> bool {
        self.readings.track.is_at_rest()
    }
}

impl PlannerService {
    /// True while something that belongs to `tick` is still on its way, lockstep only.
    fn waits(&self, roster: &Roster, tick: u64, scan_due: bool) -> bool {
        let came = |stamp: Option<Stamp>| stamp.is_some_and(|stamp| stamp.tick >= tick);
        let readings = &self.readings;
        let mapped = roster.answers(Role::Mapping, tick);
        let planned = roster.answers(Role::GlobalPlanner, tick);
        let scan_waits = !came(readings.scan_stamp)
            || readings.scan_fresh
            || (mapped && !came(readings.map.stamp()))
            || (planned && readings.path.spoken_tick() < tick);
        (scan_due && scan_waits) || (mapped && readings.map.is_lost())
    }

    #[allow(clippy::cast_precision_loss, reason = "periods far below 2^53 ns")]
    fn period_s(&self, shell: &Shell, now_ns: u64) -> f64 {
        let tick_s = shell.roster().clock.tick_ns as f64 * 1.0e-9;
        if shell.roster().lockstep() {
            return tick_s;
        }
        let since_s = now_ns.saturating_sub(self.answered_ns) as f64 * 1.0e-9;
        since_s.clamp(PERIOD_S_MIN.min(tick_s), tick_s)
    }

    #[allow(clippy::cast_precision_loss, reason = "ages far below 2^53 ns")]
    fn answer(&mut self, shell: &mut Shell, tick: u64, kind: SpanKind) {
        let clock = shell.roster().clock;
        let lockstep = shell.roster().lockstep();
        // In real time a scan between two ticks brings odometry of its own moment.
        let newest = self.readings.track.newest();
        let run_ns = match newest.filter(|newest| !lockstep && newest.tick == tick) {
            Some(newest) => newest.run_ns,
            None => tick.saturating_mul(clock.tick_ns),
        };
        let now_ns = now_ns();
        let period_s = self.period_s(shell, now_ns);
        let readings = &mut self.readings;
        let capture_ns = readings.scan_stamp.map_or(0, |stamp| stamp.capture_ns);
        let draft = shell.draft(tick, run_ns, capture_ns, readings.parents());
        let ages = readings.ages(lockstep, run_ns, now_ns);
        let odometry = readings.track.newest().map(|moment| moment.odometry);
        let points = match (readings.scan_pose, &odometry) {
            (Some(at_capture), Some(now)) => readings.points.carry(&at_capture, &now.pose),
            _ => &[],
        };
        let description = readings.description.get();
        let path = readings.path.get();
        // Older than the map may be, nobody knows where they are.
        let tracked = readings.obstacles.get().map(|view| {
            let age_ns = run_ns.saturating_sub(view.header.run_ns);
            (view.items, age_ns as f64 * 1.0e-9)
        });
        let tracked = tracked.filter(|(_, age_s)| *age_s <= OBSTACLES_AGE_S_MAX);
        let outputs = self.planner.step(&Inputs {
            tick,
            run_ns,
            period_s,
            robot: description.as_ref().map(|view| (view.meta, view.items)),
            odometry: odometry.as_ref(),
            map: readings
                .map
                .view()
                .map(|map| (readings.map.info().map_from_odom, map)),
            map_cells: readings.map_cells,
            obstacles: tracked.unwrap_or((&[], 0.0)),
            path: path.as_ref().map(|view| PathInput {
                path: view.meta,
                waypoints: view.items,
            }),
            scan_points_in_base: points,
            ages,
            stopping: shell.roster().control.stopping == 1,
        });
        let sent = self.request.publish(&draft, outputs.request, &[]);
        let output = shell.sent(&self.request, sent);
        if let Some(plan_request) = outputs.plan_request {
            let sent = self.plan_request.publish(&draft, plan_request, &[]);
            shell.sent(&self.plan_request, sent);
        }
        if outputs.status_changed || tick >= self.status_tick + STATUS_TICKS || tick == 0 {
            self.send_status(shell, &draft);
        }
        self.answered_tick = self.answered_tick.max(tick);
        self.answered_ns = now_ns;
        Self::tell(shell, &outputs);
        shell.finish(&Cycle {
            kind,
            draft,
            output,
            work: u64::from(outputs.rollouts),
        });
    }

    fn send_status(&mut self, shell: &mut Shell, draft: &zeronav_shell::Draft) {
        let (status, ended) = self.planner.status();
        if (status.task, status.goal) != self.told_goal && status.goal != 0 {
            let (task, goal) = (status.task, status.goal);
            tracing::info!(tick = draft.tick, task, goal, "goal accepted");
        }
        if status.task != self.told_goal.0 {
            self.told_ended = 0;
        }
        for end in ended.iter().skip(self.told_ended) {
            let state = State::from_code(end.state).map_or("unknown", State::label);
            let reason = EndReason::from_code(end.reason).map_or("unknown", EndReason::label);
            tracing::info!(
                tick = end.tick,
                goal = end.goal,
                state,
                reason,
                "goal ended"
            );
        }
        self.told_goal = (status.task, status.goal);
        self.told_ended = ended.len();
        let sent = self.status.publish(draft, status, ended);
        shell.sent(&self.status, sent);
        self.status_tick = draft.tick;
    }

    fn tell(shell: &mut Shell, outputs: &Outputs) {
        for (input, bit) in [
            (StaleInput::Odometry, REASON_ODOMETRY),
            (StaleInput::Scan, REASON_SCAN),
            (StaleInput::Map, REASON_MAP),
            (StaleInput::Path, REASON_PATH),
        ] {
            shell.reason(
                bit,
                outputs.stale == Some(input) || outputs.ageing.includes(input),
            );
        }
        if let Some(change) = outputs.recovery {
            // Turns towards the path are everyday business.
            if change.from == Behaviour::Align || change.to == Behaviour::Align {
                tracing::debug!(from = ?change.from, to = ?change.to, reason = ?change.reason, "recovery");
            } else {
                tracing::info!(from = ?change.from, to = ?change.to, reason = ?change.reason, "recovery");
            }
        }
    }
}

fn main() -> ExitCode {
    zeronav_shell::run::<PlannerService>()
}
