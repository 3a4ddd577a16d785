//! A minimal robot: a unicycle that takes on every commanded speed at once, in an empty world.

use serde::{Deserialize, Serialize};
use std::process::ExitCode;
use zeronav_msgs::command::Validity;
use zeronav_msgs::description::{Corner, Description, FOOTPRINT_CORNERS_MAX};
use zeronav_msgs::header::Parents;
use zeronav_msgs::odometry::Odometry;
use zeronav_msgs::pose::{Pose, wrap_angle};
use zeronav_msgs::role::Role;
use zeronav_msgs::scan::Scan;
use zeronav_msgs::span::SpanKind;
use zeronav_msgs::time::{nanoseconds, seconds};
use zeronav_msgs::topics::{GroundTruth, RobotCommand, RobotDescription, RobotOdometry, RobotScan};
use zeronav_msgs::truth::Truth;
use zeronav_robot_description::RobotSpec;
use zeronav_shell::clock::now_ns;
use zeronav_shell::doorbell::Rung;
use zeronav_shell::records::SpanReader;
use zeronav_shell::{Due, Latest, Service, Shell, StartError, Writer};
use zeronav_world::SpecError;

/// The scenario's robot; its world is ignored.
#[derive(Debug, Serialize, Deserialize)]
struct Config {
    start: [f64; 3],
    robot: RobotSpec,
    /// A real robot has no truth to tell.
    #[serde(default)]
    is_real: bool,
}

struct MinimalRobot {
    description: Description,
    corners: Vec<Corner>,
    command_timeout_ns: u64,
    odometry: Odometry,
    truth: Truth,
    description_writer: Writer<RobotDescription>,
    scan_writer: Writer<RobotScan>,
    odometry_writer: Writer<RobotOdometry>,
    truth_writer: Option<Writer<GroundTruth>>,
    command: Latest<RobotCommand>,
    command_came_ns: u64,
    spans: SpanReader,
    /// Highest tick that each role has answered, by its code; lockstep only.
    answered: [u64; 16],
    tick: u64,
    /// Run time at which the next scan is due. [ns]
    scan_due_ns: u64,
    scan_tick: u64,
    /// When the next tick is due, real time only. [ns]
    due_ns: u64,
}

impl Service for MinimalRobot {
    const ROLE: Role = Role::Robot;
    type Config = Config;

    fn open(shell: &mut Shell, config: Config) -> Result<Self, StartError> {
        let unusable = |error: SpecError| StartError::Usage(format!("configuration: {error}"));
        config.robot.check().map_err(unusable)?;
        let outline = config.robot.footprint().map_err(unusable)?;
        let (robot, lidar) = (&config.robot, &config.robot.lidar);
        let (angle_min_rad, angle_increment_rad) = lidar.directions_rad();
        let corners: Vec<Corner> = (outline.corners().iter())
            .map(|corner| Corner {
                x_m: corner.x,
                y_m: corner.y,
            })
            .collect();
        let [x_m, y_m, yaw_rad] = config.start;
        let [laser_x_m, laser_y_m, laser_yaw_rad] = lidar.pose;
        let pose = Pose::new(x_m, y_m, yaw_rad);
        let peer = shell.peer();
        Ok(Self {
            description: Description {
                inscribed_radius_m: outline.inscribed_radius_m(),
                circumscribed_radius_m: outline.circumscribed_radius_m(),
                v_mps_max: robot.v_mps_max,
                v_mps_min: robot.v_mps_min,
                w_radps_max: robot.w_radps_max,
                a_mps2_max: robot.a_mps2_max,
                brake_mps2: robot.reliable_brake_mps2(),
                alpha_radps2_max: robot.alpha_radps2_max,
                base_from_laser: Pose::new(laser_x_m, laser_y_m, laser_yaw_rad),
                angle_min_rad,
                angle_increment_rad,
                range_m_min: lidar.range_m_min,
                range_m_max: lidar.range_m_max,
                scan_period_ns: nanoseconds(1.0 / lidar.rate_hz),
                actuation_delay_ns: 0,
                n_beams: lidar.n_beams,
                n_corners: u32::try_from(corners.len()).unwrap_or(u32::MAX),
            },
            corners,
            command_timeout_ns: nanoseconds(robot.command_timeout_s),
            odometry: Odometry {
                pose,
                ..Odometry::default()
            },
            truth: Truth {
                clearance_m: 1000.0,
                ..Truth::default()
            },
            description_writer: peer.writer(FOOTPRINT_CORNERS_MAX)?,
            scan_writer: peer.writer(lidar.n_beams as usize)?,
            odometry_writer: peer.writer(1)?,
            truth_writer: (!config.is_real).then(|| peer.writer(1)).transpose()?,
            command: peer.latest()?,
            command_came_ns: 0,
            spans: peer.span_reader()?,
            answered: [0; 16],
            tick: 0,
            scan_due_ns: 0,
            scan_tick: 0,
            due_ns: 0,
        })
    }

    fn wake(&mut self, shell: &mut Shell, _rung: Rung) -> Result<(), StartError> {
        if self.due_ns == 0 {
            let draft = shell.begin(Due::IDLE, 0, 0, Parents::default());
            let (writer, robot) = (&mut self.description_writer, self.description);
            shell.answer(&draft, writer, robot, &self.corners);
            self.due_ns = now_ns() + shell.roster().clock.tick_ns;
        }
        self.description_writer.refresh();
        // A span is written after the messages of its answer: spans are read before commands.
        let answered = &mut self.answered;
        self.spans.drain(|span| {
            if let (Some(SpanKind::Answer), Some(tick)) =
                (span.kind(), answered.get_mut(usize::from(span.role)))
            {
                *tick = span.tick.max(*tick);
            }
        });
        self.take_command(shell);
        let (control, tick_ns) = (shell.roster().control, shell.roster().clock.tick_ns);
        if shell.roster().lockstep() {
            if control.paused == 0 && self.tick < control.lease && self.all_answered(shell) {
                self.tick(shell);
            }
            return Ok(());
        }
        let now = now_ns();
        if control.paused == 1 {
            self.due_ns = now + tick_ns;
        } else if now >= self.due_ns {
            self.tick(shell);
            // Late ticks are not caught up: run time slips.
            let next_ns = self.due_ns + tick_ns;
            self.due_ns = next_ns.max(now_ns());
            self.truth.slipped_ns += self.due_ns - next_ns;
            shell.slipped(self.truth.slipped_ns);
        }
        shell.wake_by(self.due_ns);
        Ok(())
    }
}

impl MinimalRobot {
    /// Takes on the newest command.
    fn take_command(&mut self, shell: &mut Shell) {
        if !self.command.poll(shell.roster()) {
            return;
        }
        shell.count(&[&self.command]);
        let Some(command) = self.command.get() else {
            return;
        };
        let header = command.header;
        let lockstep = shell.roster().lockstep();
        self.command_came_ns = if lockstep {
            header.run_ns
        } else {
            shell.woken_ns()
        };
        let drives = command.meta.validity() != Some(Validity::NoRequest);
        self.odometry.v_mps = if drives { command.meta.v_mps } else { 0.0 };
        self.odometry.w_radps = if drives { command.meta.w_radps } else { 0.0 };
        if !lockstep {
            let parents = Parents {
                request: header.id,
                ..Parents::default()
            };
            let due = Due {
                tick: header.tick,
                kind: SpanKind::Applied,
            };
            let draft = shell.begin(due, header.run_ns, header.capture_ns, parents);
            shell.finish(&draft, None, 0);
        }
    }

    /// True when every seat of the roster has answered what it owes.
    fn all_answered(&self, shell: &Shell) -> bool {
        let all_but_us = Role::SERVICES.iter().filter(|role| **role != Self::ROLE);
        all_but_us.copied().all(|role| {
            let of_scans = matches!(role, Role::Mapping | Role::GlobalPlanner);
            let owed = if of_scans { self.scan_tick } else { self.tick };
            let answered = self.answered[usize::from(role.code())];
            !shell.roster().answers(role, owed) || answered >= owed
        })
    }

    /// One tick: moves, measures, sends.
    fn tick(&mut self, shell: &mut Shell) {
        let tick_ns = shell.roster().clock.tick_ns;
        let (tick, seen_ns) = (self.tick + 1, now_ns());
        let run_ns = tick.saturating_mul(tick_ns);
        let began_ns = if shell.roster().lockstep() {
            run_ns - tick_ns
        } else {
            seen_ns
        };
        if began_ns.saturating_sub(self.command_came_ns) > self.command_timeout_ns {
            (self.odometry.v_mps, self.odometry.w_radps) = (0.0, 0.0);
        }
        self.tick = tick;
        self.drive(seconds(tick_ns));
        let scan_due = run_ns >= self.scan_due_ns;
        self.odometry.scan_due = u32::from(scan_due);
        let mut parents = Parents {
            odometry: self.odometry_writer.next_id().0,
            ..Parents::default()
        };
        let due = Due {
            tick,
            kind: SpanKind::Answer,
        };
        let mut draft = shell.begin(due, run_ns, seen_ns, parents);
        if scan_due {
            self.scan_tick = tick;
            self.scan_due_ns += self.description.scan_period_ns;
            let n_beams = self.description.n_beams as usize;
            let scan = self.scan();
            let sent = shell.send_with(&draft, &mut self.scan_writer, n_beams, |ranges| {
                ranges.fill(f32::INFINITY);
                scan
            });
            parents.scan = sent.map_or(0, |sent| sent.id.0);
            draft.parents = parents;
        }
        let (writer, odometry) = (&mut self.odometry_writer, self.odometry);
        shell.answer(&draft, writer, odometry, &[]);
        if scan_due {
            self.truth.scan = parents.scan;
            draft.hashed = false;
            if let Some(writer) = &mut self.truth_writer {
                writer.publish(&draft, self.truth, &[]);
            }
        }
    }

    /// Moves along the arc of one tick. Nothing slips, so odometry is the truth.
    fn drive(&mut self, tick_s: f64) {
        let Odometry {
            pose,
            v_mps,
            w_radps,
            ..
        } = self.odometry;
        let middle_rad = pose.yaw_rad + 0.5 * w_radps * tick_s;
        let way_m = v_mps * tick_s;
        self.odometry.pose = Pose {
            x_m: pose.x_m + way_m * middle_rad.cos(),
            y_m: pose.y_m + way_m * middle_rad.sin(),
            yaw_rad: wrap_angle(pose.yaw_rad + w_radps * tick_s),
        };
        self.truth = Truth {
            pose: self.odometry.pose,
            v_mps,
            w_radps,
            driven_m: self.truth.driven_m + way_m.abs(),
            ..self.truth
        };
    }

    #[allow(
        clippy::cast_possible_truncation,
        reason = "the contract has angles and ranges in f32"
    )]
    fn scan(&self) -> Scan {
        Scan {
            n_beams: self.description.n_beams,
            angle_min_rad: self.description.angle_min_rad as f32,
            angle_increment_rad: self.description.angle_increment_rad as f32,
            range_m_min: self.description.range_m_min as f32,
            range_m_max: self.description.range_m_max as f32,
            ..Scan::default()
        }
    }
}

fn main() -> ExitCode {
    zeronav_shell::run::<MinimalRobot>()
}
