//! The simulated robot as a process: sensors out at every tick, velocity commands in.

use std::process::ExitCode;
use zeronav_msgs::command::Validity;
use zeronav_msgs::header::Parents;
use zeronav_msgs::role::Role;
use zeronav_msgs::span::SpanKind;
use zeronav_msgs::topics::{
    GroundTruth, RobotCommand, RobotDescription, RobotOdometry, RobotScan, SimPlacement,
};
use zeronav_msgs::truth::{TRUTH_OBSTACLES_MAX, TruthObstacle};
use zeronav_robot_sim::simulator::TICK_NS_MIN;
use zeronav_robot_sim::{SimConfig, SimError, Simulator};
use zeronav_shell::clock::{both_ns, now_ns};
use zeronav_shell::doorbell::Rung;
use zeronav_shell::records::SpanReader;
use zeronav_shell::track;
use zeronav_shell::{Cycle, Latest, Service, Shell, StartError, Writer};
use zeronav_world::{SpecError, WorldError};

struct RobotService {
    config: SimConfig,
    simulator: Option<Simulator>,
    description: Writer<RobotDescription>,
    scan: Writer<RobotScan>,
    odometry: Writer<RobotOdometry>,
    truth: Writer<GroundTruth>,
    command: Latest<RobotCommand>,
    placements: Latest<SimPlacement>,
    spans: SpanReader,
    obstacles: Vec<TruthObstacle>,
    tick: u64,
    /// Newest tick with a scan.
    scan_tick: u64,
    /// When the next tick is due, real time only. [ns]
    due_ns: u64,
    /// When the newest command came in: monotonic, in lockstep run time. [ns]
    command_came_ns: Option<u64>,
    /// Highest tick that each role has answered, lockstep only.
    answered: [u64; 16],
    slipped_ns: u64,
    /// Contacts that the log has.
    told_contacts: u32,
    /// Ticks in a row that the wheels have stood.
    standing_ticks: usize,
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
            description: peer.writer(zeronav_msgs::description::FOOTPRINT_CORNERS_MAX)?,
            scan: peer.writer(config.robot.lidar.n_beams as usize)?,
            odometry: peer.writer(1)?,
            truth: peer.writer(TRUTH_OBSTACLES_MAX)?,
            command: peer.latest()?,
            placements: peer.latest()?,
            spans: peer.span_reader()?,
            obstacles: Vec::with_capacity(TRUTH_OBSTACLES_MAX),
            tick: 0,
            scan_tick: 0,
            due_ns: 0,
            command_came_ns: None,
            answered: [0; 16],
            slipped_ns: 0,
            told_contacts: 0,
            standing_ticks: 0,
            config,
        })
    }

    fn wake(&mut self, shell: &mut Shell, _rung: Rung) -> Result<Option<u64>, StartError> {
        if !shell.roster().has_clock() {
            return Ok(None);
        }
        if self.simulator.is_none() {
            self.start(shell)?;
        }
        self.description.refresh();
        let lockstep = shell.roster().lockstep();
        if lockstep {
            // Before the commands: an answer is recorded after what it answers with was sent.
            let answered = &mut self.answered;
            self.spans.drain(|span| {
                if span.kind() == Some(SpanKind::Answer)
                    && let Some(tick) = answered.get_mut(usize::from(span.role))
                {
                    *tick = (*tick).max(span.tick);
                }
            });
        }
        self.take_command(shell);
        self.take_placements(shell);
        shell.totals(
            self.command.refused() + self.placements.refused(),
            self.command.superseded(),
        );
        let control = shell.roster().control;
        if lockstep {
            if control.paused == 0 && self.tick < control.lease && self.all_answered(shell) {
                self.tick(shell);
            }
            return Ok(None);
        }
        if control.paused == 1 {
            self.due_ns = now_ns() + shell.roster().clock.tick_ns;
            return Ok(Some(self.due_ns));
        }
        Ok(Some(self.keep_time(shell)))
    }

    fn is_at_rest(&self) -> bool {
        self.standing_ticks >= track::REST_MESSAGES
    }
}

impl RobotService {
    /// Makes the world, says what the robot is, and that it is ready.
    fn start(&mut self, shell: &mut Shell) -> Result<(), StartError> {
        let clock = shell.roster().clock;
        let simulator =
            Simulator::new(&self.config, clock.seed, clock.tick_ns).map_err(unusable)?;
        for warning in simulator.map_warnings() {
            tracing::warn!("{warning}");
        }
        let (description, corners) = simulator.description();
        let draft = shell.draft(0, 0, 0, Parents::default());
        let sent = self.description.publish(&draft, description, &corners);
        let output = shell.sent(&self.description, sent);
        shell.finish(&Cycle {
            kind: SpanKind::Idle,
            draft,
            output,
            work: 0,
        });
        shell.ready();
        let seed = clock.seed;
        tracing::info!(seed, tick_ns = clock.tick_ns, "the robot begins");
        self.simulator = Some(simulator);
        self.due_ns = now_ns() + clock.tick_ns;
        Ok(())
    }

    /// Lets the newest command reach the motors.
    fn take_placements(&mut self, shell: &Shell) {
        if self.placements.poll(shell.roster())
            && let Some(view) = self.placements.get()
            && let Some(simulator) = &mut self.simulator
        {
            for placement in view.items {
                simulator.place(placement);
            }
        }
    }

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
        let lockstep = shell.roster().lockstep();
        self.command_came_ns = Some(if lockstep {
            command.header.run_ns
        } else {
            shell.woken_ns()
        });
        if lockstep {
            return;
        }
        let parents = Parents {
            request: command.header.id,
            ..Parents::default()
        };
        let (tick, capture_ns) = (command.header.tick, command.header.capture_ns);
        // The draft's start is the moment at which the set point took effect.
        let mut draft = shell.draft(tick, command.header.run_ns, capture_ns, parents);
        (draft.started_ns, draft.raw_ns) = both_ns();
        shell.finish(&Cycle {
            kind: SpanKind::Applied,
            draft,
            output: None,
            work: 0,
        });
    }

    /// True when every seat on the roster has answered what it owes up to this tick.
    fn all_answered(&self, shell: &Shell) -> bool {
        let roster = shell.roster();
        [
            Role::Mapping,
            Role::GlobalPlanner,
            Role::LocalPlanner,
            Role::CollisionGuard,
        ]
        .into_iter()
        .all(|role| {
            let owed = match role {
                Role::Mapping | Role::GlobalPlanner => self.scan_tick,
                _ => self.tick,
            };
            !roster.answers(role, owed) || self.answered[usize::from(role.code())] >= owed
        })
    }

    /// When the next step is due by the own clock, and the run time of its scan if that is captured
    /// between two ticks. [ns]
    fn next_due(&self, tick_ns: u64) -> (u64, Option<u64>) {
        let tick_run_ns = (self.tick + 1).saturating_mul(tick_ns);
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
        let tick_ns = shell.roster().clock.tick_ns;
        let (mut due_ns, mut capture_run_ns) = self.next_due(tick_ns);
        if let Some(run_ns) = capture_run_ns.filter(|_| now_ns() >= due_ns) {
            self.step(shell, run_ns, SpanKind::Extra);
            (due_ns, capture_run_ns) = self.next_due(tick_ns);
        }
        if capture_run_ns.is_none() && now_ns() >= due_ns {
            self.tick(shell);
            // Never catch up: what the machine was too busy for is run time that slipped.
            self.due_ns += tick_ns;
            let now = now_ns();
            if self.due_ns < now {
                self.slipped_ns += now - self.due_ns;
                self.due_ns = now;
            }
            shell.slipped(self.slipped_ns);
            due_ns = self.next_due(tick_ns).0;
        }
        due_ns
    }

    /// One tick.
    fn tick(&mut self, shell: &mut Shell) {
        let tick = self.tick + 1;
        let run_ns = tick.saturating_mul(shell.roster().clock.tick_ns);
        self.tick = tick;
        self.step(shell, run_ns, SpanKind::Answer);
    }

    /// Moves until `run_ns`, looks, tells. Between two ticks it tells of a scan, with the odometry
    /// of its capture so that nobody has to guess where the robot was, under the tick before.
    fn step(&mut self, shell: &mut Shell, run_ns: u64, kind: SpanKind) {
        let Some(simulator) = &mut self.simulator else {
            return;
        };
        let lockstep = shell.roster().lockstep();
        let tick = self.tick;
        let began_ns = if lockstep {
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
        // The world is still from here on: this is the moment that the sensors see.
        let (seen_ns, seen_raw_ns) = both_ns();
        let due = simulator.scan_due();
        let odometry_id = self.odometry.next_id().0;
        let mut parents = Parents {
            odometry: odometry_id,
            ..Parents::default()
        };
        let mut capture_ns = seen_ns;
        if let Some(due) = due {
            self.scan_tick = tick;
            capture_ns = seen_ns - run_ns.saturating_sub(due.capture_run_ns).min(seen_ns);
            let draft = shell.draft(tick, due.capture_run_ns, capture_ns, parents);
            let n_beams = simulator.n_beams();
            let sent = self.scan.publish_with(&draft, n_beams, |ranges| {
                simulator.scan(ranges).unwrap_or_default()
            });
            parents.scan = shell.sent(&self.scan, sent).map_or(0, |sent| sent.id.0);
        }
        let mut draft = shell.draft(tick, run_ns, capture_ns, parents);
        if !lockstep {
            draft.raw_ns = seen_raw_ns.saturating_sub(seen_ns - capture_ns);
        }
        let odometry = simulator.odometry();
        self.standing_ticks = if track::stands(&odometry) {
            self.standing_ticks.saturating_add(1)
        } else {
            0
        };
        let sent = self.odometry.publish(&draft, odometry, &[]);
        let output = shell.sent(&self.odometry, sent);
        shell.finish(&Cycle {
            kind,
            draft,
            output,
            work: due.map_or(0, |_| simulator.n_beams() as u64),
        });
        if simulator.truth_due() {
            let mut truth = simulator.truth(&mut self.obstacles);
            let contacts = truth.contacts_moving + truth.contacts_standing;
            if contacts != self.told_contacts {
                self.told_contacts = contacts;
                let (x_m, y_m, v_mps) = (truth.pose.x_m, truth.pose.y_m, truth.v_mps);
                tracing::info!(tick, contacts, x_m, y_m, v_mps, "contact");
            }
            truth.scan = parents.scan;
            truth.slipped_ns = self.slipped_ns;
            for obstacle in &mut self.obstacles {
                let ago_ns = run_ns.saturating_sub(obstacle.appeared_run_ns);
                obstacle.appeared_ns = seen_ns.saturating_sub(ago_ns);
            }
            draft.hashed = false;
            self.truth.publish(&draft, truth, &self.obstacles);
        }
    }
}

fn main() -> ExitCode {
    zeronav_shell::run::<RobotService>()
}
