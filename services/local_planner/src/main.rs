//! The local planner as a process: answers every odometry, scan and path with a velocity request.

mod choice;
mod goal_log;
mod readings;
mod report;

use choice::unusable;
use goal_log::GoalLog;
use readings::{News, Readings};
use std::process::ExitCode;
use zeronav_local_planner::{LocalPlanner, LocalPlannerConfig};
use zeronav_msgs::foresight::FORESIGHT_PREDICT;
use zeronav_msgs::header::Parents;
use zeronav_msgs::role::Role;
use zeronav_msgs::rollouts::ROLLOUTS_MAX;
use zeronav_msgs::task::GOALS_MAX;
use zeronav_msgs::time::seconds;
use zeronav_msgs::topics::{ControlRequest, DebugRollouts, PlanRequests, TaskState};
use zeronav_params::Parameter;
use zeronav_shell::doorbell::Rung;
use zeronav_shell::{Draft, Due, Rates, Sent, Service, Shell, StartError, Trigger, Writer};

/// Ticks between two statuses of an unchanged task.
const STATUS_TICKS: u64 = 10;

/// Shortest period that the controller is given, in real time. [s]
const PERIOD_S_MIN: f64 = 1.0e-3;

struct LocalPlannerService {
    planner: LocalPlanner,
    readings: Readings,
    request: Writer<ControlRequest>,
    plan_request: Writer<PlanRequests>,
    status: Writer<TaskState>,
    rollouts: Writer<DebugRollouts>,
    answered_ns: u64,
    status_tick: u64,
    goal_log: GoalLog,
}

impl Service for LocalPlannerService {
    const ROLE: Role = Role::LocalPlanner;
    type Config = LocalPlannerConfig;

    fn algorithms() -> Vec<(&'static str, String)> {
        choice::controllers()
    }

    fn parameters() -> Vec<Parameter> {
        choice::parameters()
    }

    fn check(config: &LocalPlannerConfig) -> Result<(), StartError> {
        LocalPlanner::new(config).map(|_| ()).map_err(unusable)
    }

    fn check_rates(config: &LocalPlannerConfig, rates: Rates) -> Result<(), StartError> {
        Ok(config.staleness.check(rates.scan_s)?)
    }

    fn open(shell: &mut Shell, config: LocalPlannerConfig) -> Result<Self, StartError> {
        let peer = shell.peer();
        Ok(Self {
            planner: LocalPlanner::new(&config).map_err(unusable)?,
            readings: Readings::open(peer)?,
            request: peer.writer(1)?,
            plan_request: peer.writer(1)?,
            status: peer.writer(GOALS_MAX)?,
            rollouts: peer.writer(ROLLOUTS_MAX)?,
            answered_ns: 0,
            status_tick: 0,
            goal_log: GoalLog::default(),
        })
    }

    fn wake(&mut self, shell: &mut Shell, _rung: Rung) -> Result<(), StartError> {
        self.status.refresh();
        if shell.roster().clock.foresight & FORESIGHT_PREDICT != 0 {
            self.readings.be_told(shell.peer())?;
        }
        let News { task, planning } = self.readings.poll(shell);
        self.readings.count(shell);
        if let Some(view) = self.readings.task.get().filter(|_| task) {
            self.planner
                .accept_task(view.header.id, view.meta, view.items);
        }
        let trigger = Trigger {
            tick: self.readings.odometry.tick(),
            complete: self.readings.are_complete(shell.roster()),
            deadline_ns: None,
            news: planning,
        };
        for due in shell.due(&trigger) {
            self.answer(shell, due);
        }
        Ok(())
    }

    fn is_at_rest(&self) -> bool {
        self.readings.odometry.history().is_at_rest()
    }
}

impl LocalPlannerService {
    fn answer(&mut self, shell: &mut Shell, due: Due) {
        let mut draft = self.readings.begin(shell, due);
        *self.planner.timer() = shell.stage_timer(draft.started_ns);
        let period_s = self.period_s(shell, draft.started_ns);
        if let Some((status, ends)) = self.readings.take_status_before(due.tick) {
            self.planner.follow(&status, &ends);
        }
        let outputs = self
            .planner
            .step(&self.readings.inputs(shell, &draft, period_s));
        draft.stages_ns = self.planner.timer().stages_ns();
        let sent = shell.send(&draft, &mut self.request, outputs.request, &[]);
        if let Some(plan_request) = outputs.plan_request {
            shell.send(&draft, &mut self.plan_request, plan_request, &[]);
        }
        let status_due = due.tick >= self.status_tick + STATUS_TICKS;
        let status_sent = outputs.status_changed || status_due;
        if status_sent {
            let (status, ended) = self.planner.status();
            shell.send(&draft, &mut self.status, status, ended);
            self.status_tick = due.tick;
        }
        self.answered_ns = draft.started_ns;
        report::report(shell, &outputs);
        shell.finish(&draft, sent, u64::from(outputs.rollouts));
        self.send_rollouts(shell, &draft, sent);
        // Nobody waits for the log.
        report::log(&outputs);
        if status_sent {
            let (status, ended) = self.planner.status();
            self.goal_log.log(due.tick, &status, ended);
        }
    }

    /// Sends what the answer's period looked at, and keeps that of the next one while somebody reads
    /// it. After the answer, which neither waits for it nor depends on it.
    fn send_rollouts(&mut self, shell: &Shell, draft: &Draft, request: Option<Sent>) {
        if let Some((meta, rollouts)) = self.planner.rollouts() {
            let parents = Parents {
                request: request.map_or(0, |sent| sent.id.0),
                ..draft.parents
            };
            let draft = Draft { parents, ..*draft };
            shell.send_aside(&draft, &mut self.rollouts, meta, rollouts);
        }
        self.planner.record(self.rollouts.is_read());
    }

    /// Time since the answer before, a tick at most. [s]
    fn period_s(&self, shell: &Shell, now_ns: u64) -> f64 {
        let tick_s = seconds(shell.roster().clock.tick_ns);
        if shell.roster().lockstep() {
            return tick_s;
        }
        let since_s = seconds(now_ns.saturating_sub(self.answered_ns));
        since_s.clamp(PERIOD_S_MIN.min(tick_s), tick_s)
    }
}

fn main() -> ExitCode {
    zeronav_shell::run::<LocalPlannerService>()
}
