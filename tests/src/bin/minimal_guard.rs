//! A minimal guard: limits a recent request to the robot's speeds and to what it can stop from before
//! whatever the scan shows straight ahead, and stops without one. Turning is not checked.

use std::process::ExitCode;
use zeronav_msgs::command::{Intervention, Validity, VelocityCommand};
use zeronav_msgs::header::Parents;
use zeronav_msgs::health::REASON_REQUEST;
use zeronav_msgs::pose::Pose;
use zeronav_msgs::role::Role;
use zeronav_msgs::topics::{ControlRequest, RobotCommand, RobotDescription, RobotScan};
use zeronav_shell::doorbell::Rung;
use zeronav_shell::{
    Due, Latest, NoConfig, OdometryReader, OdometrySample, Received, Service, Shell, StartError,
    Trigger, Writer,
};

/// How long after odometry the guard waits for the request that belongs to it. [ns]
const PATIENCE_NS: u64 = 5_000_000;
/// Age from which requests and odometry count as missing. [ns]
const STALE_NS: u64 = 100_000_000;
/// Age from which a scan counts as missing. [ns]
const SCAN_STALE_NS: u64 = 350_000_000;
/// Distance kept free in the way of the robot. [m]
const MARGIN_M: f64 = 0.1;

struct MinimalGuard {
    description: Latest<RobotDescription>,
    odometry: OdometryReader,
    scan: Latest<RobotScan>,
    request: Latest<ControlRequest>,
    command: Writer<RobotCommand>,
}

impl Service for MinimalGuard {
    const ROLE: Role = Role::CollisionGuard;
    type Config = NoConfig;

    fn open(shell: &mut Shell, _config: NoConfig) -> Result<Self, StartError> {
        let peer = shell.peer();
        Ok(Self {
            description: peer.latest()?,
            odometry: OdometryReader::open(peer)?,
            scan: peer.latest()?,
            request: peer.latest()?,
            command: peer.writer(1)?,
        })
    }

    fn wake(&mut self, shell: &mut Shell, _rung: Rung) -> Result<(), StartError> {
        let roster = shell.roster();
        self.odometry.poll(roster);
        self.description.poll(roster);
        self.scan.poll(roster);
        let requested = self.request.poll(roster);
        shell.count(&[&self.odometry, &self.scan, &self.request]);
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
}

impl MinimalGuard {
    fn answer(&mut self, shell: &mut Shell, due: Due) {
        let parents = Parents {
            odometry: self.odometry.id().0,
            scan: self.scan.id().0,
            request: self.request.id().0,
            ..Parents::default()
        };
        let capture_ns = self.scan.received().map_or(0, |scan| scan.capture_ns);
        let draft = shell.begin(due, shell.run_ns(due.tick), capture_ns, parents);
        let old = |message: Option<Received>, limit_ns: u64| {
            message.is_none_or(|it| shell.age_ns(&draft, &it.on_arrival()) > limit_ns)
        };
        let odometry = self.odometry.newest().map(OdometrySample::received);
        let intervention = if old(self.request.received(), STALE_NS) {
            Intervention::RequestStale
        } else if old(self.scan.received(), SCAN_STALE_NS) {
            Intervention::ScanStale
        } else if old(odometry, STALE_NS) {
            Intervention::OdometryStale
        } else {
            Intervention::None
        };
        let command = self.command_of(intervention, shell.roster().control.stopping == 1);
        shell.reason(REASON_REQUEST, intervention == Intervention::RequestStale);
        shell.answer(&draft, &mut self.command, command, &[]);
    }

    /// The command for the newest request. The reader has rejected NaN already.
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
        let safe_mps = (2.0 * limits.brake_mps2 * self.room_m(asked.v_mps)).sqrt();
        let v_mps = asked.v_mps.clamp(limits.v_mps_min, limits.v_mps_max);
        let w_radps = asked.w_radps.clamp(-limits.w_radps_max, limits.w_radps_max);
        let as_asked =
            v_mps.total_cmp(&asked.v_mps).is_eq() && w_radps.total_cmp(&asked.w_radps).is_eq();
        let intervention = if v_mps.abs() <= safe_mps {
            if as_asked {
                Intervention::None
            } else {
                Intervention::Clamped
            }
        } else if safe_mps > 0.0 {
            Intervention::Slowed
        } else {
            Intervention::StoppedShort
        };
        let v_mps = v_mps.clamp(-safe_mps, safe_mps);
        VelocityCommand {
            v_mps,
            w_radps,
            ..stop(Validity::Drive, intervention)
        }
    }

    /// Way that the newest scan leaves straight ahead, or behind for a negative speed. [m]
    fn room_m(&self, v_mps: f64) -> f64 {
        let (Some(scan), Some(robot)) = (self.scan.get(), self.description.get()) else {
            return 0.0;
        };
        let hits = (scan.items.iter().enumerate()).filter(|(_, range)| scan.meta.is_hit(**range));
        let points = hits.map(|(beam, range)| {
            let (sin, cos) = scan.meta.angle_of(beam).sin_cos();
            let in_laser = Pose::new(f64::from(*range) * cos, f64::from(*range) * sin, 0.0);
            robot.meta.base_from_laser.then(&in_laser)
        });
        let nearest_m = points
            .filter(|point| point.y_m.abs() < robot.meta.inscribed_radius_m)
            .map(|point| point.x_m.copysign(point.x_m * v_mps))
            .filter(|ahead_m| *ahead_m > 0.0)
            .fold(f64::INFINITY, f64::min);
        (nearest_m - robot.meta.circumscribed_radius_m - MARGIN_M).max(0.0)
    }
}

fn main() -> ExitCode {
    zeronav_shell::run::<MinimalGuard>()
}
