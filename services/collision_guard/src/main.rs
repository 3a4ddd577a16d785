//! The guard as a process: answers every velocity request, and odometry that no request follows.

use std::process::ExitCode;
use zeronav_collision_guard::{Guard, GuardConfig, GuardInputs, OdometryInput, ScanInput};
use zeronav_msgs::command::{Intervention, VelocityCommand};
use zeronav_msgs::header::Parents;
use zeronav_msgs::health::{REASON_ODOMETRY, REASON_REQUEST, REASON_SCAN};
use zeronav_msgs::role::Role;
use zeronav_msgs::time::seconds;
use zeronav_msgs::topics::{ControlRequest, RobotCommand, RobotDescription, RobotScan};
use zeronav_params::Parameter;
use zeronav_shell::doorbell::Rung;
use zeronav_shell::{
    Due, Latest, OdometryReader, Received, Service, Shell, StartError, Trigger, Writer,
};

/// How long after odometry the guard waits for the request that belongs to it. [ns]
const PATIENCE_NS: u64 = 5_000_000;

struct GuardService {
    guard: Guard,
    /// Until it has been checked against the periods of the run.
    config: Option<GuardConfig>,
    odometry: OdometryReader,
    description: Latest<RobotDescription>,
    scan: Latest<RobotScan>,
    request: Latest<ControlRequest>,
    command: Writer<RobotCommand>,
    /// Of the last command, to log when it changes.
    intervention: Option<Intervention>,
}

impl Service for GuardService {
    const ROLE: Role = Role::CollisionGuard;
    type Config = GuardConfig;

    fn parameters() -> Vec<Parameter> {
        zeronav_params::describe::<GuardConfig>()
    }

    fn check(config: &GuardConfig) -> Result<(), StartError> {
        // The periods that the ages must exceed come with the run.
        Ok(config.check(0.0, 0.0)?)
    }

    fn open(shell: &mut Shell, config: GuardConfig) -> Result<Self, StartError> {
        let peer = shell.peer();
        Ok(Self {
            guard: Guard::new(config),
            config: Some(config),
            odometry: OdometryReader::open(peer)?,
            description: peer.latest()?,
            scan: peer.latest()?,
            request: peer.latest()?,
            command: peer.writer(1)?,
            intervention: Some(Intervention::None),
        })
    }

    fn wake(&mut self, shell: &mut Shell, _rung: Rung) -> Result<(), StartError> {
        let roster = shell.roster();
        self.odometry.poll(roster);
        self.description.poll(roster);
        let requested = self.request.poll(roster);
        self.scan.poll(roster);
        shell.count(&[&self.odometry, &self.scan, &self.request]);
        self.check_config(shell)?;
        let (roster, tick) = (shell.roster(), self.odometry.tick());
        let trigger = Trigger {
            tick,
            complete: if roster.lockstep() {
                !roster.awaits(Role::LocalPlanner, tick, self.request.spoken_tick())
            } else {
                requested
            },
            deadline_ns: self.odometry.newest().map(|it| it.came_ns + PATIENCE_NS),
            news: requested,
        };
        for due in shell.due(&trigger) {
            self.answer(shell, due);
        }
        Ok(())
    }

    fn is_at_rest(&self) -> bool {
        self.odometry.history().is_at_rest()
    }
}

impl GuardService {
    /// Rejects ages that would run out in normal operation, once the periods are known.
    fn check_config(&mut self, shell: &Shell) -> Result<(), StartError> {
        let (Some(config), Some(description)) = (self.config, self.description.get()) else {
            return Ok(());
        };
        if !shell.roster().has_clock() {
            return Ok(());
        }
        let period_s = seconds(shell.roster().clock.tick_ns);
        let scan_period_s = seconds(description.meta.scan_period_ns);
        config.check(period_s, scan_period_s)?;
        self.config = None;
        tracing::info!(period_s, scan_period_s, "the guard begins");
        Ok(())
    }

    fn answer(&mut self, shell: &mut Shell, due: Due) {
        let scan = self.scan.get();
        let parents = Parents {
            odometry: self.odometry.id().0,
            scan: self.scan.id().0,
            request: self.request.id().0,
            ..Parents::default()
        };
        let capture_ns = scan.map_or(0, |view| view.header.capture_ns);
        let draft = shell.begin(due, shell.run_ns(due.tick), capture_ns, parents);
        let age_ns = |message: Option<Received>| {
            message.map_or(u64::MAX, |message| shell.age_ns(&draft, &message))
        };
        // A scan is as old as its capture, the other messages are as old as their arrival.
        let arrival_age_ns = |message: Option<Received>| age_ns(message.map(Received::on_arrival));
        let newest = self.odometry.newest();
        let description = self.description.get();
        let command = self.guard.decide(&GuardInputs {
            robot: description.as_ref().map(|view| (view.meta, view.items)),
            request: self
                .request
                .get()
                .map(|view| (*view.meta, arrival_age_ns(self.request.received()))),
            scan: scan.map(|view| ScanInput {
                scan: view.meta,
                ranges: view.items,
                id: view.header.id,
                run_ns: view.header.run_ns,
                age_ns: age_ns(self.scan.received()),
                odom_from_base: self.odometry.history().pose_at(view.header.run_ns),
            }),
            odometry: newest.map(|newest| OdometryInput {
                odometry: &newest.odometry,
                id: newest.id.0,
                run_ns: newest.run_ns,
                age_ns: arrival_age_ns(Some(newest.received())),
            }),
            period_ns: shell.run_ns(due.tick.saturating_sub(shell.answered_tick())),
            stopping: shell.roster().control.stopping == 1,
        });
        shell.answer(&draft, &mut self.command, command, &[]);
        self.report(shell, due.tick, &command);
    }

    /// Logs and reports in the heartbeat why the request is changed.
    fn report(&mut self, shell: &mut Shell, tick: u64, command: &VelocityCommand) {
        let intervention = command.intervention();
        if intervention != self.intervention {
            self.intervention = intervention;
            let name = intervention.map_or("unknown", Intervention::label);
            let (v_mps, w_radps) = (command.v_mps, command.w_radps);
            tracing::info!(tick, intervention = name, v_mps, w_radps);
        }
        for (stale, reason) in [
            (Intervention::RequestStale, REASON_REQUEST),
            (Intervention::ScanStale, REASON_SCAN),
            (Intervention::OdometryStale, REASON_ODOMETRY),
        ] {
            shell.reason(reason, intervention == Some(stale));
        }
    }
}

fn main() -> ExitCode {
    zeronav_shell::run::<GuardService>()
}
