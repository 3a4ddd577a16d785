//! One run: the simulated robot drives by script, mapping takes in what it sees.

use super::cases::Case;
use super::course::Course;
use super::plan::Plan;
use super::score::{Score, Truth};
use super::tally::{AHEAD_S, Tally};
use super::way::Shuttle;
use nalgebra::Isometry2;
use zeronav_mapping::{Mapping, MappingConfig, Observation};
use zeronav_measure::BEAMS_MIN;
use zeronav_msgs::Pose;
use zeronav_msgs::header::Header;
use zeronav_msgs::obstacles::Obstacle;
use zeronav_msgs::time::{nanoseconds, seconds};
use zeronav_msgs::truth::TruthObstacle;
use zeronav_robot_sim::{SimConfig, Simulator};
use zeronav_shell::odometry::OdometryHistory;
use zeronav_world::World;

/// Run time from tick to tick, as by default. [ns]
const TICK_NS: u64 = 20_000_000;

/// What is so near to the lidar, or over it, is touched and no longer looked at. [m]
const TOUCHED_M: f64 = 0.3;

/// A run in its course.
struct Run {
    simulator: Simulator,
    mapping: Mapping,
    courses: Vec<Course>,
    /// How often each obstacle has jumped.
    jumps: Vec<u64>,
    /// Its radius, and how far from the lidar its centre may be to be tracked. [m]
    radius_m: f64,
    range_m_max: f64,
    base_from_laser: Pose,
    odometry: OdometryHistory,
    scan_ns: u64,
    ranges: Vec<f32>,
    true_obstacles: Vec<TruthObstacle>,
    truths: Vec<Truth>,
    tracks: Vec<Obstacle>,
    score: Score,
}

/// Plays a case.
///
/// # Errors
/// One line naming the case.
pub(super) fn play(case: &Case, plan: &Plan) -> Result<Tally, String> {
    let mut run = Run::begin(case, plan).map_err(|problem| format!("{}: {problem}", case.name))?;
    let mut shuttle = case.drives.then(|| Shuttle::new(&case.start, &case.goal));
    let n_ticks = nanoseconds(plan.duration_s) / TICK_NS;
    for tick in 1..=n_ticks {
        let tick_run_ns = tick * TICK_NS;
        if let Some(shuttle) = &mut shuttle {
            let truth = run.simulator.truth(&mut run.true_obstacles);
            let run_s = seconds(run.simulator.run_ns());
            let (v_mps, w_radps) = shuttle.set_point(&truth.pose, run_s);
            run.simulator.set_command(v_mps, w_radps);
        }
        // A scan between two ticks is a step of its own, as in real time.
        let capture_ns = run.simulator.next_capture_run_ns(tick_run_ns);
        for run_ns in capture_ns
            .into_iter()
            .filter(|ns| *ns < tick_run_ns)
            .chain([tick_run_ns])
        {
            run.simulator.step(run_ns, 0);
            run.sense();
        }
    }
    Ok(run.score.finish())
}

impl Run {
    fn begin(case: &Case, plan: &Plan) -> Result<Self, String> {
        let world = World::new(&case.world, None).map_err(|error| error.to_string())?;
        let geometry = *world.geometry();
        let courses: Vec<Course> = world.obstacles().iter().map(Course::new).collect();
        let robot = plan.robot();
        let (range_m_max, laser) = (robot.lidar.range_m_max, robot.lidar.pose);
        let config = SimConfig {
            start: [case.start.x_m, case.start.y_m, case.start.yaw_rad],
            world: case.world.clone(),
            robot,
        };
        let simulator = Simulator::new(&config, world, case.seed, TICK_NS)
            .map_err(|error| error.to_string())?;
        let (description, corners) = simulator.description();
        let (x, y) = (geometry.origin_x_m, geometry.origin_y_m);
        let side_m = |cells: u32| f64::from(cells) * geometry.resolution_m;
        let config = MappingConfig {
            area_m: Some([
                [x, y],
                [x + side_m(geometry.width), y + side_m(geometry.height)],
            ]),
            resolution_m: geometry.resolution_m,
            ..MappingConfig::default()
        };
        let mapping = Mapping::new(&config, None, &description, &corners)
            .map_err(|error| error.to_string())?;
        Ok(Self {
            ranges: vec![0.0; simulator.n_beams()],
            simulator,
            mapping,
            jumps: vec![0; courses.len()],
            courses,
            radius_m: case.radius_m,
            range_m_max: range_m_max.min(config.tracking.range_m_max),
            base_from_laser: Pose::new(laser[0], laser[1], laser[2]),
            odometry: OdometryHistory::default(),
            scan_ns: 0,
            true_obstacles: Vec::new(),
            truths: Vec::new(),
            tracks: Vec::new(),
            score: Score::default(),
        })
    }

    /// Takes in what the sensors measure after a step.
    fn sense(&mut self) {
        let run_ns = self.simulator.run_ns();
        let odometry = self.simulator.odometry();
        let header = Header {
            run_ns,
            ..Header::default()
        };
        self.odometry.push(&header, &odometry, run_ns);
        let Some(scan) = self.simulator.scan(&mut self.ranges) else {
            return;
        };
        let steps = f64::from(scan.n_beams.saturating_sub(1));
        let turn_ns = nanoseconds(steps * f64::from(scan.time_increment_s));
        // The first turn began before the first odometry.
        let first = self.odometry.pose_at(run_ns.saturating_sub(turn_ns));
        self.mapping.take_in(&Observation {
            scan: &scan,
            ranges: &self.ranges,
            run_ns,
            odom_from_base_first: first.unwrap_or(odometry.pose),
            odom_from_base: odometry.pose,
            odometry_variance: odometry.variance,
            goal: None,
            told: None,
        });
        self.tracks.clear();
        self.tracks.extend(self.mapping.obstacles());
        let map_from_base = self.mapping.map_from_odom().0.then(&odometry.pose);
        self.take_truth(run_ns, &map_from_base);
        self.score.add(run_ns, &self.truths, &self.tracks);
    }

    /// What is true of the scan of now, in the map in which the robot is thought to be at
    /// `map_from_base`.
    fn take_truth(&mut self, run_ns: u64, map_from_base: &Pose) {
        let truth = self.simulator.truth(&mut self.true_obstacles);
        let into_map: Isometry2<f64> = map_from_base.isometry() * truth.pose.isometry().inverse();
        let laser = truth.pose.then(&self.base_from_laser).point();
        self.truths.clear();
        for obstacle in &self.true_obstacles {
            let index = obstacle.index as usize;
            let (Some(course), Some(jumps)) = (self.courses.get(index), self.jumps.get_mut(index))
            else {
                continue;
            };
            *jumps += u64::from(self.scan_ns > 0 && course.jumps(self.scan_ns, run_ns));
            let at = obstacle.pose.point();
            let away_m = (at - laser).norm();
            self.truths.push(Truth {
                number: u64::from(obstacle.index) + (*jumps << 32),
                seen: obstacle.beams >= BEAMS_MIN
                    && (self.radius_m + TOUCHED_M..=self.range_m_max).contains(&away_m),
                at: into_map * at,
                velocity: into_map * course.velocity(run_ns),
                ahead: AHEAD_S.map(|ahead_s| Some(into_map * course.ahead(run_ns, ahead_s)?)),
            });
        }
        self.scan_ns = run_ns;
    }
}
