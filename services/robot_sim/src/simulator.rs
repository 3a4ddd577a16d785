//! The simulated robot: world, body, motors and lidar, one tick after the other.

mod foresee;

use crate::config::SimConfig;
use crate::contact::Body;
use crate::delay::Delay;
use crate::describe::{describe, limits_of};
use crate::drive::{DriveLimits, Motion};
use crate::drive_state::DriveState;
use crate::faults::Faults;
use crate::history::{History, Stretch};
use crate::lidar::Lidar;
use crate::obstacles::Obstacle;
use crate::odometer::{Odometer, WheelMotion};
use crate::placing::Pending;
use crate::scan_schedule::{DueScan, ScanSchedule};
use crate::slip::{Grip, Slip};
use crate::solid_grid::SolidGrid;
use zeronav_motion::Twist;
use zeronav_msgs::description::{Corner, Description};
use zeronav_msgs::odometry::Odometry;
use zeronav_msgs::pose::wrap_angle;
use zeronav_msgs::scan::Scan;
use zeronav_msgs::time::{nanoseconds, seconds};
use zeronav_msgs::truth::{Placement, Truth, TruthObstacle};
use zeronav_msgs::{Pose, Refusal};
use zeronav_robot_description::{FaultSpec, OdometrySpec, RobotSpec};
use zeronav_world::{Footprint, SpecError, World};

/// Largest clearance that is told apart. [m]
const CLEARANCE_M_MAX: f64 = 1.0e3;

/// What rounding may add to the way of an obstacle. [m]
const REACH_SLACK_M: f64 = 1.0e-6;

/// Shortest tick. [ns]
pub const TICK_NS_MIN: u64 = 100_000;

/// Shortest and longest tick. [ns]
const TICK_NS: core::ops::RangeInclusive<u64> = TICK_NS_MIN..=1_000_000_000;

/// Why a robot cannot be simulated.
#[derive(Debug, thiserror::Error)]
pub enum SimError {
    /// There is no such robot.
    #[error("robot.{0}")]
    Robot(#[from] SpecError),
    /// The robot's description would break the contract.
    #[error("robot: {0}")]
    Description(Refusal),
    /// The start is no pose.
    #[error("{0}")]
    Start(Refusal),
    /// The robot would start in contact.
    #[error("start: the robot touches {0} there")]
    StartBlocked(String),
    /// The tick is shorter than 0.1 ms or longer than 1 s.
    #[error("a tick of {0} ns, must be 100000 to 1000000000 ns")]
    Tick(u64),
    /// More scans than ticks.
    #[error("robot.lidar.rate_hz: {rate_hz} scans a second are more than ticks of {tick_ns} ns")]
    ScanRate {
        /// Turns of the lidar per second. [Hz]
        rate_hz: f64,
        /// Length of a tick. [ns]
        tick_ns: u64,
    },
}

/// A robot in its world. The same seed and the same sequence of calls give the same bits.
#[derive(Debug, Clone)]
pub struct Simulator {
    world: World,
    /// The occupied cells of the map file.
    grid: Option<SolidGrid>,
    obstacles: Vec<Obstacle>,
    placements: Pending,
    description: Description,
    corners: Vec<Corner>,
    body: Body,
    lidar: Lidar,
    schedule: ScanSchedule,
    /// Limits under a command, and when the robot brakes by itself.
    limits: DriveLimits,
    limits_alone: DriveLimits,
    command_timeout_ns: u64,
    tick_ns: u64,
    commands: Delay,
    slip: Option<Slip>,
    faults: Faults,
    /// `None` when odometry is the truth.
    odometer: Option<Odometer>,
    /// What the wheels do; they may slip on the ground.
    wheels: Twist,
    /// On the ground.
    state: DriveState,
    run_ns: u64,
    driven_m: f64,
    due: Option<DueScan>,
    /// Where the robot has been since the scan that is due began.
    history: History,
    /// Beams of this tick's scan on each obstacle.
    beams_on: Vec<u32>,
}

impl Simulator {
    /// The robot of `config` at its start, stopped, in `world`, which is that of `config` with its
    /// files read. `seed` draws all noise; a tick lasts `tick_ns`.
    ///
    /// # Errors
    /// See [`SimError`].
    pub fn new(
        config: &SimConfig,
        world: World,
        seed: u64,
        tick_ns: u64,
    ) -> Result<Self, SimError> {
        config.robot.check()?;
        if !TICK_NS.contains(&tick_ns) {
            return Err(SimError::Tick(tick_ns));
        }
        let footprint = config.robot.footprint()?;
        let lidar = Lidar::new(&config.robot.lidar, seed);
        let sweep_ns = lidar.sweep_ns();
        let rate_hz = config.robot.lidar.rate_hz;
        let schedule = ScanSchedule::new(rate_hz)
            .filter(|schedule| schedule.period_ns() >= tick_ns)
            .ok_or(SimError::ScanRate { rate_hz, tick_ns })?;
        let corners: Vec<Corner> = footprint
            .corners()
            .iter()
            .map(|corner| Corner {
                x_m: corner.x,
                y_m: corner.y,
            })
            .collect();
        let description = describe(&config.robot, &footprint, &lidar, &schedule, tick_ns);
        description.check(&corners).map_err(SimError::Description)?;

        let [x_m, y_m, yaw_rad] = config.start;
        let start = Pose::new(x_m, y_m, yaw_rad);
        start.check("start").map_err(SimError::Start)?;
        let start = Pose::new(x_m, y_m, wrap_angle(yaw_rad));
        let obstacles: Vec<Obstacle> = world.obstacles().iter().map(Obstacle::new).collect();
        check_start(&footprint, &start, &world, &obstacles)?;

        let limits = limits_of(&config.robot);
        Ok(Self {
            grid: world.static_map().map(SolidGrid::new),
            beams_on: vec![0; obstacles.len()],
            obstacles,
            placements: Pending::default(),
            world,
            description,
            corners,
            body: Body::new(footprint),
            lidar,
            schedule,
            limits_alone: DriveLimits {
                slow_down_mps2: description.brake_mps2,
                ..limits
            },
            limits,
            command_timeout_ns: nanoseconds(config.robot.command_timeout_s),
            tick_ns,
            commands: Delay::new(nanoseconds(config.robot.actuation_delay_s)),
            slip: config.robot.slip.map(|slip| Slip::new(slip, seed)),
            faults: Faults::new(&config.robot.faults, config.robot.lidar.n_beams as usize),
            odometer: odometer_of(&config.robot, seed, start),
            wheels: Twist::REST,
            history: History::new(start, sweep_ns),
            state: DriveState {
                pose: start,
                twist: Twist::REST,
            },
            run_ns: 0,
            driven_m: 0.0,
            due: None,
        })
    }

    /// What the robot is: the message and its corners.
    #[must_use]
    pub fn description(&self) -> (Description, Vec<Corner>) {
        (self.description, self.corners.clone())
    }

    /// Number of beams of a scan.
    #[must_use]
    pub const fn n_beams(&self) -> usize {
        self.description.n_beams as usize
    }

    /// Run time of the last step; 0 before the first. [ns]
    #[must_use]
    pub const fn run_ns(&self) -> u64 {
        self.run_ns
    }

    /// A set point has reached the robot, `base` frame. It is clamped to the robot's limits; NaN
    /// in either number is a stop. The motors obey after the robot's actuation delay.
    pub fn set_command(&mut self, v_mps: f64, w_radps: f64) {
        let set_point = self.limits.clamp(Twist { v_mps, w_radps });
        self.commands.push(self.run_ns, Some(set_point));
    }

    /// There is no set point any more: the robot brakes as it does when commands are too old.
    pub fn no_command(&mut self) {
        self.commands.push(self.run_ns, None);
    }

    /// Puts an obstacle of the scenario's list somewhere for a time. Until its `from_run_ns` the
    /// obstacle does what it did before; one that was due already appears with the next step. An
    /// index just behind the list adds an obstacle; farther ones mean nothing.
    pub fn place(&mut self, placement: &Placement) {
        self.placements
            .take(&mut self.obstacles, placement, self.run_ns);
        self.beams_on.resize(self.obstacles.len(), 0);
    }

    /// A step, which ends at `run_ns` and begins where the last one ended, but at most a tick
    /// earlier. A tick is one step, or two when its scan is taken between two ticks.
    ///
    /// The robot changes its velocity towards the set point: away from zero with `a_mps2_max`,
    /// towards zero with the larger of that and `brake_mps2`, so that no command stops it worse than
    /// the guard relies on. When the last command is older than the robot's timeout it stops with
    /// `brake_mps2` alone. `command_age_ns` is the age of the last command at the start of the step.
    pub fn step(&mut self, run_ns: u64, command_age_ns: u64) {
        let from_run_ns = run_ns.saturating_sub(self.tick_ns).max(self.run_ns);
        self.placements.apply(&mut self.obstacles, run_ns);
        self.beams_on.resize(self.obstacles.len(), 0);
        for obstacle in &mut self.obstacles {
            obstacle.look_ahead(&self.world, run_ns);
        }
        let (target, limits) = match self.commands.set_point(from_run_ns) {
            Some(set_point) if command_age_ns <= self.command_timeout_ns => {
                (set_point, &self.limits)
            }
            _ => (Twist::REST, &self.limits_alone),
        };
        let duration_s = seconds(run_ns - from_run_ns);
        let start = DriveState {
            pose: self.state.pose,
            twist: self.wheels,
        };
        let wheels = Motion::towards(start, target, limits, duration_s);
        self.faults.notice(from_run_ns, self.driven_m);
        let own = self.slip.map_or(Grip::FULL, |slip| slip.at(from_run_ns));
        let grip = own.and(self.faults.grip(from_run_ns));
        let motion = if grip == Grip::FULL {
            wheels
        } else {
            wheels.slipped(grip.forward, grip.turn)
        };
        let advance = self
            .body
            .advance(&motion, &self.world, &self.obstacles, from_run_ns);
        self.state = advance.end;
        self.driven_m += advance.driven_m;
        self.run_ns = run_ns;
        // What stops the robot stops its wheels.
        let moved_s = advance.stopped.map_or(duration_s, |(at_s, _)| at_s);
        self.wheels = match advance.stopped {
            Some(_) => Twist::REST,
            None => wheels.at(duration_s).twist,
        };
        if let Some(odometer) = &mut self.odometer {
            let shift = seen_from(&start.pose, &wheels.at(moved_s).pose);
            let motion = WheelMotion {
                shift,
                turned_rad: wrap_angle(self.state.pose.yaw_rad - start.pose.yaw_rad),
                distance_m: wheels.driven_m(moved_s),
            };
            odometer.count(&motion, run_ns);
            if let Some(shift) = self.faults.take_jump(run_ns) {
                odometer.jump(&shift);
            }
        }
        self.history.push(Stretch {
            from_run_ns,
            to_run_ns: run_ns,
            motion,
            stopped: advance.stopped,
        });
        self.due = self.schedule.due(from_run_ns, run_ns);
        for obstacle in &mut self.obstacles {
            obstacle.notice(self.state.pose.point(), run_ns);
        }
        if self
            .body
            .settle(&self.state, &self.world, &self.obstacles, run_ns)
        {
            self.state.twist = Twist::REST;
            self.wheels = Twist::REST;
        }
        self.beams_on.fill(0);
    }

    /// Run time of the first scan that is captured after the last step and up to `run_ns`. [ns]
    #[must_use]
    pub fn next_capture_run_ns(&self, run_ns: u64) -> Option<u64> {
        let due = self.schedule.due(self.run_ns, run_ns)?;
        Some(due.capture_run_ns)
    }

    /// The scan that fell due in the last step and is sent, with the exact run time of its capture.
    #[must_use]
    pub fn scan_due(&self) -> Option<DueScan> {
        let sent = |due: &DueScan| !self.faults.is_silent(due.capture_run_ns);
        self.due.filter(sent)
    }

    /// True when the last step is one of the lidar's rate, sent or not.
    #[must_use]
    pub const fn truth_due(&self) -> bool {
        self.due.is_some()
    }

    /// Takes the scan that fell due in the last step, of the world and from the pose at its
    /// capture; `None` when none did or it is not sent, and `ranges` stays as it is. Taking it again gives the same
    /// bits. No allocation.
    ///
    /// # Panics
    /// When `ranges` has not [`Self::n_beams`] places.
    pub fn scan(&mut self, ranges: &mut [f32]) -> Option<Scan> {
        let due = self.scan_due()?;
        let capture_run_ns = due.capture_run_ns;
        self.lidar.turn(self.faults.turned_rad(capture_run_ns));
        let history = &self.history;
        let sweep_ns = self.lidar.sweep_ns();
        // Before the run everything stood.
        let at = |age_ns: u64| capture_run_ns.saturating_sub(age_ns);
        let mut exposure = if sweep_ns == 0 {
            self.lidar.expose(&history.at(capture_run_ns))
        } else {
            self.lidar.sweep(|age_ns| history.at(at(age_ns)))
        };
        for shape in self.world.shapes() {
            exposure.add_shape(shape.placed(), None);
        }
        for (tag, obstacle) in (0..).zip(&self.obstacles) {
            if sweep_ns == 0 {
                if obstacle.exists_at(capture_run_ns) {
                    exposure.add_shape(&obstacle.placed_at(capture_run_ns), Some(tag));
                }
                continue;
            }
            let (first_ns, middle_ns) = (at(sweep_ns), at(sweep_ns / 2));
            let there = |run_ns| obstacle.exists_at(run_ns);
            let jumps = obstacle
                .next_jump_run_ns(first_ns)
                .is_some_and(|jump_ns| jump_ns <= capture_run_ns);
            if jumps || there(first_ns) || there(capture_run_ns) {
                let reach_m = if jumps {
                    f64::INFINITY
                } else {
                    obstacle.speed_mps() * seconds(sweep_ns) * 0.5 + REACH_SLACK_M
                };
                let placed = obstacle.placed_at(middle_ns);
                exposure.add_moving(&placed, reach_m, tag, |age_ns| {
                    let run_ns = at(age_ns);
                    there(run_ns).then(|| obstacle.placed_at(run_ns))
                });
            }
        }
        if let Some(grid) = &self.grid {
            exposure.add_grid(grid);
        }
        self.beams_on.fill(0);
        let scan = exposure.finish(due.index, ranges, &mut self.beams_on);
        if !self.faults.spoil(capture_run_ns, ranges) {
            self.beams_on.fill(0);
        }
        Some(scan)
    }

    /// Odometry at the end of the last tick: what the wheels say, and the gyro. Without slip, errors
    /// of odometry and faults that mislead it, it is the truth, `odom` is `map` and the variances
    /// are 0.
    #[must_use]
    pub fn odometry(&self) -> Odometry {
        let wheels_radps = self.wheels.w_radps;
        let (pose, w_radps, variance) = match &self.odometer {
            Some(odometer) => (
                odometer.pose(),
                odometer.w_radps(wheels_radps, self.state.twist.w_radps),
                odometer.variance(),
            ),
            None => (self.state.pose, wheels_radps, [0.0; 3]),
        };
        Odometry {
            pose,
            v_mps: self.wheels.v_mps,
            w_radps,
            variance,
            scan_due: u32::from(self.scan_due().is_some()),
            spare: 0,
        }
    }

    /// The truth at the end of the last tick. `obstacles` becomes those that exist, with the beams
    /// of this tick's scan on them once [`Self::scan`] has been called.
    ///
    /// Whoever has a clock and message ids fills in what the simulator cannot know and leaves 0:
    /// [`Truth::scan`], [`Truth::slipped_ns`], [`TruthObstacle::appeared_ns`].
    pub fn truth(&mut self, obstacles: &mut Vec<TruthObstacle>) -> Truth {
        obstacles.clear();
        for ((index, obstacle), beams) in (0..).zip(&self.obstacles).zip(&self.beams_on) {
            // One that was seen has vanished since at the most.
            let (true, Some(appeared_run_ns)) = (
                obstacle.exists_at(self.run_ns) || *beams > 0,
                obstacle.appears_run_ns(),
            ) else {
                continue;
            };
            obstacles.push(TruthObstacle {
                index,
                beams: *beams,
                appeared_run_ns,
                appeared_ns: 0,
                pose: obstacle.pose_at(self.run_ns),
            });
        }
        Truth {
            pose: self.state.pose,
            v_mps: self.state.twist.v_mps,
            w_radps: self.state.twist.w_radps,
            clearance_m: self.body.clearance_m(
                &self.state.pose,
                &self.world,
                &self.obstacles,
                self.run_ns,
                CLEARANCE_M_MAX,
            ),
            driven_m: self.driven_m,
            in_contact: u32::from(self.body.in_contact()),
            contacts_moving: self.body.contacts_moving(),
            contacts_standing: self.body.contacts_standing(),
            n_obstacles: u32::try_from(obstacles.len()).unwrap_or(u32::MAX),
            scan: 0,
            slipped_ns: 0,
        }
    }
}

/// The odometer of a robot whose odometry is not the truth.
fn odometer_of(robot: &RobotSpec, seed: u64, start: Pose) -> Option<Odometer> {
    const EXACT: OdometrySpec = OdometrySpec {
        distance_per_distance: 0.0,
        distance_per_turn: 0.0,
        turn_per_turn: 0.0,
        turn_per_distance: 0.0,
        gyro: false,
    };
    let misled = robot.slip.is_some() || robot.faults.iter().any(FaultSpec::misleads_odometry);
    let errs = robot.odometry.or(misled.then_some(EXACT));
    errs.map(|errs| Odometer::new(errs, seed, start))
}

/// `pose` in the frame of `frame`.
fn seen_from(frame: &Pose, pose: &Pose) -> Pose {
    let shift = pose.point() - frame.point();
    let (sin, cos) = frame.yaw_rad.sin_cos();
    Pose::new(
        cos * shift.x + sin * shift.y,
        cos * shift.y - sin * shift.x,
        wrap_angle(pose.yaw_rad - frame.yaw_rad),
    )
}

/// Refuses a start in contact: it would count as the first contact of the run.
fn check_start(
    footprint: &Footprint,
    start: &Pose,
    world: &World,
    obstacles: &[Obstacle],
) -> Result<(), SimError> {
    let placed = footprint.placed(start);
    if Body::touches(world.convex_distance_m(&placed, 1.0)) {
        return Err(SimError::StartBlocked("something static".to_owned()));
    }
    for (obstacle, described) in obstacles.iter().zip(world.obstacles()) {
        if obstacle.exists_at(0) && Body::touches(placed.distance_m(&obstacle.placed_at(0))) {
            let name = described.spec.name.clone();
            return Err(SimError::StartBlocked(name));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests;
