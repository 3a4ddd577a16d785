//! The guard as a process: answers every velocity request, and odometry that no request follows.

mod readings;

use readings::Readings;
use std::process::ExitCode;
use zeronav_collision_guard::{Guard, GuardConfig};
use zeronav_msgs::command::{Intervention, VelocityCommand};
use zeronav_msgs::health::{REASON_ODOMETRY, REASON_REQUEST, REASON_SCAN};
use zeronav_msgs::role::Role;
use zeronav_msgs::time::seconds;
use zeronav_msgs::topics::RobotCommand;
use zeronav_params::Parameter;
use zeronav_shell::doorbell::Rung;
use zeronav_shell::{Due, Rates, Service, Shell, StartError, Writer};

struct GuardService {
    guard: Guard,
    /// Until it has been checked against the periods of the run.
    config: Option<GuardConfig>,
    readings: Readings,
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

    fn check_rates(config: &GuardConfig, rates: Rates) -> Result<(), StartError> {
        Ok(config.check(rates.tick_s, rates.scan_s)?)
    }

    fn open(shell: &mut Shell, config: GuardConfig) -> Result<Self, StartError> {
        let peer = shell.peer();
        Ok(Self {
            guard: Guard::new(config),
            config: Some(config),
            readings: Readings::open(peer)?,
            command: peer.writer(1)?,
            intervention: Some(Intervention::None),
        })
    }

    fn wake(&mut self, shell: &mut Shell, _rung: Rung) -> Result<(), StartError> {
        let trigger = self.readings.poll(shell);
        self.check_config(shell)?;
        self.follow_zones(shell, trigger.tick)?;
        for due in shell.due(&trigger) {
            self.answer(shell, due);
        }
        if let Some(inputs) = self.readings.ahead(shell) {
            self.guard.take_in(&inputs);
        }
        Ok(())
    }

    fn is_at_rest(&self) -> bool {
        self.readings.odometry.history().is_at_rest()
    }
}

impl GuardService {
    /// Rejects ages that would run out in normal operation, once the periods are known.
    fn check_config(&mut self, shell: &Shell) -> Result<(), StartError> {
        let (Some(config), Some(description)) = (self.config, self.readings.description.get())
        else {
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

    /// Takes in zones, and where the robot is among them.
    fn follow_zones(&mut self, shell: &Shell, tick: u64) -> Result<(), StartError> {
        if self.readings.zones.advance(tick) {
            self.guard.take_zones(self.readings.zones.set());
        }
        let is_missing = self.readings.zones.is_missing(shell.roster());
        self.guard.lacks_zones(is_missing);
        if let Some(map) = self.readings.located(shell)? {
            self.guard.locate(&map);
        }
        Ok(())
    }

    fn answer(&mut self, shell: &mut Shell, due: Due) {
        let draft = self.readings.begin(shell, due);
        let command = self.guard.decide(&self.readings.inputs(shell, &draft));
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
