//! The guard as a process: answers every velocity request, and odometry that no request follows.

use std::process::ExitCode;
use zeronav_collision_guard::{Guard, GuardConfig, GuardInputs, OdometryInput, ScanInput};
use zeronav_msgs::command::Intervention;
use zeronav_msgs::header::Parents;
use zeronav_msgs::health::{REASON_ODOMETRY, REASON_REQUEST, REASON_SCAN};
use zeronav_msgs::role::Role;
use zeronav_msgs::span::SpanKind;
use zeronav_msgs::topics::{
    ControlRequest, RobotCommand, RobotDescription, RobotOdometry, RobotScan,
};
use zeronav_params::Parameter;
use zeronav_shell::clock::now_ns;
use zeronav_shell::doorbell::Rung;
use zeronav_shell::{Cycle, Latest, Service, Shell, Stamp, StartError, Stream, Track, Writer};

/// How long after odometry the guard waits for the request that belongs to it. [ns]
const PATIENCE_NS: u64 = 5_000_000;

struct GuardService {
    guard: Guard,
    /// Until it has been checked against the periods of the run.
    config: Option<GuardConfig>,
    description: Latest<RobotDescription>,
    odometry: Stream<RobotOdometry>,
    scan: Latest<RobotScan>,
    request: Latest<ControlRequest>,
    command: Writer<RobotCommand>,
    track: Track,
    /// When the newest message of each kind came in, by this process's own clock. [ns]
    odometry_came_ns: u64,
    scan_came_ns: u64,
    request_came_ns: u64,
    answered_tick: u64,
    idle_said: bool,
    /// Of the last command, to tell when it changes.
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
            description: peer.latest()?,
            odometry: peer.stream()?,
            scan: peer.latest()?,
            request: peer.latest()?,
            command: peer.writer(1)?,
            track: Track::default(),
            odometry_came_ns: 0,
            scan_came_ns: 0,
            request_came_ns: 0,
            answered_tick: 0,
            idle_said: false,
            intervention: Some(Intervention::None),
        })
    }

    fn wake(&mut self, shell: &mut Shell, _rung: Rung) -> Result<Option<u64>, StartError> {
        let roster = shell.roster();
        // Odometry first: in lockstep it carries the tick, and whatever was sent before it (its
        // scan, the description) is then surely found by the others.
        let mut moved = false;
        let track = &mut self.track;
        self.odometry.drain(roster, |view| {
            track.push(view.header, view.meta);
            moved = true;
        });
        self.description.poll(roster);
        let asked = self.request.poll(roster);
        if self.scan.poll(roster) {
            self.scan_came_ns = shell.woken_ns();
        }
        if moved {
            self.odometry_came_ns = shell.woken_ns();
        }
        if asked {
            self.request_came_ns = shell.woken_ns();
        }
        shell.totals(
            self.odometry.refused() + self.scan.refused() + self.request.refused(),
            self.scan.superseded() + self.request.superseded(),
        );
        self.check_config(shell)?;
        if !self.idle_said && shell.roster().has_clock() {
            self.answer(shell, 0, SpanKind::Idle);
            self.idle_said = true;
            shell.ready();
        }
        if shell.roster().lockstep() {
            self.lockstep(shell);
            return Ok(None);
        }
        let tick = self.track.newest().map_or(0, |moment| moment.tick);
        let due_ns = self.odometry_came_ns + PATIENCE_NS;
        if asked && tick > 0 {
            let kind = if tick > self.answered_tick {
                SpanKind::Answer
            } else {
                SpanKind::Extra
            };
            self.answer(shell, tick, kind);
        } else if tick > self.answered_tick && now_ns() < due_ns {
            return Ok(Some(due_ns));
        } else if tick > self.answered_tick {
            self.answer(shell, tick, SpanKind::Answer);
        }
        Ok(None)
    }

    fn is_at_rest(&self) -> bool {
        self.track.is_at_rest()
    }
}

impl GuardService {
    /// Refuses ages that would run out in normal operation, once the periods are known.
    #[allow(clippy::cast_precision_loss, reason = "periods far below 2^53 ns")]
    fn check_config(&mut self, shell: &Shell) -> Result<(), StartError> {
        let (Some(config), Some(description)) = (self.config, self.description.get()) else {
            return Ok(());
        };
        if !shell.roster().has_clock() {
            return Ok(());
        }
        let period_s = shell.roster().clock.tick_ns as f64 * 1.0e-9;
        let scan_period_s = description.meta.scan_period_ns as f64 * 1.0e-9;
        config.check(period_s, scan_period_s)?;
        self.config = None;
        tracing::info!(period_s, scan_period_s, "the guard begins");
        Ok(())
    }

    /// Answers the newest tick once, after the local planner if that has to answer it.
    fn lockstep(&mut self, shell: &mut Shell) {
        let Some(tick) = self.track.newest().map(|moment| moment.tick) else {
            return;
        };
        let roster = shell.roster();
        let waits = roster.answers(Role::LocalPlanner, tick) && self.request.spoken_tick() < tick;
        if tick > self.answered_tick && !waits && roster.answers(Role::CollisionGuard, tick) {
            self.answer(shell, tick, SpanKind::Answer);
        }
    }

    fn answer(&mut self, shell: &mut Shell, tick: u64, kind: SpanKind) {
        let lockstep = shell.roster().lockstep();
        let tick_ns = shell.roster().clock.tick_ns;
        let run_ns = tick.saturating_mul(tick_ns);
        let now_ns = now_ns();
        // A message is as old as its arrival, a scan as its capture.
        let age_ns = |message_run_ns: u64, came_ns: u64| {
            let stamp = Stamp {
                tick,
                run_ns: message_run_ns,
                capture_ns: came_ns,
                came_ns,
            };
            stamp.age_ns(lockstep, run_ns, now_ns)
        };
        let moment = self.track.newest();
        let scan = self.scan.get();
        let request = self.request.get();
        let parents = Parents {
            odometry: moment.map_or(0, |moment| moment.id.0),
            scan: scan.map_or(0, |view| view.header.id),
            request: request.map_or(0, |view| view.header.id),
            ..Parents::default()
        };
        let capture_ns = scan.map_or(0, |view| view.header.capture_ns);
        let draft = shell.draft(tick, run_ns, capture_ns, parents);
        let description = self.description.get();
        let command = self.guard.decide(&GuardInputs {
            robot: description.as_ref().map(|view| (view.meta, view.items)),
            request: request
                .map(|view| (*view.meta, age_ns(view.header.run_ns, self.request_came_ns))),
            scan: scan.map(|view| {
                let came_ns = self.scan_came_ns.min(view.header.capture_ns);
                ScanInput {
                    scan: view.meta,
                    ranges: view.items,
                    id: view.header.id,
                    run_ns: view.header.run_ns,
                    age_ns: age_ns(view.header.run_ns, came_ns),
                    odom_from_base: self.track.pose_at(view.header.run_ns),
                }
            }),
            odometry: moment.map(|moment| OdometryInput {
                odometry: &moment.odometry,
                id: moment.id.0,
                run_ns: moment.run_ns,
                age_ns: age_ns(moment.run_ns, self.odometry_came_ns),
            }),
            period_ns: tick
                .saturating_sub(self.answered_tick)
                .saturating_mul(tick_ns),
            stopping: shell.roster().control.stopping == 1,
        });
        let sent = self.command.publish(&draft, command, &[]);
        self.answered_tick = self.answered_tick.max(tick);
        let intervention = command.intervention();
        if intervention != self.intervention {
            self.intervention = intervention;
            let name = intervention.map_or("unknown", Intervention::label);
            tracing::info!(
                tick,
                intervention = name,
                v_mps = command.v_mps,
                w_radps = command.w_radps
            );
        }
        shell.reason(
            REASON_REQUEST,
            intervention == Some(Intervention::RequestStale),
        );
        shell.reason(REASON_SCAN, intervention == Some(Intervention::ScanStale));
        shell.reason(
            REASON_ODOMETRY,
            intervention == Some(Intervention::OdometryStale),
        );
        let output = shell.sent(&self.command, sent);
        shell.finish(&Cycle {
            kind,
            draft,
            output,
            work: 0,
        });
    }
}

fn main() -> ExitCode {
    zeronav_shell::run::<GuardService>()
}
