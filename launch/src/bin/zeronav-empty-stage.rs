//! A stage that does nothing but pass on: the floor under every latency of the stack. It fills the
//! seat that its configuration names; launch starts five of them, see `zeronav::floor`.

use clap::Parser;
use std::process::ExitCode;
use zeronav::floor::StageConfig;
use zeronav_console::terminal::note;
use zeronav_measure::result::trials::Load;
use zeronav_msgs::GridGeometry;
use zeronav_msgs::command::{Validity, VelocityCommand, VelocityRequest};
use zeronav_msgs::header::{Id, Parents};
use zeronav_msgs::map::{MapInfo, MapTile};
use zeronav_msgs::path::{Path, PathCause, PathStatus, Waypoint};
use zeronav_msgs::role::Role;
use zeronav_msgs::scan::Scan;
use zeronav_msgs::span::SpanKind;
use zeronav_msgs::topics::{ControlRequest, MapUpdate, PlanPath, RobotCommand, RobotScan, Topic};
use zeronav_shell::clock::now_ns;
use zeronav_shell::doorbell::Rung;
use zeronav_shell::error::EXIT_USAGE;
use zeronav_shell::flags::Flags;
use zeronav_shell::{Due, Latest, Service, Shell, StartError, Writer};

/// What a stage takes in and passes on.
trait Stage {
    const ROLE: Role;
    type In: Topic;
    type Out: Topic;

    /// Items of the message that goes out.
    fn len(load: &Load) -> usize;
    /// Fills them, and says the fixed fields of message `id`.
    fn fill(id: Id, items: &mut [<Self::Out as Topic>::Item]) -> <Self::Out as Topic>::Meta;
}

/// Waits for a message, sends one.
struct Passing<S: Stage> {
    input: Latest<S::In>,
    output: Writer<S::Out>,
    len: usize,
}

impl<S: Stage> Service for Passing<S> {
    const ROLE: Role = S::ROLE;
    type Config = StageConfig;

    fn open(shell: &mut Shell, config: StageConfig) -> Result<Self, StartError> {
        let len = S::len(&config.load);
        Ok(Self {
            input: shell.peer().latest()?,
            output: shell.peer().writer(len.max(1))?,
            len,
        })
    }

    fn wake(&mut self, shell: &mut Shell, _rung: Rung) -> Result<(), StartError> {
        if !shell.roster().has_clock() {
            return Ok(());
        }
        shell.ready();
        if !self.input.poll(shell.roster()) {
            return Ok(());
        }
        let Some(view) = self.input.get() else {
            return Ok(());
        };
        let header = *view.header;
        // Given back at once: of a stream, one message is lent at a time.
        self.input.release();
        let id = self.output.next_id();
        let due = Due {
            tick: header.tick,
            kind: SpanKind::Answer,
        };
        let draft = shell.begin(due, header.run_ns, header.capture_ns, Parents::default());
        let fill = |items: &mut [_]| S::fill(id, items);
        let output = shell.send_with(&draft, &mut self.output, self.len, fill);
        shell.finish(&draft, output, 0);
        Ok(())
    }
}

/// Sends a scan per period, takes the command.
struct Source {
    scan: Writer<RobotScan>,
    command: Latest<RobotCommand>,
    load: Load,
    tick: u64,
    due_ns: u64,
}

impl Service for Source {
    const ROLE: Role = Role::Robot;
    type Config = StageConfig;

    fn open(shell: &mut Shell, config: StageConfig) -> Result<Self, StartError> {
        Ok(Self {
            scan: shell.peer().writer(config.load.beams as usize)?,
            command: shell.peer().latest()?,
            load: config.load,
            tick: 0,
            due_ns: 0,
        })
    }

    fn wake(&mut self, shell: &mut Shell, _rung: Rung) -> Result<(), StartError> {
        if !shell.roster().has_clock() {
            return Ok(());
        }
        shell.ready();
        self.command.poll(shell.roster());
        let capture_ns = now_ns();
        if capture_ns < self.due_ns {
            shell.wake_by(self.due_ns);
            return Ok(());
        }
        self.due_ns = capture_ns + self.load.period_ns;
        self.tick += 1;
        let run_ns = self.tick * self.load.period_ns;
        let due = Due {
            tick: self.tick,
            kind: SpanKind::Answer,
        };
        let draft = shell.begin(due, run_ns, capture_ns, Parents::default());
        let beams = self.load.beams;
        let output = shell.send_with(&draft, &mut self.scan, beams as usize, |ranges| {
            ranges.fill(1.0);
            Scan {
                n_beams: beams,
                angle_increment_rad: 0.01,
                range_m_max: 10.0,
                ..Scan::default()
            }
        });
        shell.finish(&draft, output, 0);
        shell.wake_by(self.due_ns);
        Ok(())
    }
}

enum Mapping {}

impl Stage for Mapping {
    const ROLE: Role = Role::Mapping;
    type In = RobotScan;
    type Out = MapUpdate;

    fn len(load: &Load) -> usize {
        load.tiles as usize
    }

    fn fill(id: Id, tiles: &mut [MapTile]) -> MapInfo {
        tiles.fill(MapTile::default());
        MapInfo {
            geometry: GridGeometry {
                resolution_m: 0.05,
                width: 600,
                height: 400,
                ..GridGeometry::default()
            },
            revision: id.0,
            parts: 1,
            n_tiles: u32::try_from(tiles.len()).unwrap_or(0),
            clearance_limit_mm: 1,
            current: 1,
            ..MapInfo::default()
        }
    }
}

enum GlobalPlanner {}

impl Stage for GlobalPlanner {
    const ROLE: Role = Role::GlobalPlanner;
    type In = MapUpdate;
    type Out = PlanPath;

    fn len(load: &Load) -> usize {
        load.waypoints as usize
    }

    fn fill(id: Id, waypoints: &mut [Waypoint]) -> Path {
        waypoints.fill(Waypoint::default());
        Path {
            planner: Path::planner_bytes("empty"),
            status: PathStatus::Found.code(),
            cause: PathCause::Goal.code(),
            n_waypoints: u32::try_from(waypoints.len()).unwrap_or(0),
            geometry: id.0,
            ..Path::default()
        }
    }
}

enum LocalPlanner {}

impl Stage for LocalPlanner {
    const ROLE: Role = Role::LocalPlanner;
    type In = PlanPath;
    type Out = ControlRequest;

    fn len(_load: &Load) -> usize {
        0
    }

    fn fill(_id: Id, _items: &mut [u8]) -> VelocityRequest {
        VelocityRequest {
            validity: Validity::Drive.code(),
            ..VelocityRequest::default()
        }
    }
}

enum Guard {}

impl Stage for Guard {
    const ROLE: Role = Role::CollisionGuard;
    type In = ControlRequest;
    type Out = RobotCommand;

    fn len(_load: &Load) -> usize {
        0
    }

    fn fill(_id: Id, _items: &mut [u8]) -> VelocityCommand {
        VelocityCommand {
            validity: Validity::Drive.code(),
            ..VelocityCommand::default()
        }
    }
}

fn main() -> ExitCode {
    // The seat is in the configuration; the shell reads flags and configuration again.
    let seat = Flags::parse().member.read_config(|_: &StageConfig| Ok(()));
    match seat.map(|config| Role::from_label(&config.seat)) {
        Ok(Some(Role::Robot)) => zeronav_shell::run::<Source>(),
        Ok(Some(Role::Mapping)) => zeronav_shell::run::<Passing<Mapping>>(),
        Ok(Some(Role::GlobalPlanner)) => zeronav_shell::run::<Passing<GlobalPlanner>>(),
        Ok(Some(Role::LocalPlanner)) => zeronav_shell::run::<Passing<LocalPlanner>>(),
        Ok(Some(Role::CollisionGuard)) => zeronav_shell::run::<Passing<Guard>>(),
        Ok(_) => {
            note("the configuration's `seat` names no seat of the ring");
            ExitCode::from(EXIT_USAGE)
        }
        Err(error) => {
            note(&error.to_string());
            error.exit_code()
        }
    }
}
