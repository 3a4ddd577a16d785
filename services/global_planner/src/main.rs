//! The global planner as a process: answers every map update, goal and request with a path.

mod choice;
mod readings;

use choice::unusable;
use readings::Readings;
use std::process::ExitCode;
use zeronav_global_planner::{Control, GlobalPlannerConfig, News, Replanner, Step};
use zeronav_msgs::path::{Path, WAYPOINTS_MAX};
use zeronav_msgs::role::Role;
use zeronav_msgs::span::SpanKind;
use zeronav_msgs::stages::Stage;
use zeronav_msgs::topics::PlanPath;
use zeronav_params::Parameter;
use zeronav_shell::clock::now_ns;
use zeronav_shell::doorbell::Rung;
use zeronav_shell::{Due, Service, Shell, StartError, Writer};

/// Expansions of work ahead between two polls of the inputs: some 50 us, which a map update may
/// have to wait.
const AHEAD_EXPANSIONS: u64 = 512;

/// Time from an answer to work ahead, and to the search that follows a detour unless news come
/// before: the cores are left to local planner and guard, which act on the same scan. [ns]
const QUIET_NS: u64 = 4_000_000;

struct GlobalPlannerService {
    replanner: Replanner,
    inputs: Readings,
    path: Writer<PlanPath>,
    /// Until when [`QUIET_NS`] after the last answer lasts. [ns]
    quiet_until_ns: u64,
}

impl Service for GlobalPlannerService {
    const ROLE: Role = Role::GlobalPlanner;
    type Config = GlobalPlannerConfig;

    fn algorithms() -> Vec<(&'static str, String)> {
        choice::planners()
    }

    fn parameters() -> Vec<Parameter> {
        choice::parameters()
    }

    fn check(config: &GlobalPlannerConfig) -> Result<(), StartError> {
        Replanner::new(config).map(|_| ()).map_err(unusable)
    }

    fn open(shell: &mut Shell, config: GlobalPlannerConfig) -> Result<Self, StartError> {
        let replanner = Replanner::new(&config).map_err(unusable)?;
        let peer = shell.peer();
        Ok(Self {
            replanner,
            inputs: Readings::open(peer, config.blocks_below_mps)?,
            path: peer.writer(WAYPOINTS_MAX)?,
            quiet_until_ns: 0,
        })
    }

    fn wake(&mut self, shell: &mut Shell, _rung: Rung) -> Result<(), StartError> {
        let lockstep = shell.roster().lockstep();
        let news = self.inputs.poll(shell);
        // In lockstep the search that follows a detour belongs to the next tick.
        let is_quiet = shell.woken_ns() < self.quiet_until_ns;
        let search_due = self.replanner.plan().is_detour && !lockstep && !is_quiet;
        let trigger = self.inputs.trigger(shell, news || search_due);
        for due in shell.due(&trigger) {
            let started_ns = now_ns();
            *self.replanner.timer() = shell.stage_timer(started_ns);
            if let Some(path) = self.plan(shell, due) {
                if due.kind == SpanKind::Extra && !news && path == News::Unchanged {
                    // Nothing better was found.
                    continue;
                }
                self.publish(shell, due, path, started_ns);
                self.quiet_until_ns = now_ns() + QUIET_NS;
            }
        }
        if !lockstep && now_ns() < self.quiet_until_ns {
            shell.wake_by(self.quiet_until_ns);
            return Ok(());
        }
        // In lockstep all of it before the next tick, so that wall time does not affect the run.
        while self.replanner.prepare(AHEAD_EXPANSIONS) {
            shell.progress();
            if !lockstep {
                shell.wake_by(shell.woken_ns());
                break;
            }
        }
        Ok(())
    }
}

impl GlobalPlannerService {
    /// One cycle of the replanner; `None` before the first odometry.
    fn plan(&mut self, shell: &mut Shell, due: Due) -> Option<News> {
        if due == Due::IDLE {
            return Some(News::New);
        }
        let Self {
            replanner, inputs, ..
        } = self;
        let robot = inputs.map_from_base()?;
        inputs.goal.advance(shell.roster(), due.tick);
        let geometry = replanner.plan().geometry;
        let mut step = replanner.begin(&inputs.situation(robot, geometry));
        replanner.timer().mark(Stage::Map);
        inputs.changed.clear();
        let lockstep = shell.roster().lockstep();
        loop {
            match step {
                Step::Publish(news) => return Some(news),
                Step::Search(_) => {}
            }
            // A search is given up for a new goal; everything else waits for its result.
            let goal = &inputs.goal;
            replanner.search(&inputs.situation(robot, geometry), &mut |_| {
                shell.progress();
                if !lockstep && goal.waits() {
                    Control::Stop
                } else {
                    Control::Go
                }
            });
            if !lockstep {
                inputs.poll(shell);
                inputs.goal.advance(shell.roster(), due.tick);
            }
            step = replanner.settle(&inputs.situation(robot, geometry));
            replanner.timer().mark(Stage::Settle);
            inputs.changed.clear();
        }
    }

    fn publish(&mut self, shell: &mut Shell, due: Due, news: News, started_ns: u64) {
        let is_new = news == News::New;
        let mut draft = self.inputs.map.begin(shell, due, self.inputs.parents());
        draft.started_ns = started_ns;
        draft.stages_ns = self.replanner.timer().stages_ns();
        if is_new {
            // When there is no memory for this message, the next one has the same identity.
            self.replanner.name_geometry(self.path.next_id().0);
        }
        let plan = self.replanner.plan();
        let mut message = Path::default();
        plan.fill(&mut message);
        let sent = shell.send(&draft, &mut self.path, message, &plan.waypoints);
        let work = if is_new { plan.cells.stats.expanded } else { 0 };
        shell.finish(&draft, sent, work);
        // Nobody waits for the log.
        if is_new {
            tracing::info!(
                tick = due.tick,
                cause = plan.cause.label(),
                status = plan.status.label(),
                length_m = plan.length_m,
                cost = plan.cells.stats.cost,
                expanded = plan.cells.stats.expanded,
                planner = plan.planner,
                "path"
            );
        }
    }
}

fn main() -> ExitCode {
    zeronav_shell::run::<GlobalPlannerService>()
}
