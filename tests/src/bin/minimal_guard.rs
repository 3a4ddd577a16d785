//! The least that can sit in the guard's seat: a young request is brought into the robot's limits,
//! everything else is a stop.

use std::process::ExitCode;
use zeronav_msgs::command::{Intervention, Validity, VelocityCommand};
use zeronav_msgs::header::Parents;
use zeronav_msgs::health::REASON_REQUEST;
use zeronav_msgs::role::Role;
use zeronav_msgs::topics::{ControlRequest, RobotCommand, RobotDescription, RobotScan};
use zeronav_shell::clock::now_ns;
use zeronav_shell::doorbell::Rung;
use zeronav_shell::{
    Latest, NoConfig, Service, Shell, StartError, TrackReader, Trigger, Turn, Writer,
};

/// How long after odometry the guard waits for the request that belongs to it. [ns]
const PATIENCE_NS: u64 = 5_000_000;
/// Age from which requests and odometry count as missing. [ns]
const STALE_NS: u64 = 100_000_000;
/// Age from which a scan counts as missing. [ns]
const SCAN_STALE_NS: u64 = 350_000_000;

struct MinimalGuard {
    description: Latest<RobotDescription>,
    odometry: TrackReader,
    scan: Latest<RobotScan>,
    request: Latest<ControlRequest>,
    command: Writer<RobotCommand>,
    /// When odometry, scan and request came in last, by the own clock. [ns]
    came_ns: [u64; 3],
}

impl Service for MinimalGuard {
    const ROLE: Role = Role::CollisionGuard;
    type Config = NoConfig;

    fn open(shell: &mut Shell, _config: NoConfig) -> Result<Self, StartError> {
        let peer = shell.peer();
        Ok(Self {
            description: peer.latest()?,
            odometry: TrackReader::open(peer)?,
            scan: peer.latest()?,
            request: peer.latest()?,
            command: peer.writer(1)?,
            came_ns: [0; 3],
        })
    }

    fn wake(&mut self, shell: &mut Shell, _rung: Rung) -> Result<Option<u64>, StartError> {
        let roster = shell.roster();
        let moved = self.odometry.poll(roster);
        self.description.poll(roster);
        let news = [moved, self.scan.poll(roster), self.request.poll(roster)];
        for (came_ns, _) in self.came_ns.iter_mut().zip(news).filter(|(_, new)| *new) {
            *came_ns = shell.woken_ns();
        }
        shell.totals(self.request.refused() + self.odometry.refused(), 0);
        let (tick, asked) = (self.odometry.tick(), news[2]);
        let due_ns = self.came_ns[0] + PATIENCE_NS;
        let roster = shell.roster();
        let early = !roster.lockstep() && !asked && now_ns() < due_ns;
        let unasked = roster.answers(Role::LocalPlanner, tick) && self.request.tick() < tick;
        let waits = early || (roster.lockstep() && unasked);
        let trigger = Trigger {
            tick,
            complete: !waits,
            news: asked,
        };
        for turn in shell.turns(&trigger) {
            self.answer(shell, turn);
        }
        Ok(early.then_some(due_ns))
    }
}

impl MinimalGuard {
    fn answer(&mut self, shell: &mut Shell, turn: Turn) {
        let scan = self.scan.get().map(|view| *view.header);
        let request = self.request.get().map(|view| *view.header);
        let odometry = self.odometry.track().newest();
        let run_ns = turn.tick.saturating_mul(shell.roster().clock.tick_ns);
        let parents = Parents {
            odometry: self.odometry.id().0,
            scan: scan.map_or(0, |header| header.id),
            request: request.map_or(0, |header| header.id),
            ..Parents::default()
        };
        let capture_ns = scan.map_or(0, |header| header.capture_ns);
        let draft = shell.draft(turn.tick, run_ns, capture_ns, parents);
        // Ages are run time in lockstep and the own clock otherwise.
        let (lockstep, now_ns) = (shell.roster().lockstep(), now_ns());
        let old = |made_run_ns: Option<u64>, came_ns: u64, limit_ns: u64| {
            let age_ns = if lockstep {
                made_run_ns.map_or(u64::MAX, |made| run_ns.saturating_sub(made))
            } else {
                now_ns.saturating_sub(came_ns)
            };
            age_ns > limit_ns
        };
        let [odometry_ns, scan_ns, request_ns] = self.came_ns;
        let intervention = if old(request.map(|h| h.run_ns), request_ns, STALE_NS) {
            Intervention::RequestStale
        } else if old(scan.map(|h| h.run_ns), scan_ns, SCAN_STALE_NS) {
            Intervention::ScanStale
        } else if old(odometry.map(|m| m.run_ns), odometry_ns, STALE_NS) {
            Intervention::OdometryStale
        } else {
            Intervention::None
        };
        let command = self.command_of(intervention, shell.roster().control.stopping == 1);
        shell.reason(REASON_REQUEST, intervention == Intervention::RequestStale);
        shell.answer(turn.kind, &draft, &mut self.command, command, &[]);
    }

    /// The command for the newest request. What is no number did not get past the port.
    fn command_of(&self, stale: Intervention, stopping: bool) -> VelocityCommand {
        let stop = |validity: Validity, intervention: Intervention| VelocityCommand {
            validity: validity.code(),
            intervention: intervention.code(),
            ..VelocityCommand::default()
        };
        let (Some(request), Some(robot)) = (self.request.get(), self.description.get()) else {
            return stop(Validity::NoRequest, Intervention::None);
        };
        let meaning = request.meta.validity().unwrap_or(Validity::Stale);
        if stopping {
            return stop(Validity::Stopped, Intervention::None);
        }
        if stale != Intervention::None {
            return stop(Validity::Stale, stale);
        }
        if meaning != Validity::Drive {
            return stop(meaning, Intervention::None);
        }
        let (asked, limits) = (request.meta, robot.meta);
        let v_mps = asked.v_mps.clamp(limits.v_mps_min, limits.v_mps_max);
        let w_radps = asked.w_radps.clamp(-limits.w_radps_max, limits.w_radps_max);
        let as_asked =
            v_mps.total_cmp(&asked.v_mps).is_eq() && w_radps.total_cmp(&asked.w_radps).is_eq();
        let intervention = if as_asked {
            Intervention::None
        } else {
            Intervention::Clamped
        };
        VelocityCommand {
            v_mps,
            w_radps,
            ..stop(Validity::Drive, intervention)
        }
    }
}

fn main() -> ExitCode {
    zeronav_shell::run::<MinimalGuard>()
}
