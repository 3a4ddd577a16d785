//! The simulated robot as a process: sensors out at every tick, velocity commands in.

mod answers;
mod commands;
mod own_clock;
mod sensors;
mod world;

use answers::AnswerReader;
use commands::Commands;
use own_clock::OwnClock;
use sensors::{Moment, Sensors};
use std::process::ExitCode;
use world::simulator;
use zeronav_msgs::role::Role;
use zeronav_msgs::span::SpanKind;
use zeronav_msgs::stages::Stage;
use zeronav_params::Parameter;
use zeronav_robot_sim::simulator::TICK_NS_MIN;
use zeronav_robot_sim::{SimConfig, Simulator};
use zeronav_shell::clock::now_ns;
use zeronav_shell::doorbell::Rung;
use zeronav_shell::{Due, Service, Shell, StartError};

struct RobotService {
    config: SimConfig,
    simulator: Option<Simulator>,
    sensors: Sensors,
    commands: Commands,
    answers: AnswerReader,
    tick: u64,
    /// Real time only.
    clock: OwnClock,
}

impl Service for RobotService {
    const ROLE: Role = Role::Robot;
    type Config = SimConfig;

    fn parameters() -> Vec<Parameter> {
        SimConfig::parameters()
    }

    fn check(config: &SimConfig) -> Result<(), StartError> {
        // The length of a tick and the seed come with the run.
        simulator(config, 0, TICK_NS_MIN).map(|_| ())
    }

    fn open(shell: &mut Shell, config: SimConfig) -> Result<Self, StartError> {
        let peer = shell.peer();
        Ok(Self {
            simulator: None,
            sensors: Sensors::open(peer, config.robot.lidar.n_beams as usize)?,
            commands: Commands::open(peer)?,
            answers: AnswerReader::open(peer)?,
            tick: 0,
            clock: OwnClock::default(),
            config,
        })
    }

    fn wake(&mut self, shell: &mut Shell, _rung: Rung) -> Result<(), StartError> {
        if self.simulator.is_none() {
            self.start(shell)?;
        }
        self.sensors.refresh();
        let lockstep = shell.roster().lockstep();
        if lockstep {
            self.answers.poll();
        }
        if let Some(simulator) = &mut self.simulator {
            self.commands.poll(shell, simulator);
        }
        let (roster, scan_tick) = (shell.roster(), self.sensors.scan_tick());
        let control = roster.control;
        if lockstep {
            let leased = control.paused == 0 && self.tick < control.lease;
            if leased && self.answers.are_complete(roster, self.tick, scan_tick) {
                self.tick(shell);
            }
        } else if control.paused == 1 {
            let due_ns = self.clock.restart(roster.clock.tick_ns);
            shell.wake_by(due_ns);
        } else {
            let due_ns = self.keep_time(shell);
            shell.wake_by(due_ns);
        }
        Ok(())
    }

    fn is_at_rest(&self) -> bool {
        self.sensors.is_at_rest()
    }
}

impl RobotService {
    /// Makes the world.
    fn start(&mut self, shell: &mut Shell) -> Result<(), StartError> {
        let clock = shell.roster().clock;
        let simulator = simulator(&self.config, clock.seed, clock.tick_ns)?;
        if clock.foresight != 0 {
            self.sensors.foresee(shell.peer())?;
        }
        self.sensors.send_description(shell, &simulator);
        let seed = clock.seed;
        tracing::info!(seed, tick_ns = clock.tick_ns, "the robot begins");
        self.simulator = Some(simulator);
        self.clock.restart(clock.tick_ns);
        Ok(())
    }

    /// When the next step is due by the own clock, and the run time of its scan if that is captured
    /// between two ticks. [ns]
    fn next_due(&self, shell: &Shell) -> (u64, Option<u64>) {
        let tick_run_ns = shell.run_ns(self.tick + 1);
        let simulator = self.simulator.as_ref();
        let capture_run_ns = simulator.and_then(|it| it.next_capture_run_ns(tick_run_ns));
        self.clock.next_due(tick_run_ns, capture_run_ns)
    }

    /// Does what is due by the own clock: a scan that is captured between two ticks, then a tick.
    /// Returns when the next of them is due. [ns]
    fn keep_time(&mut self, shell: &mut Shell) -> u64 {
        let (mut due_ns, mut capture_run_ns) = self.next_due(shell);
        if let Some(run_ns) = capture_run_ns.filter(|_| now_ns() >= due_ns) {
            self.step(shell, run_ns, SpanKind::Extra);
            (due_ns, capture_run_ns) = self.next_due(shell);
        }
        if capture_run_ns.is_none() && now_ns() >= due_ns {
            self.tick(shell);
            self.clock.ticked(shell.roster().clock.tick_ns);
            shell.slipped(self.clock.slipped_ns());
            due_ns = self.next_due(shell).0;
        }
        due_ns
    }

    fn tick(&mut self, shell: &mut Shell) {
        self.tick += 1;
        self.step(shell, shell.run_ns(self.tick), SpanKind::Answer);
    }

    /// Moves until `run_ns` and publishes. Between two ticks that is a scan, with the odometry of
    /// its capture, under the tick before.
    fn step(&mut self, shell: &mut Shell, run_ns: u64, kind: SpanKind) {
        let Some(simulator) = &mut self.simulator else {
            return;
        };
        let started_ns = now_ns();
        let mut timer = shell.stage_timer(started_ns);
        let began_ns = if shell.roster().lockstep() {
            simulator.run_ns()
        } else {
            started_ns
        };
        let age_ns = self.commands.age_ns(shell, began_ns);
        simulator.step(run_ns, age_ns);
        timer.mark(Stage::Step);
        let due = Due {
            tick: self.tick,
            kind,
        };
        let moment = Moment {
            due,
            run_ns,
            slipped_ns: self.clock.slipped_ns(),
            started_ns,
        };
        self.sensors.send(shell, simulator, &moment, timer);
    }
}

fn main() -> ExitCode {
    zeronav_shell::run::<RobotService>()
}
