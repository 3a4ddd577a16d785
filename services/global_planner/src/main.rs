//! The global planner as a process: answers every map update, goal and request with a path.

use std::process::ExitCode;
use zeronav_global_planner::replan::{BuildError, News, Replanner, Request, Situation, Step};
use zeronav_global_planner::table::{PLANNERS, PlannerRow};
use zeronav_global_planner::{Control, GlobalPlannerConfig, Target, UnknownPlanner};
use zeronav_msgs::CellRect;
use zeronav_msgs::header::Parents;
use zeronav_msgs::health::REASON_MAP;
use zeronav_msgs::path::{Path, WAYPOINTS_MAX};
use zeronav_msgs::pose::Pose;
use zeronav_msgs::request::RequestReason;
use zeronav_msgs::role::Role;
use zeronav_msgs::span::SpanKind;
use zeronav_msgs::task::{TaskKind, TaskState as State};
use zeronav_msgs::topics::{PlanPath, PlanRequests, RobotOdometry, TaskState};
use zeronav_params::Parameter;
use zeronav_shell::clock::now_ns;
use zeronav_shell::doorbell::Rung;
use zeronav_shell::nearest::unknown;
use zeronav_shell::{
    Cycle, Latest, MapInput, Service, Shell, StartError, Stream, Tasks, Track, Writer,
};

/// Expansions of work ahead between two looks at the inputs: some 0.2 ms, which a map update may
/// have to wait.
const AHEAD_EXPANSIONS: u64 = 4096;

/// Everything that the planner takes in.
struct Inputs {
    odometry: Stream<RobotOdometry>,
    map: MapInput,
    request: Latest<PlanRequests>,
    tasks: Tasks,
    status: Latest<TaskState>,
    /// Task, goal at hand and state, as the local planner said them last.
    at_hand: Option<(u64, u64, u16)>,
    track: Track,
    /// Rectangles written since the last situation.
    changed: Vec<CellRect>,
}

struct PlannerService {
    replanner: Replanner,
    inputs: Inputs,
    path: Writer<PlanPath>,
    answered_tick: u64,
    idle_said: bool,
    /// A path is new but there was no memory to send it.
    unsent: bool,
}

impl Inputs {
    /// Takes in what has come; true when there is something to answer in real time.
    ///
    /// Odometry is drained first: in lockstep it carries the tick, and whatever belongs to that
    /// tick was sent before or is waited for by its own tick.
    fn poll(&mut self, shell: &Shell) -> bool {
        let roster = shell.roster();
        let track = &mut self.track;
        self.odometry
            .drain(roster, |view| track.push(view.header, view.meta));
        let mut news = self.map.poll(shell);
        self.changed.extend_from_slice(self.map.changed());
        news |= self.request.poll(roster);
        news |= self.tasks.poll(roster);
        // A status that says nothing new about the goal at hand asks for no path.
        self.status.poll(roster);
        let at_hand = self
            .status
            .get()
            .map(|view| (view.meta.task, view.meta.goal, view.meta.state));
        news |= at_hand != self.at_hand;
        self.at_hand = at_hand;
        news
    }

    /// Where the robot is on the map.
    fn map_from_base(&self) -> Option<Pose> {
        let odometry = self.track.newest()?;
        Some(self.map.map_from_base(&odometry.odometry.pose))
    }

    /// Where to, from the task and how far the local planner has come with it.
    fn target(&self) -> Option<Target> {
        let task = self
            .tasks
            .current()
            .filter(|task| task.kind == TaskKind::Go)?;
        let status = self
            .status
            .get()
            .filter(|status| status.meta.task == task.id.0);
        let done = status.is_some_and(|status| {
            !matches!(status.meta.state(), Some(State::Idle | State::Active))
        });
        if done {
            return None;
        }
        let at_hand = status.map_or(0, |status| status.meta.goal);
        let named = task.goals.iter().find(|goal| goal.id == at_hand);
        let goal = named.or(task.goals.first())?;
        Some(Target {
            task: task.id.0,
            goal: goal.id,
            pose: goal.pose,
            tolerance_m: goal.tolerance_m,
        })
    }

    /// The newest request, and the path that it is about.
    fn request(&self, geometry: u64) -> Option<Request> {
        let request = self.request.get()?;
        let about_this = geometry != 0 && request.header.parents.path >= geometry;
        Some(Request {
            id: request.header.id,
            geometry: if about_this { geometry } else { 0 },
            reason: request.meta.reason().unwrap_or(RequestReason::None),
        })
    }

    fn situation(&self, robot: Pose, geometry: u64) -> Situation<'_> {
        Situation {
            robot,
            map: self.map.view(),
            revision: self.map.revision().0,
            changed: &self.changed,
            target: self.target(),
            request: self.request(geometry),
        }
    }

    fn parents(&self) -> Parents {
        Parents {
            odometry: self.track.newest().map_or(0, |moment| moment.id.0),
            map: self.map.revision().0,
            request: self.request.id().0,
            goal: self.tasks.current().map_or(0, |task| task.id.0),
            ..Parents::default()
        }
    }
}

fn unusable(error: BuildError) -> StartError {
    match error {
        BuildError::Planner(UnknownPlanner { key }) => {
            let known = PLANNERS.iter().map(|row| row.key);
            StartError::config("planner", unknown("planner", &key, known))
        }
        BuildError::Parameter(error) => error.into(),
    }
}

impl Service for PlannerService {
    const ROLE: Role = Role::GlobalPlanner;
    type Config = GlobalPlannerConfig;

    fn algorithms() -> Vec<(&'static str, String)> {
        let line = |row: &PlannerRow| {
            let may_fail = if row.complete {
                ""
            } else {
                "; may miss a way that there is"
            };
            (row.key, format!("{}{may_fail} ({})", row.title, row.source))
        };
        PLANNERS.iter().map(line).collect()
    }

    fn parameters() -> Vec<Parameter> {
        zeronav_params::describe::<GlobalPlannerConfig>()
    }

    fn check(config: &GlobalPlannerConfig) -> Result<(), StartError> {
        Replanner::new(config).map(|_| ()).map_err(unusable)
    }

    fn open(shell: &mut Shell, config: GlobalPlannerConfig) -> Result<Self, StartError> {
        let replanner = Replanner::new(&config).map_err(unusable)?;
        let peer = shell.peer();
        Ok(Self {
            replanner,
            inputs: Inputs {
                odometry: peer.stream()?,
                map: MapInput::open(peer)?,
                request: peer.latest()?,
                tasks: Tasks::open(peer)?,
                status: peer.latest()?,
                at_hand: None,
                track: Track::default(),
                changed: Vec::new(),
            },
            path: peer.writer(WAYPOINTS_MAX)?,
            answered_tick: 0,
            idle_said: false,
            unsent: false,
        })
    }

    fn wake(&mut self, shell: &mut Shell, _rung: Rung) -> Result<Option<u64>, StartError> {
        let news = self.inputs.poll(shell);
        self.tell(shell);
        if !shell.roster().has_clock() {
            return Ok(None);
        }
        if !self.idle_said {
            self.idle_said = true;
            self.publish(shell, 0, SpanKind::Idle, News::New);
            shell.ready();
        }
        if shell.roster().lockstep() {
            let Some(newest) = self.inputs.track.newest() else {
                return Ok(None);
            };
            let (tick, due) = (newest.tick, newest.odometry.scan_due());
            let roster = shell.roster();
            let mapped = roster.answers(Role::Mapping, tick);
            let waits = mapped && !self.inputs.map.has(tick);
            let owes = due && tick > self.answered_tick;
            if owes && !waits && roster.answers(Role::GlobalPlanner, tick) {
                self.answer(shell, tick, SpanKind::Answer);
                // All of it before the next tick, so that wall time does not show in the run.
                while self.replanner.prepare(AHEAD_EXPANSIONS) {
                    shell.progress();
                }
            }
            return Ok(None);
        }
        if let Some(map) = self.inputs.map.stamp().filter(|map| news && map.tick > 0) {
            let tick = map.tick;
            let kind = if tick > self.answered_tick {
                SpanKind::Answer
            } else {
                SpanKind::Extra
            };
            self.answer(shell, tick, kind);
        }
        let more = self.replanner.prepare(AHEAD_EXPANSIONS);
        if more {
            shell.progress();
        }
        Ok(more.then(|| shell.woken_ns()))
    }
}

impl PlannerService {
    /// Health: what is missing, what was refused.
    fn tell(&mut self, shell: &mut Shell) {
        let inputs = &self.inputs;
        shell.reason(
            REASON_MAP,
            inputs.map.is_lost() || inputs.map.info().current == 0,
        );
        shell.totals(
            inputs.odometry.refused()
                + inputs.map.refused()
                + inputs.request.refused()
                + inputs.tasks.refused(),
            inputs.request.superseded(),
        );
    }

    fn answer(&mut self, shell: &mut Shell, tick: u64, kind: SpanKind) {
        let Some(robot) = self.inputs.map_from_base() else {
            return;
        };
        self.inputs.tasks.at(tick);
        let started_ns = now_ns();
        let geometry = self.replanner.plan().geometry;
        let mut step = self
            .replanner
            .begin(&self.inputs.situation(robot, geometry));
        self.inputs.changed.clear();
        let lockstep = shell.roster().lockstep();
        while let Step::Search(_) = step {
            let Self {
                replanner, inputs, ..
            } = self;
            let situation = inputs.situation(robot, geometry);
            // A search is given up for a new goal; everything else waits for its result.
            let tasks = &inputs.tasks;
            replanner.search(&situation, &mut |_| {
                shell.progress();
                if !lockstep && tasks.waits() {
                    Control::Stop
                } else {
                    Control::Go
                }
            });
            if !lockstep {
                inputs.poll(shell);
                inputs.tasks.at(tick);
            }
            step = replanner.settle(&inputs.situation(robot, geometry));
            inputs.changed.clear();
        }
        let news = match step {
            Step::Publish(news) if !self.unsent => news,
            _ => News::New,
        };
        self.publish_from(shell, tick, kind, news, started_ns);
    }

    fn publish(&mut self, shell: &mut Shell, tick: u64, kind: SpanKind, news: News) {
        self.publish_from(shell, tick, kind, news, now_ns());
    }

    fn publish_from(
        &mut self,
        shell: &mut Shell,
        tick: u64,
        kind: SpanKind,
        news: News,
        started_ns: u64,
    ) {
        let inputs = &self.inputs;
        let map = inputs.map.stamp().unwrap_or_default();
        let run_ns = if tick == map.tick {
            map.run_ns
        } else {
            tick.saturating_mul(shell.roster().clock.tick_ns)
        };
        let mut draft = shell.draft(tick, run_ns, map.capture_ns, inputs.parents());
        draft.started_ns = started_ns;
        if news == News::New {
            self.replanner.name_geometry(self.path.next_id().0);
        }
        let plan = self.replanner.plan();
        if news == News::New {
            tracing::info!(
                tick,
                cause = plan.cause.label(),
                status = plan.status.label(),
                length_m = plan.length_m,
                cost = plan.cells.stats.cost,
                expanded = plan.cells.stats.expanded,
                planner = plan.planner,
                "path"
            );
        }
        let waypoints = &plan.waypoints;
        let sent = self.path.publish_with(&draft, waypoints.len(), |slot| {
            slot.copy_from_slice(waypoints);
            let mut message = Path::default();
            plan.fill(&mut message);
            message
        });
        self.unsent = sent.is_none() && news == News::New;
        let work = plan.cells.stats.expanded;
        let output = shell.sent(&self.path, sent);
        self.answered_tick = self.answered_tick.max(tick);
        let work = if news == News::New { work } else { 0 };
        shell.finish(&Cycle {
            kind,
            draft,
            output,
            work,
        });
    }
}

fn main() -> ExitCode {
    zeronav_shell::run::<PlannerService>()
}
