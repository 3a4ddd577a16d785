//! The simulated robot as a process: sensors out at every tick, velocity commands in.

mod answers;
mod sensors;

use answers::AnswerReader;
use sensors::Sensors;
use std::process::ExitCode;
use zeronav_msgs::command::Validity;
use zeronav_msgs::header::Parents;
use zeronav_msgs::role::Role;
use zeronav_msgs::span::SpanKind;
use zeronav_msgs::topics::{RobotCommand, SimPlacement};
use zeronav_params::Parameter;
use zeronav_robot_sim::simulator::TICK_NS_MIN;
use zeronav_robot_sim::{SimConfig, SimError, Simulator};
use zeronav_shell::clock::{both_ns, now_ns};
use zeronav_shell::doorbell::Rung;
use zeronav_shell::{Due, Latest, Service, Shell, StartError};
use zeronav_world::{SpecError, WorldError};

struct RobotService {
    config: SimConfig,
    simulator: Option<Simulator>,
    sensors: Sensors,
    command: Latest<RobotCommand>,
    placements: Latest<SimPlacement>,
    answers: AnswerReader,
    tick: u64,
    /// When the next tick is due, real time only. [ns]
    due_ns: u64,
    /// Real time that was lost because ticks were late. [ns]
    slipped_ns: u64,
    /// When the newest command came in: monotonic, in lockstep run time. [ns]
    command_came_ns: Option<u64>,
}

fn unusable(error: SimError) -> StartError {
    let of = |error: SpecError| StartError::config(error.field, error.why);
    match error {
        SimError::World(WorldError::Spec(error)) => of(error.within("world")),
        SimError::World(WorldError::Map(error)) => StartError::config("world.map", error),
        SimError::World(WorldError::Data { field, error }) => {
            StartError::config(format!("world.{field}"), error)
        }
        SimError::Robot(error) => of(error.within("robot")),
        SimError::Description(refusal) => StartError::config("robot", refusal),
        SimError::Start(refusal) => StartError::config("start", refusal),
        SimError::StartBlocked(what) => {
            StartError::config("start", format!("the robot touches {what} there"))
        }
        SimError::ScanRate { .. } => StartError::config("robot.lidar.rate_hz", error),
        SimError::Tick(_) => StartError::Usage(error.to_string()),
    }
}

impl Service for RobotService {
    const ROLE: Role = Role::Robot;
    type Config = SimConfig;

    fn parameters() -> Vec<Parameter> {
        SimConfig::parameters()
    }

    fn check(config: &SimConfig) -> Result<(), StartError> {
        // The length of a tick and the seed come with the run.
        Simulator::new(config, 0, TICK_NS_MIN)
            .map(|_| ())
            .map_err(unusable)
    }

    fn open(shell: &mut Shell, config: SimConfig) -> Result<Self, StartError> {
        let peer = shell.peer();
        Ok(Self {
            simulator: None,
            sensors: Sensors::open(peer, config.robot.lidar.n_beams as usize)?,
            command: peer.latest()?,
            placements: peer.latest()?,
            answers: AnswerReader::open(peer)?,
            tick: 0,
            due_ns: 0,
            slipped_ns: 0,
            command_came_ns: None,
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
        self.take_command(shell);
        self.take_placements(shell);
        shell.count(&[&self.command, &self.placements]);
        let (roster, scan_tick) = (shell.roster(), self.sensors.scan_tick());
        let control = roster.control;
        if lockstep {
            let leased = control.paused == 0 && self.tick < control.lease;
            if leased && self.answers.are_complete(roster, self.tick, scan_tick) {
                self.tick(shell);
            }
        } else if control.paused == 1 {
            self.due_ns = now_ns() + roster.clock.tick_ns;
            shell.wake_by(self.due_ns);
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
        let simulator =
            Simulator::new(&self.config, clock.seed, clock.tick_ns).map_err(unusable)?;
        for warning in simulator.map_warnings() {
            tracing::warn!("{warning}");
        }
        self.sensors.send_description(shell, &simulator);
        let seed = clock.seed;
        tracing::info!(seed, tick_ns = clock.tick_ns, "the robot begins");
        self.simulator = Some(simulator);
        self.due_ns = now_ns() + clock.tick_ns;
        Ok(())
    }

    /// Puts obstacles into the world.
    fn take_placements(&mut self, shell: &Shell) {
        if self.placements.poll(shell.roster())
            && let (Some(view), Some(simulator)) = (self.placements.get(), &mut self.simulator)
        {
            for placement in view.items {
                simulator.place(placement);
            }
        }
    }

    /// Passes the newest command to the motors.
    fn take_command(&mut self, shell: &mut Shell) {
        if !self.command.poll(shell.roster()) {
            return;
        }
        let (Some(command), Some(simulator)) = (self.command.get(), &mut self.simulator) else {
            return;
        };
        if command.meta.validity() == Some(Validity::NoRequest) {
            simulator.no_command();
        } else {
            simulator.set_command(command.meta.v_mps, command.meta.w_radps);
        }
        let header = command.header;
        if shell.roster().lockstep() {
            self.command_came_ns = Some(header.run_ns);
            return;
        }
        self.command_came_ns = Some(shell.woken_ns());
        let parents = Parents {
            request: header.id,
            ..Parents::default()
        };
        let due = Due {
            tick: header.tick,
            kind: SpanKind::Applied,
        };
        // The draft's start is the moment at which the set point took effect.
        let mut draft = shell.begin(due, header.run_ns, header.capture_ns, parents);
        (draft.started_ns, draft.raw_ns) = both_ns();
        shell.finish(&draft, None, 0);
    }

    /// When the next step is due by the own clock, and the run time of its scan if that is captured
    /// between two ticks. [ns]
    fn next_due(&self, shell: &Shell) -> (u64, Option<u64>) {
        let tick_run_ns = shell.run_ns(self.tick + 1);
        let simulator = self.simulator.as_ref();
        let capture_run_ns = simulator.and_then(|it| it.next_capture_run_ns(tick_run_ns));
        match capture_run_ns.filter(|capture_run_ns| *capture_run_ns < tick_run_ns) {
            Some(capture_run_ns) => {
                let before_ns = tick_run_ns - capture_run_ns;
                (self.due_ns.saturating_sub(before_ns), Some(capture_run_ns))
            }
            None => (self.due_ns, None),
        }
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
            // Late ticks are not caught up: run time slips.
            self.due_ns += shell.roster().clock.tick_ns;
            let now = now_ns();
            if self.due_ns < now {
                self.slipped_ns += now - self.due_ns;
                self.due_ns = now;
            }
            shell.slipped(self.slipped_ns);
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
        let began_ns = if shell.roster().lockstep() {
            simulator.run_ns()
        } else {
            now_ns()
        };
        // Without launch no command counts any more: the driver brings the robot to rest.
        let age_ns = self
            .command_came_ns
            .filter(|_| !shell.is_orphaned())
            .map_or(u64::MAX, |came_ns| began_ns.saturating_sub(came_ns));
        simulator.step(run_ns, age_ns);
        let due = Due {
            tick: self.tick,
            kind,
        };
        self.sensors
            .send(shell, simulator, due, run_ns, self.slipped_ns);
    }
}

fn main() -> ExitCode {
    zeronav_shell::run::<RobotService>()
}
