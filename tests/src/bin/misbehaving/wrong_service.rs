//! The zoo of the contract's kit: a service that is right but for one fault, which the environment names
//! (`FAULT=NAME`). The faults have the names of the clauses that they break.

use std::env::var;
use std::io::Write;
use std::process::ExitCode;
use std::time::Duration;
use zeronav_msgs::command::{Validity, VelocityRequest};
use zeronav_msgs::header::Parents;
use zeronav_msgs::path::{Path, PathCause, PathStatus, Waypoint};
use zeronav_msgs::role::Role;
use zeronav_msgs::span::SpanKind;
use zeronav_msgs::task::TaskStatus;
use zeronav_msgs::topics::{ControlRequest, PlanPath, RobotOdometry, RobotScan, TaskState};
use zeronav_shell::clock::now_ns;
use zeronav_shell::doorbell::Rung;
use zeronav_shell::{
    CurrentGoal, Domain, Draft, Due, Input, Latest, MapInput, NoConfig, OdometryReader, Peer,
    Service, Shell, StartError, Stream, Trigger, Writer,
};

/// Age of a scan at which the robot stops. [ns]
const SCAN_AGE_NS_MAX: u64 = 300_000_000;

/// What a leak takes for every rejected scan: on a busy machine few are read. [bytes]
const LEAK_BYTES: usize = 1 << 23;

/// What it takes at most. [bytes]
const LEAK_BYTES_MAX: usize = 1 << 27;

/// True when this is the fault that was asked for.
fn fault(name: &str) -> bool {
    var("FAULT").is_ok_and(|fault| fault == name)
}

/// A local planner that drives straight ahead while scans come.
struct Straight {
    odometry: OdometryReader,
    scan: Latest<RobotScan>,
    request: Writer<ControlRequest>,
    status: Writer<TaskState>,
    /// Odometry of any author with the epoch after the obeyed one.
    unobeyed: Option<Stream<RobotOdometry>>,
    is_misled: bool,
    /// A topic of another seat.
    _foreign: Option<Writer<PlanPath>>,
    /// A member with another epoch.
    _twin: Option<Peer>,
    leak: Vec<u8>,
    orphaned: bool,
}

impl Service for Straight {
    const ROLE: Role = Role::LocalPlanner;
    type Config = NoConfig;

    fn open(shell: &mut Shell, _config: NoConfig) -> Result<Self, StartError> {
        let peer = shell.peer();
        let twin = || {
            Peer::join(
                Domain::join(peer.domain().root())?,
                Self::ROLE,
                peer.epoch() + 1,
            )
        };
        let twin = fault("epoch").then(twin).transpose()?;
        Ok(Self {
            odometry: OdometryReader::open(peer)?,
            scan: peer.latest()?,
            request: twin.as_ref().unwrap_or(peer).writer(1)?,
            status: peer.writer(1)?,
            unobeyed: fault("obeyed_only").then(|| peer.stream()).transpose()?,
            is_misled: false,
            _foreign: fault("topics").then(|| peer.writer(1)).transpose()?,
            _twin: twin,
            leak: Vec::new(),
            orphaned: false,
        })
    }

    fn wake(&mut self, shell: &mut Shell, _rung: Rung) -> Result<(), StartError> {
        self.odometry.poll(shell.roster());
        self.scan.poll(shell.roster());
        shell.count(&[&self.odometry, &self.scan]);
        self.status.refresh();
        self.orphaned = shell.is_orphaned();
        self.misbehave(shell)?;
        let trigger = Trigger {
            tick: self.odometry.tick(),
            complete: true,
            ..Trigger::default()
        };
        for due in shell.due(&trigger) {
            let lockstep = shell.roster().lockstep();
            match due {
                Due::IDLE if fault("idle_output") => shell.ready(),
                Due { tick: 140, .. } if fault("lockstep") && lockstep => {}
                _ => self.answer(shell, due),
            }
        }
        Ok(())
    }

    fn is_at_rest(&self) -> bool {
        self.odometry.history().is_at_rest()
    }
}

impl Straight {
    /// Faults that belong to no answer.
    fn misbehave(&mut self, shell: &Shell) -> Result<(), StartError> {
        while fault("orphan") && self.orphaned {
            std::thread::sleep(Duration::from_millis(10));
        }
        if fault("heartbeat") && self.odometry.tick() == 0 {
            std::thread::sleep(Duration::from_millis(300));
        }
        if fault("hostile_input") && self.scan.refused() > 0 {
            return Err(StartError::system("reading scans", "one makes no sense"));
        }
        let rejected = usize::try_from(self.scan.refused()).unwrap_or(0);
        let leak = rejected.saturating_mul(LEAK_BYTES).min(LEAK_BYTES_MAX);
        if fault("bounded_memory") && self.leak.len() < leak {
            self.leak.resize(leak, 1);
        }
        if let Some(unobeyed) = &mut self.unobeyed {
            let mut roster = shell.roster().clone();
            roster.own = None;
            for seat in &mut roster.seats {
                seat.epoch += 1;
            }
            unobeyed.drain(&roster, |_| self.is_misled = true);
        }
        Ok(())
    }

    fn answer(&mut self, shell: &mut Shell, due: Due) {
        let parents = Parents {
            odometry: self.odometry.id().0,
            scan: self.scan.id().0,
            ..Parents::default()
        };
        let draft = shell.begin(due, shell.run_ns(due.tick), 0, parents);
        if fault("latency") && due.tick > 0 && !shell.roster().lockstep() {
            std::thread::sleep(Duration::from_millis(40));
        }
        let request = self.request(shell, &draft);
        if due == Due::IDLE {
            shell.send(&draft, &mut self.status, TaskStatus::default(), &[]);
        }
        if fault("lockstep_twice") && due.tick == 20 {
            shell.send(&draft, &mut self.request, request, &[]);
        }
        let sent = shell.send(&draft, &mut self.request, request, &[]);
        let output = sent.filter(|_| !(fault("records_unnamed") && due.tick == 20));
        shell.finish(&draft, output, 0);
        if fault("records") && due.tick == 20 {
            shell.finish(&draft, sent, 0);
        }
    }

    fn request(&self, shell: &Shell, draft: &Draft) -> VelocityRequest {
        let scan = self.scan.received();
        let age_ns = scan.map_or(u64::MAX, |scan| shell.age_ns(draft, &scan));
        let stale = age_ns > SCAN_AGE_NS_MAX && !fault("lost_input");
        let stopping = shell.roster().control.stopping == 1;
        if draft.kind == SpanKind::Idle || stale || stopping {
            return VelocityRequest {
                validity: Validity::Stale.code(),
                ..VelocityRequest::default()
            };
        }
        let v_mps = match () {
            () if fault("legal_output") => 5.0,
            () if fault("legal_output_nan") => f64::NAN,
            () if fault("repeatable") && now_ns().is_multiple_of(2) => 0.15,
            () if self.is_misled => 0.1,
            () => 0.2,
        };
        VelocityRequest {
            v_mps,
            validity: Validity::Drive.code(),
            ..VelocityRequest::default()
        }
    }
}

impl Drop for Straight {
    fn drop(&mut self) {
        if fault("stop") && !self.orphaned {
            std::thread::sleep(Duration::from_secs(4));
        }
    }
}

/// A global planner whose path is a straight line, whatever lies on it.
struct Line {
    odometry: OdometryReader,
    map: MapInput,
    goal: CurrentGoal,
    path: Writer<PlanPath>,
}

impl Service for Line {
    const ROLE: Role = Role::GlobalPlanner;
    type Config = NoConfig;

    fn open(shell: &mut Shell, _config: NoConfig) -> Result<Self, StartError> {
        let peer = shell.peer();
        Ok(Self {
            odometry: OdometryReader::open(peer)?,
            map: MapInput::open(peer)?,
            goal: CurrentGoal::open(peer)?,
            path: peer.writer(2)?,
        })
    }

    fn wake(&mut self, shell: &mut Shell, _rung: Rung) -> Result<(), StartError> {
        self.odometry.poll(shell.roster());
        let news = self.map.poll(shell) | self.goal.poll(shell.roster());
        let trigger = self.map.trigger(shell.roster(), &self.odometry, news);
        for due in shell.due(&trigger) {
            self.goal.advance(shell.roster(), due.tick);
            let draft = self.map.begin(shell, due, Parents::default());
            let line = self.line();
            let path = match self.goal.goal() {
                Some(goal) if !line.is_empty() => {
                    let (status, cause) = (PathStatus::Found, PathCause::Goal);
                    Path::new("line", status, cause, goal.id, &line)
                }
                _ => Path::default(),
            };
            shell.answer(&draft, &mut self.path, path, &line);
        }
        Ok(())
    }
}

impl Line {
    fn line(&self) -> Vec<Waypoint> {
        let (Some(robot), Some(goal)) = (self.odometry.newest(), self.goal.goal()) else {
            return Vec::new();
        };
        [&robot.odometry.pose, &goal.pose]
            .map(|pose| Waypoint {
                x_m: pose.x_m,
                y_m: pose.y_m,
                ..Waypoint::default()
            })
            .to_vec()
    }
}

pub(crate) fn run() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let has = |flag: &str| arguments.iter().any(|argument| argument == flag);
    let config = arguments
        .iter()
        .skip_while(|argument| *argument != "--config")
        .nth(1);
    let text = config.and_then(|config| std::fs::read_to_string(config).ok());
    let bad_config = text.is_some_and(|text| !text.trim().is_empty());
    if fault("help") && has("--help") {
        return ExitCode::FAILURE;
    }
    if fault("help_flood") && has("--help") {
        // Until nobody reads any more.
        let mut out = std::io::stdout().lock();
        while out.write_all(&[b'x'; 1 << 12]).is_ok() {}
        return ExitCode::SUCCESS;
    }
    if fault("unknown_flag") && has("--no-such-flag") {
        return ExitCode::SUCCESS;
    }
    if fault("print_config") && has("--print-config") && config.is_some() && !bad_config {
        return ExitCode::FAILURE;
    }
    if fault("bad_config") && bad_config {
        return ExitCode::from(2);
    }
    let code = if fault("legal_output_path") {
        zeronav_shell::run::<Line>()
    } else {
        zeronav_shell::run::<Straight>()
    };
    let mapped = [("other_contract", 3), ("no_memory", 4), ("one_per_seat", 2)];
    let is_wrong = |(name, right): &(&str, u8)| {
        fault(name) && has("--domain") && code == ExitCode::from(*right)
    };
    if mapped.iter().any(is_wrong) {
        return ExitCode::FAILURE;
    }
    code
}
